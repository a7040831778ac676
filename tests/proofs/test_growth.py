"""Growth metrics."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

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


@pytest.mark.slow
def test_growth(proven: Callable[[str], Proof]) -> None:
    proof = proven("growth")
    assert len(proof.checks) == 14
    assert max(c.error for c in proof.checks if c.id.startswith("cone")) < 1e-3
    assert max(c.error for c in proof.checks if c.id.startswith("radius")) < 2e-3
