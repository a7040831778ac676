"""What the patterns of the library share: clean contours, bars, curves of small error, room."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from sheetmorph.design.fields import problem
from sheetmorph.design.shapes import placed

if TYPE_CHECKING:
    from shapely import Polygon
    from shapely.geometry.base import BaseGeometry

CHORD_ERROR = 4e-6
"""Curves of the library are replaced by chords that leave them by no more than this [m]."""

SHORTEST_EDGE = 1e-6
STRAIGHT = 1e-9
REACH = 5e-5
"""What fills the sheet up to its rim goes past it by this fraction of the sheet's diagonal.

It stays below `layout.EDGE_TOLERANCE`; the nodes of a curved rim, which lie a little outside the
polygon that stands for it, then belong to the pattern.
"""


def tidy(shape: BaseGeometry) -> BaseGeometry:
    """The shape without needless corners, without edges and holes below a micrometre [m]."""
    import shapely

    plain = shapely.simplify(_without_specks(shape), STRAIGHT)
    clean = shapely.remove_repeated_points(plain, SHORTEST_EDGE)
    return clean if shapely.is_valid(clean) else shapely.buffer(clean, 0.0)


def _without_specks(shape: BaseGeometry) -> BaseGeometry:
    """The shape without the holes that rounding leaves where arms meet in a point."""
    import shapely

    if not any(
        shapely.Polygon(ring).area <= SHORTEST_EDGE**2
        for part in shapely.get_parts(shape)
        for ring in part.interiors
    ):
        return shape
    parts = [
        shapely.Polygon(
            part.exterior,
            [ring for ring in part.interiors if shapely.Polygon(ring).area > SHORTEST_EDGE**2],
        )
        for part in shapely.get_parts(shape)
    ]
    return parts[0] if len(parts) == 1 else shapely.MultiPolygon(parts)


def bar(start: tuple[float, float], end: tuple[float, float], half_width: float) -> Polygon:
    """A rectangle about the line from `start` to `end` [m]."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    length, w = math.hypot(dx, dy), half_width
    corners = [(0.0, -w), (length, -w), (length, w), (0.0, w)]
    return placed(corners, start, math.atan2(dy, dx))


def turned(
    corners: list[tuple[float, float]], centre: tuple[float, float], rotation: float, count: int
) -> list[Polygon]:
    """Copies of a polygon about the origin, turned by equal angles and moved to `centre` [m]."""
    turn = 2 * math.pi / count
    return [placed(corners, centre, rotation + k * turn) for k in range(count)]


def chord_angle(radius: float) -> float:
    """Angle [rad] of a chord of a circle that stays within `CHORD_ERROR` of it, at most 6°."""
    return min(math.sqrt(8 * CHORD_ERROR / radius), math.radians(6.0))


def room(sheet: Polygon, margin: float) -> BaseGeometry:
    """The sheet without a strip of width `margin` along its rim and its holes [m].

    Without a margin it goes a little past the rim, see `REACH`.

    Raises:
        PydanticCustomError: nothing is left.
    """
    import shapely

    low_x, low_y, high_x, high_y = sheet.bounds
    reach = REACH * math.hypot(high_x - low_x, high_y - low_y)
    inner = shapely.buffer(sheet, -margin if margin > 0 else reach, join_style="mitre")
    if inner.is_empty:
        raise problem(
            "leaves no room on the sheet",
            key="margin",
            value=f"{1e3 * margin:g} mm",
            allowed="less than half the width of the sheet",
        )
    return inner


def without_slivers(shape: BaseGeometry, width: float) -> BaseGeometry:
    """The shape without what is narrower than `width`, its sharp tips cut short [m].

    Corners of 60° and more stay as they are.
    """
    import shapely

    thin = shapely.buffer(shape, -width / 2, join_style="mitre", mitre_limit=2.0)
    return shapely.buffer(thin, width / 2, join_style="mitre", mitre_limit=2.0)


def sheet_reach(sheet: Polygon, point: tuple[float, float]) -> float:
    """Distance [m] from a point to the farthest corner of the box around the sheet."""
    low_x, low_y, high_x, high_y = sheet.bounds
    return max(math.dist(point, (x, y)) for x in (low_x, high_x) for y in (low_y, high_y))
