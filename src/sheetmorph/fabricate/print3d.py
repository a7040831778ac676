"""Printed parts: flat plans extruded to closed bodies, laid on the bed glued face down."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.fabricate.printer import PrinterProfile

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

    from sheetmorph.fabricate.stack import Level

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

BED_SPACING = 5e-3
"""Distance between parts on one bed [m]."""

MAX_PARTS_ON_PLATES = 200

_SAME = 1e-7
"""Corners closer than this [m] are one: STL rounds coordinates to about a tenth of it."""


@dataclass(frozen=True, eq=False)
class Body:
    """A closed surface, normals outward.

    Attributes:
        name: for people.
        points: [m], shape (V, 3).
        triangles: corners, counter-clockwise from outside, shape (T, 3).
    """

    name: str
    points: Floats
    triangles: Indices


@dataclass(frozen=True, eq=False)
class PrintedPart:
    """An inert part as it lies on the printer's bed: glued face down, on z = 0.

    A part of the top face lies as in the design, seen from above. A part of the underside
    is glued to the sheet after that is turned over like a page, left to right; on the bed it
    is therefore the mirror image of the design seen from above.

    Attributes:
        level: its layer, with its place in the design.
        plan: its plan on the bed, seen from above [m].
        angle: by which it is turned on the bed [rad].
        fits: False when the bed is too small for it, however it is turned.
        to_design: rigid motion that takes the printed part to its place in the design;
            no reflection, shape (4, 4), translation in [m].
    """

    level: Level
    plan: MultiPolygon
    angle: float
    fits: bool
    to_design: Floats

    @property
    def name(self) -> str:
        """Name of the layer."""
        return self.level.layer.name

    @property
    def thickness(self) -> float:
        """Height of the print [m]."""
        return self.level.layer.thickness

    def bodies(self) -> tuple[Body, ...]:
        """One closed body for each piece of the plan."""
        pieces = self.plan.geoms
        return tuple(
            extruded(piece, self.thickness, self.name if len(pieces) == 1 else f"{self.name} {k}")
            for k, piece in enumerate(pieces, 1)
        )

    def moved(self, x: float, y: float, *, turned: bool = False) -> PrintedPart:
        """The part elsewhere on the bed: turned by 90 degrees if wanted, then shifted [m]."""
        turn = 0.5 * math.pi if turned else 0.0
        motion = _motion(turn, x, y)
        return replace(
            self,
            plan=_apply(self.plan, motion),
            angle=self.angle + turn,
            to_design=self.to_design @ np.linalg.inv(motion),
        )


def lay_on_bed(level: Level, profile: PrinterProfile) -> PrintedPart:
    """Lay a part in the middle of the bed, turned only if it fits no other way."""
    assert level.part is not None  # noqa: S101  callers pass levels of parts
    below = level.face == "bottom"
    # Half a turn about the y-axis: what was the upper, glued face then lies on the bed.
    over = np.diag([-1.0, 1.0, -1.0, 1.0]) if below else np.eye(4)
    plan = _apply(level.part.region, over)
    angle, fits = _bed_angle(plan, profile)
    turn = _motion(angle, 0.0, 0.0)
    turned = _apply(plan, turn)
    low_x, low_y, high_x, high_y = turned.bounds
    shift = _motion(
        0.0,
        0.5 * (profile.bed_width - low_x - high_x),
        0.5 * (profile.bed_depth - low_y - high_y),
    )
    lift = np.eye(4)
    lift[2, 3] = level.high if below else level.low
    to_design = lift @ np.linalg.inv(shift @ turn @ over)
    return PrintedPart(level, _apply(turned, shift), angle, fits, to_design)


def arrange(parts: Sequence[PrintedPart], profile: PrinterProfile) -> list[list[PrintedPart]]:
    """Distribute parts over as few beds as they need; parts that fit none are left out.

    Returns:
        For each bed its parts, apart by at least `BED_SPACING`, together in its middle.
    """
    from rectpack import newPacker

    fitting = [part for part in parts if part.fits][:MAX_PARTS_ON_PLATES]
    # Whole micrometres, because the packer compares sums.
    gap = round(1e6 * BED_SPACING)
    width, depth = (round(1e6 * side) + gap for side in (profile.bed_width, profile.bed_depth))
    packer = newPacker(rotation=True)
    packer.add_bin(width, depth, count=len(fitting))
    for index, part in enumerate(fitting):
        packer.add_rect(*(math.ceil(1e6 * side - 1e-3) + gap for side in _size(part)), rid=index)
    packer.pack()
    beds = []
    for found in packer:
        bed = []
        for rectangle in found:
            part = fitting[rectangle.rid]
            wide = math.ceil(1e6 * _size(part)[0] - 1e-3) + gap
            turned = part.moved(0.0, 0.0, turned=rectangle.width != wide)
            low_x, low_y = turned.plan.bounds[:2]
            bed.append(turned.moved(1e-6 * rectangle.x - low_x, 1e-6 * rectangle.y - low_y))
        bounds = np.array([part.plan.bounds for part in bed])
        low, high = bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)
        x, y = 0.5 * (np.array([profile.bed_width, profile.bed_depth]) - low - high)
        order = {part.name: index for index, part in enumerate(fitting)}
        beds.append(sorted((part.moved(x, y) for part in bed), key=lambda part: order[part.name]))
    return beds


def extruded(plan: Polygon, height: float, name: str) -> Body:
    """The straight prism over a polygon with holes, from z = 0 to `height` [m].

    Raises:
        InputError: the polygon cannot be closed to a body.
    """
    import shapely
    from manifold3d import triangulate

    flat = shapely.orient_polygons(shapely.remove_repeated_points(plan, tolerance=_SAME))
    rings = [np.asarray(ring.coords)[:-1, :2] for ring in (flat.exterior, *flat.interiors)]
    points = np.concatenate(rings)
    count = len(points)
    cap = np.asarray(triangulate(rings), dtype=np.int64)
    starts = np.concatenate([[0], np.cumsum([len(ring) for ring in rings])])
    following = np.arange(1, count + 1)
    following[starts[1:] - 1] = starts[:-1]
    here = np.arange(count)
    walls = np.concatenate(
        [
            np.column_stack([here, following, following + count]),
            np.column_stack([here, following + count, here + count]),
        ]
    )
    body = Body(
        name,
        np.column_stack([np.tile(points, (2, 1)), np.repeat([0.0, height], count)]),
        np.concatenate([cap[:, ::-1], cap + count, walls]),
    )
    if not is_closed(body.triangles):
        x, y = 1e3 * points[0]
        raise InputError(
            f"{name}: the piece at ({x:.1f}, {y:.1f}) mm cannot be made a closed body; simplify it"
        )
    return body


def is_closed(triangles: Indices) -> bool:
    """Whether every edge is run through once in each direction."""
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    size = int(triangles.max()) + 1
    one, other = ends[:, 0] * size + ends[:, 1], ends[:, 1] * size + ends[:, 0]
    keys = np.sort(one)
    return bool((np.diff(keys) > 0).all() and np.array_equal(keys, np.sort(other)))


def _bed_angle(plan: MultiPolygon, profile: PrinterProfile) -> tuple[float, bool]:
    """The smallest turn with which a plan fits the bed, in degrees as radians, if there is one."""
    import shapely

    hull = shapely.get_coordinates(plan.convex_hull)
    angles = np.deg2rad(np.concatenate([[0, 90], np.arange(1, 90), np.arange(91, 180)]))
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    wide = np.ptp(c * hull[:, 0] - s * hull[:, 1], axis=1)
    deep = np.ptp(s * hull[:, 0] + c * hull[:, 1], axis=1)
    fit = (wide <= profile.bed_width + 1e-9) & (deep <= profile.bed_depth + 1e-9)
    return (float(angles[np.argmax(fit)]), True) if fit.any() else (0.0, False)


def _size(part: PrintedPart) -> tuple[float, float]:
    low_x, low_y, high_x, high_y = part.plan.bounds
    return high_x - low_x, high_y - low_y


def _motion(angle: float, x: float, y: float) -> Floats:
    """A turn about the z-axis, then a shift [m], as a matrix of shape (4, 4)."""
    matrix = np.eye(4)
    if angle:
        c, s = math.cos(angle), math.sin(angle)
        matrix[:2, :2] = [[c, -s], [s, c]]
    matrix[:2, 3] = x, y
    return matrix


def _apply(plan: MultiPolygon, motion: Floats) -> MultiPolygon:
    import shapely

    return shapely.transform(plan, lambda xy: xy @ motion[:2, :2].T + motion[:2, 3])
