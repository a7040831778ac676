"""Layers with a natural state of their own, pulled back to the flat sheet.

A layer that shrinks has the natural stretch F_g: U = I + e in the plane, and 1/det U through its
thickness if it keeps its volume, 1 if not. Its energy is that of Saint-Venant and Kirchhoff for
the strain from the natural state. In the flat sheet, where programs integrate, the same energy is

    W = J_g · ½ C_ref : (E − E_g) : (E − E_g),   E_g = ½ (F_gᵀ F_g − I),
    C_ref^IJKL = λ G^IJ G^KL + μ (G^IK G^JL + G^IL G^JK),   G = (F_gᵀ F_g)⁻¹,   J_g = det F_g,

with Green and Lagrange's strain E of the flat sheet. Nothing is left out.
"""

from __future__ import annotations

import numpy as np

from sheetmorph.geometry.mesh import Floats

VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Order of the strain components xx, yy, zz, xy, xz, yz."""

UPPER = tuple((row, column) for column in range(6) for row in range(column + 1))
"""Places of the 21 constants of an anisotropic material, column by column of the upper half.

D1111, D1122, D2222, D1133, D2233, D3333, D1112, D2212, D3312, D1212, ….
"""


def natural_metric(eigenstrain: Floats, thickening: bool = True) -> Floats:
    """F_gᵀ F_g of layers with these strains, shape (n, 3, 3).

    Args:
        eigenstrain: e11, e22, e12 (engineering strain L/L0 − 1 along the axes; e12 is the
            component of the tensor), shape (n, 3).
        thickening: True where a layer keeps its volume.
    """
    e11, e22, e12 = np.asarray(eigenstrain, dtype=np.float64).T
    stretch = np.zeros((len(e11), 3, 3))
    stretch[:, 0, 0], stretch[:, 1, 1] = 1.0 + e11, 1.0 + e22
    stretch[:, 0, 1] = stretch[:, 1, 0] = e12
    area = (1.0 + e11) * (1.0 + e22) - e12**2
    stretch[:, 2, 2] = 1.0 / area if thickening else 1.0
    return np.asarray(stretch @ stretch)


def natural_strain(metric: Floats) -> Floats:
    """E_g in the order of `VOIGT`, components of the tensor, shape (n, 6)."""
    green = 0.5 * (metric - np.eye(3))
    return np.stack([green[:, row, column] for row, column in VOIGT], axis=1)


def pulled_back_stiffness(metric: Floats, young: float, poisson: float) -> Floats:
    """The 21 constants of J_g C_ref [Pa] in the order of `UPPER`, shape (n, 21).

    Args:
        metric: F_gᵀ F_g, shape (n, 3, 3).
        young: Young's modulus of the natural state [Pa].
        poisson: its Poisson's ratio.
    """
    lame = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    shear = young / (2.0 * (1.0 + poisson))
    inverse = np.linalg.inv(metric)
    volume = np.sqrt(np.linalg.det(metric))

    def component(first: int, second: int) -> Floats:
        (i, j), (k, m) = VOIGT[first], VOIGT[second]
        g = inverse
        shears = g[:, i, k] * g[:, j, m] + g[:, i, m] * g[:, j, k]
        return np.asarray(volume * (lame * g[:, i, j] * g[:, k, m] + shear * shears))

    return np.stack([component(row, column) for row, column in UPPER], axis=1)
