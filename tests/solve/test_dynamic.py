"""Motion in time against oscillators whose every step is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from toys import Broken, Toy, system_of

from sheetmorph.core.events import TimeStepRejected
from sheetmorph.solve.dynamic import REMEDIES, Motion, MotionOptions, move, start_of_motion
from sheetmorph.solve.inertia import Inertia, Integrator, Moment
from sheetmorph.solve.minimise import NewtonOptions
from sheetmorph.solve.path import Status
from sheetmorph.solve.system import System

EULER, TRAPEZOIDAL = Integrator.IMPLICIT_EULER, Integrator.TRAPEZOIDAL
STIFF = 4.0
OMEGA = 2.0


class Spring(Toy):
    """Stiffness 4 in x, coupled to y, which has none of its own but follows x: y = x/2."""

    def derivatives(self, x, y):  # type: ignore[no-untyped-def]
        u = y - 0.5 * x
        return 0.5 * STIFF * x * x + 0.5 * u * u, (STIFF * x - 0.5 * u, u), (STIFF + 0.25, -0.5, 1)


class TwoWells(Toy):
    """x⁴/4 − x²/2 + 1: a saddle at 0, minima at ±1."""

    def derivatives(self, x, y):  # type: ignore[no-untyped-def]
        return x**4 / 4 - x * x / 2 + y * y / 2 + 1.0, (x**3 - x, y), (3 * x * x - 1, 0.0, 1.0)


@dataclass
class Book:
    """Balances the energy of a system that does not change in time."""

    system: System
    inertia: Inertia
    largest: float = 0.0
    made: float = 0.0
    forged: float = 0.0

    def energy(self, moment: Moment) -> float:
        return self.system.value(moment.x) + self.inertia.kinetic(moment.velocity)

    def weigh(self, before: Moment, after: Moment) -> tuple[float, float]:
        gained = self.energy(after) - self.energy(before)
        return gained + after.dissipated + self.forged, self.energy(after)

    def enter(self, before: Moment, after: Moment) -> None:
        self.made += self.weigh(before, after)[0]
        self.largest = max(self.largest, self.energy(before), self.energy(after))


def options(step: float, integrator: Integrator = EULER, **more: object) -> MotionOptions:
    tight = NewtonOptions(1e-12)
    return replace(MotionOptions(tight, 1e-14, integrator, step), **more)  # type: ignore[arg-type]


def run(
    energy: Toy,
    chosen: MotionOptions,
    x0: tuple[float, float] = (1.0, 0.5),
    drag: float = 0.0,
    retardation: float = 0.0,
    forged: float = 0.0,
    on_event: Callable[[object], None] = lambda event: None,
    on_moment: Callable[[Moment, Moment], None] | None = None,
) -> tuple[Motion, list[Moment]]:
    """Let go at x0; x has the mass 1, y has none."""
    system = system_of(energy)
    inertia = Inertia(np.array([1.0, 0.0]), np.array([drag, 0.0]), retardation)
    moments = [start_of_motion(lambda t: system, inertia, np.array(x0), chosen)]

    def keep(before: Moment, after: Moment) -> None:
        moments.append(after)
        if on_moment is not None:
            on_moment(before, after)

    book = Book(system, inertia, forged=forged)
    motion = move(
        lambda t: system.at(t, 0.0),
        lambda t: system.at(t, 0.0),
        inertia,
        moments[0],
        chosen,
        account=book,
        on_event=on_event,
        on_moment=keep,
    )
    return motion, moments


def test_implicit_euler_is_the_recursion_of_the_paper() -> None:
    h = 0.1
    _, moments = run(Spring(), options(h, end_time=2.0))
    x, v = 1.0, 0.0
    for moment in moments[1:]:
        # M (x1 − x0 − h v0)/h² + k x1 = 0, v1 = (x1 − x0)/h
        x, before = (x + h * v) / (1.0 + STIFF * h * h), x
        v = (x - before) / h
        assert moment.x[0] == pytest.approx(x, abs=1e-12)
        assert moment.velocity[0] == pytest.approx(v, abs=1e-11)
        assert moment.x[1] == pytest.approx(0.5 * x, abs=1e-12)  # without mass: in equilibrium
    # Its amplitude falls by the known factor in every step, and its energy always.
    sizes = [np.hypot(OMEGA * m.x[0], m.velocity[0]) for m in moments]
    np.testing.assert_allclose(
        np.divide(sizes[1:], sizes[:-1]), (1.0 + STIFF * h * h) ** -0.5, rtol=1e-10
    )


def test_the_trapezoidal_rule_keeps_the_energy_and_shifts_the_phase_as_known() -> None:
    h = 0.1
    _, moments = run(Spring(), options(h, TRAPEZOIDAL, end_time=50.0))
    energies = [0.5 * STIFF * m.x[0] ** 2 + 0.5 * m.velocity[0] ** 2 for m in moments]
    np.testing.assert_allclose(energies, energies[0], rtol=1e-10)
    turn = 2.0 * np.arctan(0.5 * OMEGA * h)
    np.testing.assert_allclose(
        [m.x[0] for m in moments], np.cos(turn * np.arange(len(moments))), atol=1e-9
    )


@pytest.mark.parametrize(("integrator", "order"), [(EULER, 1), (TRAPEZOIDAL, 2)])
def test_order_of_accuracy(integrator: Integrator, order: int) -> None:
    ends = []
    steps = [0.02, 0.01, 0.005]
    for h in steps:
        motion, _ = run(Spring(), options(h, integrator, end_time=1.0), drag=0.4)
        ends.append(motion.last.x[0])
    damped = np.sqrt(STIFF - 0.04)
    exact = np.exp(-0.2) * (np.cos(damped) + 0.2 / damped * np.sin(damped))
    errors = np.abs(np.array(ends) - exact)
    slopes = np.log2(errors[:-1] / errors[1:])
    np.testing.assert_allclose(slopes, order, atol=0.1)


@pytest.mark.parametrize("retardation", [0.0, 0.1])
def test_damping_takes_what_it_is_said_to_take(retardation: float) -> None:
    drag = 0.0 if retardation else 0.4
    chosen = options(0.001, TRAPEZOIDAL, end_time=1.0)
    motion, moments = run(Spring(), chosen, drag=drag, retardation=retardation)
    rate = retardation * STIFF + drag
    frequency = np.sqrt(STIFF - 0.25 * rate**2)
    exact = np.exp(-0.5 * rate) * (np.cos(frequency) + 0.5 * rate / frequency * np.sin(frequency))
    assert motion.last.x[0] == pytest.approx(exact, abs=1e-5)
    first, last = (
        0.5 * STIFF * m.x[0] ** 2 + 0.5 * m.velocity[0] ** 2 for m in (moments[0], moments[-1])
    )
    assert sum(m.dissipated for m in moments) == pytest.approx(first - last, rel=1e-6)


def test_steps_follow_the_error_that_is_allowed() -> None:
    chosen = options(0.1, step_error=1e-5, end_time=4.0)
    events: list[object] = []
    motion, moments = run(Spring(), chosen, on_event=events.append)
    rejected = [event for event in events if isinstance(event, TimeStepRejected)]
    steps = np.diff([m.time for m in moments])
    # Half h² a is the error of a step of implicit Euler.
    errors = [0.5 * h * h * abs(m.acceleration[0]) for h, m in zip(steps, moments[1:], strict=True)]
    assert max(errors) <= 1e-5
    assert rejected and steps.max() > 1.5 * steps.min()
    assert motion.last.time == 4.0


def test_steps_end_at_corners() -> None:
    _, moments = run(Spring(), options(0.3, corners=(0.5, 0.6), end_time=1.0))
    times = [m.time for m in moments]
    assert {0.5, 0.6, 1.0} <= set(times)
    assert np.diff(times).min() > 1e-3


def test_it_rests_in_the_equilibrium() -> None:
    motion, moments = run(TwoWells(), options(0.1), x0=(0.1, 0.3), drag=1.0)
    assert motion.status is Status.COMPLETED and motion.at_rest
    np.testing.assert_allclose(motion.last.x, [1.0, 0.0], atol=1e-12)
    assert not motion.last.velocity.any()
    assert 0.0 < motion.settled_by < 1e-2
    assert motion.settled_by == pytest.approx(abs(moments[-1].x[0] - 1.0), rel=1e-6)


def test_a_saddle_is_no_place_to_rest() -> None:
    motion, _ = run(TwoWells(), options(0.1), x0=(0.0, 0.3), drag=1.0)
    assert motion.status is Status.UNSTABLE and motion.negative_pivots == 1
    assert "perturbation" in REMEDIES[motion.status]


def test_where_it_goes_on_it_is_the_same_motion() -> None:
    chosen = options(0.1, TRAPEZOIDAL, step_error=1e-3, end_time=5.0)
    whole, moments = run(TwoWells(), chosen, x0=(0.1, 0.0), drag=0.1)
    system = system_of(TwoWells())
    inertia = Inertia(np.array([1.0, 0.0]), np.array([0.1, 0.0]))
    again = move(
        lambda t: system,
        lambda t: system,
        inertia,
        moments[len(moments) // 2],
        chosen,
        account=Book(system, inertia, largest=1.0),
    )
    assert again.last.time == whole.last.time and again.last.index == whole.last.index
    np.testing.assert_array_equal(again.last.x, whole.last.x)


def _stop(before: Moment, after: Moment) -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("status", "energy", "more"),
    [
        (Status.NOT_FINITE, Broken(), {}),
        (Status.TOO_MANY_STEPS, Spring(), {"max_steps": 3}),
        (Status.TIME_LIMIT, Spring(), {"time_limit": 0.0}),
    ],
)
def test_failures_have_their_status(status: Status, energy: Toy, more: dict[str, object]) -> None:
    motion, moments = run(energy, options(0.1, end_time=1.0, **more))
    assert motion.status is status and REMEDIES[status] and motion.detail
    assert motion.last is moments[-1]
    assert motion.last.time < 0.5


def test_energy_out_of_nothing_is_no_motion() -> None:
    # A little in every step is let pass until it is too much; much in one step never is.
    motion, _ = run(Spring(), options(0.01, TRAPEZOIDAL, end_time=20.0), forged=1e-4)
    assert motion.status is Status.ENERGY_GREW and motion.status.remedy
    motion, _ = run(Spring(), options(0.01, TRAPEZOIDAL, end_time=20.0), forged=1.0)
    assert motion.status is Status.STEP_TOO_SMALL and "nothing" in motion.detail


def test_ctrl_c_ends_between_steps() -> None:
    motion, moments = run(Spring(), options(0.1, end_time=1.0), on_moment=_stop)
    assert motion.status is Status.INTERRUPTED and motion.last is moments[-1]


def test_every_status_has_a_remedy() -> None:
    assert set(REMEDIES) == set(Status)
