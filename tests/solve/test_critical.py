"""The first place on a path where stability is lost, on energies where it is known."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from toys import Broken, Fold, Pitchfork, Rosenbrock, Toy, system_of

from sheetmorph.core.errors import ComputationError
from sheetmorph.solve.critical import Critical, first_critical, stationary
from sheetmorph.solve.linear import available

NEWTON = partial(stationary, tolerance=1e-12)


class TwoStruts(Toy):
    """Two struts that buckle at t = 0.3 and t = 0.35, and move sideways with t."""

    later = 0.35

    def derivatives(self, x, y):  # type: ignore[no-untyped-def]
        a, b = self.ramp - 0.3, self.ramp - self.later
        return (
            x**4 / 4 - a * x**2 / 2 + y**4 / 4 - b * y**2 / 2,
            (x**3 - a * x, y**3 - b * y),
            (3 * x**2 - a, 0.0, 3 * y**2 - b),
        )


class TwinStruts(TwoStruts):
    """Both buckle at 0.3: a double mode."""

    later = 0.3


class Softening(Toy):
    """Stiffness 1 − t² along (1, 2), as seen from an equilibrium that moves: x + y = t."""

    def derivatives(self, x, y):  # type: ignore[no-untyped-def]
        u, v = (x + 2 * y) / np.sqrt(5), (2 * x - y - self.ramp) / np.sqrt(5)
        soft = 1.0 - self.ramp**2
        p, q = np.array([1, 2]) / np.sqrt(5), np.array([2, -1]) / np.sqrt(5)
        h = soft * np.outer(p, p) + 3.0 * np.outer(q, q)
        g = soft * u * p + 3.0 * v * q
        return soft * u**2 / 2 + 1.5 * v**2, tuple(g), (h[0, 0], h[0, 1], h[1, 1])


def search(toy: Toy, ramps: list[float], solver: str = "scipy") -> Critical | None:
    return first_critical(system_of(toy, solver), np.zeros(2), ramps, NEWTON)


@pytest.mark.parametrize("solver", available())
@pytest.mark.parametrize("ramps", [[0.0, 1.0], [0.0, 0.25, 0.5, 0.75], [0.1, 0.3, 0.5]])
def test_a_strut(ramps: list[float], solver: str) -> None:
    """The last of the ramps has the zero at one of them, where the Hessian is singular."""
    found = search(Pitchfork(), ramps, solver)
    assert found is not None
    assert found.ramp == pytest.approx(0.3, rel=2e-8)
    np.testing.assert_allclose(found.mode, [1.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(found.x, 0.0, atol=1e-12)
    assert abs(found.eigenvalue) < 1e-8


def test_the_first_of_two_that_have_both_passed() -> None:
    """At both ends of this bracket the eigenvalue next to zero is that of the second strut or
    as near; at 0.35 it is zero, and the first is negative."""
    for ramps in ([0.0, 1.0], [0.0, 0.35], [0.29, 0.36], [0.25, 0.45]):
        found = search(TwoStruts(), ramps)
        assert found is not None
        assert found.ramp == pytest.approx(0.3, rel=2e-8)
        np.testing.assert_allclose(np.abs(found.mode), [1.0, 0.0], atol=1e-6)


def test_a_double_mode_is_told() -> None:
    found = search(TwinStruts(), [0.0, 0.5])
    assert found is not None
    assert found.ramp == pytest.approx(0.3, rel=2e-8)
    assert found.negative_pivots == 2


def test_the_mode_and_an_equilibrium_that_moves() -> None:
    found = search(Softening(), np.linspace(0.0, 1.5, 4).tolist())
    assert found is not None
    assert found.ramp == pytest.approx(1.0, rel=2e-8)
    np.testing.assert_allclose(found.mode, [0.5, 1.0], atol=1e-6)
    np.testing.assert_allclose(found.x, [0.4, -0.2], atol=1e-9)


def test_no_zero_in_the_range() -> None:
    assert search(Pitchfork(), [0.0, 0.1, 0.2, 0.299]) is None
    assert first_critical(system_of(Rosenbrock()), np.ones(2), [0.0, 0.5, 1.0], NEWTON) is None


def test_a_path_that_begins_unstable() -> None:
    with pytest.raises(ComputationError, match=r"first ramp, 0\.4, is not stable"):
        search(Pitchfork(), [0.4, 0.6])


def test_a_path_whose_equilibria_end() -> None:
    with pytest.raises(ComputationError, match=r"no equilibrium was found at the ramp 0\.8"):
        first_critical(system_of(Fold()), np.array([0.7, 0.0]), [0.0, 0.4, 0.8], NEWTON)
    with pytest.raises(ComputationError, match="no equilibrium was found at the ramp 1"):
        search(Broken(), [0.0, 1.0])


def test_newton_without_safeguards_keeps_to_a_saddle() -> None:
    found = stationary(system_of(Pitchfork().at(1.0, 0.0)), np.array([0.01, 0.5]), 1e-12)
    assert found is not None
    np.testing.assert_allclose(found, 0.0, atol=1e-12)
    assert stationary(system_of(Fold().at(0.9, 0.0)), np.array([0.1, 0.0]), 1e-12) is None
