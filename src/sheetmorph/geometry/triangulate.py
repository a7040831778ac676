"""Constrained Delaunay triangulation of a planar domain with holes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.compiled import kernel
from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from shapely import Geometry

Indices = NDArray[np.intp]


def triangulate(points: Floats, segments: Indices, domain: Geometry) -> Indices:
    """Triangulate points so that every segment is an edge, and keep what lies in the domain.

    Args:
        points: distinct positions, shape (N, 2).
        segments: point indices, shape (M, 2); they enclose the domain and meet only at points.
        domain: says which of the regions that the segments enclose to keep.

    Returns:
        Corner indices, counter-clockwise, shape (T, 3).

    Raises:
        InputError: two points coincide or two segments cross.
    """
    import pythoncdt
    import shapely

    engine = pythoncdt.Triangulation(
        pythoncdt.VertexInsertionOrder.AUTO,
        pythoncdt.IntersectingConstraintEdges.NOT_ALLOWED,
        0.0,
    )
    try:
        engine.insert_vertices(np.ascontiguousarray(points, dtype=np.float64))
        engine.insert_edges(np.ascontiguousarray(segments, dtype=np.uint32))
    except RuntimeError as error:
        raise InputError(
            "the boundaries run too close to each other for the mesh size; choose a smaller size"
        ) from error
    engine.erase_super_triangle()
    table = engine.triangles_array()
    triangles = table["vertices"].astype(np.intp)
    regions = _regions(triangles, table["neighbors"], segments, len(points))
    areas = signed_areas(points, triangles)
    # One point decides for a whole region: the centroid of its largest triangle.
    order = np.lexsort((-areas, regions))
    first = order[np.flatnonzero(np.diff(regions[order], prepend=-1))]
    centre = points[triangles[first]].mean(axis=1)
    inside = shapely.contains_xy(domain, centre[:, 0], centre[:, 1])
    # Between collinear points of a straight rim lie triangles without area.
    return np.asarray(triangles[(inside & (areas[first] > 1e-9))[regions]])


def _regions(
    triangles: Indices, neighbours: NDArray[np.uint32], segments: Indices, count: int
) -> Indices:
    """Number of the region of each triangle: regions end at segments."""
    walls = np.sort(segments.min(axis=1) * count + segments.max(axis=1))
    on_wall = np.zeros(count, dtype=np.bool_)
    on_wall[segments] = True
    regions = np.full(len(triangles), -1, dtype=np.intp)
    _write_regions(triangles, neighbours, walls, on_wall, count, regions)
    return regions


@kernel
def _write_regions(triangles, neighbours, walls, on_wall, count, regions):  # type: ignore[no-untyped-def]
    """Number the regions by walking from triangle to triangle; −1 is not yet numbered.

    Neighbour k lies across the side from corner k to corner k + 1. Walls are sorted keys of
    segments, the smaller number of their ends times `count` plus the larger.
    """
    stack = np.empty(len(triangles), dtype=np.intp)
    number = 0
    for seed in range(len(triangles)):
        if regions[seed] >= 0:
            continue
        regions[seed] = number
        stack[0], height = seed, 1
        while height > 0:
            height -= 1
            here = stack[height]
            for k in range(3):
                beyond = np.int64(neighbours[here, k])
                if beyond >= len(triangles) or regions[beyond] >= 0:
                    continue
                a, b = triangles[here, k], triangles[here, (k + 1) % 3]
                if on_wall[a] and on_wall[b]:
                    key = min(a, b) * count + max(a, b)
                    place = np.searchsorted(walls, key)
                    if place < len(walls) and walls[place] == key:
                        continue
                regions[beyond] = number
                stack[height] = beyond
                height += 1
        number += 1


def enclosed(points: Floats, segments: Indices, outline: Geometry) -> Geometry:
    """Union of the faces that segments enclose inside an outline."""
    import shapely

    faces = shapely.get_parts(shapely.polygonize(shapely.linestrings(points[segments])))
    inner = shapely.point_on_surface(faces)
    return shapely.unary_union(faces[shapely.contains(outline, inner)])


def signed_areas(points: Floats, triangles: Indices) -> Floats:
    """Signed areas, positive when counter-clockwise, shape (T,)."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    return np.asarray(0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]))
