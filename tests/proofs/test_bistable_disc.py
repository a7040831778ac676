"""The bistable disc, and what it is measured by."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid, solve_bvp, trapezoid

from sheetmorph.proofs.bilayer_disc import (
    LENS_UNIT,
    POISSON,
    RADIUS,
    THICKNESS,
    DiscSheet,
)
from sheetmorph.proofs.bistable_disc import (
    CRITICAL_K,
    CRITICAL_S,
    PRODUCT,
    dish_curvature,
    pipe_curvatures,
)
from sheetmorph.proofs.karman_disc import bifurcation, dish, stiffness_against_waves
from sheetmorph.proofs.karman_pipe import half_pipe
from sheetmorph.proofs.proof import Proof

NU = POISSON


def curvature_by_differential_equations(natural: float) -> float:
    """K of the dish of constant thickness: von Kármán's equations as a boundary value problem."""
    k0, inner = 4.0 * natural, 1e-2

    def rates(r: np.ndarray, y: np.ndarray) -> np.ndarray:
        u, du, slope, bend = y
        radial = 12.0 * (du + 0.5 * slope**2 + NU * u / r)
        hoop = 12.0 * (u / r + NU * (du + 0.5 * slope**2))
        ddu = ((hoop - radial) / (12.0 * r)) - slope * bend - NU * (du / r - u / r**2)
        moments = (1.0 - NU) * (bend - slope / r)
        ddslope = radial * slope - moments / r - NU * (bend / r - slope / r**2)
        return np.vstack([du, ddu, bend, ddslope])

    def ends(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        radial = b[1] + 0.5 * b[2] ** 2 + NU * b[0]
        moment = b[3] - k0 + NU * (b[2] - k0)
        return np.array([a[0] - inner * a[1], a[2] - inner * a[3], radial, moment])

    r = np.linspace(inner, 1.0, 400)
    found = solve_bvp(
        rates, ends, r, np.vstack([0 * r, 0 * r, r, 1 + 0 * r]), tol=1e-6, max_nodes=50000
    )
    assert found.success
    r = np.linspace(0.0, 1.0, 20001)
    slope = np.where(r > inner, found.sol(r)[2], r / inner * found.sol(inner)[2])
    w = cumulative_trapezoid(slope, r, initial=0.0)
    parabola = r * r - 0.5
    fit = trapezoid(parabola * w * r, r) / trapezoid(parabola**2 * r, r)
    return float(fit / 2.0)


@pytest.mark.parametrize("natural", [0.3, 1.3, 4.0])
def test_series_solve_the_differential_equations(natural: float) -> None:
    expected = curvature_by_differential_equations(natural)
    assert dish(natural, NU).curvature == pytest.approx(expected, rel=1e-5)


def test_bifurcation_of_constant_thickness() -> None:
    s, k = bifurcation(NU)
    assert (s, k) == pytest.approx((1.36210, 0.81500), rel=1e-5)
    assert stiffness_against_waves(dish(0.9 * s, NU), NU) > 0
    assert stiffness_against_waves(dish(1.1 * s, NU), NU) < 0


def test_the_series_of_the_half_pipe_holds_the_dish_too() -> None:
    """Before the bifurcation the series in r and θ returns to the dish of the other."""
    known = dish(1.0, NU).curvature
    assert half_pipe(1.0, NU, (0.8, 0.6)) == pytest.approx([known, known], rel=1e-6)


def test_half_pipes_part_from_the_dish_at_its_bifurcation() -> None:
    """(Kx − Ky)² over S² is zero where the second variation of the dish says, to its curve."""
    near = np.array([1.38, 1.40])
    parts = [np.ptp(half_pipe(s, NU, (1.0, 0.65))) ** 2 for s in near]
    slope = (parts[1] - parts[0]) / (near[1] ** 2 - near[0] ** 2)
    assert near[0] ** 2 - parts[0] / slope == pytest.approx(bifurcation(NU)[0] ** 2, rel=2e-3)


def test_a_flat_disc_bends_as_a_plate() -> None:
    """Without a natural curvature the stiffness against waves is that of bending alone."""
    assert stiffness_against_waves(dish(0.0, NU), NU) > 0
    assert dish(1e-4, NU).curvature == pytest.approx(1e-4, rel=1e-6)


def test_branches_meet_at_the_bifurcation() -> None:
    assert dish_curvature(CRITICAL_S) == pytest.approx(CRITICAL_K, rel=1e-12)
    just = pipe_curvatures(CRITICAL_S * (1 + 1e-12))
    assert just == pytest.approx((CRITICAL_K, CRITICAL_K), rel=1e-5)
    assert np.prod(pipe_curvatures(3.0)) == pytest.approx(PRODUCT)


def test_a_lens_of_uniform_curvature_is_in_balance() -> None:
    """Mansfield's lens: from its stress function to the coefficient that `LENS_UNIT` stands for.

    With N = cof ∇∇φ, φ = A (1 − r²)³ and h = 1 − r² (R = h0 = E = 1), compatibility gives A and
    balance of moments gives κ0 − κ, both the same everywhere.
    """
    rng = np.random.default_rng(0)
    kx, ky, d0 = 1.3, 0.4, 1.0 / (12.0 * (1.0 - NU**2))
    step = 1e-3

    def strain(x: float, y: float, a: float) -> tuple[float, float, float]:
        h = 1.0 - x * x - y * y
        xx, yy, xy = (
            a * (24.0 * x * x * h - 6.0 * h * h),
            a * (24.0 * y * y * h - 6.0 * h * h),
            a * 24.0 * x * y * h,
        )
        return (yy - NU * xx) / h, (xx - NU * yy) / h, -(1.0 + NU) * xy / h

    a = -kx * ky / (24.0 * (7.0 + NU))
    for x, y in rng.uniform(-0.6, 0.6, (4, 2)):
        e = [[strain(x + i * step, y + j * step, a) for j in (-1, 0, 1)] for i in (-1, 0, 1)]
        xx, yy, xy = np.array(e).transpose(2, 0, 1)
        incompatible = (
            (xx[1, 2] - 2 * xx[1, 1] + xx[1, 0])
            + (yy[2, 1] - 2 * yy[1, 1] + yy[0, 1])
            - 0.5 * (xy[2, 2] - xy[2, 0] - xy[0, 2] + xy[0, 0])
        ) / step**2
        assert incompatible == pytest.approx(-kx * ky, rel=1e-4)
    # D0 (1 − r²)³ m balances φ where D0 mx = A ky; for a dish that is S = K (1 + (1 − ν) K²).
    k = 0.7 * LENS_UNIT
    more = -(-k * k / (24.0 * (7.0 + NU))) * k / (d0 * (1.0 + NU))
    assert (k + more) / LENS_UNIT == pytest.approx(0.7 * (1 + (1 - NU) * 0.7**2), rel=1e-12)


def test_curvatures_of_known_shapes() -> None:
    for quarter in (True, False):
        sheet = DiscSheet.of(6, 1.0, lens=False, quarter=quarter)
        x = sheet.problem.start.copy()
        nodes = sheet.problem.mesh.nodes
        x[2 : nodes.size : 3] = 0.5 * (0.3 * nodes[:, 0] ** 2 - 0.2 * nodes[:, 1] ** 2)
        unit = 4.0 * THICKNESS / RADIUS**2
        assert sheet.curvatures(x) * unit == pytest.approx([0.3, -0.2], rel=1e-9)


@pytest.mark.slow
def test_bistable_disc(proven: Callable[[str], Proof]) -> None:
    proof = proven("bistable_disc")
    assert len(proof.checks) == 62
    dishes = [c.error for c in proof.checks if c.id.startswith("lens") and "K at S =" in c.what]
    assert len(dishes) == 10
    assert max(dishes) < 1e-3
