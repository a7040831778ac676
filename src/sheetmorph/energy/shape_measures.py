"""From the six shape measures of a triangle to its fundamental forms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sheetmorph.energy.laminate_kernel import measure_shapes
from sheetmorph.energy.laminate_patch import Patch
from sheetmorph.geometry.mesh import Floats


@dataclass(frozen=True, eq=False)
class ShapeMeasures:
    """The measures p = (l0², l1², l2², β0, β1, β2) of the triangles, and what they stand for.

    In the frame of a triangle, with the gradients ∇λ_i of its corners' area coordinates at rest,
    a = −½ Σ l_i² (∇λ_j ∇λ_kᵀ + ∇λ_k ∇λ_jᵀ) over {i, j, k}, and b = −Σ β_i ∇λ_i ∇λ_iᵀ.

    Attributes:
        strain_maps: from p to (½ a, −b), each as (11, 22, 2·12), shape (T, 6, 6).
        strain_inverses: back, shape (T, 6, 6).
        areas: at rest [m²], shape (T,).
        reference_curvatures: −b of the sheet at rest [1/m], shape (T, 3).
    """

    strain_maps: Floats
    strain_inverses: Floats
    areas: Floats
    reference_curvatures: Floats

    @classmethod
    def of(cls, nodes: Floats, patch: Patch, frames: Floats) -> ShapeMeasures:
        """The maps of a sheet at rest.

        Args:
            nodes: positions at rest [m], shape (V, 3).
            patch: its triangles.
            frames: two orthonormal vectors in the plane of each triangle, shape (T, 2, 3).
        """
        maps, areas = strain_maps(nodes[patch.stencil[:, :3]], frames)
        inverses = np.zeros_like(maps)
        inverses[:, :3, :3] = np.linalg.inv(maps[:, :3, :3])
        inverses[:, 3:, 3:] = np.linalg.inv(maps[:, 3:, 3:])
        resting = measures_at(nodes, patch)[:, 3:]
        curvatures = np.einsum("tij,tj->ti", maps[:, 3:, 3:], resting)
        return cls(maps, inverses, areas, curvatures)

    def forms(self, x: Floats, patch: Patch) -> tuple[Floats, Floats]:
        """First and second fundamental form of the triangles at the degrees of freedom x.

        Returns:
            (a11, a22, a12), without unit, and (b11, b22, b12) [1/m], shape (T, 3) each.
        """
        measures = measures_at(x.reshape(-1, 3), patch)
        strains = np.einsum("tij,tj->ti", self.strain_maps, measures)
        first = strains[:, :3] * [2.0, 2.0, 1.0]
        second = strains[:, 3:] * [-1.0, -1.0, -0.5]
        return np.asarray(first), np.asarray(second)


def strain_maps(corners: Floats, frames: Floats) -> tuple[Floats, Floats]:
    """From p to (½ a, −b) of triangles, shape (T, 6, 6), and their areas [m²], shape (T,).

    Args:
        corners: at rest [m], shape (T, 3, 3).
        frames: two orthonormal vectors in the plane of each triangle, shape (T, 2, 3).
    """
    plane = np.einsum("tcx,tdx->tcd", corners - corners[:, :1], frames)
    u, v = plane[:, 1], plane[:, 2]
    double = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    second = np.stack([v[:, 1], -v[:, 0]], axis=1) / double[:, None]
    third = np.stack([-u[:, 1], u[:, 0]], axis=1) / double[:, None]
    slopes = np.stack([-second - third, second, third], axis=1)  # ∇λ, shape (T, 3, 2)
    maps = np.zeros((len(corners), 6, 6))
    for i in range(3):
        p, q = slopes[:, (i + 1) % 3], slopes[:, (i + 2) % 3]
        own = slopes[:, i]
        maps[:, 0, i] = -0.5 * p[:, 0] * q[:, 0]
        maps[:, 1, i] = -0.5 * p[:, 1] * q[:, 1]
        maps[:, 2, i] = -0.5 * (p[:, 0] * q[:, 1] + p[:, 1] * q[:, 0])
        maps[:, 3, 3 + i] = own[:, 0] ** 2
        maps[:, 4, 3 + i] = own[:, 1] ** 2
        maps[:, 5, 3 + i] = 2.0 * own[:, 0] * own[:, 1]
    return maps, np.asarray(0.5 * double)


def measures_at(rows: Floats, patch: Patch) -> Floats:
    """The measures p of the triangles, shape (T, 6).

    Args:
        rows: degrees of freedom in rows of three; without rows for the directors, none turns.
        patch: the triangles.
    """
    missing = int(patch.directors.max()) // 3 + 1 - len(rows)
    if missing > 0:
        rows = np.concatenate([rows, np.zeros((missing, 3))])
    found = np.empty((len(patch.stencil), 6))
    measure_shapes(
        np.ascontiguousarray(rows),
        patch.stencil,
        patch.directors,
        patch.share,
        patch.turn,
        patch.lean,
        patch.flap,
        found,
    )
    return found
