"""The same disc beyond its bifurcation, rolled up: series in r and θ, see `karman_disc`."""

from __future__ import annotations

import numpy as np

from sheetmorph.core.errors import ComputationError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.proofs.karman_disc import radial_series

TERMS = 8
"""Terms of each series over the radius."""
WAVES = (0, 2, 4, 6)
"""Of deflection and displacements around the disc, which has two planes of symmetry."""

_RADIAL, _WEIGHTS = np.polynomial.legendre.leggauss(24)
_ANGLES = 16
_R = np.repeat(0.5 * (_RADIAL + 1.0), _ANGLES)
_THETA = np.tile((np.arange(_ANGLES) + 0.5) * 0.5 * np.pi / _ANGLES, len(_RADIAL))
_AREA = np.repeat(0.5 * _WEIGHTS, _ANGLES) * _R / _ANGLES
"""A quarter of the disc."""


def half_pipe(natural: float, poisson_ratio: float, start: tuple[float, float]) -> Floats:
    """Kx ≥ Ky of the quadratic surface that fits the rolled disc best.

    Args:
        natural: S = κ0 R²/(4 h), beyond the bifurcation.
        poisson_ratio: ν.
        start: a guess of Kx and Ky.

    Raises:
        ComputationError: Newton's method did not converge.
    """
    maps = _Maps()
    x = np.zeros(maps.count)
    x[0], x[TERMS] = start[0] + start[1], start[0] - start[1]
    for held in (maps.deflections, np.array([], dtype=np.intp)):  # in the plane first, then all
        free = np.setdiff1d(np.arange(maps.count), held)
        x = _balanced(maps, x, free, 4.0 * natural, poisson_ratio)
    deflection = maps.deflection @ x
    terms = [np.ones_like(_R), 2.0 * (_R * np.cos(_THETA)) ** 2, 2.0 * (_R * np.sin(_THETA)) ** 2]
    weight = np.sqrt(_AREA)
    fit = np.linalg.lstsq(np.column_stack(terms) * weight[:, None], deflection * weight, rcond=None)
    return np.sort(fit[0][1:])[::-1]


class _Maps:
    """From coefficients to deflection, slopes, curvatures and linear strains at the points."""

    def __init__(self) -> None:
        radius = _R[:, None]
        columns: list[list[Floats]] = [[], [], []]
        for n in WAVES:
            cos, sin = np.cos(n * _THETA)[:, None], np.sin(n * _THETA)[:, None]
            f, df, ddf = radial_series(_R, max(n, 2), TERMS)
            bend = (
                df / radius - (n / radius) ** 2 * f,
                -n * (df / radius - f / radius**2),
            )
            parts = (
                f * cos,
                df * cos,
                -n * f / radius * sin,
                ddf * cos,
                bend[0] * cos,
                bend[1] * sin,
            )
            columns[0].append(np.stack(parts))
            g, dg, _ = radial_series(_R, abs(n - 1), TERMS)
            columns[1].append(np.stack([dg * cos, g / radius * cos, -n * g / radius * sin]))
            if n:
                around = np.zeros_like(g), n * g / radius * cos, (dg - g / radius) * sin
                columns[2].append(np.stack(around))
        bent, *flat = (np.concatenate(part, axis=2) for part in columns)
        plane = np.concatenate(flat, axis=2)
        sizes = bent.shape[2], plane.shape[2]
        self.count = sum(sizes)
        self.deflections = np.arange(sizes[0])
        wide = np.pad(bent, ((0, 0), (0, 0), (0, sizes[1])))
        self.deflection, self.slope_r, self.slope_t = wide[:3]
        self.curvatures = wide[3:]
        self.strains = np.pad(plane, ((0, 0), (0, 0), (sizes[0], 0)))


def _balanced(
    maps: _Maps, x: Floats, free: np.ndarray[tuple[int], np.dtype[np.intp]], k0: float, nu: float
) -> Floats:
    """Newton's method on the free coefficients."""
    plate = np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]])
    twisting = plate * np.array([1.0, 1.0, 4.0])  # 2 (1 − ν) of the twist, which is no shear
    for _ in range(60):
        r, t = maps.slope_r @ x, maps.slope_t @ x
        strain = maps.strains @ x + np.stack([0.5 * r * r, 0.5 * t * t, r * t])
        force = 12.0 * plate @ strain
        moment = twisting @ (maps.curvatures @ x - np.array([[k0], [k0], [0.0]]))
        slopes = np.stack(
            [
                r[:, None] * maps.slope_r,
                t[:, None] * maps.slope_t,
                r[:, None] * maps.slope_t + t[:, None] * maps.slope_r,
            ]
        )
        rates = maps.strains + slopes
        gradient = np.einsum("p,ip,ipk->k", _AREA, force, rates)
        gradient += np.einsum("p,ip,ipk->k", _AREA, moment, maps.curvatures)
        hessian = _square(rates, 12.0 * plate, rates)
        hessian += _square(maps.curvatures, twisting, maps.curvatures)
        both = np.stack([maps.slope_r, maps.slope_t])
        for i, j, part in ((0, 0, 0), (1, 1, 1), (0, 1, 2), (1, 0, 2)):
            hessian += (both[i].T * (_AREA * force[part])) @ both[j]
        kept = hessian[np.ix_(free, free)]
        step = np.linalg.solve(kept, gradient[free])
        x = x.copy()
        x[free] -= step
        if np.abs(step).max() <= 1e-9 * np.abs(x).max():
            return x
    raise ComputationError("the series of the rolled disc did not converge")


def _square(a: Floats, moduli: Floats, b: Floats) -> Floats:
    """Σ aᵢᵀ moduliᵢⱼ bⱼ over the area."""
    return sum(
        (
            moduli[i, j] * ((a[i].T * _AREA) @ b[j])
            for i in range(3)
            for j in range(3)
            if moduli[i, j]
        ),
        start=np.zeros((a.shape[2], b.shape[2])),
    )
