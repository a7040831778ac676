"""Neighbours in a triangle soup: what coincides, what hangs together, which way it turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from sheetmorph.geometry.mesh import Floats

Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

# Points are the same when they differ by less than this share of the scan's extent, which
# is about the rounding of single precision; along open edges a little more is closed.
SAME = 1e-6
SEAM = 1e-5
CLOSED = 0.02  # holes that could hold less of the area than this leave a surface closed


@dataclass(frozen=True, eq=False)
class Edges:
    """Edges of a surface.

    Attributes:
        ends: points of every edge, lower first, shape (E, 2).
        of_corner: the edge that follows each corner of each triangle, shape (T, 3).
        uses: number of triangles at each edge, shape (E,).
        turned: edges that two triangles run through in the same direction, which
            neighbours turned the same way never do, shape (E,).
    """

    ends: Indices
    of_corner: Indices
    uses: Indices
    turned: Mask


def weld(points: Floats, triangles: Indices) -> tuple[Floats, Indices]:
    """Make points one that coincide to single precision, and leave out unused ones.

    Returns:
        Points, shape (V', 3), and triangles of them, shape (T, 3).
    """
    low, extent = points.min(axis=0), float(np.ptp(points, axis=0).max())
    cells = np.rint((points - low) * (1.0 / (SAME * extent))).astype(np.int64)
    key = (cells[:, 0] << 42) | (cells[:, 1] << 21) | cells[:, 2]
    first, inverse = np.unique(key, return_index=True, return_inverse=True)[1:]
    corners = inverse[triangles]
    used = np.zeros(len(first), dtype=bool)
    used[corners] = True
    new = np.cumsum(used) - 1
    return points[first[used]], new[corners].astype(np.int64)


def weld_seams(points: Floats, triangles: Indices) -> tuple[Indices, int]:
    """Close cracks: points on open edges that nearly coincide become one.

    Returns:
        The triangles, shape (T, 3), and how many points went.
    """
    edges = edges_of(triangles, len(points))
    rim = np.unique(edges.ends[edges.uses == 1])
    if len(rim) < 2:
        return triangles, 0
    extent = float(np.ptp(points, axis=0).max())
    pairs = cKDTree(points[rim]).query_pairs(SEAM * extent, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(rim),) * 2)
    count, label = connected_components(graph, directed=False)
    target = np.arange(len(points))
    target[rim] = rim[np.unique(label, return_index=True)[1]][label]
    return target[triangles], len(rim) - int(count)


def sound_triangles(points: Floats, triangles: Indices) -> tuple[Mask, Mask]:
    """Which triangles have no area, and which repeat an earlier one, shape (T,) each."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    doubled = np.linalg.norm(np.cross(u, v), axis=1)
    longest = np.maximum((u * u).sum(axis=1), (v * v).sum(axis=1))
    flat = ~(doubled > 1e-10 * longest)
    corners = np.sort(triangles, axis=1)
    pair = _ranks(corners[:, 0] * len(points) + corners[:, 1])
    key = pair * len(points) + corners[:, 2]
    order = np.argsort(key, kind="stable")
    again = np.zeros(len(triangles), dtype=bool)
    again[order[1:]] = key[order[1:]] == key[order[:-1]]
    return flat, again


def edges_of(triangles: Indices, count: int) -> Edges:
    """The edges of triangles, shape (T, 3), over `count` points."""
    start = triangles.ravel()
    end = triangles[:, [1, 2, 0]].ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    keys, inverse, uses = np.unique(low * count + high, return_inverse=True, return_counts=True)
    inverse = inverse.reshape(-1)
    forward = np.bincount(inverse[start < end], minlength=len(keys))
    turned = (uses == 2) & (forward != 1)
    ends = np.stack([keys // count, keys % count], axis=1)
    return Edges(ends, inverse.reshape(-1, 3).astype(np.int64), uses.astype(np.int64), turned)


def components(triangles: Indices, count: int) -> Indices:
    """Number of the connected piece of each triangle (over common points), shape (T,)."""
    pairs = np.concatenate([triangles[:, :2], triangles[:, 1:]])
    graph = coo_array((np.ones(len(pairs), dtype=bool), pairs.T), shape=(count, count))
    label = connected_components(graph, directed=False)[1]
    return _ranks(label[triangles[:, 0]].astype(np.int64))


def loop_lengths(points: Floats, edges: Edges) -> Floats:
    """Lengths of the loops of open edges, longest first; none where a surface is closed."""
    ends = edges.ends[edges.uses == 1]
    graph = coo_array((np.ones(len(ends), dtype=bool), ends.T), shape=(len(points),) * 2)
    label = connected_components(graph, directed=False)[1]
    length = np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1)
    sums = np.bincount(_ranks(label[ends[:, 0]].astype(np.int64)), length)
    return np.sort(sums)[::-1].astype(np.float64)


def is_closed(lengths: Floats, area: float) -> bool:
    """Whether the discs that loops of these lengths could hold are small against an area."""
    return bool((lengths**2).sum() / (4.0 * np.pi) <= CLOSED * area)


def orient(triangles: Indices, areas: Floats, edges: Edges) -> tuple[Indices, Mask]:
    """Turn neighbours the same way; of each patch the larger area stays as it is.

    Returns:
        The triangles, shape (T, 3), and which were turned, shape (T,).
    """
    import igl

    if not edges.turned.any():
        return triangles, np.zeros(len(triangles), dtype=bool)
    turned, patch = igl.bfs_orient(np.ascontiguousarray(triangles))
    # The result starts at any corner, so the direction is told by what follows the first one.
    place = (turned == triangles[:, :1]).argmax(axis=1)
    after = np.take_along_axis(turned, ((place + 1) % 3)[:, None], axis=1)[:, 0]
    other = after != triangles[:, 1]
    share = np.bincount(patch, areas * other) / np.bincount(patch, areas)
    other ^= share[patch] > 0.5
    return np.where(other[:, None], triangles[:, ::-1], triangles), other


def enclosed_volume(points: Floats, triangles: Indices) -> float:
    """Volume inside a closed surface, negative when its normals point inwards."""
    a, b, c = (points[triangles[:, k]] - points.mean(axis=0) for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6.0)


def _ranks(values: Indices) -> Indices:
    return np.unique(values, return_inverse=True)[1].reshape(-1).astype(np.int64)
