"""Making a mesh that fits an outline, the regions of a pattern, and slits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.geometry import slits as cuts
from sheetmorph.geometry.boundary import Curves, trace
from sheetmorph.geometry.cells import resolved
from sheetmorph.geometry.features import (
    TooThinError,
    check_grading,
    check_size,
    checked_lines,
    checked_outline,
    checked_pattern,
)
from sheetmorph.geometry.improve import sharpen
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.geometry.plan import Plan
from sheetmorph.geometry.sampling import (
    even_stations,
    part_counts,
    refined_stations,
    sample,
    sharp_corners,
)
from sheetmorph.geometry.seeds import filled, interior_points
from sheetmorph.geometry.sizing import GradedSize, SizeField, UniformSize
from sheetmorph.geometry.smooth import corner_angles, relax
from sheetmorph.geometry.topology import build_mesh
from sheetmorph.geometry.triangulate import Indices, enclosed, triangulate

if TYPE_CHECKING:
    from shapely import Geometry, Polygon

ROUNDS, SWEEPS = 8, 3  # smoothing: triangulations, and sweeps after each
FILLS = (1, 3)  # rounds after which missing points are added and crowded ones removed
TARGET = np.radians(40.0)  # triangles below this are improved one by one
ENOUGH = np.radians(30.0)  # a mesh whose smallest angle is below this is tried again
TOLERANCE = 0.02  # relative error of the mean edge length at which the search ends
FAIR = 0.05  # error that is accepted for the sake of better angles
TRIALS = 6
GRADED_ROUNDS, GRADED_FILLS = 12, (1, 3, 5, 7)  # the same for graded meshes
GRADED_SCALES = (0.97, 1.03, 0.94, 1.06, 0.91, 0.88)  # what graded meshes try next


def generate_mesh(
    outline: Polygon,
    pattern: Geometry | Sequence[Geometry],
    size: float,
    *,
    slits: Geometry | None = None,
    boundary_size: float | None = None,
    growth: float = 0.3,
    locked: Geometry | None = None,
    open_slits: bool = True,
) -> SheetMesh:
    """Triangulate a sheet so that every triangle lies wholly inside or outside each region.

    Boundary curves and slits are noded together, split at corners (turning above 25°, kept
    exactly) and divided into equal parts near the wanted length, so a curved boundary becomes
    chords with their ends on the curve. Corners and junctions closer than 0.3 lengths become
    one node; parts and gaps of the pattern thinner than 0.4 lengths and smaller than a length
    squared are absorbed, and boundaries of different regions closer than 0.05 lengths become
    one. Interior points start on a row along the boundaries and on hexagonal lattices; they
    are smoothed by optimal Delaunay smoothing (Chen 2004) with constrained Delaunay
    retriangulation, and the worst triangles are improved by local max-min-angle moves
    (Freitag & Ollivier-Gooch 1997). A lattice of one length is rescaled until the mean edge
    length is close to `size`. The result depends on the input alone.

    Args:
        outline: boundary of the sheet [m], holes allowed.
        pattern: region or regions of the pattern [m] inside the outline; each one polygon
            or polygons, that may be empty, overlap, touch or nest.
        size: wanted mean edge length [m]; with `boundary_size`, the largest one.
        slits: lines [m] along which the mesh opens.
        boundary_size: wanted edge length [m] at the boundaries of the regions and at slits,
            from size / 20 to size; from there edges grow to `size`.
        growth: how much longer edges become per distance from there.
        locked: straight lines on the outline's boundary [m] whose nodes stay where equal
            parts put them, so that congruent lines get congruent nodes.
        open_slits: whether nodes on slits are repeated; if not, edges only follow slits.

    Returns:
        The mesh, z = 0.

    Raises:
        InputError: a shape is empty, invalid or self-crossing, the pattern or a slit reaches
            outside the outline, slits are too short, too close to other lines or cut the
            sheet into pieces, or the sizes do not suit the outline (too large, too thin a
            part, too many nodes).
    """
    import shapely

    outline = checked_outline(outline)
    check_size(size, outline)
    single = isinstance(pattern, shapely.Geometry) or not isinstance(pattern, Sequence)
    given = [pattern] if single else list(pattern)
    regions = [checked_pattern(region, outline, size) for region in given]
    plan = Plan(
        outline,
        tuple(region for region in regions if not region.is_empty),
        checked_lines(slits, "slits"),
        checked_lines(locked, "locked line"),
    )
    check_grading(size, boundary_size, growth, plan)
    finest = size if boundary_size is None else boundary_size
    plan = plan.with_slits(
        cuts.checked_slits(plan.slits, outline, plan.regions, finest, plan.locked)
    )
    draft = _searched(plan, size, finest, growth)
    if not open_slits or plan.slits.is_empty:
        return build_mesh(*draft)
    return build_mesh(*cuts.open_slits(*draft, plan.slits))


Draft = tuple[Floats, Indices]


def _searched(plan: Plan, size: float, finest: float, growth: float) -> Draft:
    """The best of a few meshes at different scales: first good angles, then the right size."""
    import shapely

    centre = shapely.centroid(plan.outline)
    origin = np.array([centre.x, centre.y])
    graded = finest < size and bool(plan.regions or not plan.slits.is_empty)
    unit = finest if graded else size
    best: tuple[tuple[bool, bool, float, float], Draft] | None = None
    failure: InputError | None = None
    short, long = 0.0, np.inf  # scales known to give too short and too long edges
    scale = 1.0
    for trial in range(TRIALS):
        try:
            draft, smallest = _trial(plan, scale * unit, size / unit, growth, origin)
        except InputError as error:
            failure = failure or error
            scale *= 0.97
            continue
        if graded:
            if best is None or -smallest < best[0][2]:
                best = (False, False, -smallest, 0.0), draft
            if smallest >= ENOUGH:
                break
            scale = GRADED_SCALES[trial]
            continue
        mean = _mean_edge_length(*draft) / size
        off = abs(mean - 1.0)
        good = off <= TOLERANCE and smallest >= ENOUGH
        # First a mesh of the right size with good angles, then nearly that with the best ones.
        key = not good, off > FAIR, -min(smallest, ENOUGH), off
        if best is None or key < best[0]:
            best = key, draft
        if good:
            break
        if mean < 1.0:
            short = max(short, scale)
        else:
            long = min(long, scale)
        scale = _next_scale(scale, mean, short, long)
    if best is None:
        raise failure or InputError("the outline cannot be meshed", value=f"size {size} m")
    return best[1]


def _mean_edge_length(points: Floats, triangles: Indices) -> float:
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    keys = np.unique(sides[:, 0] * len(points) + sides[:, 1])
    ends = points[np.stack([keys // len(points), keys % len(points)])]
    return float(np.linalg.norm(ends[1] - ends[0], axis=1).mean())


def _next_scale(scale: float, mean: float, short: float, long: float) -> float:
    """Where to try next: proportional, but between the scales known to be short and long."""
    guess = scale / mean if abs(mean - 1.0) > TOLERANCE else 0.985 * scale
    if short < guess < long:
        return guess
    if short < long < np.inf and short > 0.0:
        return 0.5 * (short + long)
    return 0.985 * scale


def _trial(
    plan: Plan, unit: float, coarsest: float, growth: float, origin: Floats
) -> tuple[Draft, float]:
    """A mesh in metres whose shortest wanted edge is `unit` long, and its smallest angle."""
    import shapely

    normalised = plan.moved(lambda xy: np.asarray((xy - origin) / unit))
    size: SizeField = UniformSize()
    if coarsest > 1.0:
        size = GradedSize.around(normalised.marked_lines(), 1.0, coarsest, growth)
    try:
        (points, triangles), smallest = _draft(normalised, size)
    except TooThinError as error:
        raise error.in_metres(unit, origin) from None
    except shapely.errors.GEOSException as error:
        raise InputError(
            "the boundaries run too close to each other for the mesh size; choose a smaller size",
            value=f"size {unit * 1e3:.3g} mm",
        ) from error
    return (origin + unit * points, triangles), smallest


def _draft(plan: Plan, size: SizeField) -> tuple[Draft, float]:
    """Points, triangles, smallest angle [rad]; lengths in shortest wanted edge lengths."""
    curves = trace(resolved(plan, size), size)
    stations = even_stations(curves, part_counts(curves))
    draft, smallest = _filled_in(plan, size, curves, stations)
    if smallest < ENOUGH:
        more = refined_stations(curves, stations)
        if len(more) > len(stations):
            other, better = _filled_in(plan, size, curves, more)
            if better > smallest:
                return other, better
    return draft, smallest


def _filled_in(
    plan: Plan, size: SizeField, curves: Curves, stations: Floats
) -> tuple[Draft, float]:
    """Points and triangles between boundary nodes at given arc lengths, and the smallest angle.

    Triangles at corners of the drawing that are sharp themselves do not count.
    """
    sampling = sample(curves, stations)
    fixed, segments = sampling.points, sampling.segments
    domain = enclosed(fixed, segments, plan.outline)
    points = np.concatenate([fixed, interior_points(fixed, segments, domain, size)])
    free = np.arange(len(points)) >= len(fixed)
    triangles = triangulate(points, segments, domain)
    graded = not isinstance(size, UniformSize)
    rounds, fills = (GRADED_ROUNDS, GRADED_FILLS) if graded else (ROUNDS, FILLS)
    for turn in range(rounds):
        points = relax(points, triangles, free, SWEEPS, size)
        if turn in fills:
            points = filled(points, triangles, segments, len(fixed), domain, size)
            free = np.arange(len(points)) >= len(fixed)
        triangles = triangulate(points, segments, domain)
    stations = sampling.stations
    for _ in range(4):
        moved, stations = sharpen(points, stations, triangles, curves, sampling, TARGET, 16)
        if (moved == points).all():
            break
        points = moved
        triangles = triangulate(points, segments, domain)
    smallest = corner_angles(points, triangles).min(axis=1)
    blunt = ~np.isin(triangles, sharp_corners(sampling)).any(axis=1)
    return (points, triangles), float(smallest[blunt].min(initial=np.pi / 3.0))
