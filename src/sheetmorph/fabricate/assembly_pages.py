"""The assembly sheet as one self-contained HTML page and as a PDF."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from html import escape
from importlib import resources
from typing import TYPE_CHECKING, Any

from sheetmorph import __version__
from sheetmorph.core.errors import InputError
from sheetmorph.fabricate.options import PAPERS
from sheetmorph.fabricate.paint import (
    BOLD,
    FONT,
    POINT,
    Frame,
    paint,
    printable,
    svg_text,
    use_fonts,
)

if TYPE_CHECKING:
    from reportlab.platypus.flowables import Flowable

    from sheetmorph.fabricate.assembly import Assembly, Table
    from sheetmorph.fabricate.picture import Picture

TEMPLATE = "assembly.html"
_MARGIN = 18e-3


def assembly_html(sheet: Assembly) -> str:
    """The page as text; it refers to nothing outside itself."""
    from jinja2 import Environment, StrictUndefined
    from markupsafe import Markup

    text = resources.files("sheetmorph.fabricate").joinpath("templates", TEMPLATE)
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    picture = sheet.picture_png
    # The drawings are made of numbers here, and their labels are escaped there.
    return environment.from_string(text.read_text(encoding="utf-8")).render(
        sheet=sheet,
        version=__version__,
        plan=Markup(svg_text(sheet.plan, f"{sheet.title}: the flat sheet")),  # noqa: S704
        exploded=Markup(svg_text(sheet.exploded, f"{sheet.title}: its layers")),  # noqa: S704
        picture="" if picture is None else base64.b64encode(picture).decode("ascii"),
    )


def assembly_pdf(sheet: Assembly, paper: str = "a4") -> bytes:
    """The same as a PDF; the same content gives the same bytes.

    Args:
        sheet: what it says.
        paper: one of `PAPERS`.

    Raises:
        InputError: the predicted picture cannot be read.
    """
    from reportlab.platypus import SimpleDocTemplate

    use_fonts()
    buffer = io.BytesIO()
    width, height = (side / POINT for side in PAPERS[paper])
    margin = _MARGIN / POINT
    document = SimpleDocTemplate(
        buffer,
        pagesize=(width, height),
        leftMargin=margin,
        rightMargin=margin,
        topMargin=margin,
        bottomMargin=margin,
        title=printable(f"{sheet.title}: assembly"),
        creator="sheetmorph",
        invariant=1,
    )
    footer = printable(f"{sheet.title} · assembly sheet · sheetmorph {__version__}")

    def number(canvas: Any, layout: Any) -> None:
        canvas.setFont(FONT, 7)
        canvas.setFillGray(0.4)
        canvas.drawString(margin, 0.55 * margin, footer[:110])
        canvas.drawRightString(width - margin, 0.55 * margin, f"page {layout.page}")

    document.build(_story(sheet, width - 2 * margin - 12), onFirstPage=number, onLaterPages=number)
    return buffer.getvalue()


def _story(sheet: Assembly, width: float) -> list[Flowable]:
    """The page as flowables of reportlab, `width` [pt] wide."""
    from reportlab.platypus import KeepTogether

    said = _styles()
    story: list[Flowable] = [_text(sheet.title, said["title"]), _text(sheet.lead, said["lead"])]
    if sheet.warnings:
        story.append(_text("Before you start", said["heading"]))
        story += [_text(f"! {warning}", said["warning"]) for warning in sheet.warnings]
    story += [
        _text("The sheet and its layers", said["heading"]),
        _pictures([sheet.plan, sheet.exploded], width),
        _text(
            "Left: seen from above; parts on the underside dashed. Right: the layers pulled "
            "apart, counted from below.",
            said["small"],
        ),
        _table(sheet.layers, (0.11, 0.27, 0.12, 0.5), width, said),
        KeepTogether(
            [
                _text("Parts", said["heading"]),
                _table(sheet.parts, (0.22, 0.19, 0.12, 0.11, 0.12, 0.13, 0.11), width, said),
            ]
        ),
    ]
    for index, step in enumerate(sheet.steps, 1):
        lines = [_text(f"– {line}", said["line"]) for line in step.lines]
        title = _text(f"{index}. {step.title}", said["heading"])
        story += [title, *lines]
    safety = [_text(f"– {line}", said["line"]) for line in sheet.safety]
    story += [_text("Safety", said["heading"]), *safety]
    expected: list[Flowable] = [_text("The shape to expect", said["heading"])]
    if sheet.picture_png is not None:
        expected.append(_image(sheet.picture_png, 0.6 * width))
    if sheet.expected:
        expected.append(_plain_table(sheet.expected, (0.35, 0.65), width, said))
    story.append(KeepTogether([*expected, _text(sheet.expected_note, said["note"])]))
    if sheet.files.rows:
        story += [
            _text("Files", said["heading"]),
            _table(sheet.files, (0.35, 0.65), width, said),
        ]
    sources = [_text(source, said["small"]) for source in sheet.sources]
    story.append(KeepTogether([_text("Sources", said["heading"]), *sources]))
    return story


def _styles() -> dict[str, Any]:
    from reportlab.lib.styles import ParagraphStyle

    def style(name: str, size: float, **more: Any) -> Any:
        return ParagraphStyle(
            name, **{"fontName": FONT, "fontSize": size, "leading": 1.35 * size, **more}
        )

    return {
        "title": style("title", 19, fontName=BOLD, spaceAfter=4),
        "lead": style("lead", 9.5, textColor="#4a5560", spaceAfter=4),
        "heading": style(
            "heading", 12, fontName=BOLD, spaceBefore=11, spaceAfter=4, keepWithNext=1
        ),
        "line": style("line", 9, leftIndent=9, firstLineIndent=-9, spaceAfter=3),
        "note": style("note", 9, spaceBefore=4, spaceAfter=3),
        "warning": style(
            "warning", 9, leftIndent=9, firstLineIndent=-9, spaceAfter=3, textColor="#8a4b00"
        ),
        "cell": style("cell", 8),
        "number": style("number", 8, alignment=2),
        "head": style("head", 7.5, textColor="#5c6975"),
        "head-number": style("head-number", 7.5, textColor="#5c6975", alignment=2),
        "small": style("small", 7.5, textColor="#5c6975", spaceBefore=2, spaceAfter=4),
    }


def _text(text: str, style: Any) -> Flowable:
    from reportlab.platypus import Paragraph

    return Paragraph(escape(printable(text)), style)


def _table(table: Table, shares: Sequence[float], width: float, said: dict[str, Any]) -> Flowable:
    head = [
        _text(title, said["head-number" if index in table.numbers else "head"])
        for index, title in enumerate(table.titles)
    ]
    rows = [
        [
            _text(cell, said["number" if index in table.numbers else "cell"])
            for index, cell in enumerate(row)
        ]
        for row in table.rows
    ]
    return _ruled([head, *rows], shares, width, 1)


def _plain_table(
    rows: Sequence[Sequence[str]], shares: Sequence[float], width: float, said: dict[str, Any]
) -> Flowable:
    return _ruled([[_text(cell, said["cell"]) for cell in row] for row in rows], shares, width, 0)


def _ruled(
    rows: list[list[Flowable]], shares: Sequence[float], width: float, head: int
) -> Flowable:
    from reportlab.platypus import Table as PageTable

    return PageTable(
        rows,
        colWidths=[share * width for share in shares],
        repeatRows=head,
        hAlign="LEFT",
        style=[
            ("LINEBELOW", (0, 0), (-1, -1), 0.3, "#c9d1d8"),
            ("VALIGN", (0, 0), (-1, -1), "TOP"),
            ("LEFTPADDING", (0, 0), (-1, -1), 0),
            ("RIGHTPADDING", (0, 0), (-1, -1), 8),
            ("TOPPADDING", (0, 0), (-1, -1), 2),
            ("BOTTOMPADDING", (0, 0), (-1, -1), 3),
        ],
    )


def _image(png: bytes, width: float) -> Flowable:
    from reportlab.platypus import Image

    try:
        image = Image(io.BytesIO(png))
        share = min(width / image.imageWidth, 0.8 * width / image.imageHeight)
        image.drawWidth, image.drawHeight = share * image.imageWidth, share * image.imageHeight
        image._restrictSize(width, width)
    except Exception as error:
        # reportlab wraps whatever its reader of pictures raises.
        raise InputError("cannot be read as a picture", key="prediction.picture_png") from error
    image.hAlign = "LEFT"
    return image


def _pictures(pictures: Sequence[Picture], width: float) -> Flowable:
    """Pictures side by side in equal boxes, each as large as its box allows."""
    from reportlab.platypus.flowables import Flowable

    gap = 14.0
    box = (width - gap * (len(pictures) - 1)) / len(pictures)
    sides = [(p.bounds[2] - p.bounds[0], p.bounds[3] - p.bounds[1]) for p in pictures]
    scales = [min(box * POINT / w, 0.95 * box * POINT / h) for w, h in sides]
    height = max(scale * h / POINT for scale, (_, h) in zip(scales, sides, strict=True))

    class Row(Flowable):  # type: ignore[misc]
        def wrap(self, *_: float) -> tuple[float, float]:
            return width, height

        def draw(self) -> None:
            for index, (picture, scale) in enumerate(zip(pictures, scales, strict=True)):
                w, h = (scale * side / POINT for side in sides[index])
                left = index * (box + gap) + 0.5 * (box - w)
                low = 0.5 * (height - h)
                frame = Frame(*picture.bounds[:2], left * POINT, low * POINT, scale)
                paint(self.canv, picture, frame)

    return Row()
