"""Growth metrics."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from sheetmorph.proofs.excess_cone import steepest_ray
from sheetmorph.proofs.growth import SHAPES
from sheetmorph.proofs.proof import Proof


@pytest.mark.parametrize("name", SHAPES)
def test_curvatures_are_those_of_the_metrics(name: str) -> None:
    """Brioschi's formula, K = −(G′/E)′/(E G) with E = λr, G = r λθ, by differences."""
    growth, step = SHAPES[name], 1e-4

    def turn(r: np.ndarray) -> np.ndarray:
        radius = [s * growth.around(s) for s in (r + step, r - step)]
        return (radius[0] - radius[1]) / (2 * step) / growth.along(r)

    r = np.linspace(0.1, 0.9, 5)
    rate = (turn(r + step) - turn(r - step)) / (2 * step)
    known = -rate / (growth.along(r) * r * growth.around(r))
    assert growth.curvature(r) == pytest.approx(known, rel=1e-5)


def test_a_small_excess_lifts_the_rays_as_a_cosine() -> None:
    """β = a cos 2φ with a² = 4/3 (λ − 1): the length of a nearly flat curve on the sphere."""
    assert steepest_ray(1.0003) == pytest.approx(np.sqrt(4.0 / 3.0 * 0.0003), rel=1e-3)


def test_more_terms_do_not_move_the_rays(monkeypatch: pytest.MonkeyPatch) -> None:
    few = steepest_ray(1.2)
    monkeypatch.setattr("sheetmorph.proofs.excess_cone.TERMS", 7)
    assert steepest_ray(1.2) == pytest.approx(few, rel=1e-5)


@pytest.mark.slow
def test_growth(proven: Callable[[str], Proof]) -> None:
    proof = proven("growth")
    assert len(proof.checks) == 16
    assert max(c.error for c in proof.checks if c.what.startswith("half the angle")) < 1e-3
    assert max(c.error for c in proof.checks if c.id.startswith("radius")) < 2e-3
