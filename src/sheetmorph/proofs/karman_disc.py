"""A thin disc of constant thickness that would curve alike both ways, by Ritz's method.

Plate theory for moderate slopes (Föppl, von Kármán) in polar coordinates: the axisymmetric shape,
and the waves cos 2θ that end its stability. Lengths along the disc are over R, deflections over h,
displacements in the plane over h²/R; energies are over D h²/R².
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sheetmorph.geometry.mesh import Floats

TERMS = 10
"""Terms of each series. Ten give ten digits at the bifurcation."""
WAVES = 2

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(48)
_R = 0.5 * (_POINTS + 1.0)
_AREA = 0.5 * _WEIGHTS * _R


@dataclass(frozen=True, eq=False)
class Dish:
    """The axisymmetric shape at a natural curvature κ0.

    Attributes:
        curvature: K = κ R²/(4 h), κ the curvature of the paraboloid that fits the shape best.
        slope: dw/dr at the points of integration.
        forces: radial and hoop, there.
        coefficients: of both series.
    """

    curvature: float
    slope: Floats
    forces: tuple[Floats, Floats]
    coefficients: Floats


def dish(natural: float, poisson_ratio: float, start: Dish | None = None) -> Dish:
    """The axisymmetric shape, by Newton's method.

    Args:
        natural: S = κ0 R²/(4 h).
        poisson_ratio: ν.
        start: a shape nearby; flat by default.
    """
    bend, flat = _series(2), _series(1)
    none, radius = np.zeros_like(_R)[:, None] * bend[0], _R[:, None]
    curvatures = (
        np.hstack([bend[2], none]),
        np.hstack([bend[1] / radius, none]),
    )
    slopes = np.hstack([bend[1], none])
    plane = np.hstack([none, flat[1]]), np.hstack([none, flat[0] / radius])
    x = np.zeros(2 * TERMS) if start is None else start.coefficients
    for _ in range(50):
        slope = slopes @ x
        strains = plane[0] @ x + 0.5 * slope**2, plane[1] @ x
        forces = _resultants(12.0, strains, poisson_ratio)
        bent = curvatures[0] @ x - 4.0 * natural, curvatures[1] @ x - 4.0 * natural
        moments = _resultants(1.0, bent, poisson_ratio)
        rates = plane[0] + slope[:, None] * slopes, plane[1]
        gradient = sum(
            rate.T @ (_AREA * force)
            for rate, force in zip((*rates, *curvatures), (*forces, *moments), strict=True)
        )
        hessian = _energy(12.0, rates, poisson_ratio) + _energy(1.0, curvatures, poisson_ratio)
        step = np.linalg.solve(hessian + _square(slopes, slopes, forces[0]), gradient)
        x = x - step
        if np.abs(step).max() <= 1e-11 * max(1.0, np.abs(x).max()):
            break
    deflection = bend[0] @ x[:TERMS]
    parabola = _R**2 - 0.5
    fit = (_AREA * parabola) @ deflection / ((_AREA * parabola) @ parabola)
    return Dish(0.5 * float(fit), slope, forces, x)


def stiffness_against_waves(state: Dish, poisson_ratio: float) -> float:
    """Smallest eigenvalue of the second variation for waves cos 2θ; negative beyond stability."""
    n, radius = WAVES, _R[:, None]
    bend, flat = _series(n), _series(n - 1)
    none = np.zeros_like(bend[0])
    slope = state.slope[:, None]
    strains = (
        np.hstack([slope * bend[1], flat[1], none]),
        np.hstack([none, flat[0] / radius, n * flat[0] / radius]),
    )
    shear = np.hstack(
        [-n * slope * bend[0] / radius, -n * flat[0] / radius, flat[1] - flat[0] / radius]
    )
    curvatures = bend[2], bend[1] / radius - (n / radius) ** 2 * bend[0]
    twist = n * (bend[1] / radius - bend[0] / radius**2)
    membrane = _energy(12.0, strains, poisson_ratio)
    membrane += 6.0 * (1.0 - poisson_ratio) * _square(shear, shear)
    stiffness = _energy(1.0, curvatures, poisson_ratio)
    stiffness += 2.0 * (1.0 - poisson_ratio) * _square(twist, twist)
    stiffness += _square(bend[1], bend[1], state.forces[0])
    stiffness += _square(n * bend[0] / radius, n * bend[0] / radius, state.forces[1])
    # The displacements in the plane follow the deflection.
    own, across, rest = (
        membrane[:TERMS, :TERMS],
        membrane[:TERMS, TERMS:],
        membrane[TERMS:, TERMS:],
    )
    stiffness += own - across @ np.linalg.solve(rest, across.T)
    return float(np.linalg.eigvalsh(stiffness)[0])


def bifurcation(poisson_ratio: float) -> tuple[float, float]:
    """S and K at which the axisymmetric shape loses its stability."""
    from scipy.optimize import brentq

    critical = brentq(
        lambda s: stiffness_against_waves(dish(s, poisson_ratio), poisson_ratio), 0.8, 2.0
    )
    return float(critical), dish(critical, poisson_ratio).curvature


def radial_series(r: Floats, power: int, terms: int) -> tuple[Floats, Floats, Floats]:
    """r^power Pj(2 r² − 1), its first and second derivatives; shape (points, terms) each."""
    values = np.empty((3, len(r), terms))
    s = 2.0 * r**2 - 1.0
    front = r**power
    rise = power * r ** (power - 1)
    turn = power * (power - 1) * r ** max(power - 2, 0)
    for j in range(terms):
        p, dp, ddp = (np.polynomial.Legendre.basis(j).deriv(k)(s) for k in range(3))
        first, second = 4.0 * r * dp, 16.0 * r**2 * ddp + 4.0 * dp
        values[:, :, j] = (
            front * p,
            rise * p + front * first,
            turn * p + 2.0 * rise * first + front * second,
        )
    return values[0], values[1], values[2]


def _series(power: int) -> tuple[Floats, Floats, Floats]:
    return radial_series(_R, power, TERMS)


def _square(a: Floats, b: Floats, factor: Floats | float = 1.0) -> Floats:
    return np.asarray((a.T * (_AREA * factor)) @ b)


def _energy(scale: float, parts: tuple[Floats, Floats], nu: float) -> Floats:
    """Matrix of scale (p1² + p2² + 2 ν p1 p2)."""
    first, second = parts
    cross = _square(first, second)
    return scale * (_square(first, first) + _square(second, second) + nu * (cross + cross.T))


def _resultants(scale: float, parts: tuple[Floats, Floats], nu: float) -> tuple[Floats, Floats]:
    return scale * (parts[0] + nu * parts[1]), scale * (parts[1] + nu * parts[0])
