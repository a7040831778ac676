"""Fewer triangles for a scan that has more than its comparison needs."""

from __future__ import annotations

import numpy as np

from sheetmorph.compare.surface import Surface


def reduced(surface: Surface, triangles: int) -> tuple[Surface, float]:
    """A surface of about so many triangles, by averaging the points in the cells of a grid.

    Vertex clustering (Rossignac and Borrel 1993), but points with opposite normals are not
    averaged, so that the two faces of a sheet stay apart however thin it is. The error is
    that of the chord over one cell.

    Args:
        surface: shape (T, 3) triangles.
        triangles: how many are wanted; a surface with fewer is returned as it is.

    Returns:
        The surface and the width of the cells (0 when nothing was done).
    """
    if len(surface.triangles) <= triangles:
        return surface, 0.0
    corners, count = surface.triangles, len(surface.points)
    # A regular surface has two triangles for each point, one point in each cell.
    cell = float(np.sqrt(2.0 * surface.area / triangles))
    weighted = surface.normals * surface.areas[:, None]
    normals = np.stack(
        [
            sum(np.bincount(corners[:, k], weighted[:, axis], minlength=count) for k in range(3))
            for axis in range(3)
        ],
        axis=1,
    )
    place = ((surface.points - surface.box[0]) / cell).astype(np.int64)
    spans = place.max(axis=0) + 1
    key = (place[:, 0] * spans[1] + place[:, 1]) * spans[2] + place[:, 2]
    first, inside = np.unique(key, return_index=True, return_inverse=True)[1:]
    along = (normals * normals[first][inside.reshape(-1)]).sum(axis=1) >= 0.0
    group = np.unique(2 * inside.reshape(-1) + along, return_inverse=True)[1].reshape(-1)
    members = np.bincount(group)
    points = np.stack([np.bincount(group, surface.points[:, k]) / members for k in range(3)], 1)
    merged = group[corners].astype(np.int64)
    whole = (merged != merged[:, [1, 2, 0]]).all(axis=1)
    return Surface(points, merged[whole]), cell
