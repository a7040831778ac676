"""Pictures drawn: onto a page of a PDF, or as the text of an SVG."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.fabricate.picture import Label, Mark, Picture

if TYPE_CHECKING:
    from reportlab.pdfgen.canvas import Canvas
    from shapely.geometry.base import BaseGeometry

POINT = 0.0254 / 72.0
"""A point of PDF [m]."""

FONT, BOLD = "sheetmorph-regular", "sheetmorph-bold"


@dataclass(frozen=True)
class Frame:
    """Where a picture comes to lie on a page.

    Attributes:
        x, y: the place in the picture [m] that comes to lie at
        page_x, page_y: this place of the page, from its lower left corner [m];
        scale: of the picture, 1 for true size.
    """

    x: float
    y: float
    page_x: float
    page_y: float
    scale: float = 1.0

    def points(self, shape: BaseGeometry) -> np.ndarray:
        """Coordinates of a shape on the page [pt], shape (N, 2)."""
        import shapely

        xy = shapely.get_coordinates(shape)
        page = (xy - [self.x, self.y]) * self.scale + [self.page_x, self.page_y]
        return np.asarray(page / POINT)


def paint(canvas: Canvas, picture: Picture, frame: Frame) -> None:
    """Draw a picture onto a page."""
    for item in picture.items:
        if isinstance(item, Label):
            size = item.size * frame.scale / POINT
            x = ((item.x - frame.x) * frame.scale + frame.page_x) / POINT
            y = ((item.y - frame.y) * frame.scale + frame.page_y) / POINT
            canvas.setFillColor(_colour(item.colour))
            canvas.setFont(FONT, size)
            canvas.drawString(x, y, printable(item.text))
        else:
            _paint_mark(canvas, item, frame)


def svg_text(picture: Picture, title: str) -> str:
    """A picture as an SVG element, for a page; its unit is the millimetre."""
    low_x, low_y, high_x, high_y = picture.bounds
    width, height = 1e3 * (high_x - low_x), 1e3 * (high_y - low_y)
    lines = [
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label="{escape(title)}" '
            f'viewBox="{1e3 * low_x:.3f} {-1e3 * high_y:.3f} {width:.3f} {height:.3f}">'
        )
    ]
    for item in picture.items:
        if isinstance(item, Label):
            lines.append(
                f'<text x="{1e3 * item.x:.3f}" y="{-1e3 * item.y:.3f}" '
                f'font-size="{1e3 * item.size:.3f}" fill="{item.colour}">{escape(item.text)}</text>'
            )
            continue
        style = f'fill="{item.fill or "none"}" fill-rule="evenodd"'
        if item.stroke:
            style += f' stroke="{item.stroke}" stroke-width="{1e3 * item.width:.3f}"'
            style += ' stroke-linejoin="round"'
        if item.dashes:
            style += f' stroke-dasharray="{" ".join(f"{1e3 * dash:.3f}" for dash in item.dashes)}"'
        lines.append(f'<path d="{_path_data(item.shape)}" {style}/>')
    return "\n".join([*lines, "</svg>"])


def printable(text: str) -> str:
    """Text in which characters that the fonts of the PDF lack are replaced by `?`."""
    known = use_fonts()
    return "".join(letter if ord(letter) in known else "?" for letter in text)


@lru_cache(maxsize=1)
def use_fonts() -> frozenset[int]:
    """Make the fonts known to reportlab; returns the characters that they have."""
    from reportlab.pdfbase import pdfmetrics
    from reportlab.pdfbase.ttfonts import TTFont

    faces = [TTFont(FONT, "Vera.ttf"), TTFont(BOLD, "VeraBd.ttf")]
    for face in faces:
        pdfmetrics.registerFont(face)
    pdfmetrics.registerFontFamily(FONT, normal=FONT, bold=BOLD, italic=FONT, boldItalic=BOLD)
    return frozenset.intersection(*(frozenset(face.face.charToGlyph) for face in faces))


def _paint_mark(canvas: Canvas, mark: Mark, frame: Frame) -> None:
    path = canvas.beginPath()
    for ring, closed in _chains(mark.shape):
        points = frame.points(ring).tolist()
        path.moveTo(*points[0])
        for point in points[1 : len(points) - closed]:
            path.lineTo(*point)
        if closed:
            path.close()
    if mark.fill:
        canvas.setFillColor(_colour(mark.fill))
    if mark.stroke:
        canvas.setStrokeColor(_colour(mark.stroke))
        canvas.setLineWidth(mark.width * frame.scale / POINT)
        canvas.setLineJoin(1)
        canvas.setDash([dash * frame.scale / POINT for dash in mark.dashes])
    canvas.drawPath(path, stroke=bool(mark.stroke), fill=bool(mark.fill), fillMode=0)
    canvas.setDash()


def _chains(shape: BaseGeometry) -> list[tuple[BaseGeometry, bool]]:
    """The rings and lines of a shape, and whether each is a ring of an area."""
    import shapely

    found: list[tuple[BaseGeometry, bool]] = []
    parts = shapely.get_parts(shapely.get_parts(shape))
    for part in parts:
        if part.is_empty:
            continue
        if isinstance(part, shapely.Polygon):
            found += [(ring, True) for ring in (part.exterior, *part.interiors)]
        elif not isinstance(part, shapely.Point):
            found.append((part, False))
    return found


def _path_data(shape: BaseGeometry) -> str:
    import shapely

    data = []
    for ring, closed in _chains(shape):
        xy = 1e3 * shapely.get_coordinates(ring)[: -1 if closed else None]
        text = "L".join(f"{x:.3f} {-y:.3f}" for x, y in xy.tolist())
        data.append(f"M{text}{'Z' if closed else ''}")
    return "".join(data)


def _colour(text: str) -> object:
    from reportlab.lib.colors import HexColor

    return HexColor(text)
