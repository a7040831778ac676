"""Newton's method and path following on energies with known answers, and on ones that fail."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from toys import Broken, Fold, Pitchfork, Rosenbrock, Stiff, Toy, system_of

from sheetmorph.core.events import StateReached, StepRejected
from sheetmorph.solve.minimise import NewtonOptions, Outcome, minimise
from sheetmorph.solve.path import PathOptions, Status, Waypoint, follow, start_of_path
from sheetmorph.solve.stability import escape_saddle, negative_pivots

NEWTON = NewtonOptions(residual_tolerance=1e-12)
LEGS = (Waypoint(0.0, 1.0), Waypoint(1.0, 1.0), Waypoint(1.0, 0.0))


def walk(toy: Toy, x: float = 0.0, **options):  # type: ignore[no-untyped-def]
    chosen = PathOptions(newton=NEWTON, **options)
    events: list[object] = []
    start = start_of_path(np.array([x, 0.0]), LEGS, chosen)
    path = follow(system_of(toy), LEGS, [start], chosen, on_event=events.append)
    return path, events


def test_newton_finds_the_bottom_of_a_curved_valley() -> None:
    found = minimise(system_of(Rosenbrock()), np.array([-1.2, 1.0]), NEWTON)
    assert found.outcome is Outcome.CONVERGED
    np.testing.assert_allclose(found.x, 1.0, atol=1e-10)
    assert found.stable


def test_newton_leaves_a_region_of_negative_curvature_downhill() -> None:
    system = system_of(Pitchfork().at(1.0, 1.0))
    found = minimise(system, np.array([0.01, 0.5]), NEWTON)
    assert found.outcome is Outcome.CONVERGED
    assert found.x[0] > 0.8
    assert negative_pivots(system, found.x)[0] == 0


def test_newton_stops_where_told() -> None:
    found = minimise(
        system_of(Rosenbrock()), np.array([-1.2, 1.0]), NewtonOptions(1e-12, max_iterations=3)
    )
    assert found.outcome is Outcome.TOO_MANY_ITERATIONS
    assert found.iterations == 3


def test_newton_is_done_where_no_digit_is_left() -> None:
    """The gradient rounds to more than the tolerance wherever one looks."""
    found = minimise(system_of(Stiff()), np.array([1.0, 2.0]), NEWTON)
    assert found.outcome is Outcome.CONVERGED
    assert found.residual > 1e3 * NEWTON.residual_tolerance
    np.testing.assert_allclose(found.x, np.sqrt([2.0, 3.0]), rtol=4e-16)


def test_newton_on_nothing_finite() -> None:
    found = minimise(system_of(Broken().at(0.9, 0.0)), np.zeros(2), NEWTON)
    assert found.outcome is Outcome.NOT_FINITE


def test_path_passes_a_buckling_point_and_unloads() -> None:
    path, events = walk(Pitchfork())
    assert path.status is Status.COMPLETED
    final = path.states[-1]
    assert (final.ramp, final.load) == (1.0, 0.0)
    assert final.x[0] == pytest.approx(np.sqrt(0.7), abs=1e-12)
    assert final.negative_pivots == 0
    assert sum(isinstance(e, StateReached) for e in events) == len(path.states) - 1
    for state in path.states[1:]:
        assert state.residual <= NEWTON.residual_tolerance


def test_tangents_are_those_of_the_path() -> None:
    """Even where a state is found with a factor from far off, as a loose tolerance allows."""
    options = PathOptions(newton=NewtonOptions(residual_tolerance=1e-4), max_step=0.05)
    start = start_of_path(np.zeros(2), LEGS, options)
    path = follow(system_of(Pitchfork()), LEGS, [start], options)
    states = [state for state in path.states if state.leg == 0 and state.s > 0.0]
    assert len(states) > 10
    for state in states:
        x = state.x[0]
        assert state.tangent[0] == pytest.approx(x / (3 * x * x - (state.ramp - 0.3)), rel=0.01)


def test_path_ends_where_the_equilibrium_ends() -> None:
    path, events = walk(Fold(), 0.7, min_step=1e-3)
    assert path.status is Status.STEP_TOO_SMALL
    assert path.status.remedy
    assert path.states[-1].ramp == pytest.approx(0.5, abs=5e-3)
    assert any(isinstance(e, StepRejected) for e in events)


def test_path_keeps_the_last_good_state_when_numbers_fail() -> None:
    path, _ = walk(Broken(), min_step=1e-3)
    assert path.status is Status.NOT_FINITE
    assert path.states[-1].ramp == pytest.approx(0.4, abs=5e-3)


def test_limits() -> None:
    assert walk(Pitchfork(), max_steps=3)[0].status is Status.TOO_MANY_STEPS
    assert walk(Pitchfork(), time_limit=0.0)[0].status is Status.TIME_LIMIT


def test_interrupt_keeps_what_was_reached() -> None:
    options = PathOptions(newton=NEWTON)

    def stop(index: int, state: object) -> None:
        if index == 4:
            raise KeyboardInterrupt

    path = follow(
        system_of(Pitchfork()),
        LEGS,
        [start_of_path(np.zeros(2), LEGS, options)],
        options,
        on_state=stop,
    )
    assert path.status is Status.INTERRUPTED
    assert len(path.states) == 5


@pytest.mark.parametrize("cut", [1, 3, 6])
def test_a_path_cut_anywhere_goes_on_to_the_same_bits(cut: int) -> None:
    options = PathOptions(newton=NEWTON)
    whole, _ = walk(Pitchfork())
    rest = follow(system_of(Pitchfork()), LEGS, whole.states[:cut], options)
    assert len(rest.states) == len(whole.states)
    for a, b in zip(rest.states, whole.states, strict=True):
        np.testing.assert_array_equal(a.x, b.x)


def test_equal_steps_of_a_leg() -> None:
    options = PathOptions(newton=NEWTON)
    path = follow(
        system_of(Pitchfork()),
        LEGS,
        [start_of_path(np.zeros(2), LEGS, options)],
        options,
        equal_steps={1: 4},
    )
    loads = [s.load for s in path.states if s.ramp == 1.0]
    np.testing.assert_allclose(loads, [1.0, 0.75, 0.5, 0.25, 0.0], atol=1e-12)


def test_a_saddle_is_seen_and_left() -> None:
    """Without a push the straight strut stays straight: an equilibrium, but no minimum."""
    saddle = system_of(Pitchfork().at(1.0, 0.0))
    pivots, _, gradient = negative_pivots(saddle, np.zeros(2))
    assert pivots == 1
    assert not gradient.any()
    kicked = escape_saddle(saddle, np.array([0.0, 1e-3]))
    assert abs(kicked[0]) > 0


def test_a_path_through_a_bifurcation_ends_in_a_minimum_without_any_push() -> None:
    class Unpushed(Pitchfork):
        def at(self, ramp: float, load: float) -> Toy:
            return super().at(ramp, 0.0)

    path, _ = walk(Unpushed())
    assert path.status is Status.COMPLETED
    assert abs(path.states[-1].x[0]) == pytest.approx(0.7**0.5, abs=1e-10)
    assert all(state.negative_pivots == 0 for state in path.states)


def test_a_library_that_fails_is_a_status_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """An exception of the linear solver becomes a shorter step, and at last a status."""
    from sheetmorph.solve.linear import ScipySuperLU, SingularMatrixError

    real, calls = ScipySuperLU.solve, []

    def failing(self, rhs):  # type: ignore[no-untyped-def]
        calls.append(1)
        if 12 < len(calls) < 16 or len(calls) > 40:
            raise SingularMatrixError("a large residual")
        return real(self, rhs)

    monkeypatch.setattr(ScipySuperLU, "solve", failing)
    path, _ = walk(Pitchfork(), max_step=0.01, min_step=1e-3)
    assert path.status is Status.STEP_TOO_SMALL
    assert len(path.states) > 5
    assert np.isfinite(path.states[-1].x).all()


def test_time_runs_out_within_a_step() -> None:
    import time

    found = minimise(
        system_of(Rosenbrock()),
        np.array([-1.2, 1.0]),
        NewtonOptions(1e-12, deadline=time.perf_counter()),
    )
    assert found.outcome is Outcome.OUT_OF_TIME


class FarAway(Toy):
    """A bent valley y = 1 + 6 sin x that begins to fall towards x = 20 at t = 0.5."""

    def derivatives(self, x, y):  # type: ignore[no-untyped-def]
        off, slope, bend = y - 1.0 - 6.0 * np.sin(x), -6.0 * np.cos(x), 6.0 * np.sin(x)
        goal = 20.0 if self.ramp > 0.5 else 0.0
        return (
            50.0 * off**2 + 0.5 * (x - goal) ** 2,
            (100.0 * off * slope + x - goal, 100.0 * off),
            (100.0 * (slope**2 + off * bend) + 1.0, 100.0 * slope, 100.0),
        )


def test_a_jump_to_a_branch_far_away_is_given_more_iterations() -> None:
    legs = [Waypoint(0.0, 0.0), Waypoint(1.0, 0.0)]
    statuses = {}
    for iterations in (2, 30):
        options = PathOptions(replace(NEWTON, max_iterations=iterations), min_step=1e-2)
        start = start_of_path(np.array([0.0, 1.0]), legs, options)
        events: list[object] = []
        path = follow(system_of(FarAway()), legs, [start], options, on_event=events.append)
        statuses[iterations] = path.status
    assert statuses == {2: Status.STEP_TOO_SMALL, 30: Status.COMPLETED}
    assert path.states[-1].x[0] == pytest.approx(20.0)
    assert any(isinstance(event, StepRejected) for event in events)  # 30 steps did not do
