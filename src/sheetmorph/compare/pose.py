"""Similarity transforms: scale, rotation and shift, and the best one for pairs of points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from sheetmorph.geometry.mesh import Floats


@dataclass(frozen=True, eq=False)
class Similarity:
    """The map x → scale · rotation x + translation.

    Attributes:
        scale: positive.
        rotation: orthogonal, shape (3, 3); its determinant is −1 where the map mirrors.
        translation: in the unit of the target [m], shape (3,).
    """

    scale: float
    rotation: Floats
    translation: Floats

    @classmethod
    def identity(cls) -> Similarity:
        """The map that leaves everything where it is."""
        return cls(1.0, np.eye(3), np.zeros(3))

    @property
    def mirrors(self) -> bool:
        """Whether a left hand becomes a right hand."""
        return bool(np.linalg.det(self.rotation) < 0.0)

    @property
    def angle(self) -> float:
        """Angle of the rotation [rad], 0 to π; of what is left after x → −x where it mirrors."""
        proper = -self.rotation if self.mirrors else self.rotation
        # The sine through the skew part: the cosine alone loses half of the digits near 0.
        skew = proper - proper.T
        sine = 0.5 * float(np.sqrt(skew[2, 1] ** 2 + skew[0, 2] ** 2 + skew[1, 0] ** 2))
        return float(np.arctan2(sine, 0.5 * (float(np.trace(proper)) - 1.0)))

    def apply(self, points: ArrayLike) -> Floats:
        """Moved points, shape (..., 3)."""
        moved = _times(points, self.scale * self.rotation)
        moved += self.translation
        return moved

    def turn(self, directions: ArrayLike) -> Floats:
        """Directions turned, not stretched or shifted, shape (..., 3)."""
        return _times(directions, self.rotation)

    def inverse(self) -> Similarity:
        """The map back."""
        back = self.rotation.T
        return Similarity(1.0 / self.scale, back, -(back @ self.translation) / self.scale)

    def after(self, other: Similarity) -> Similarity:
        """The map that does `other` first and then this one."""
        return Similarity(
            self.scale * other.scale,
            self.rotation @ other.rotation,
            self.apply(other.translation),
        )

    def to_json(self) -> dict[str, Any]:
        """Plain numbers: scale, rotation (rows), translation_m."""
        return {
            "scale": float(self.scale),
            "rotation": self.rotation.tolist(),
            "translation_m": self.translation.tolist(),
        }


def best_similarity(
    source: Floats,
    target: Floats,
    weights: Floats | None = None,
    *,
    scale: float | None = None,
    mirror: bool = False,
) -> Similarity:
    """The similarity with the least weighted squared distance from source to target points.

    Closed form of Umeyama (1991, eqs. 40 to 43).

    Args:
        source: points, shape (n, 3).
        target: where each belongs, shape (n, 3).
        weights: not negative, shape (n,); equal when absent.
        scale: held at this value when given.
        mirror: whether the map mirrors; never chosen by the fit.
    """
    share = np.full(len(source), 1.0 / len(source)) if weights is None else weights / weights.sum()
    source_mean, target_mean = share @ source, share @ target
    p, q = source - source_mean, target - target_mean
    left, stretch, right = np.linalg.svd((q * share[:, None]).T @ p)
    signs = np.ones(3)
    signs[2] = (-1.0 if mirror else 1.0) * np.sign(np.linalg.det(left @ right))
    rotation = (left * signs) @ right
    if scale is None:
        spread = float(share @ (p**2).sum(axis=1))
        scale = float((stretch * signs).sum()) / max(spread, np.finfo(float).tiny)
    return Similarity(scale, rotation, target_mean - scale * (rotation @ source_mean))


def _times(vectors: ArrayLike, matrix: Floats) -> Floats:
    """The matrix times each of the vectors, shape (..., 3)."""
    # In memory the transpose has to be one: NumPy multiplies by a view four times as slowly.
    columns = np.ascontiguousarray(matrix.T)
    return np.asarray(np.asarray(vectors, dtype=np.float64) @ columns)
