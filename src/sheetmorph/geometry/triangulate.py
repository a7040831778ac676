"""Constrained Delaunay triangulation of a planar domain with holes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

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
    missing = np.iinfo(np.uint32).max
    # Neighbour k lies across the side from corner k to corner k + 1.
    starts, ends = triangles, np.roll(triangles, -1, axis=1)
    walls = np.sort(segments.min(axis=1) * count + segments.max(axis=1))
    on_wall = np.zeros(count, dtype=bool)
    on_wall[segments] = True
    open_side = neighbours != missing
    suspect = np.nonzero(open_side & on_wall[starts] & on_wall[ends])
    keys = np.minimum(starts[suspect], ends[suspect]) * count
    keys += np.maximum(starts[suspect], ends[suspect])
    found = np.minimum(np.searchsorted(walls, keys), len(walls) - 1)
    open_side[suspect] = walls[found] != keys
    rows, _ = np.nonzero(open_side)
    cols = neighbours[open_side].astype(np.intp)
    graph = coo_array(
        (np.ones(len(rows), dtype=np.int8), (rows, cols)), shape=(len(triangles),) * 2
    )
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.intp)


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
