"""Barriers of energies whose saddles are known."""

from __future__ import annotations

import numpy as np
import pytest
from toys import Toy, system_of

from sheetmorph.core.errors import ComputationError
from sheetmorph.solve.critical import stationary
from sheetmorph.solve.string import StringOptions, passage

OPTIONS = StringOptions(tolerance=1e-10)


class Smooth(Toy):
    """The metric of the string is H, but nowhere softer than `least`."""

    least = 10.0

    def evaluate(self, x, order):  # type: ignore[no-untyped-def]
        energy, gradient, hessian = super().evaluate(x, order)
        if order == 3:
            values, vectors = np.linalg.eigh(np.array([hessian[:2], hessian[1:]]))
            full = (vectors * np.maximum(values, self.least)) @ vectors.T
            hessian = np.array([full[0, 0], full[0, 1], full[1, 1]])
        return energy, gradient, hessian


class Bent(Smooth):
    """(x² − 1)² + 5 (y − x²)²: minima (∓1, 1), the saddle (0, 0) of the energy 1 between them."""

    def derivatives(self, x, y):  # type: ignore[no-untyped-def]
        a, b = x * x - 1, y - x * x
        return (
            a * a + 5 * b * b,
            (4 * a * x - 20 * b * x, 10 * b),
            (4 * a + 8 * x * x - 20 * b + 40 * x * x, -20 * x, 10.0),
        )


class MuellerBrown(Smooth):
    """The surface of Müller and Brown (1979), with three minima and two saddles."""

    least = 300.0

    A = (-200.0, -100.0, -170.0, 15.0)
    a = (-1.0, -1.0, -6.5, 0.7)
    b = (0.0, 0.0, 11.0, 0.6)
    c = (-10.0, -10.0, -6.5, 0.7)
    X = (1.0, 0.0, -0.5, -1.0)
    Y = (0.0, 0.5, 1.5, 1.0)

    def derivatives(self, x, y):  # type: ignore[no-untyped-def]
        energy, g, h = 0.0, np.zeros(2), np.zeros((2, 2))
        for A, a, b, c, x0, y0 in zip(self.A, self.a, self.b, self.c, self.X, self.Y, strict=True):
            u, v = x - x0, y - y0
            e = A * np.exp(a * u * u + b * u * v + c * v * v)
            d = np.array([2 * a * u + b * v, b * u + 2 * c * v])
            energy += e
            g += e * d
            h += e * (np.outer(d, d) + np.array([[2 * a, b], [b, 2 * c]]))
        return energy, tuple(g), (h[0, 0], h[0, 1], h[1, 1])


def minimum(system, guess):  # type: ignore[no-untyped-def]
    found = stationary(system, np.array(guess), 1e-11)
    assert found is not None
    return found


def test_a_bent_valley() -> None:
    """The straight line between the minima climbs to 6."""
    found = passage(system_of(Bent()), np.array([-1.0, 1.0]), np.array([1.0, 1.0]), OPTIONS)
    assert found.converged and found.negative == 1
    assert found.height == pytest.approx(1.0, abs=1e-10)
    assert found.back == pytest.approx(1.0, abs=1e-10)
    np.testing.assert_allclose(found.top, 0.0, atol=1e-8)
    # The string climbs to the saddle and descends from it.
    assert found.energies.max() == pytest.approx(1.0, abs=0.01)
    middle = len(found.energies) // 2
    assert (np.diff(found.energies[: middle + 1]) > 0.0).all()
    assert (np.diff(found.energies[middle:]) < 0.0).all()


@pytest.mark.parametrize(
    ("ends", "energy", "saddle"),
    [
        (((-0.558, 1.442), (0.623, 0.028)), -40.6648, (-0.8220, 0.6243)),
        (((0.623, 0.028), (-0.558, 1.442)), -40.6648, (-0.8220, 0.6243)),
        (((-0.050, 0.467), (0.623, 0.028)), -72.2489, (0.2125, 0.2930)),
    ],
)
def test_the_surface_of_mueller_and_brown(ends, energy, saddle) -> None:  # type: ignore[no-untyped-def]
    """Between the outer minima the way goes through the third; the higher saddle counts."""
    system = system_of(MuellerBrown())
    first, second = (minimum(system, end) for end in ends)
    found = passage(system, first, second, StringOptions(tolerance=1e-9, images=25))
    assert found.converged and found.negative == 1
    assert found.energy == pytest.approx(energy, abs=1e-4)
    np.testing.assert_allclose(found.top, saddle, atol=1e-4)
    assert found.height == pytest.approx(found.energy - system.value(first), abs=1e-9)
    assert found.back == pytest.approx(found.energy - system.value(second), abs=1e-9)


def test_too_few_sweeps_are_told() -> None:
    options = StringOptions(tolerance=1e-10, sweeps=2)
    found = passage(system_of(Bent()), np.array([-1.0, 1.0]), np.array([1.0, 1.0]), options)
    assert not found.converged and found.sweeps == 2
    assert found.energy >= 1.0 - 1e-3


def test_no_way_to_itself() -> None:
    with pytest.raises(ComputationError, match="itself"):
        passage(system_of(Bent()), np.ones(2), np.ones(2), OPTIONS)
