"""Where points lie relative to a flat region: inside or not, and how far from its edge."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry


def contains(region: BaseGeometry, points: Floats, tolerance: float) -> NDArray[np.bool_]:
    """Which points lie in the region or within `tolerance` [m] of it, shape (n,).

    Args:
        region: polygon or polygons [m]; may be empty.
        points: [m], shape (n, 2).
    """
    import shapely

    if region.is_empty:
        return np.zeros(len(points), dtype=np.bool_)
    grown = shapely.buffer(region, tolerance, join_style="mitre", quad_segs=2)
    shapely.prepare(grown)
    return np.asarray(shapely.intersects_xy(grown, points[:, 0], points[:, 1]), dtype=np.bool_)


def distance_to_boundary(region: BaseGeometry, points: Floats) -> Floats:
    """Distance of points to the boundary line of the region [m], shape (n,).

    Searches the boundary's segments in a tree, so that many points and many segments cost
    n log n.

    Args:
        region: polygon or polygons [m], not empty.
        points: [m], shape (n, 2).
    """
    import shapely

    segments = _segments(region)
    tree = shapely.STRtree(segments)
    _, distances = tree.query_nearest(
        shapely.points(points), return_distance=True, all_matches=False
    )
    return np.asarray(distances, dtype=np.float64)


def signed_distance(region: BaseGeometry, points: Floats) -> Floats:
    """Distance to the boundary [m], negative inside the region, shape (n,)."""
    inside = contains(region, points, 0.0)
    distances = distance_to_boundary(region, points)
    return np.where(inside, -distances, distances)


def _segments(region: BaseGeometry) -> NDArray[np.object_]:
    import shapely

    rings = shapely.get_rings(shapely.get_parts(region))
    coordinates, ring = shapely.get_coordinates(rings, return_index=True)
    joined = np.flatnonzero(ring[1:] == ring[:-1])
    ends = np.stack([coordinates[joined], coordinates[joined + 1]], axis=1)
    return np.asarray(shapely.linestrings(ends))
