"""The plan of a design and its layers pulled apart, as shapes to draw."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

    from sheetmorph.design.spec import Design
    from sheetmorph.fabricate.stack import Level

INK = "#1b2530"
QUIET = "#7a858f"
FILM = "#f4f6f8"
SLIT = "#b3123c"
TOP = ("#d7e5f4", "#7f9fc2", "#23527f")
BOTTOM = ("#f7e6cf", "#cfa66a", "#8a5a12")
"""Shade, hatch and contour of parts on the two faces."""

TICK = 5e-3
"""Length of the ticks about the sheet [m]."""

Bounds = tuple[float, float, float, float]


@dataclass(frozen=True, eq=False)
class Mark:
    """A shape to draw; lengths are those of the drawn plane [m].

    Attributes:
        shape: areas or lines.
        fill: "#rrggbb", or None.
        stroke: "#rrggbb", or None.
        width: of the stroke.
        dashes: lengths of dash and gap; empty for a solid stroke.
    """

    shape: BaseGeometry
    fill: str | None = None
    stroke: str | None = None
    width: float = 0.3e-3
    dashes: tuple[float, ...] = ()


@dataclass(frozen=True)
class Label:
    """A line of text that begins at (x, y) [m], its letters `size` high."""

    text: str
    x: float
    y: float
    size: float
    colour: str = INK


@dataclass(frozen=True, eq=False)
class Picture:
    """What to draw, in order, within bounds (low x, low y, high x, high y) [m]."""

    items: tuple[Mark | Label, ...]
    bounds: Bounds


def plan_picture(
    design: Design,
    levels: Sequence[Level],
    *,
    pen: float,
    hatch: float,
    below: bool = False,
    ticks: bool = False,
) -> Picture:
    """The flat sheet with its parts: those on the far face dashed.

    Args:
        design: what to draw.
        levels: its layers, from `stack.levels_of`.
        pen: width of the contours [m].
        hatch: distance of the lines that shade the parts [m].
        below: seen from below, turned over left to right.
        ticks: draw ticks beside the sheet in line with its centre and the parts' ends.
    """
    sheet = design.outline_polygon()
    items: list[Mark] = [Mark(sheet, FILM, INK, 1.3 * pen)]
    near = "bottom" if below else "top"
    parts = [level for level in levels if level.part is not None]
    for level in sorted(parts, key=lambda level: level.face == near):
        shade, line, edge = TOP if level.face == "top" else BOTTOM
        angle = 45.0 if level.face == "top" else -45.0
        dashes = () if level.face == near else (6.0 * pen, 4.0 * pen)
        items.append(Mark(level.region, shade))
        items.append(Mark(hatched(level.region, hatch, angle), None, line, 0.4 * pen))
        items.append(Mark(level.region, None, edge, pen, dashes))
    items.append(Mark(sheet, None, INK, 1.3 * pen))
    if not design.layout.slits.is_empty:
        items.append(Mark(design.layout.slits, None, SLIT, 1.6 * pen))
    low_x, low_y, high_x, high_y = sheet.bounds
    x, y = 0.5 * (low_x + high_x), 0.5 * (low_y + high_y)
    items.append(Mark(_cross(x, y, 8.0 * pen), None, INK, 0.7 * pen))
    room = 2.0 * pen
    if ticks:
        items.append(Mark(_ticks(sheet.bounds, parts), None, QUIET, 0.7 * pen))
        room = 1.6 * TICK
    if below:
        items = [
            Mark(_mirrored(item.shape), item.fill, item.stroke, item.width, item.dashes)
            for item in items
        ]
        low_x, high_x = -high_x, -low_x
    return Picture(tuple(items), (low_x - room, low_y - room, high_x + room, high_y + room))


def exploded_picture(levels: Sequence[Level], slits: BaseGeometry) -> Picture:
    """The layers one above the other, seen aslant, each with its number and name.

    Args:
        levels: from the bottom up.
        slits: lines along which the film is cut [m].
    """
    import shapely
    from shapely.affinity import affine_transform

    bounds = np.array([level.region.bounds for level in levels])
    low, high = bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)
    width, depth = high - low
    size = math.hypot(width, depth)
    pen, text = size / 450, 0.042 * size
    rise = min(0.34 * depth + 0.06 * size, 1.3 * size / max(len(levels) - 1, 1))
    rise = max(rise, 2.7 * text)
    x0, y0 = 0.5 * (low + high)
    right = 0.5 * width + 0.2 * depth + 0.05 * size
    items: list[Mark | Label] = []
    for number, level in enumerate(levels):
        up = number * rise
        matrix = [1.0, 0.4, 0.0, 0.42, -x0 - 0.4 * y0, up - 0.42 * y0]
        shape = affine_transform(level.region, matrix)
        shade, edge = FILM, INK
        if level.part is not None:
            colours = TOP if level.face == "top" else BOTTOM
            shade, edge = colours[0], colours[2]
        items.append(Mark(shape, shade, edge, pen))
        if level.part is None and not slits.is_empty:
            items.append(Mark(affine_transform(slits, matrix), None, SLIT, 1.5 * pen))
        edge_x, edge_y = max(shapely.get_coordinates(shape).tolist())
        leader = shapely.LineString([(edge_x + 0.01 * size, edge_y), (right, up)])
        items.append(Mark(leader, None, QUIET, 0.7 * pen))
        what = "printed" if level.part is not None else level.layer.role
        items.append(Label(f"{number + 1}  {level.layer.name}", right + 0.02 * size, up, text))
        second = f"{what}, {1e3 * level.layer.thickness:g} mm"
        items.append(Label(second, right + 0.02 * size, up - 1.25 * text, 0.85 * text, QUIET))
    shapes = [item for item in items if isinstance(item, Mark)]
    boxes = np.array([mark.shape.bounds for mark in shapes])
    longest = max(len(item.text) * item.size for item in items if isinstance(item, Label))
    end = right + 0.02 * size + max(0.62 * longest, 0.3 * size)
    return Picture(
        tuple(items),
        (
            float(boxes[:, 0].min()) - 2 * pen,
            float(min(boxes[:, 1].min(), -2.0 * text)) - 2 * pen,
            end,
            float(max(boxes[:, 3].max(), (len(levels) - 1) * rise + 1.5 * text)) + 2 * pen,
        ),
    )


def hatched(region: BaseGeometry, spacing: float, angle: float) -> BaseGeometry:
    """Parallel lines at an angle [degrees] across a region, through multiples of the spacing."""
    import shapely

    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    box = shapely.get_coordinates(region.envelope)
    along, across = box @ [c, s], box @ [-s, c]
    first, last = math.ceil(across.min() / spacing), math.floor(across.max() / spacing)
    places = spacing * np.arange(first, last + 1)[:2000]
    ends = np.array([along.min(), along.max()])
    points = np.stack(
        np.broadcast_arrays(c * ends - s * places[:, None], s * ends + c * places[:, None]),
        axis=-1,
    )
    return shapely.intersection(region, shapely.multilinestrings(shapely.linestrings(points)))


def _ticks(sheet: Bounds, parts: Sequence[Level]) -> BaseGeometry:
    """Ticks outside a sheet, in line with its middle and with the ends of its parts."""
    import shapely

    boxes = np.array([level.region.bounds for level in parts]).reshape(-1, 4)
    bars = []
    for axis in (0, 1):
        low, high = sheet[axis], sheet[axis + 2]
        ends = boxes[:, [axis, axis + 2]].ravel()
        places = np.unique(np.round(np.append(ends, 0.5 * (low + high)), 4))
        base, top = sheet[1 - axis], sheet[3 - axis]
        for place in places[:200].tolist():
            for start, way in ((base, -1.0), (top, 1.0)):
                bar = np.array(
                    [[place, start + 0.4 * way * TICK], [place, start + 1.4 * way * TICK]]
                )
                bars.append(bar if axis == 0 else bar[:, ::-1])
    return shapely.multilinestrings(shapely.linestrings(np.array(bars)))


def _cross(x: float, y: float, arm: float) -> BaseGeometry:
    import shapely

    return shapely.MultiLineString([[(x - arm, y), (x + arm, y)], [(x, y - arm), (x, y + arm)]])


def _mirrored(shape: BaseGeometry) -> BaseGeometry:
    import shapely

    return shapely.transform(shape, lambda xy: xy * [-1.0, 1.0])
