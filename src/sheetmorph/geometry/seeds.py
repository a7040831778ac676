"""First positions of the interior points of a mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.triangulate import Indices

if TYPE_CHECKING:
    from shapely import Geometry

# All lengths here are in units of the wanted edge length.
ROW = np.sqrt(0.75)
APEX = 0.8  # distance of the first row from the boundary, a little less than ROW
CLEAR = 0.55  # no point closer to the boundary than this
APART = 0.5  # points of the first row closer than this become one
WIDE = 0.75  # a triangle with a larger circumcircle has room for a point; ideal are 0.58
SPACE = 0.75  # no lattice point closer to the first row than this


def interior_points(boundary: Floats, segments: Indices, domain: Geometry) -> Floats:
    """Points inside a domain: a row along its boundary segments, then a hexagonal lattice.

    The row stands on both sides of each segment where the apex of a nearly equilateral
    triangle goes, so that irregular nodes end up away from the boundary; in a strip two
    rows that nearly meet become one in the middle. The lattice is centred on the origin.

    Args:
        boundary: positions, shape (B, 2), in units of the wanted edge length.
        segments: indices into `boundary`, shape (M, 2).
        domain: where points may lie.

    Returns:
        Positions, shape (N, 2).
    """
    import shapely

    ends = boundary[segments]
    walls = _wall_tree(ends)
    middle = ends.mean(axis=1)
    along = ends[:, 1] - ends[:, 0]
    normal = np.stack([-along[:, 1], along[:, 0]], -1)
    normal *= APEX / np.linalg.norm(along, axis=1)[:, None]
    row = np.concatenate([middle + normal, middle - normal])
    row = row[shapely.contains_xy(domain, row[:, 0], row[:, 1])]
    row = merged(row[walls.query(row)[0] > CLEAR - 0.1], APART)
    row = row[walls.query(row)[0] > CLEAR]

    grid = hexagonal_lattice(domain.bounds)
    grid = grid[walls.query(grid, distance_upper_bound=2.0)[0] > APEX + 0.1]
    if len(row):
        grid = grid[cKDTree(row).query(grid, distance_upper_bound=2.0)[0] > SPACE]
    grid = grid[shapely.contains_xy(domain, grid[:, 0], grid[:, 1])]
    return np.concatenate([row, grid])


def filled(
    points: Floats, triangles: Indices, segments: Indices, fixed: int, domain: Geometry
) -> Floats:
    """Points with one added in each empty place, and those with too few neighbours removed.

    Args:
        points: positions, shape (N, 2), the first `fixed` on the boundary.
        triangles: corner indices, shape (T, 3).
        segments: indices of boundary points, shape (M, 2).
        domain: where points may lie.

    Returns:
        The boundary points, the interior points that stay, then the new ones.
    """
    import shapely

    keep = np.bincount(triangles.ravel(), minlength=len(points)) > 4
    keep[:fixed] = True
    centre, radius = circumcircles(points, triangles)
    wide = (radius > WIDE) & (radius < 2.0)
    new = merged(centre[wide], SPACE)
    new = new[shapely.contains_xy(domain, new[:, 0], new[:, 1])]
    points = points[keep]
    if len(new):
        alone = cKDTree(points).query(new)[0] > 0.8 * WIDE
        new = new[alone & (_wall_tree(points[segments]).query(new)[0] > 0.8 * CLEAR)]
    return np.concatenate([points, new])


def circumcircles(points: Floats, triangles: Indices) -> tuple[Floats, Floats]:
    """Centres, shape (T, 2), and radii, shape (T,), of the circles through the corners."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    uu, vv = (u * u).sum(axis=1), (v * v).sum(axis=1)
    offset = np.stack([v[:, 1] * uu - u[:, 1] * vv, u[:, 0] * vv - v[:, 0] * uu], -1)
    offset /= np.maximum(2.0 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]), 1e-12)[:, None]
    return a + offset, np.linalg.norm(offset, axis=1)


def _wall_tree(ends: Floats) -> cKDTree:
    """Points on the segments, close enough to each other to measure distances to them."""
    parts = np.linspace(0.0, 1.0, 9)[:, None, None]
    return cKDTree((ends[:, 0] * (1 - parts) + ends[:, 1] * parts).reshape(-1, 2))


def hexagonal_lattice(bounds: tuple[float, float, float, float]) -> Floats:
    """Points of the unit hexagonal lattice through the origin in a box, shape (N, 2)."""
    low_x, low_y, high_x, high_y = bounds
    rows = np.arange(np.floor(low_y / ROW), np.ceil(high_y / ROW) + 1)
    columns = np.arange(np.floor(low_x) - 1, np.ceil(high_x) + 2)
    i, j = np.meshgrid(columns, rows)
    return np.stack([(i + 0.5 * (j % 2)).ravel(), (ROW * j).ravel()], -1)


def merged(points: Floats, distance: float) -> Floats:
    """Points with every group of points closer than `distance` replaced by its mean."""
    if len(points) < 2:
        return points
    pairs = cKDTree(points).query_pairs(distance, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(points),) * 2)
    groups, label = connected_components(graph, directed=False)
    size = np.bincount(label, minlength=groups)
    return np.stack([np.bincount(label, points[:, k], groups) / size for k in (0, 1)], -1)
