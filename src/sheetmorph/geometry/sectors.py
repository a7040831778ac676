"""A sector of a symmetric sheet: what lies between two rays from the centre, and its mesh."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.rays import along, between, faces_between, of_kind, on_each
from sheetmorph.geometry.symmetry import Symmetry, cosine_sine
from sheetmorph.geometry.triangulate import Indices

if TYPE_CHECKING:
    from shapely import Geometry, Polygon

CAP_ORDERS = range(5, 15)  # numbers of triangles around a point without angles below 25°
MAX_CAP_ORDER = CAP_ORDERS[-1]
CAP_MARGIN = 0.6  # in edge lengths: no detail of the drawing this close to the cap
ROW = math.sqrt(0.75)


class UnfitError(InputError):
    """A mesh of a sector that cannot be copied and welded to a good one."""


@dataclass(frozen=True)
class Sheet:
    """Outline, regions of the pattern, and slits [m]."""

    outline: Polygon
    pattern: tuple[Geometry, ...]
    slits: Geometry

    def lines(self) -> list[Geometry]:
        """What edges of a mesh must follow."""
        rims = [shape.boundary for shape in (self.outline, *self.pattern)]
        return [line for line in (*rims, self.slits) if not line.is_empty]


@dataclass(frozen=True)
class Lengths:
    """Wanted edge lengths [m] and their growth, see `symmetric_mesh`."""

    size: float
    boundary_size: float | None
    growth: float

    def scaled(self, scale: float) -> Lengths:
        """All lengths multiplied."""
        fine = self.boundary_size
        return replace(
            self, size=scale * self.size, boundary_size=None if fine is None else scale * fine
        )


@dataclass(frozen=True, eq=False)
class Sector:
    """What lies between two rays, turned about the centre so that the first is the x-axis.

    Attributes:
        group: the group whose elements copy the sector to the sheet.
        direction: that of the first ray in the drawing [rad].
        cap: radii of the nodes on the two rays where the tip is cut off [m], or None.
        outlines: the pieces of the sheet in it.
        pattern: each region of the pattern in it.
        slits: the slits in it, and other lines on the rays whose ends must be nodes.
        locked: lines on the rays and the cap whose nodes must not slide.
    """

    group: Symmetry
    direction: float
    cap: tuple[float, float] | None
    outlines: tuple[Polygon, ...]
    pattern: tuple[Geometry, ...]
    slits: Geometry
    locked: Geometry


def sector_angle(group: Symmetry) -> float:
    """Angle of a fundamental domain [rad]."""
    return 2.0 * math.pi / group.elements


def cap_of(sheet: Sheet, lengths: Lengths, group: Symmetry) -> tuple[float, float] | None:
    """Where to cut off the tips of sectors between mirror lines: radii on the two rays [m].

    As many equal triangles as there are rotations meet at the centre; they straddle every
    second mirror line, and outside each sits another, whose apex is on that line. None where
    tips are wide enough, such triangles too sharp, or a detail of the drawing too close.
    """
    import shapely

    if group.mirror is None or group.order not in CAP_ORDERS:
        return None
    centre = shapely.Point(group.centre)
    if not sheet.outline.contains(centre):
        return None
    clear = min(shapely.distance(rim, centre) for rim in sheet.lines())
    size = lengths.size
    if lengths.boundary_size is not None:
        # Edges grow with the distance from boundaries; this is the length where the cap ends.
        grown = lengths.boundary_size + lengths.growth * clear
        size = min(size, grown / (1.0 + 1.3 * lengths.growth))
    half = math.pi / group.order
    spoke = size / math.sqrt(2.0 * math.sin(half))
    base = 2.0 * spoke * math.sin(half)
    apex = spoke * math.cos(half) + ROW * math.sqrt(base * size)
    if clear < apex + CAP_MARGIN * size:
        return None
    return spoke, apex


def sector_of(sheet: Sheet, lengths: Lengths, group: Symmetry, direction: float) -> Sector:
    """The sector of a sheet that begins at a direction."""
    import shapely

    centre = np.array(group.centre)
    c, s = cosine_sine(np.array(direction))
    turn = np.array([[c, -s], [s, c]])

    def placed(shape: Geometry) -> Geometry:
        return shapely.transform(shape, lambda xy: (xy - centre) @ turn)

    outline = placed(sheet.outline)
    angle = sector_angle(group)
    reach = 4.0 * float(np.abs(shapely.bounds(outline)).max())
    rim = np.stack(cosine_sine(np.linspace(0.0, angle, 5 if angle > 1.0 else 2)), -1)
    cap = cap_of(sheet, lengths, group)
    tip = [(0.0, 0.0)] if cap is None else [cap[1] * rim[-1], cap[0] * rim[0]]
    wedge = shapely.Polygon([*tip, *(reach * rim)])
    rays = [shapely.LineString([(0.0, 0.0), reach * end]) for end in (rim[0], rim[-1])]
    slits = placed(sheet.slits)
    ends = along(slits, rays)
    if group.mirror is None:
        # Both rays get the ends of what lies on either, so that their nodes match.
        rims = [placed(shape).boundary for shape in sheet.pattern]
        ends = on_each([*ends, *(part for rim in rims for part in along(rim, rays))], rays)
    locked = list(ends)
    if group.mirror is None or lengths.boundary_size is not None:
        # Edges must be short along boundaries, but a locked ray in a region is none.
        sides = [[tip[-1], reach * rim[0]], [tip[0], reach * rim[-1]]]
        locked = of_kind(outline.intersection(shapely.MultiLineString(sides)), "LineString")
    if cap is not None:
        locked.append(shapely.LineString(tip))
    inside = shapely.intersection(outline, wedge)
    return Sector(
        group,
        direction,
        cap,
        tuple(of_kind(inside, "Polygon")),
        tuple(_areas(shapely.intersection(placed(shape), wedge)) for shape in sheet.pattern),
        shapely.MultiLineString([*between(slits, wedge, rays), *ends]),
        shapely.MultiLineString(locked),
    )


def sector_mesh(sector: Sector, lengths: Lengths) -> tuple[Floats, Indices]:
    """Nodes, shape (N, 2), and triangles, shape (T, 3), of all pieces of a sector.

    Raises:
        InputError: a piece cannot be meshed.
    """
    import shapely

    from sheetmorph.geometry.generate import generate_mesh

    nodes: list[Floats] = []
    triangles: list[Indices] = []
    count = 0
    for piece in sector.outlines:
        slits, faces = faces_between(sector.slits, piece)
        regions = [_areas(shapely.intersection(shape, piece)) for shape in sector.pattern]
        mesh = generate_mesh(
            piece,
            [*regions, *faces],
            lengths.size,
            slits=slits,
            boundary_size=lengths.boundary_size,
            growth=lengths.growth,
            locked=sector.locked if sector.locked.length > 0.0 else None,
            open_slits=False,
        )
        nodes.append(mesh.nodes[:, :2])
        triangles.append(mesh.triangles.astype(np.intp) + count)
        count += len(mesh.nodes)
    return np.concatenate(nodes), np.concatenate(triangles)


def _areas(shape: Geometry) -> Geometry:
    import shapely

    return shapely.union_all(of_kind(shape, "Polygon"))
