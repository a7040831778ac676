"""The published model against closed forms, with the order of convergence."""

from __future__ import annotations

import numpy as np
import pytest

from sheetmorph.paper.strips import MODULUS, THICKNESS, cantilever, pulled


@pytest.mark.parametrize("strain", [1e-4, -1e-4], ids=["tension", "compression"])
def test_uniaxial(strain: float) -> None:
    """Y h within 4 % on the finest strip. The spare springs of the rim make the order 1."""
    rows = np.array([8, 16, 32])
    moduli, ratios = np.array([pulled(int(n), strain) for n in rows]).T
    errors = np.abs(moduli / (MODULUS * THICKNESS) - 1)
    order = -np.polyfit(np.log(rows), np.log(errors), 1)[0]
    assert order == pytest.approx(1.0, abs=0.15)
    assert errors[-1] < 0.04
    # What is left at rows → ∞, by Richardson's extrapolation of order 1.
    assert 2 * moduli[-1] - moduli[-2] == pytest.approx(MODULUS * THICKNESS, rel=2e-3)
    assert ratios[-1] == pytest.approx(1 / 3, abs=0.01)


def test_cantilever_under_a_small_end_load() -> None:
    """δ = P L³/(3 EI) with EI = (8/9) D w. The missing hinges of the rim make the order 1."""
    rows = np.array([4, 8, 16])
    load = 1e-2
    deflections = np.array([cantilever(int(n), load, THICKNESS)[0] for n in rows]) / (load / 3)
    errors = np.abs(deflections - 1)
    assert errors[-1] < 5e-4
    order = -np.polyfit(np.log(rows), np.log(errors), 1)[0]
    assert order > 0.9


@pytest.mark.parametrize(
    ("load", "deflection", "shortening"),
    [(1.0, 0.30172, 0.05643), (2.0, 0.49346, 0.16064), (5.0, 0.71379, 0.38763)],
)
def test_elastica_under_a_large_end_load(load: float, deflection: float, shortening: float) -> None:
    """Tip deflection and shortening over L of the inextensible elastica at P L²/EI.

    Values by elliptic integrals: Mattiasson, IJNME 17, 145 (1981). The strip is thick, so
    that bending does not flatten its cross-section (w² κ/h stays small).
    """
    found = cantilever(8, load, 10 * THICKNESS)
    np.testing.assert_allclose(found, [deflection, shortening], rtol=5e-3)
