"""Limit points of the von Mises truss, whose curve is known."""

from __future__ import annotations

import numpy as np
import pytest
from toys import Broken, Fold, Pitchfork, Toy, system_of

from sheetmorph.core.errors import ComputationError
from sheetmorph.solve.arclength import ArcOptions, actuated, displaced, pushed, trace
from sheetmorph.solve.linear import available

HALF, RISE = 1.0, 0.3
REST = float(np.hypot(HALF, RISE))
OPTIONS = ArcOptions(tolerance=1e-12, length=0.1, amount=0.01, max_step=0.5)
DOWN = np.array([0.0, -1.0])


class Truss(Toy):
    """Two bars from (∓1, 0) to an apex at (x, y), of the stiffness 1 along their length."""

    def derivatives(self, x, y):  # type: ignore[no-untyped-def]
        energy, g, h = 0.0, np.zeros(2), np.zeros((2, 2))
        for foot in (-HALF, HALF):
            d = np.array([x - foot, y])
            length = np.linalg.norm(d)
            energy += 0.5 * (length - REST) ** 2
            g += (1 - REST / length) * d
            h += (1 - REST / length) * np.eye(2) + REST / length**3 * np.outer(d, d)
        return energy, tuple(g), (h[0, 0], h[0, 1], h[1, 1])


def load_at(y: float) -> float:
    """The force down that holds the apex at the height y."""
    return float(-2.0 * y * (1.0 - REST / np.hypot(HALF, y)))


@pytest.mark.parametrize("solver", available())
def test_the_truss_by_arc_length(solver: str) -> None:
    loading = pushed(system_of(Truss(), solver), DOWN)
    curve = trace(loading, np.array([0.0, RISE]), 0.0, OPTIONS, lambda p: p.x[1] < -1.3 * RISE)
    for point in curve.points:
        assert point.parameter == pytest.approx(load_at(point.x[1]), abs=1e-11)
    height = np.sqrt((REST * HALF**2) ** (2 / 3) - HALF**2)  # where the load is largest
    assert [limit.kind for limit in curve.limits] == ["maximum", "minimum"]
    for limit, y in zip(curve.limits, (height, -height), strict=True):
        assert limit.x[1] == pytest.approx(y, rel=1e-6)
        assert limit.parameter == pytest.approx(load_at(y), rel=1e-9)
    between = [p.negative_pivots for p in curve.points if abs(p.x[1]) < 0.99 * height]
    outside = [p.negative_pivots for p in curve.points if abs(p.x[1]) > 1.01 * height]
    assert len(between) > 3 and set(between) == {1} and set(outside) == {0}


def test_the_truss_by_displacement() -> None:
    loading = pushed(system_of(Truss()), DOWN)
    distances = np.linspace(0.05, 0.7, 14)
    found = displaced(loading, np.array([0.0, RISE]), 0.0, 3.0 * DOWN, 3.0 * distances, 1e-12)
    np.testing.assert_allclose([p.x[1] for p in found], RISE - distances, atol=1e-12)
    known = [load_at(p.x[1]) for p in found]
    np.testing.assert_allclose([p.parameter for p in found], known, atol=1e-12)


def test_the_actuation_turns_round_at_a_fold() -> None:
    """x³/3 − (1/2 − t) x: x² = 1/2 − t, stable for x > 0."""
    loading = actuated(system_of(Fold()))
    options = ArcOptions(tolerance=1e-12, length=0.3, amount=0.3, max_step=0.5)
    curve = trace(loading, np.array([0.5**0.5, 0.0]), 0.0, options, lambda p: p.x[0] < -0.5)
    (limit,) = curve.limits
    assert limit.kind == "maximum"
    assert limit.parameter == pytest.approx(0.5, abs=1e-9)
    for point in curve.points:
        assert point.parameter == pytest.approx(0.5 - point.x[0] ** 2, abs=1e-10)
        assert point.negative_pivots == (1 if point.x[0] < 0.0 else 0)


def test_backwards_and_most_points() -> None:
    loading = actuated(system_of(Fold()))
    options = ArcOptions(tolerance=1e-12, length=0.3, amount=0.3, max_points=4)
    curve = trace(loading, np.array([0.5**0.5, 0.0]), 0.0, options, lambda p: False, direction=-1.0)
    assert len(curve.points) == 4
    assert curve.points[-1].parameter < 0.0 and not curve.limits


def test_a_bifurcation_is_passed_and_counted() -> None:
    """The straight strut is followed beyond its buckling."""
    loading = actuated(system_of(Pitchfork()))
    options = ArcOptions(tolerance=1e-12, length=0.3, amount=0.3)
    curve = trace(loading, np.zeros(2), 0.0, options, lambda p: p.parameter > 0.8)
    assert not curve.limits
    for point in curve.points:
        np.testing.assert_allclose(point.x, 0.0, atol=1e-9)
        assert point.negative_pivots == (1 if point.parameter > 0.3 else 0)


def test_curves_that_end() -> None:
    options = ArcOptions(tolerance=1e-12, length=0.3, amount=0.3)
    with pytest.raises(ComputationError, match="cannot be followed beyond"):
        trace(actuated(system_of(Broken())), np.zeros(2), 0.0, options, lambda p: False)
    with pytest.raises(ComputationError, match="displacement 1"):
        displaced(
            actuated(system_of(Broken())), np.zeros(2), 0.0, np.array([1.0, 0.0]), [1.0], 1e-12
        )
