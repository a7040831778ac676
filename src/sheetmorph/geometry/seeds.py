"""First positions of the interior points of a mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.sizing import SizeField, UniformSize
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
CROWDED = 0.6  # in a graded mesh, of two points closer than this one goes
BLOCK = 8  # a lattice in a graded mesh is made in blocks of so many points squared


def interior_points(
    boundary: Floats, segments: Indices, domain: Geometry, size: SizeField
) -> Floats:
    """Points inside a domain: a row along its boundary segments, then a hexagonal lattice.

    The row stands on both sides of each segment where the apex of a nearly equilateral
    triangle goes, so that irregular nodes end up away from the boundary; in a strip two
    rows that nearly meet become one in the middle. The lattice is centred on the origin.

    Args:
        boundary: positions, shape (B, 2).
        segments: indices into `boundary`, shape (M, 2).
        domain: where points may lie.
        size: wanted edge lengths.

    Returns:
        Positions, shape (N, 2).
    """
    import shapely

    ends = boundary[segments]
    walls = _wall_tree(ends)
    middle = ends.mean(axis=1)
    along = ends[:, 1] - ends[:, 0]
    normal = np.stack([-along[:, 1], along[:, 0]], -1)
    normal *= (APEX * size.at(middle) / np.linalg.norm(along, axis=1))[:, None]
    row = np.concatenate([middle + normal, middle - normal])
    row = row[shapely.contains_xy(domain, row[:, 0], row[:, 1])]
    row = merged(row[_clearance(walls, row, size) > CLEAR - 0.1], APART, size)
    row = row[_clearance(walls, row, size) > CLEAR]

    grid = lattice(domain.bounds, size)
    grid = grid[_clearance(walls, grid, size) > APEX + 0.1]
    if len(row):
        grid = grid[_clearance(cKDTree(row), grid, size) > SPACE]
    grid = grid[shapely.contains_xy(domain, grid[:, 0], grid[:, 1])]
    return np.concatenate([row, grid])


def _clearance(tree: cKDTree, points: Floats, size: SizeField) -> Floats:
    """Distance to the nearest place of a tree, up to 2, in wanted edge lengths."""
    distance = tree.query(points, distance_upper_bound=2.0 * size.coarsest)[0]
    return distance if isinstance(size, UniformSize) else np.asarray(distance / size.at(points))


def filled(
    points: Floats,
    triangles: Indices,
    segments: Indices,
    fixed: int,
    domain: Geometry,
    size: SizeField,
) -> Floats:
    """Points with one added in each empty place, and those with too few neighbours removed.

    Args:
        points: positions, shape (N, 2), the first `fixed` on the boundary.
        triangles: corner indices, shape (T, 3).
        segments: indices of boundary points, shape (M, 2).
        domain: where points may lie.
        size: wanted edge lengths.

    Returns:
        The boundary points, the interior points that stay, then the new ones.
    """
    import shapely

    keep = np.bincount(triangles.ravel(), minlength=len(points)) > 4
    if not isinstance(size, UniformSize):
        keep &= ~_crowded(points, triangles, fixed, size)
    keep[:fixed] = True
    centre, radius = circumcircles(points, triangles)
    radius = radius / size.at(centre)
    wide = (radius > WIDE) & (radius < 2.0)
    new = merged(centre[wide], SPACE, size)
    new = new[shapely.contains_xy(domain, new[:, 0], new[:, 1])]
    points = points[keep]
    if len(new):
        alone = _clearance(cKDTree(points), new, size) > 0.8 * WIDE
        walls = _wall_tree(points[segments])
        new = new[alone & (_clearance(walls, new, size) > 0.8 * CLEAR)]
    return np.concatenate([points, new])


def _crowded(points: Floats, triangles: Indices, fixed: int, size: SizeField) -> NDArray[np.bool_]:
    """Interior points closer than `CROWDED` to a neighbour that stays, shape (N,)."""
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    sides.sort(axis=1)
    length = np.linalg.norm(points[sides[:, 0]] - points[sides[:, 1]], axis=1)
    wanted = size.at(points)[sides].mean(axis=1)
    later = sides[(length < CROWDED * wanted) & (sides[:, 1] >= fixed)]
    crowded = np.zeros(len(points), dtype=bool)
    crowded[later[:, 1]] = True
    # Of a chain of close points every other one stays.
    again = later[~crowded[later[:, 0]], 1]
    crowded[:] = False
    crowded[again] = True
    return crowded


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


def lattice(bounds: tuple[float, float, float, float], size: SizeField) -> Floats:
    """Points of hexagonal lattices through the origin in a box, shape (N, 2).

    Where the wanted length changes, lattices whose spacings differ by √2 take turns.
    """
    levels = 1 + int(np.ceil(2.0 * np.log2(size.coarsest / size.finest) - 1e-6))
    parts = []
    for level in range(levels):
        spacing = size.coarsest * 2.0 ** (-0.5 * level)
        points = _hexagonal_lattice(bounds, spacing, size)
        if levels > 1:
            ratio = size.at(points) / spacing
            low = ratio >= 2.0**-0.25 if level < levels - 1 else ratio > 0.0
            points = points[low & ((ratio < 2.0**0.25) | (level == 0))]
        parts.append(points)
    points = np.concatenate(parts)
    return points if levels == 1 else merged(points, 0.75, size)


def _hexagonal_lattice(
    bounds: tuple[float, float, float, float], spacing: float, size: SizeField
) -> Floats:
    """Points of one lattice, in a graded mesh only near places that want its spacing."""
    low_x, low_y, high_x, high_y = np.array(bounds) / spacing
    rows = np.arange(np.floor(low_y / ROW), np.ceil(high_y / ROW) + 1)
    columns = np.arange(np.floor(low_x) - 1, np.ceil(high_x) + 2)
    if isinstance(size, UniformSize):
        i, j = np.meshgrid(columns, rows)
        return spacing * np.stack([(i + 0.5 * (j % 2)).ravel(), (ROW * j).ravel()], -1)
    block_i, block_j = np.meshgrid(columns[::BLOCK], rows[::BLOCK])
    corner = np.stack([block_i.ravel(), block_j.ravel()], -1)
    middle = spacing * (corner + 0.5 * BLOCK) * [1.0, ROW]
    wanted, spread = size.at(middle), size.growth * spacing * 0.8 * BLOCK
    near = (wanted - spread < 2.0**0.25 * spacing) | (spacing >= size.coarsest)
    near &= wanted + spread > 2.0**-0.25 * spacing
    offset = np.stack(np.meshgrid(np.arange(BLOCK), np.arange(BLOCK)), -1).reshape(-1, 2)
    i, j = (corner[near][:, None] + offset).reshape(-1, 2).T
    return spacing * np.stack([i + 0.5 * (j % 2), ROW * j], -1)


def merged(points: Floats, distance: float, size: SizeField) -> Floats:
    """Points with every group closer than `distance` wanted lengths replaced by its mean."""
    if len(points) < 2:
        return points
    pairs = cKDTree(points).query_pairs(distance * size.coarsest, output_type="ndarray")
    if not isinstance(size, UniformSize):
        wanted = size.at(points)[pairs].min(axis=1)
        apart = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
        pairs = pairs[apart < distance * wanted]
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(points),) * 2)
    groups, label = connected_components(graph, directed=False)
    count = np.bincount(label, minlength=groups)
    return np.stack([np.bincount(label, points[:, k], groups) / count for k in (0, 1)], -1)
