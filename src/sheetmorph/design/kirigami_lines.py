"""Lines on a sheet: where they may lie, how they are joined, smoothed and checked."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.design.library_tools import CHORD_ERROR, SHORTEST_EDGE
from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from shapely import LineString, Polygon
    from shapely.geometry.base import BaseGeometry

PLACES, CANDIDATES = 50, 12
"""Places tried for the centre of one polygon, and how many of those on the sheet are compared."""

SNAP = 1e-7
"""Corners are rounded to this [m], so that the last bits of a sine change nothing."""

KEPT = 0.004
"""Closing by a disc changes the area of a shape without narrow gaps by at most this fraction."""


def shrunk(sheet: Polygon, margin: float) -> BaseGeometry:
    """The sheet without a strip along its rim and its holes [m]."""
    import shapely

    return shapely.buffer(sheet, -margin, quad_segs=_segments(margin))


def grown(shape: BaseGeometry, distance: float) -> BaseGeometry:
    """All points within a distance of the shape; within it, for a negative one."""
    import shapely

    return shapely.buffer(shape, distance, quad_segs=_segments(distance))


def _segments(radius: float) -> int:
    """Chords of a quarter circle that stay within `CHORD_ERROR` of it, 4 to 60."""
    return min(60, max(4, math.ceil(math.pi / 4 * math.sqrt(abs(radius) / (2 * CHORD_ERROR)))))


def smoothed(shape: BaseGeometry, width: float) -> BaseGeometry:
    """The shape closed and then opened by a disc: no gaps and no ribs below a width [m]."""
    import shapely

    if width <= SHORTEST_EDGE:
        return shape
    for sign in (1.0, -1.0):
        # A little more than asked, which pays for the chords of the arcs.
        distance = sign * 1.01 * width / 2
        shape = shapely.simplify(grown(grown(shape, distance), -distance), CHORD_ERROR / 2)
    return shape


def is_narrow(shape: BaseGeometry, width: float) -> bool:
    """Whether closing by a disc of this width changes the shape: it was opened last."""
    changed = grown(grown(shape, width / 2), -width / 2)
    return bool(abs(changed.area - shape.area) > KEPT * shape.area)


def heart_of(lanes: BaseGeometry, margin: float) -> BaseGeometry:
    """What lies away from the rim of a region, by a margin or as far as there is room [m]."""
    import shapely

    reach = shapely.length(shapely.maximum_inscribed_circle(lanes))
    return shapely.buffer(lanes, -min(margin, 0.7 * reach))


def place(random: np.random.Generator, heart: BaseGeometry, taken: list[Floats]) -> Floats:
    """A random point of a region, away from others, rounded [m], shape (2,).

    Of some points spread evenly it is the one farthest from those taken already.
    """
    import shapely

    low_x, low_y, high_x, high_y = heart.bounds
    tries = random.random((PLACES, 2)) * [high_x - low_x, high_y - low_y] + [low_x, low_y]
    tries = np.round(tries / SNAP) * SNAP
    inside = tries[shapely.contains_xy(heart, tries)][:CANDIDATES]
    if not len(inside):
        largest = max(shapely.get_parts(heart), key=lambda part: part.area)
        return np.asarray(shapely.get_coordinates(shapely.point_on_surface(largest))[0])
    if not taken:
        return np.asarray(inside[0])
    away = np.linalg.norm(inside[:, None] - np.array(taken), axis=2).min(axis=1)
    return np.asarray(inside[np.argmax(away)])


def far_end(line: BaseGeometry, centre: Floats) -> Floats:
    """The end of a line that lies farther from a point."""
    import shapely

    ends = shapely.get_coordinates(line)
    return np.asarray(ends[np.argmax(np.hypot(*(ends - centre).T))])


def shortest_bars(
    shape: BaseGeometry, strokes: list[BaseGeometry], lanes: BaseGeometry
) -> list[LineString]:
    """Lines that join the parts of a shape, along the shortest tree within a region.

    They run from a stroke of the one part to a stroke of the other. A part that no straight line
    within the region reaches is left out.
    """
    import shapely

    parts = list(shapely.get_parts(shape))
    lines = np.array(strokes)
    cores = [shapely.union_all(lines[shapely.intersects(part, lines)]) for part in parts]
    reachable = shapely.buffer(lanes, SNAP)
    shapely.prepare(reachable)
    bars: list[LineString] = []
    joined, rest = [0], list(range(1, len(parts)))
    links = {
        (i, j): line
        for i in range(len(parts))
        for j in range(i)
        if reachable.covers(line := shapely.shortest_line(cores[i], cores[j]))
    }
    while rest:
        found = [
            (line.length, i, line)
            for i in rest
            for j in joined
            if (line := links.get((max(i, j), min(i, j)))) is not None
        ]
        if not found:
            break
        _, nearest, line = min(found, key=lambda item: item[:2])
        bars.append(line)
        joined.append(nearest)
        rest.remove(nearest)
    return bars
