"""Several copies of one sheet on sheets of stock: rows that interlock, or packed rectangles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from sheetmorph.core.errors import InputError

if TYPE_CHECKING:
    from shapely import Polygon
    from shapely.geometry.base import BaseGeometry

    Shape = TypeVar("Shape", bound=BaseGeometry)

_OFFSETS = 12
_HALVINGS = 16
_ANGLES = (0.0, 90.0, 30.0, 60.0)
_SLACK = 1e-8
_MAX_CORNERS = 400


@dataclass(frozen=True)
class Placement:
    """Where a copy lies: turned about the origin first, then shifted.

    Attributes:
        angle: counter-clockwise [rad].
        x: [m], from the left edge of the stock.
        y: [m], from its lower edge.
    """

    angle: float
    x: float
    y: float

    def apply(self, shape: Shape) -> Shape:
        """The shape at this place."""
        from shapely.affinity import rotate, translate

        turned = rotate(shape, self.angle, origin=(0, 0), use_radians=True)
        placed: Shape = translate(turned, self.x, self.y)
        return placed


def nest(
    shape: Polygon, copies: int, stock: tuple[float, float], spacing: float
) -> list[list[Placement]]:
    """Place copies of a shape on as few sheets of stock as these arrangements need.

    Tried are straight and interlocking rows, every other row turned by 180 degrees or not,
    the shape turned by several angles; and its bounding rectangle packed by rectpack. The
    arrangement that holds most copies is used for every sheet of stock.

    Args:
        shape: the cut line of one copy [m].
        copies: how many.
        stock: width and height of a sheet of stock [m].
        spacing: between copies, and between copies and the edge of the stock [m].

    Returns:
        For each sheet of stock the places of its copies.

    Raises:
        InputError: not one copy fits the stock.
    """
    room = (stock[0] - 2 * spacing + _SLACK, stock[1] - 2 * spacing + _SLACK)
    outer = _simple(shape)
    best: list[Placement] = []
    for angle in [*_ANGLES, *_aligned(outer)]:
        for flip in (False, True):
            found = _rows(outer, math.radians(angle), flip, room, spacing, copies)
            if len(found) > len(best):
                best = found
            if len(best) >= copies:
                break
        if len(best) >= copies:
            break
    if len(best) < copies:
        packed = _packed(outer, room, spacing, copies)
        best = packed if len(packed) > len(best) else best
    if not best:
        low_x, low_y, high_x, high_y = shape.bounds
        raise InputError(
            f"a copy of {1e3 * (high_x - low_x):.1f} × {1e3 * (high_y - low_y):.1f} mm does not "
            f"fit a stock of {1e3 * stock[0]:g} × {1e3 * stock[1]:g} mm with "
            f"{1e3 * spacing:g} mm at each edge; use larger stock or less spacing",
            key="stock_width",
        )
    placed = [Placement(p.angle, p.x + spacing, p.y + spacing) for p in best]
    return [placed[: copies - first] for first in range(0, copies, len(placed))]


def _simple(shape: Polygon) -> Polygon:
    """The outer contour; with fewer corners, grown to hold the shape, where it has very many."""
    import shapely

    outer = shapely.Polygon(shape.exterior)
    if len(outer.exterior.coords) <= _MAX_CORNERS:
        return outer
    tolerance = 1e-3 * math.sqrt(outer.area)
    grown = outer.simplify(tolerance).buffer(tolerance, join_style="mitre")
    return grown if grown.covers(outer) and grown.geom_type == "Polygon" else outer.convex_hull


def _aligned(shape: Polygon) -> list[float]:
    """Angles in degrees that lay the smallest rectangle about the shape along the axes."""
    import shapely

    x, y = np.diff(shapely.get_coordinates(shape.minimum_rotated_rectangle)[:2], axis=0)[0]
    angle = -math.degrees(math.atan2(y, x)) % 90.0
    return [] if min(angle, 90.0 - angle) < 1e-6 else [angle, angle + 90.0]


def _rows(
    shape: Polygon,
    angle: float,
    flip: bool,
    room: tuple[float, float],
    spacing: float,
    copies: int,
) -> list[Placement]:
    """Rows of equal pitch, each shifted against the one below so that it comes closest."""
    from shapely.affinity import translate

    first = _at_origin(shape, angle)
    second = _at_origin(shape, angle + math.pi) if flip else first
    width, height = first[0].bounds[2:]
    if width > room[0] or height > room[1]:
        return []
    pitch = _contact(first[0], [first[0]], (1.0, 0.0), width + spacing, spacing)
    row = [translate(first[0], k * pitch) for k in range(-3, 4)]
    best: list[Placement] = []
    for k in range(_OFFSETS):
        offset = k / _OFFSETS * pitch
        moved = translate(second[0], offset)
        rise = _contact(moved, row, (0.0, 1.0), height + spacing, spacing)
        found = []
        # Bounded by the number of copies: a row or a column beyond them is not needed.
        for j in range(min(int((room[1] - height) / rise) + 1, copies)):
            start = offset if j % 2 else 0.0
            if start + width > room[0]:
                continue
            base = second[1] if j % 2 else first[1]
            found += [
                Placement(base.angle, base.x + start + i * pitch, base.y + j * rise)
                for i in range(min(int((room[0] - start - width) / pitch) + 1, copies))
            ]
            if len(found) >= copies:
                break
        found = found[:copies]
        if len(found) > len(best) and apart(shape, found, spacing):
            best = found
    return best


def apart(shape: Polygon, placements: Sequence[Placement], spacing: float) -> bool:
    """Whether all placed copies are at least `spacing` from each other."""
    import shapely

    placed = np.array([placement.apply(shape) for placement in placements], dtype=object)
    tree = shapely.STRtree(placed)
    if not spacing:
        pairs = tree.query(placed, predicate="intersects")
        one, other = pairs[:, pairs[0] < pairs[1]]
        overlap = shapely.area(shapely.intersection(placed[one], placed[other]))
        return bool((overlap < 1e-12).all())
    one, other = tree.query(placed, predicate="dwithin", distance=spacing * (1 - 1e-9))
    return bool((one == other).all())


def _packed(
    shape: Polygon, room: tuple[float, float], spacing: float, copies: int
) -> list[Placement]:
    """The bounding rectangles of the copies, some of them turned."""
    from rectpack import newPacker

    angle = math.radians(next(iter(_aligned(shape)), 0.0))
    upright, lying = _at_origin(shape, angle), _at_origin(shape, angle + 0.5 * math.pi)
    # Whole micrometres, because the packer compares sums.
    gap = math.ceil(1e6 * spacing)
    width, height = (math.ceil(1e6 * side - 1e-3) + gap for side in upright[0].bounds[2:])
    packer = newPacker(rotation=True)
    packer.add_bin(math.floor(1e6 * room[0]) + gap, math.floor(1e6 * room[1]) + gap)
    fit = int(room[0] * room[1] / shape.area) + 1
    for number in range(min(copies, fit)):
        packer.add_rect(width, height, rid=number)
    packer.pack()
    found = []
    for rectangle in (rectangle for bin_ in packer for rectangle in bin_):
        _, base = upright if rectangle.width == width else lying
        x, y = base.x + 1e-6 * rectangle.x, base.y + 1e-6 * rectangle.y
        found.append(Placement(base.angle, x, y))
    return sorted(found, key=lambda place: (place.y, place.x))


def _at_origin(shape: Polygon, angle: float) -> tuple[Polygon, Placement]:
    """The shape turned, its bounding box in the corner of the first quadrant."""
    low_x, low_y = Placement(angle, 0.0, 0.0).apply(shape).bounds[:2]
    place = Placement(angle, -low_x, -low_y)
    return place.apply(shape), place


def _contact(
    shape: Polygon,
    others: Sequence[Polygon],
    direction: tuple[float, float],
    clear: float,
    spacing: float,
) -> float:
    """A distance along `direction` after which the shape is clear of others, at most `clear`."""
    import shapely
    from shapely.affinity import translate

    still = shapely.MultiPolygon(list(others)) if len(others) == 1 else shapely.union_all(others)
    shapely.prepare(still)
    low, high = 0.0, clear
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        moved = translate(shape, direction[0] * middle, direction[1] * middle)
        if shapely.dwithin(still, moved, spacing):
            low = middle
        else:
            high = middle
    return high + _SLACK
