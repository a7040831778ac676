"""A paper template in true size: tiled over pages, with rulers to check the printer by."""

from __future__ import annotations

import io
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from string import ascii_uppercase
from typing import TYPE_CHECKING

from sheetmorph.core.errors import InputError
from sheetmorph.fabricate.options import PAPER_NAMES, PAPERS
from sheetmorph.fabricate.paint import BOLD, FONT, POINT, Frame, paint, printable, use_fonts
from sheetmorph.fabricate.picture import Bounds, Picture, plan_picture

if TYPE_CHECKING:
    from reportlab.pdfgen.canvas import Canvas

    from sheetmorph.design.spec import Design
    from sheetmorph.fabricate.stack import Level

MARGIN = 10e-3
FOOTER = 25e-3
OVERLAP = 10e-3
"""Room that a printer leaves free, height of the notes below the drawing, and how far
neighbouring pages show the same [m]."""

MAX_PAGES = 60
BARS = (("50 mm", 50e-3), ("2 in", 50.8e-3))
BAR_HEIGHT = 1.2e-3


@dataclass(frozen=True)
class Tile:
    """One page of a template.

    Attributes:
        label: column as a letter, row as a number counted from the top: "A1".
        window: what of the plane it shows (low x, low y, high x, high y) [m].
    """

    label: str
    window: Bounds


@dataclass(frozen=True)
class Tiling:
    """How a drawing is spread over pages.

    Attributes:
        paper: width and height of the page as it lies [m].
        columns: pages side by side.
        rows: pages one above the other.
        tiles: row by row from the top left.
        origin: where the lower left corner of a window lies on its page [m].
    """

    paper: tuple[float, float]
    columns: int
    rows: int
    tiles: tuple[Tile, ...]
    origin: tuple[float, float] = (MARGIN, MARGIN + FOOTER)


def tiling(bounds: Bounds, paper: str) -> Tiling:
    """Spread bounds [m] over as few pages as possible, upright or lying.

    Raises:
        InputError: more than `MAX_PAGES` pages would be needed.
    """
    upright = PAPERS[paper]
    choices = [_spread(bounds, size) for size in (upright, upright[::-1])]
    best = min(choices, key=lambda spread: spread[1] * spread[2])
    size, columns, rows = best
    if columns * rows > MAX_PAGES:
        raise InputError(
            f"the template would take {columns * rows} pages of {PAPER_NAMES[paper]}",
            key="papers",
            allowed=f"≤ {MAX_PAGES} pages",
        )
    width, height = _window(size)
    step_x, step_y = width - OVERLAP, height - OVERLAP
    left = 0.5 * (bounds[0] + bounds[2] - columns * step_x - OVERLAP)
    top = 0.5 * (bounds[1] + bounds[3] + rows * step_y + OVERLAP)
    tiles = [
        Tile(
            f"{_letters(column)}{row + 1}",
            (
                left + column * step_x,
                top - row * step_y - height,
                left + column * step_x + width,
                top - row * step_y,
            ),
        )
        for row in range(rows)
        for column in range(columns)
    ]
    return Tiling(size, columns, rows, tuple(tiles))


def template_pdf(design: Design, levels: Sequence[Level], paper: str) -> bytes:
    """The template of a design as PDF; with parts on the underside, that face as well.

    Args:
        design: what to draw.
        levels: its layers, from `stack.levels_of`.
        paper: one of `PAPERS`.

    Raises:
        InputError: it would take too many pages.
    """
    from reportlab.pdfgen.canvas import Canvas

    use_fonts()
    views = [("", "Seen from above, in true size.", False)]
    if any(level.face == "bottom" and level.part is not None for level in levels):
        views.append(("U-", "Underside, in true size: the sheet turned over left to right.", True))
    pictures = [
        plan_picture(design, levels, pen=0.3e-3, hatch=2.5e-3, below=below, ticks=True)
        for _, _, below in views
    ]
    plan = tiling(pictures[0].bounds, paper)
    buffer = io.BytesIO()
    size = (plan.paper[0] / POINT, plan.paper[1] / POINT)
    canvas = Canvas(buffer, pagesize=size, invariant=1)
    canvas.setTitle(printable(f"{design.name}: template"))
    canvas.setCreator("sheetmorph")
    pages = len(plan.tiles) * len(views)
    number = 0
    for (prefix, view, _), picture in zip(views, pictures, strict=True):
        spread = tiling(picture.bounds, paper)
        for tile in spread.tiles:
            number += 1
            _draw_tile(canvas, picture, spread, tile, prefix)
            _draw_footer(
                canvas,
                plan.paper[0],
                prefix + tile.label,
                [
                    f"{design.name}: template",
                    view,
                    "Print at 100 % (actual size, not “fit to page”); then measure both bars.",
                    _legend(design, levels),
                    f"Page {number} of {pages}" + (_pasting(spread) if spread.tiles[1:] else ""),
                ],
            )
            canvas.showPage()
    canvas.save()
    return buffer.getvalue()


def _draw_tile(canvas: Canvas, picture: Picture, plan: Tiling, tile: Tile, prefix: str) -> None:
    low_x, low_y, high_x, high_y = tile.window
    x, y = plan.origin
    box = (x / POINT, y / POINT, (high_x - low_x) / POINT, (high_y - low_y) / POINT)
    canvas.saveState()
    clip = canvas.beginPath()
    clip.rect(*box)
    canvas.clipPath(clip, stroke=0, fill=0)
    paint(canvas, picture, Frame(low_x, low_y, x, y))
    canvas.restoreState()
    if len(plan.tiles) == 1:
        return
    canvas.setStrokeColorRGB(0.72, 0.75, 0.78)
    canvas.setLineWidth(0.4)
    canvas.rect(*box)
    for cross_x, cross_y, name in _crosses(plan, prefix):
        if low_x < cross_x < high_x and low_y < cross_y < high_y:
            _draw_cross(canvas, (x + cross_x - low_x) / POINT, (y + cross_y - low_y) / POINT, name)


def _draw_cross(canvas: Canvas, x: float, y: float, name: str) -> None:
    arm = 3e-3 / POINT
    canvas.setStrokeColorRGB(0.25, 0.3, 0.35)
    canvas.setFillColorRGB(0.25, 0.3, 0.35)
    canvas.setLineWidth(0.5)
    canvas.line(x - arm, y, x + arm, y)
    canvas.line(x, y - arm, x, y + arm)
    canvas.circle(x, y, 0.5 * arm, stroke=1, fill=0)
    canvas.setFont(FONT, 5)
    canvas.drawString(x + 0.25 * arm, y + 0.6 * arm, name)


def _crosses(plan: Tiling, prefix: str) -> list[tuple[float, float, str]]:
    """Centres of the crosses in the overlaps, with the two pages that each joins."""
    found = []
    grid = [plan.tiles[row * plan.columns : (row + 1) * plan.columns] for row in range(plan.rows)]
    for row in grid:
        for one, other in itertools.pairwise(row):
            x = 0.5 * (one.window[2] + other.window[0])
            low, high = one.window[1], one.window[3]
            name = f"{prefix}{one.label}|{prefix}{other.label}"
            found += [(x, low + part * (high - low), name) for part in (0.2, 0.5, 0.8)]
    for upper, lower in itertools.pairwise(grid):
        for one, other in zip(upper, lower, strict=True):
            y = 0.5 * (one.window[1] + other.window[3])
            low, high = one.window[0], one.window[2]
            name = f"{prefix}{one.label}|{prefix}{other.label}"
            found += [(low + part * (high - low), y, name) for part in (0.2, 0.5, 0.8)]
    return found


def _draw_footer(canvas: Canvas, width: float, label: str, lines: Sequence[str]) -> None:
    canvas.setFillColorRGB(0.0, 0.0, 0.0)
    for index, (text, length) in enumerate(BARS):
        y = MARGIN + (0.0115 - 0.0085 * index)
        canvas.rect(MARGIN / POINT, y / POINT, length / POINT, BAR_HEIGHT / POINT, 0, 1)
        canvas.setFont(FONT, 7)
        canvas.drawString(MARGIN / POINT, (y + BAR_HEIGHT + 0.8e-3) / POINT, text)
    left = MARGIN + 50.8e-3 + 5e-3
    room = width - MARGIN - left - 22e-3
    for index, line in enumerate(lines):
        y = MARGIN + 0.0185 - 0.0046 * index
        _fitted(canvas, line, left, y, room, 8.0 if index == 0 else 7.0, bold=index == 0)
    canvas.setFont(BOLD, 20)
    canvas.drawRightString((width - MARGIN) / POINT, (MARGIN + 2e-3) / POINT, label)


def _fitted(
    canvas: Canvas, text: str, x: float, y: float, room: float, size: float, *, bold: bool
) -> None:
    """A line of text made smaller, then cut off, to keep within its room."""
    font, text = BOLD if bold else FONT, printable(text)
    wide = canvas.stringWidth(text, font, size) * POINT
    size = max(size * min(1.0, room / wide), 4.0) if wide > 0 else size
    while len(text) > 1 and canvas.stringWidth(text, font, size) * POINT > room + 1e-6:
        text = text[:-2].rstrip(" …") + "…"
    canvas.setFont(font, size)
    canvas.drawString(x / POINT, y / POINT, text)


def _legend(design: Design, levels: Sequence[Level]) -> str:
    faces = {level.face for level in levels if level.part is not None}
    told = ["Dark line: cut."]
    if not design.layout.slits.is_empty:
        told.append("Red: slit.")
    if faces:
        told.append("Shaded: glue the part here.")
    if "bottom" in faces:
        told.append("Dashed: other face.")
    told.append("Ticks: middle and ends.")
    return " ".join(told)


def _pasting(plan: Tiling) -> str:
    return (
        f", {plan.columns} × {plan.rows}: letters run right, numbers down; "
        "paste with crosses of one name upon each other."
    )


def _spread(bounds: Bounds, size: tuple[float, float]) -> tuple[tuple[float, float], int, int]:
    sides = (bounds[2] - bounds[0], bounds[3] - bounds[1])
    columns, rows = (
        max(math.ceil((side - OVERLAP) / (room - OVERLAP) - 1e-9), 1)
        for side, room in zip(sides, _window(size), strict=True)
    )
    return size, columns, rows


def _window(size: tuple[float, float]) -> tuple[float, float]:
    return size[0] - 2 * MARGIN, size[1] - 2 * MARGIN - FOOTER


def _letters(index: int) -> str:
    letter = ascii_uppercase[index % 26]
    return letter if index < 26 else _letters(index // 26 - 1) + letter
