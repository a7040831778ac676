"""Making a mesh that fits an outline and a pattern."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.boundary import part_counts, sample, trace
from sheetmorph.geometry.features import (
    TooThinError,
    check_size,
    checked_outline,
    checked_pattern,
    resolved,
)
from sheetmorph.geometry.improve import sharpen
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.geometry.seeds import filled, interior_points
from sheetmorph.geometry.smooth import relax
from sheetmorph.geometry.topology import build_mesh
from sheetmorph.geometry.triangulate import Indices, enclosed, triangulate

if TYPE_CHECKING:
    from shapely import Geometry, Polygon

ROUNDS, SWEEPS = 8, 3  # smoothing: triangulations, and sweeps after each
FILLS = (1, 3)  # rounds after which missing points are added and crowded ones removed
TARGET = np.radians(40.0)  # triangles below this are improved one by one
ENOUGH = np.radians(30.0)  # a mesh whose smallest angle is below this is tried again
TOLERANCE = 0.02  # relative error of the mean edge length at which the search ends
TRIALS = 6


def generate_mesh(outline: Polygon, pattern: Geometry, size: float) -> SheetMesh:
    """Triangulate a sheet so that every triangle lies wholly inside or outside its pattern.

    Boundary curves are noded together, split at corners (turning above 25°, kept exactly)
    and divided into equal parts near `size`, so a curved boundary becomes chords with their
    ends on the curve. Corners and junctions closer than 0.3 size become one node; parts and
    gaps of the pattern thinner than 0.4 size and smaller than size² are absorbed. Interior
    points start on a row along the boundaries and a hexagonal lattice centred on the
    outline's centroid; they are smoothed by optimal Delaunay smoothing (Chen 2004) with
    constrained Delaunay retriangulation, and the worst triangles are improved by local
    max-min-angle moves (Freitag & Ollivier-Gooch 1997). The lattice is rescaled until the
    mean edge length is close to `size`. The result depends on the input alone.

    Args:
        outline: boundary of the sheet [m], holes allowed.
        pattern: polygon or polygons of the pattern [m] inside the outline; may be empty.
        size: wanted mean edge length [m].

    Returns:
        The mesh, z = 0.

    Raises:
        InputError: a shape is empty, invalid or self-crossing, the pattern reaches outside
            the outline, or the size does not suit the outline (too large, too thin a part,
            too many nodes).
    """
    import shapely

    outline = checked_outline(outline)
    check_size(size, outline)
    pattern = checked_pattern(pattern, outline, size)
    centre = shapely.centroid(outline)
    origin = np.array([centre.x, centre.y])
    best: tuple[bool, float, SheetMesh] | None = None
    failure: InputError | None = None
    short, long = 0.0, np.inf  # scales known to give too short and too long edges
    scale = 1.0
    for _ in range(TRIALS):
        try:
            mesh, smallest = _trial(outline, pattern, scale * size, origin)
        except InputError as error:
            failure = failure or error
            scale *= 0.97
            continue
        mean = mesh.mean_edge_length / size
        off = abs(mean - 1.0)
        good = off <= TOLERANCE and smallest >= ENOUGH
        # First a mesh of the right size with good angles, then the closest size.
        if best is None or (not good, off) < best[:2]:
            best = not good, off, mesh
        if good:
            break
        if mean < 1.0:
            short = max(short, scale)
        else:
            long = min(long, scale)
        scale = _next_scale(scale, mean, short, long)
    if best is None:
        raise failure or InputError("the outline cannot be meshed", value=f"size {size} m")
    return best[2]


def _next_scale(scale: float, mean: float, short: float, long: float) -> float:
    """Where to try next: proportional, but between the scales known to be short and long."""
    guess = scale / mean if abs(mean - 1.0) > TOLERANCE else 0.985 * scale
    if short < guess < long:
        return guess
    if short < long < np.inf and short > 0.0:
        return 0.5 * (short + long)
    return 0.985 * scale


def _trial(
    outline: Polygon, pattern: Geometry, unit: float, origin: Floats
) -> tuple[SheetMesh, float]:
    """A mesh whose lattice has edges of length `unit`, and its smallest angle [rad]."""
    import shapely

    def normalised(xy: Floats) -> Floats:
        return np.asarray((xy - origin) / unit)

    try:
        points, triangles = _draft(
            shapely.transform(outline, normalised), shapely.transform(pattern, normalised)
        )
    except TooThinError as error:
        raise error.in_metres(unit, origin) from None
    except shapely.errors.GEOSException as error:
        raise InputError(
            "the boundaries run too close to each other for the mesh size; choose a smaller size",
            value=f"size {unit * 1e3:.3g} mm",
        ) from error
    mesh = build_mesh(origin + unit * points, triangles)
    return mesh, float(mesh.minimum_angles.min())


def _draft(outline: Polygon, pattern: Geometry) -> tuple[Floats, Indices]:
    """Points and triangles for edges of unit length."""
    curves = trace(outline, resolved(outline, pattern))
    sampling = sample(curves, part_counts(curves))
    fixed, segments = sampling.points, sampling.segments
    domain = enclosed(fixed, segments, outline)
    points = np.concatenate([fixed, interior_points(fixed, segments, domain)])
    free = np.arange(len(points)) >= len(fixed)
    triangles = triangulate(points, segments, domain)
    for turn in range(ROUNDS):
        points = relax(points, triangles, free, SWEEPS)
        if turn in FILLS:
            points = filled(points, triangles, segments, len(fixed), domain)
            free = np.arange(len(points)) >= len(fixed)
        triangles = triangulate(points, segments, domain)
    stations = sampling.stations
    for _ in range(4):
        moved, stations = sharpen(points, stations, triangles, curves, sampling, TARGET, 16)
        if (moved == points).all():
            break
        points = moved
        triangles = triangulate(points, segments, domain)
    return points, triangles
