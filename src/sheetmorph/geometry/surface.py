"""Measures of a deformed sheet: strains, fold angles, normals, curvatures, extents.

Every function takes positions of one state, shape (V, 3), or of all states at once, shape
(S, V, 3), and returns one row of values or one per state.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats

Indices = NDArray[np.integer]
Width = Literal["feret_max", "feret_min", "x", "y", "side"]


def edge_lengths(positions: ArrayLike, edges: Indices) -> Floats:
    """Edge lengths [m], shape (..., E)."""
    x = np.asarray(positions, dtype=np.float64)
    return np.asarray(_norm(x[..., edges[:, 1], :] - x[..., edges[:, 0], :]))


def edge_strain(positions: ArrayLike, edges: Indices, rest_lengths: Floats) -> Floats:
    """Engineering strain l/l0 − 1 of the edges, shape (..., E).

    Args:
        rest_lengths: l0 [m], shape (E,).
    """
    strain = edge_lengths(positions, edges)
    strain /= rest_lengths
    strain -= 1.0
    return strain


def dihedral_angles(positions: ArrayLike, hinges: Indices) -> Floats:
    """Signed angle between the normals of triangles abc and adb about a→b [rad].

    Zero when flat, positive where the hinge is a ridge seen from +z (the side from which
    abc runs counter-clockwise), negative where it is a valley. Reversing a hinge (b, a, d, c)
    does not change it.

    Args:
        hinges: nodes (a, b, c, d), shape (H, 4).

    Returns:
        Angles in (−π, π], shape (..., H).
    """
    x = np.asarray(positions, dtype=np.float64)
    a, b, c, d = (x[..., hinges[:, k], :] for k in range(4))
    along = b - a
    left = np.cross(along, c - a)
    right = np.cross(d - a, along)
    sine = _dot(np.cross(left, right), along) / _norm(along)
    return np.asarray(np.arctan2(sine, _dot(left, right)))


def triangle_normals(positions: ArrayLike, triangles: Indices) -> Floats:
    """Unit normals of the triangles, +z for a flat sheet, shape (..., T, 3)."""
    normals = _area_vectors(positions, triangles)
    normals /= np.maximum(_norm(normals), np.finfo(float).tiny)[..., None]
    return normals


def frames_of(normals: Floats) -> Floats:
    """Two unit vectors in the plane of each triangle, see `SheetMesh.triangle_frames`, (T, 2, 3).

    Args:
        normals: unit normals of the triangles, shape (T, 3).
    """
    first = np.zeros_like(normals)
    steep = np.abs(normals[:, 0]) > 1.0 - 1e-9
    first[:, 0] = 1.0
    first[steep] = (0.0, 0.0, 1.0)
    first -= (first * normals).sum(axis=1)[:, None] * normals
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(normals, first)], axis=1)


def triangle_areas(positions: ArrayLike, triangles: Indices) -> Floats:
    """Areas of the triangles [m²], shape (..., T)."""
    return np.asarray(_norm(_area_vectors(positions, triangles)))


def smallest_angles(positions: ArrayLike, triangles: Indices) -> Floats:
    """Smallest angle of each triangle [rad], shape (T,), of one state of shape (V, 3)."""
    corners = np.asarray(positions, dtype=np.float64)[triangles]
    angles = []
    for k in range(3):
        u = corners[:, (k + 1) % 3] - corners[:, k]
        v = corners[:, (k + 2) % 3] - corners[:, k]
        angles.append(np.arctan2(_norm(np.cross(u, v)), _dot(u, v)))
    return np.asarray(np.min(angles, axis=0))


def vertex_normals(positions: ArrayLike, triangles: Indices) -> Floats:
    """Unit normals at the nodes, the area-weighted mean of the triangles around, (..., V, 3)."""
    x = np.asarray(positions, dtype=np.float64)
    vectors = _area_vectors(x, triangles)
    normals = np.empty(x.shape)
    for state in np.ndindex(x.shape[:-2]):
        for k in range(3):
            normals[state][:, k] = _gather(triangles, vectors[state][:, k], x.shape[-2])
    normals /= np.maximum(_norm(normals), np.finfo(float).tiny)[..., None]
    return normals


def mean_curvature(positions: ArrayLike, triangles: Indices) -> Floats:
    """Mean curvature (κ1 + κ2)/2 at the nodes [1/m], shape (..., V).

    Cotangent Laplacian over the mixed area, along the vertex normal (Meyer, Desbrun,
    Schröder & Barr 2003, eq. 8). Positive where the sheet is a dome seen from +z, the sign
    of `dihedral_angles`: a sphere of radius R with outward normals has 1/R. On the rim,
    where the Laplacian is one-sided, a node takes the mean of its inner neighbours, zero
    if it has none.
    """
    x = np.asarray(positions, dtype=np.float64)
    count = x.shape[-2]
    normals = vertex_normals(x, triangles)
    rim = _rim_nodes(triangles, count)
    starts, ends = _inner_neighbours(triangles, rim, count)
    result = np.empty(x.shape[:-1])
    for state in np.ndindex(x.shape[:-2]):
        p = x[state]
        cotangent, _, area = _corners(p, triangles)
        laplacian = np.zeros((count, 3))
        for k in range(3):
            i, j = triangles[:, (k + 1) % 3], triangles[:, (k + 2) % 3]
            pull = 0.5 * cotangent[:, k, None] * (p[j] - p[i])
            for axis in range(3):
                laplacian[:, axis] += np.bincount(i, pull[:, axis], count)
                laplacian[:, axis] -= np.bincount(j, pull[:, axis], count)
        value = -0.5 * _dot(laplacian, normals[state]) / area
        value[rim] = 0.0
        inner = np.bincount(starts, minlength=count)
        spread = np.bincount(starts, value[ends], count)
        value[rim] = spread[rim] / np.maximum(inner[rim], 1)
        result[state] = value
    return result


def gaussian_curvature(positions: ArrayLike, triangles: Indices) -> Floats:
    """Gaussian curvature κ1 κ2 at the nodes [1/m²], shape (..., V); zero on the rim.

    Angle defect 2π − Σ angles over the mixed area (Meyer et al. 2003, eq. 9).
    """
    x = np.asarray(positions, dtype=np.float64)
    count = x.shape[-2]
    rim = _rim_nodes(triangles, count)
    result = np.empty(x.shape[:-1])
    for state in np.ndindex(x.shape[:-2]):
        _, angles, area = _corners(x[state], triangles)
        total = np.bincount(triangles.ravel(), angles.ravel(), count)
        result[state] = (2.0 * np.pi - total) / area
    result[..., rim] = 0.0
    return result


def aspect_ratio(positions: ArrayLike, width: Width = "feret_max", azimuth: float = 0.0) -> Floats:
    """Height over in-plane width, h/d, shape (...).

    h is the peak-to-peak height along z, d the `in_plane_width`. NaN where the width is zero.

    Raises:
        InputError: `width` is none of these.
    """
    across = in_plane_width(positions, width, azimuth)
    height = np.ptp(np.asarray(positions, dtype=np.float64)[..., 2], axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(across > 0.0, height / across, np.nan))


def in_plane_width(
    positions: ArrayLike, width: Width = "feret_max", azimuth: float = 0.0
) -> Floats:
    """The width d of the projection to the xy plane [m], shape (...).

    - "feret_max": largest caliper width, the largest distance between two nodes; no
      rotation about z changes it.
    - "feret_min": smallest caliper width, between the closest parallel lines that hold all
      nodes; no rotation about z changes it either.
    - "x": extent along x, what a side view along y shows; "y": extent along y.
    - "side": extent across the view of a camera that looks from the side, see `side_view`.

    Args:
        azimuth: direction of that camera [rad], for "side" alone.

    Raises:
        InputError: `width` is none of these.
    """
    if width not in get_args(Width):
        raise InputError(
            "no such width", key="width", value=width, allowed=", ".join(get_args(Width))
        )
    x = np.asarray(positions, dtype=np.float64)
    if width == "side":
        return np.asarray(side_view(x, azimuth)[..., 0])
    if width in ("x", "y"):
        return np.asarray(np.ptp(x[..., "xy".index(width)], axis=-1))
    across = np.empty(x.shape[:-2])
    for state in np.ndindex(across.shape):
        across[state] = _caliper(x[state][:, :2], width == "feret_max")
    return across


def side_view(positions: ArrayLike, azimuth: float = 0.0, elevation: float = 0.0) -> Floats:
    """Width and height of the shadow in a parallel view from the side [m], shape (..., 2).

    Args:
        azimuth: by how much the camera is turned about z [rad]; at 0 it looks along +y, with
            x to the right, at π/2 along −x.
        elevation: by how much it looks down [rad]; at 0 the height is that of the shape.
    """
    x = np.asarray(positions, dtype=np.float64)
    right = x[..., 0] * np.cos(azimuth) + x[..., 1] * np.sin(azimuth)
    away = x[..., 1] * np.cos(azimuth) - x[..., 0] * np.sin(azimuth)
    up = x[..., 2] * np.cos(elevation) + away * np.sin(elevation)
    return np.stack([np.ptp(right, axis=-1), np.ptp(up, axis=-1)], axis=-1)


def _caliper(points: Floats, largest: bool) -> float:
    from scipy.spatial import ConvexHull, QhullError
    from scipy.spatial.distance import pdist

    try:
        hull = points[ConvexHull(points).vertices]
    except QhullError:  # all nodes on one line
        return float(np.linalg.norm(np.ptp(points, axis=0))) if largest else 0.0
    if largest:
        return float(pdist(hull).max())
    sides = np.roll(hull, -1, axis=0) - hull
    normals = np.stack([-sides[:, 1], sides[:, 0]], -1) / _norm(sides)[:, None]
    return float(np.ptp(hull @ normals.T, axis=0).min())


def _corners(points: Floats, triangles: Indices) -> tuple[Floats, Floats, Floats]:
    """Cotangents and angles at the corners, (T, 3) each, and mixed areas at the nodes, (V,)."""
    corners = points[triangles]
    cotangent = np.empty(triangles.shape)
    angle = np.empty(triangles.shape)
    square = np.empty(triangles.shape)  # squared length of the side opposite each corner
    doubled = np.empty(len(triangles))
    for k in range(3):
        u = corners[:, (k + 1) % 3] - corners[:, k]
        v = corners[:, (k + 2) % 3] - corners[:, k]
        doubled = _norm(np.cross(u, v))
        dot = _dot(u, v)
        angle[:, k] = np.arctan2(doubled, dot)
        cotangent[:, k] = dot / np.maximum(doubled, np.finfo(float).tiny)
        square[:, k] = _dot(v - u, v - u)
    # Voronoi shares; an obtuse triangle gives half to its obtuse corner, a quarter to others.
    weighted = cotangent * square
    share = (weighted.sum(axis=1, keepdims=True) - weighted) / 8.0
    obtuse = cotangent < 0.0
    wide = obtuse.any(axis=1)
    share[wide] = np.where(obtuse[wide], 0.25, 0.125) * doubled[wide, None]
    area = np.bincount(triangles.ravel(), share.ravel(), len(points))
    return cotangent, angle, np.asarray(area, dtype=np.float64)


def _rim_nodes(triangles: Indices, count: int) -> NDArray[np.bool_]:
    """Nodes on an edge that only one triangle has, shape (V,)."""
    faces = triangles.astype(np.int64)
    halves = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    keys, uses = np.unique(halves.min(axis=1) * count + halves.max(axis=1), return_counts=True)
    single = keys[uses == 1]
    rim = np.zeros(count, dtype=bool)
    rim[single // count] = True
    rim[single % count] = True
    return rim


def _inner_neighbours(
    triangles: Indices, rim: NDArray[np.bool_], count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs (rim node, neighbour off the rim)."""
    faces = triangles.astype(np.int64)
    pairs = np.concatenate([faces[:, [i, j]] for i in range(3) for j in range(3) if i != j])
    pairs = pairs[rim[pairs[:, 0]] & ~rim[pairs[:, 1]]]
    keys = np.unique(pairs[:, 0] * count + pairs[:, 1])
    return keys // count, keys % count


def _area_vectors(positions: ArrayLike, triangles: Indices) -> Floats:
    x = np.asarray(positions, dtype=np.float64)
    a = x[..., triangles[:, 0], :]
    vectors = np.cross(x[..., triangles[:, 1], :] - a, x[..., triangles[:, 2], :] - a)
    vectors *= 0.5
    return np.asarray(vectors)


def _gather(triangles: Indices, values: Floats, count: int) -> Floats:
    """Sum of a value per triangle over the triangles around each node, shape (V,)."""
    return np.asarray(np.bincount(triangles.ravel(), np.repeat(values, 3), count))


def _dot(u: Floats, v: Floats) -> Floats:
    return np.asarray(np.einsum("...k,...k->...", u, v))


def _norm(u: Floats) -> Floats:
    return np.asarray(np.sqrt(_dot(u, u)))
