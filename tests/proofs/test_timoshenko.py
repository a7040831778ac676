"""Strips of two layers, and what layers alone decide."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize

from sheetmorph.proofs.bilayer import (
    Bilayer,
    circle_of_exact_fibres,
    circle_of_the_law,
    curvature_of_a_wide_strip,
    timoshenko_curvature,
)
from sheetmorph.proofs.proof import Proof

STRIPS = [
    Bilayer((0.5, 0.5), (1.0, 1.0), -0.3),
    Bilayer((0.5, 0.5), (1.0, 1.0), -0.3, thickening=True),
    Bilayer((0.2, 0.7), (3.0, 1.0), -0.1, thickening=True),
]


def least(layers: Bilayer, square: float) -> float:
    """Curvature of least energy, by quadrature and a search without gradients."""
    film = 1.0 + layers.mismatch
    low = layers.thicknesses[0] / (film if layers.thickening else 1.0)
    middle = 0.5 * (low + layers.thicknesses[1])

    def energy(p: np.ndarray) -> float:
        length, bend = p

        def density(z: float, modulus: float, f: float) -> float:
            height = z - middle
            now = length**2 * (1.0 - 2.0 * height * bend + square * (height * bend) ** 2)
            return modulus * f * (0.5 * (now / f**2 - 1.0)) ** 2

        return (
            quad(density, 0.0, low, args=(layers.moduli[0], film))[0]
            + quad(density, low, 2 * middle, args=(layers.moduli[1], 1.0))[0]
        )

    options = {"xatol": 1e-11, "fatol": 1e-15, "maxiter": 2000}
    start = [1.0 + 0.5 * layers.mismatch, timoshenko_curvature(layers)]
    return float(minimize(energy, start, method="Nelder-Mead", options=options).x[1])


@pytest.mark.parametrize("layers", STRIPS, ids=["plain", "thickening", "uneven"])
def test_circles_minimise_the_energy(layers: Bilayer) -> None:
    assert circle_of_the_law(layers) == pytest.approx(least(layers, 0.0), rel=1e-6)
    assert circle_of_exact_fibres(layers) == pytest.approx(least(layers, 1.0), rel=1e-6)


def test_small_mismatch_is_timoshenko_for_both() -> None:
    for m, n in ((0.1, 10.0), (1.0, 1.0), (3.0, 0.2)):
        layers = Bilayer((m, 1.0), (n, 1.0), 1e-6)
        known = timoshenko_curvature(layers)
        assert circle_of_the_law(layers) == pytest.approx(known, rel=1e-5)
        # its minimum is found to the root of rounding
        strong = Bilayer((m, 1.0), (n, 1.0), 1e-3)
        known = timoshenko_curvature(strong)
        assert circle_of_exact_fibres(strong) == pytest.approx(known, rel=5e-3)


def test_a_wide_strip_between_its_limits() -> None:
    narrow, wide = (curvature_of_a_wide_strip(1.0, w, 1.0, 0.3) for w in (0.05, 120.0))
    assert narrow == pytest.approx(1.0, abs=1e-5)
    assert wide == pytest.approx(1.3, abs=0.01)
    # Without Poisson's effect a wide strip has its natural curvature again.
    assert curvature_of_a_wide_strip(1.0, 60.0, 1.0, 0.0) == pytest.approx(1.0, abs=0.01)


@pytest.mark.slow
def test_strips(proven: Callable[[str], Proof]) -> None:
    proof = proven("timoshenko")
    small = [c for c in proof.checks if c.id.startswith("small")]
    large = [c for c in proof.checks if c.id.startswith("large")]
    assert (len(small), len(large)) == (50, 14)
    # What is left at small mismatch is of the order of the mismatch itself.
    assert max(c.error for c in small) < 0.0035
    assert max(c.error for c in large) < 6e-4
    assert all(c.found < 0 for c in (*small, *large))
    orders = [c.found for c in proof.checks if c.id.startswith("order")]
    assert orders == pytest.approx([2.0, 2.0], abs=0.05)


@pytest.mark.slow
def test_wide_strips(proven: Callable[[str], Proof]) -> None:
    proof = proven("wide_strip")
    found = {c.id: c.found for c in proof.checks}
    assert found["structured-0.2"] == pytest.approx(1.0, abs=0.01)
    assert found["structured-5"] < 0.9
    assert found["structured-200"] > 1.28


@pytest.mark.slow
def test_layers(proven: Callable[[str], Proof]) -> None:
    assert len(proven("layers").checks) == 3
