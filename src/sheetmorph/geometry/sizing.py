"""How long the edges of a mesh shall be, place by place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from shapely import Geometry

SPACING = 0.2  # of the finest length: how densely lines are sampled to measure distances


@dataclass(frozen=True)
class UniformSize:
    """The same length everywhere."""

    length: float = 1.0

    @property
    def finest(self) -> float:
        """The shortest length."""
        return self.length

    @property
    def coarsest(self) -> float:
        """The longest length."""
        return self.length

    def at(self, points: Floats) -> Floats:
        """Wanted edge lengths at points of shape (N, 2), shape (N,)."""
        return np.full(len(points), self.length)


@dataclass(frozen=True, eq=False)
class GradedSize:
    """Short on some lines, growing with the distance from them: min(coarsest, finest + growth·d).

    Attributes:
        finest: length on the lines.
        coarsest: length far away.
        growth: change of the length per distance.
        lines: where the length is shortest.
        tree: places on the lines.
    """

    finest: float
    coarsest: float
    growth: float
    lines: Geometry
    tree: cKDTree

    @classmethod
    def around(
        cls, lines: Geometry, finest: float, coarsest: float, growth: float
    ) -> GradedSize | UniformSize:
        """The size that grows from given lines; uniform where there are none."""
        import shapely

        if lines.is_empty or finest >= coarsest:
            return UniformSize(coarsest)
        places = shapely.get_coordinates(shapely.segmentize(lines, SPACING * finest))
        return cls(finest, coarsest, growth, lines, cKDTree(places))

    def at(self, points: Floats) -> Floats:
        """Wanted edge lengths at points of shape (N, 2), shape (N,)."""
        reach = (self.coarsest - self.finest) / self.growth
        distance = self.tree.query(points, distance_upper_bound=reach)[0]
        return np.asarray(np.minimum(self.coarsest, self.finest + self.growth * distance))

    def exactly_at(self, points: Floats) -> Floats:
        """The same with exact distances: slower, but the same wherever a drawing is the same."""
        import shapely

        distance = shapely.distance(self.lines, shapely.points(points))
        return np.asarray(np.minimum(self.coarsest, self.finest + self.growth * distance))


SizeField = UniformSize | GradedSize
