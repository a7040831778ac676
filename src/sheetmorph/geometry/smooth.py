"""Moving the free points of a triangulation until its triangles are nearly equilateral."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.sizing import SizeField, UniformSize
from sheetmorph.geometry.triangulate import Indices, signed_areas


def corner_angles(points: Floats, triangles: Indices) -> Floats:
    """Angle at each corner of each triangle [rad], shape (T, 3); negative when flipped."""
    corners = points[triangles]
    angles = np.empty((len(triangles), 3))
    for k in range(3):
        u = corners[:, (k + 1) % 3] - corners[:, k]
        v = corners[:, (k + 2) % 3] - corners[:, k]
        angles[:, k] = np.arctan2(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], (u * v).sum(axis=1))
    return angles


def relax(
    points: Floats, triangles: Indices, free: NDArray[np.bool_], sweeps: int, size: SizeField
) -> Floats:
    """Move free points to the area-weighted circumcentres of their triangles, `sweeps` times.

    This is the optimal Delaunay smoothing of Chen (2004), "Mesh smoothing schemes based on
    optimal Delaunay triangulations". Circumcentres of obtuse triangles lie outside; they are
    drawn back to the centroid, which keeps the step stable next to boundaries. Steps that
    would turn a triangle over are halved. In a graded mesh triangles weigh by the density
    h⁻⁴ of the wanted length h, which spreads the points as 1/h².

    Args:
        points: positions, shape (N, 2).
        triangles: corner indices, counter-clockwise, shape (T, 3).
        free: points that may move, shape (N,).
        size: wanted edge lengths.

    Returns:
        New positions, shape (N, 2).
    """
    count = len(points)
    flat = triangles.ravel()
    graded = not isinstance(size, UniformSize)
    for _ in range(sweeps):
        area = signed_areas(points, triangles)
        centre = _centres(points, triangles, area)
        if graded:
            area = area * size.at(points[triangles].mean(axis=1)) ** -4
        weight = np.bincount(flat, np.repeat(area, 3), count)
        goal = np.stack(
            [np.bincount(flat, np.repeat(area * centre[:, k], 3), count) for k in (0, 1)], -1
        )
        moved = points.copy()
        moved[free] = goal[free] / np.maximum(weight[free, None], 1e-12)
        points = _without_flips(points, moved, triangles)
    return points


def _centres(points: Floats, triangles: Indices, area: Floats) -> Floats:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    uu, vv = (u * u).sum(axis=1), (v * v).sum(axis=1)
    offset = np.stack([v[:, 1] * uu - u[:, 1] * vv, u[:, 0] * vv - v[:, 0] * uu], -1)
    offset /= np.maximum(4.0 * area[:, None], 1e-12)
    to_centroid = (u + v) / 3.0
    # Beyond 0.35 of the shortest height the circumcentre is out of reach.
    away = offset - to_centroid
    reach = 0.35 * np.sqrt(area)
    length = np.linalg.norm(away, axis=1)
    away *= np.minimum(1.0, reach / np.maximum(length, 1e-12))[:, None]
    return np.asarray(a + to_centroid + away)


def _without_flips(points: Floats, moved: Floats, triangles: Indices) -> Floats:
    """`moved`, with the points of flat or flipped triangles drawn back towards `points`."""
    floor = 0.1 * signed_areas(points, triangles)
    for _ in range(4):
        bad = signed_areas(moved, triangles) < floor
        if not bad.any():
            return moved
        back = np.unique(triangles[bad])
        moved[back] = 0.5 * (moved[back] + points[back])
    moved[back] = points[back]
    for _ in range(10):
        bad = signed_areas(moved, triangles) <= 0.0
        if not bad.any():
            return moved
        back = np.unique(triangles[bad])
        moved[back] = points[back]
    return points
