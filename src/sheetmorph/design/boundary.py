"""The boundary of a flat region as corners and sides: signed distances and how they change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.design.distance import contains
from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

TOUCHING = 1e-12
"""Points closer to the boundary than this lie on it [m]."""


@dataclass(frozen=True, eq=False)
class Boundary:
    """The rings of a region: M corners, each ring closed by its first corner again.

    Attributes:
        region: polygon or polygons [m], not empty.
        corners: [m], shape (M, 2).
        sides: index of the first corner of each side, the second follows it, shape (S,).
        turns: 1 where the region lies on the left of a side, −1 where on the right, shape (S,).
    """

    region: BaseGeometry
    corners: Floats
    sides: NDArray[np.intp]
    turns: Floats

    @classmethod
    def of(cls, region: BaseGeometry) -> Boundary:
        """The boundary of a region."""
        import shapely

        polygons = shapely.get_parts(region)
        rings, polygon = shapely.get_rings(polygons, return_index=True)
        corners, ring = shapely.get_coordinates(rings, return_index=True)
        sides = np.flatnonzero(ring[1:] == ring[:-1])
        outer = np.concatenate([[True], polygon[1:] != polygon[:-1]])
        turns = np.where(shapely.is_ccw(rings) == outer, 1.0, -1.0)
        return cls(region, corners, sides, turns[ring[sides]])

    def nearest(self, points: Floats) -> Nearest:
        """Signed distance of points, and the places of the boundary next to them.

        Args:
            points: [m], shape (N, 2).
        """
        import shapely

        a, b = self.corners[self.sides], self.corners[self.sides + 1]
        tree = shapely.STRtree(shapely.linestrings(np.stack([a, b], axis=1)))
        _, side = tree.query_nearest(shapely.points(points), all_matches=False)
        along, start = (b - a)[side], a[side]
        squared = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
        share = np.clip(((points - start) * along).sum(axis=1) / squared, 0.0, 1.0)
        away = points - start - share[:, None] * along
        lengths = np.linalg.norm(away, axis=1)
        sign = np.where(contains(self.region, points, 0.0), -1.0, 1.0)
        outward = np.stack([along[:, 1], -along[:, 0]], axis=1)
        outward *= (self.turns[side] / np.sqrt(squared))[:, None]
        apart = lengths > TOUCHING
        outward[apart] = (sign[apart] / lengths[apart])[:, None] * away[apart]
        return Nearest(sign * lengths, self.sides[side], share, outward)

    def distance(self, points: Floats) -> Floats:
        """Distance of points to the boundary [m], negative inside the region, shape (N,)."""
        return self.nearest(points).distance


@dataclass(frozen=True, eq=False)
class Nearest:
    """Signed distances of N points from a boundary.

    Attributes:
        distance: negative inside [m], shape (N,).
        corner: first corner of the nearest side, shape (N,).
        share: from there to the second corner, 0 to 1, where the nearest place is, shape (N,).
        slope: gradient of the signed distance, a unit vector, shape (N, 2).
    """

    distance: Floats
    corner: NDArray[np.intp]
    share: Floats
    slope: Floats

    def onto_corners(self, weights: Floats, count: int) -> Floats:
        """By the corners' positions, the derivative of Σ weight · distance, shape (count, 2).

        A point's distance changes by −slope · (motion of the nearest place), and that place
        moves with the two corners of its side (to first order it does not matter that it slides).

        Args:
            weights: of the points, shape (N,).
            count: number of corners M.
        """
        pull = -weights[:, None] * self.slope
        found = np.zeros((count, 2))
        np.add.at(found, self.corner, (1.0 - self.share)[:, None] * pull)
        np.add.at(found, self.corner + 1, self.share[:, None] * pull)
        return found
