"""A triangle surface in space: areas, samples, and the nearest point on it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.tree import Tree
from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.surface import mean_curvature, triangle_areas, triangle_normals

Indices = NDArray[np.int64]

FLAT = 1e-12  # a surface with less area than this share of its size squared is a line


@dataclass(frozen=True, eq=False)
class Samples:
    """Points on a surface, spread evenly over its area.

    Attributes:
        points: shape (n, 3).
        triangle: on which triangle each lies, shape (n,).
    """

    points: Floats
    triangle: Indices


@dataclass(frozen=True, eq=False)
class Nearest:
    """What of a surface is nearest to each of n points.

    Attributes:
        distance: not negative, shape (n,).
        triangle: shape (n,).
        point: shape (n, 3).
    """

    distance: Floats
    triangle: Indices
    point: Floats


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles in space; they need not be closed, connected or manifold.

    Attributes:
        points: corners [m] (or the unit of a scan), shape (V, 3).
        triangles: indices of corners, shape (T, 3).

    Raises:
        InputError: the arrays have other shapes, hold numbers that are not finite or
            corners that do not exist, or the surface has no area.
    """

    points: Floats
    triangles: Indices

    def __post_init__(self) -> None:
        points = np.ascontiguousarray(self.points, dtype=np.float64)
        triangles = np.ascontiguousarray(self.triangles, dtype=np.int64)
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "triangles", triangles)
        if points.ndim != 2 or points.shape[1] != 3 or not len(points):
            raise InputError("a surface needs points with 3 coordinates each", value=points.shape)
        if triangles.ndim != 2 or triangles.shape[1] != 3 or not len(triangles):
            raise InputError("a surface needs triangles of 3 corners each", value=triangles.shape)
        if not np.isfinite(points).all():
            raise InputError("the surface has a coordinate that is not a finite number")
        if triangles.min() < 0 or triangles.max() >= len(points):
            raise InputError(
                "a triangle of the surface refers to a point that does not exist",
                allowed=f"0 to {len(points) - 1}",
            )
        if not self.area > FLAT * self.size**2:
            raise InputError("the surface has no area: all its points lie on one line")

    @cached_property
    def areas(self) -> Floats:
        """Areas of the triangles, shape (T,)."""
        return triangle_areas(self.points, self.triangles)

    @cached_property
    def area(self) -> float:
        """Area of the whole."""
        return float(self.areas.sum())

    @cached_property
    def normals(self) -> Floats:
        """Unit normals of the triangles, zero where a triangle has no area, shape (T, 3)."""
        return triangle_normals(self.points, self.triangles)

    @cached_property
    def used(self) -> Indices:
        """Points that a triangle uses, increasing."""
        used = np.zeros(len(self.points), dtype=bool)
        used[self.triangles] = True
        return np.flatnonzero(used)

    @cached_property
    def box(self) -> Floats:
        """Lowest and highest corner of the box around the triangles, shape (2, 3)."""
        corners = self.points[self.used]
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    @cached_property
    def size(self) -> float:
        """Diagonal of the bounding box."""
        return float(np.linalg.norm(self.box[1] - self.box[0]))

    @cached_property
    def centroid(self) -> Floats:
        """Centre of the area, shape (3,)."""
        centres = self.points[self.triangles].mean(axis=1)
        return np.asarray(self.areas @ centres / self.area)

    @cached_property
    def radius(self) -> float:
        """Root mean square distance of the area from its centroid."""
        middle = self.points[self.triangles] - self.centroid
        # Exact for a triangle with its corners: ∫|x|² = A/12 (Σ|xᵢ|² + |Σxᵢ|²).
        second = (middle**2).sum(axis=(1, 2)) + (middle.sum(axis=1) ** 2).sum(axis=1)
        return float(np.sqrt(self.areas @ second / (12.0 * self.area)))

    @cached_property
    def rim_edges(self) -> Indices:
        """Edges that only one triangle has, shape (R, 2)."""
        faces = self.triangles
        halves = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), 1)
        count = len(self.points)
        keys, uses = np.unique(halves[:, 0] * count + halves[:, 1], return_counts=True)
        single = keys[uses == 1]
        return np.stack([single // count, single % count], axis=1)

    @cached_property
    def rim_triangles(self) -> NDArray[np.bool_]:
        """Triangles with a corner on the rim, shape (T,)."""
        on_rim = np.zeros(len(self.points), dtype=bool)
        on_rim[self.rim_edges] = True
        return np.asarray(on_rim[self.triangles].any(axis=1))

    @cached_property
    def mean_curvature(self) -> Floats:
        """Mean curvature at the points, not smoothed, shape (V,); zero at points not used.

        Positive where the surface is a dome seen from the side of its normals.
        """
        values = mean_curvature(self.points[self.used], np.searchsorted(self.used, self.triangles))
        result = np.zeros(len(self.points))
        result[self.used] = np.where(np.isfinite(values), values, 0.0)
        return result

    def sample(self, count: int, seed: int = 0) -> Samples:
        """Points spread evenly over the area; the same seed gives the same points.

        The triangles are drawn at even steps of the summed area, so that the number of
        points on any part is right to within one or two; where they lie on a triangle is
        left to chance (Osada et al. 2002, eq. 1).
        """
        random = np.random.default_rng(seed)
        steps = (np.arange(count) + random.random(count)) / count * self.area
        triangle = np.searchsorted(np.cumsum(self.areas), steps, side="right")
        triangle = np.minimum(triangle, len(self.triangles) - 1)
        root, along = np.sqrt(random.random(count)), random.random(count)
        weights = np.stack([1.0 - root, root * (1.0 - along), root * along], axis=1)
        corners = self.points[self.triangles[triangle]]
        return Samples(np.einsum("nk,nkd->nd", weights, corners), triangle)

    def nearest(self, points: Floats) -> Nearest:
        """The nearest point of the surface to each of n points, exactly.

        Args:
            points: shape (n, 3).
        """
        unit, centre = self.size, self._centre
        square, triangle, point = self._tree.nearest((points - centre) / unit)
        return Nearest(unit * np.sqrt(square), self._solid[triangle], unit * point + centre)

    def meets(self, points: Floats, directions: Floats) -> tuple[Indices, Floats]:
        """The first triangle that a ray from each of n points meets, and how far away.

        A triangle that the point lies on is not met.

        Args:
            points: shape (n, 3).
            directions: unit vectors, shape (n, 3).

        Returns:
            Triangles, -1 where there is none, and distances, infinite there, shape (n,) each.
        """
        tree, corners, faces = self._rays
        unit, centre, lift = self.size, self._centre, 1e-6
        start = np.ascontiguousarray((points - centre) / unit + lift * directions)
        hit, length, _ = tree.intersect_ray_first(
            corners, faces, start, np.ascontiguousarray(directions)
        )
        met = hit >= 0
        triangle = np.where(met, self._solid[np.where(met, hit, 0)], -1)
        return triangle, np.where(met, unit * (np.where(met, length, 0.0) + lift), np.inf)

    def moved(self, pose: Similarity) -> Surface:
        """The surface in another pose; where the map mirrors, the triangles are turned over."""
        triangles = self.triangles[:, ::-1] if pose.mirrors else self.triangles
        return Surface(pose.apply(self.points), triangles)

    def part(self, mask: NDArray[np.bool_]) -> Surface:
        """The triangles of a mask, shape (T,), and only the points they use."""
        kept, corners = np.unique(self.triangles[mask], return_inverse=True)
        return Surface(self.points[kept], corners.reshape(-1, 3))

    @cached_property
    def _solid(self) -> Indices:
        """Triangles with an area; those without may have no nearest point in floats."""
        return np.flatnonzero(self.areas > FLAT**2 * self.size**2)

    @cached_property
    def _centre(self) -> Floats:
        return np.asarray(self.box.mean(axis=0))

    @cached_property
    def _unit_points(self) -> Floats:
        """The corners, moved to the origin and to size 1."""
        return np.ascontiguousarray((self.points - self._centre) / self.size)

    @cached_property
    def _tree(self) -> Tree:
        return Tree.over(self._unit_points, self.triangles[self._solid])

    @cached_property
    def _rays(self) -> tuple[Any, Floats, Indices]:
        """Bounding volume tree for rays, and what it is over."""
        import igl

        faces = np.ascontiguousarray(self.triangles[self._solid])
        tree = igl.AABB()
        tree.init(self._unit_points, faces)
        return tree, self._unit_points, faces
