"""Meshes with exactly the symmetry of their sheet: one part is meshed, copied and welded."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.features import (
    check_size,
    checked_lines,
    checked_outline,
    checked_pattern,
)
from sheetmorph.geometry.mesh import SheetMesh
from sheetmorph.geometry.sectors import (
    MAX_CAP_ORDER,
    Lengths,
    Sheet,
    UnfitError,
    cap_of,
    sector_angle,
    sector_mesh,
    sector_of,
)
from sheetmorph.geometry.slits import checked_slits, open_slits
from sheetmorph.geometry.symmetry import Symmetry, has_symmetry
from sheetmorph.geometry.topology import build_mesh
from sheetmorph.geometry.welding import welded

if TYPE_CHECKING:
    from shapely import Geometry, Polygon

Wanted = Literal["full", "mirror", "rotation"]

SMALLEST_ANGLE = math.radians(25.0)
GOOD_ANGLE = math.radians(29.5)  # no further rays are tried once a mesh has this
TIP_ANGLE = math.radians(30.0)  # smallest angle of sectors that meet in the sheet
CLEAR_WIDTH = 2.0  # edges across a sector at its inner rim, when they do not meet in the sheet
RAYS = 8  # directions of the rays that are tried where any will do
SCALES = (1.0, 0.97)  # of the size, tried in turn
TRIALS = 3  # corrections of the mean edge length
SIZE_TOLERANCE = 0.04
RIM_TOLERANCE = 0.02  # relative error of the length of the rim: more, and the mesh is torn
CHORD = 0.06  # in edge lengths: chords are off their curve by less than this
SHOWN = 6  # groups named when none will do


def symmetric_mesh(
    outline: Polygon,
    pattern: Sequence[Geometry],
    size: float,
    symmetry: Symmetry,
    *,
    slits: Geometry | None = None,
    boundary_size: float | None = None,
    growth: float = 0.3,
    wanted: Wanted = "full",
) -> SheetMesh:
    """Triangulate a sheet so that its mesh has its symmetry, exactly but for rounding.

    A fundamental domain of the group is meshed: the sector between two neighbouring mirror
    lines, or between two rays that a rotation maps to each other. Its copies share the nodes
    on the rays. Narrow sectors between mirror lines are cut off around the centre, which gets
    a regular polygon of triangles. Where a group leaves no good triangles (sectors below 30°
    that meet at a detail of the pattern, a mirror line that makes slivers of an arm), the
    largest of its subgroups that does is used.

    Args:
        outline: boundary of the sheet [m], holes allowed.
        pattern: regions of the pattern [m], each inside the outline; may be empty.
        size: wanted mean edge length [m].
        symmetry: the group of all the shapes, see `find_symmetry`.
        slits: lines along which the sheet is cut [m].
        boundary_size: wanted edge length at the boundaries [m]; `size` by default.
        growth: how fast edges grow away from the boundaries.
        wanted: "mirror" for groups with mirror lines, "rotation" for groups without, "full"
            for the one with more elements; of equal ones that with mirror lines.

    Returns:
        The mesh, z = 0. `symmetry.node_images` tells whether it has a group, and which nodes
        correspond.

    Raises:
        InputError: the sheet has no symmetry of this kind, or no symmetric mesh with angles
            of at least 25° was found; the message says what was tried.
    """
    groups = subgroups(symmetry, wanted)
    if not groups:
        raise InputError(
            "outline, pattern and slits have no symmetry in common"
            if symmetry.trivial
            else f"outline, pattern and slits have {symmetry}, and no {wanted}",
            key="mesh.symmetry",
            value=wanted,
        )
    sheet = _checked(outline, pattern, slits, size, boundary_size)
    if not has_symmetry([outline, *pattern, sheet.slits], symmetry):
        raise InputError(f"the sheet does not have {symmetry}", key="mesh.symmetry")
    lengths = Lengths(size, boundary_size, growth)
    tried = []
    for group in groups:
        reason = _too_narrow(sheet, lengths, group)
        if reason is None:
            mesh, reason = _best(sheet, lengths, group)
            if mesh is not None:
                return _opened(mesh, sheet.slits)
        tried.append(f"{group}: {reason}")
    raise InputError(
        "no symmetric mesh with angles of at least 25° was found; choose a smaller size or a "
        f"mesh without symmetry. Tried {'; '.join(tried[:SHOWN])}",
        key="mesh.symmetry",
        value=f"size {size * 1e3:.3g} mm",
    )


def _checked(
    outline: Polygon,
    pattern: Sequence[Geometry],
    slits: Geometry | None,
    size: float,
    boundary_size: float | None,
) -> Sheet:
    """The shapes, or an InputError that says what is wrong with them."""
    import shapely

    outline = checked_outline(outline)
    check_size(size, outline)
    regions = tuple(checked_pattern(region, outline, size) for region in pattern)
    finest = size if boundary_size is None else boundary_size
    none = shapely.MultiLineString()
    if slits is None or slits.is_empty:
        return Sheet(outline, regions, none)
    lines = checked_slits(checked_lines(slits, "slits"), outline, regions, finest, none)
    return Sheet(outline, regions, lines)


def subgroups(symmetry: Symmetry, wanted: Wanted = "full") -> list[Symmetry]:
    """The subgroups of a kind, see `symmetric_mesh`, largest first; not the trivial one."""
    divisors = [n for n in range(symmetry.order, 0, -1) if symmetry.order % n == 0]
    groups = []
    if symmetry.mirror is not None and wanted != "rotation":
        step = math.pi / symmetry.order
        # A subgroup takes only some of the mirror lines: those of one kind, or of the other.
        groups = [
            Symmetry(symmetry.centre, n, symmetry.mirror + k * step)
            for n in divisors
            for k in range(min(2, symmetry.order // n))
        ]
    if wanted != "mirror":
        groups += [Symmetry(symmetry.centre, n, None) for n in divisors if n > 1]
    groups.sort(key=lambda group: -group.elements)
    return groups


def _too_narrow(sheet: Sheet, lengths: Lengths, group: Symmetry) -> str | None:
    """Why the sectors of a group leave no room for good triangles, None when they do."""
    import shapely

    if sector_angle(group) >= TIP_ANGLE - 1e-9 or cap_of(sheet, lengths, group) is not None:
        return None
    hole = shapely.distance(sheet.outline, shapely.Point(group.centre))
    if hole == 0.0:
        free = "" if group.order > MAX_CAP_ORDER else " on a detail of the pattern"
        return f"sectors below 30° meet{free}"
    if hole * sector_angle(group) < CLEAR_WIDTH * lengths.size:
        return "sectors less than 2 edges wide"
    return None


def _best(sheet: Sheet, lengths: Lengths, group: Symmetry) -> tuple[SheetMesh | None, str]:
    """The best mesh over the directions of the rays; None and the reason when none is good."""
    from shapely.errors import GEOSException

    best: SheetMesh | None = None
    reason = ""
    for scale in SCALES:
        for direction in _directions(sheet, group):
            try:
                mesh = _sized(sheet, lengths.scaled(scale), group, direction)
            except InputError as error:
                # The place that it may name is that in the turned sector, not on the sheet.
                reason = reason or error.message.partition(" near (")[0]
                continue
            except GEOSException:
                reason = reason or "boundaries run too close to each other or to a ray"
                continue
            if best is None or mesh.minimum_angles.min() > best.minimum_angles.min():
                best = mesh
            if best.minimum_angles.min() > GOOD_ANGLE:
                break
        if best is not None:
            break
    return best, reason


def _directions(sheet: Sheet, group: Symmetry) -> list[float]:
    """Directions in which the first ray may run: a mirror line, or for rotations any.

    Where boundaries of the pattern meet at the centre, a ray along one makes no new corner.
    """
    import shapely

    angle = sector_angle(group)
    if group.mirror is not None:
        return [group.mirror, group.mirror + angle]
    centre = shapely.Point(group.centre)
    spokes: set[float] = set()
    for rim in (shape.boundary for shape in sheet.pattern if shape.distance(centre) == 0.0):
        line = shapely.get_coordinates(rim) - np.array(group.centre)
        radius = np.linalg.norm(line, axis=1)
        near = radius < 1e-9 * radius.max()
        beside = np.union1d(np.flatnonzero(near) - 1, np.flatnonzero(near) + 1) % len(line)
        ends = line[beside[~near[beside]]]
        spokes |= {round(float(a), 9) for a in np.arctan2(ends[:, 1], ends[:, 0]) % angle}
    # First those that are farthest apart.
    order = sorted(range(RAYS), key=lambda k: f"{k:03b}"[::-1])
    return [*sorted(spokes)[:RAYS], *(k * angle / RAYS for k in order)]


def _sized(sheet: Sheet, lengths: Lengths, group: Symmetry, direction: float) -> SheetMesh:
    """The welded mesh, made again while its mean edge length is off."""
    scale = 1.0
    for _ in range(TRIALS):
        wanted = lengths.scaled(scale)
        sector = sector_of(sheet, wanted, group, direction)
        mesh = build_mesh(*welded(*sector_mesh(sector, wanted), sector, wanted.size))
        _check_covers(mesh, sheet, wanted.size)
        smallest = float(mesh.minimum_angles.min())
        if smallest < SMALLEST_ANGLE:
            raise UnfitError(f"smallest angle {math.degrees(smallest):.1f}°")
        ratio = mesh.mean_edge_length / lengths.size
        if lengths.boundary_size is not None or abs(ratio - 1.0) < SIZE_TOLERANCE:
            return mesh
        scale /= ratio
    raise UnfitError(f"mean edge length {mesh.mean_edge_length * 1e3:.3g} mm")


def _check_covers(mesh: SheetMesh, sheet: Sheet, size: float) -> None:
    """Refuse a mesh that is torn along the rays or does not follow the drawing."""
    import shapely

    rim = np.ones(len(mesh.edges), dtype=bool)
    rim[mesh.hinge_edges[:, 0]] = False
    length = float(mesh.edge_lengths[rim].sum())
    if abs(length - sheet.outline.length) > RIM_TOLERANCE * sheet.outline.length:
        raise UnfitError("the copies of a sector do not close to the sheet")
    for shape in (sheet.outline, *sheet.pattern):
        inside = shapely.contains_xy(shape, *mesh.triangle_centroids.T)
        area = float(mesh.triangle_areas[inside].sum())
        if abs(area - shape.area) > CHORD * size * shape.length:
            raise UnfitError("the mesh does not follow the drawing")


def _opened(mesh: SheetMesh, slits: Geometry) -> SheetMesh:
    """The mesh cut along slits."""
    return (
        mesh
        if slits.is_empty
        else build_mesh(*open_slits(mesh.nodes[:, :2], mesh.triangles.astype(np.intp), slits))
    )
