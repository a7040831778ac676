"""Motion in time: M a + C v + ∇E(x, t) = 0 by implicit steps, each a minimisation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.events import Listener, MomentReached, TimeStepRejected, silent
from sheetmorph.solve.inertia import Inertia, Integrator, Moment, Moving, Pull
from sheetmorph.solve.linear import SingularMatrixError
from sheetmorph.solve.minimise import Minimum, NewtonOptions, Outcome, minimise
from sheetmorph.solve.path import Status
from sheetmorph.solve.stability import negative_pivots
from sheetmorph.solve.system import System

Floats = NDArray[np.float64]
SystemAt = Callable[[float], System]
"""The problem at a time [s]."""

SHORTEST = 1e-6
"""Shortest step before the motion is given up, as a fraction of the longest."""

LONGER, SHORTER, MARGIN = 1.5, 0.2, 0.9
"""Most by which a step grows, least to which it shrinks, share of the error that is aimed at."""

ROUNDING = 1e-15
"""Rounding of the forces of inertia, as a fraction of their stiffness times the coordinates."""

LOOK_EVERY = 5
"""Steps between two looks whether the sheet rests: each may cost a factorisation."""

STEP_GAIN, GAIN = 1e-3, 0.05
"""Energy that a step of the trapezoidal rule, and all together, may make out of nothing, over the
largest so far: beyond it the step is tried again, shorter, and the motion is given up. A step of
implicit Euler ends in a minimum that lies below its start, and cannot run away."""

REMEDIES = {
    Status.COMPLETED: "",
    Status.UNSTABLE: (
        "the sheet came to rest on a saddle; give it a perturbation load that breaks the symmetry"
    ),
    Status.STEP_TOO_SMALL: (
        "the last moment in motion is kept; try a smaller solver.dynamic.time_step, a smaller "
        "actuation or a finer mesh.size"
    ),
    Status.TOO_MANY_STEPS: (
        "raise solver.max_steps and continue with --resume; or raise solver.dynamic.damping, so "
        "that the sheet comes to rest, or give a solver.dynamic.end_time"
    ),
    Status.TIME_LIMIT: "continue with --resume, or raise solver.time_limit",
    Status.NOT_FINITE: (
        "the energy is not a finite number; check moduli, densities and thicknesses for extreme "
        "values"
    ),
    Status.ENERGY_GREW: Status.ENERGY_GREW.remedy,
    Status.INTERRUPTED: "the last moment that was kept is there; continue with --resume",
}
"""What to try after each status of a motion."""


@dataclass(frozen=True)
class MotionOptions:
    """How time is divided and when to stop.

    Attributes:
        newton: of the minimisation for the equilibrium at rest.
        tolerance: largest imbalance of the forces at the end of a step [N].
        integrator: see `Integrator`.
        time_step: longest step [s].
        step_error: most that a step may err in position, by estimate [m]; infinite: all steps
            are as long as they may be.
        corners: times at which a step must end, increasing; the forces change at none after the
            last [s].
        end_time: when to stop at the latest [s].
        rest: the sheet rests when the energy that it has still to lose is this fraction of the
            largest it had.
        max_steps: most steps.
        time_limit: wall seconds.
    """

    newton: NewtonOptions
    tolerance: float
    integrator: Integrator
    time_step: float
    step_error: float = float("inf")
    corners: tuple[float, ...] = ()
    end_time: float = float("inf")
    rest: float = 1e-6
    max_steps: int = 100_000
    time_limit: float = float("inf")


class Account(Protocol):
    """Keeps the balance of energy."""

    @property
    def largest(self) -> float:
        """Largest kinetic and elastic energy so far [J]."""
        ...

    @property
    def made(self) -> float:
        """Energy that the steps have made out of nothing so far, less what they took [J]."""
        ...

    def weigh(self, before: Moment, after: Moment) -> tuple[float, float]:
        """Energy that a step would make out of nothing, negative where it takes some, and the
        kinetic and elastic energy after it [J]."""
        ...

    def enter(self, before: Moment, after: Moment) -> None:
        """Take a step into the account."""
        ...


@dataclass(frozen=True, eq=False)
class Motion:
    """How a motion ended.

    Attributes:
        last: the last moment; where the sheet rests, the equilibrium.
        status: how it ended; `REMEDIES` says what to do.
        detail: more of it, for people.
        at_rest: True when the sheet came to rest.
        negative_pivots: of the static Hessian at rest; 0 in motion.
        settled_by: largest distance from the last moment in motion to the equilibrium [m].
    """

    last: Moment
    status: Status
    detail: str = ""
    at_rest: bool = False
    negative_pivots: int = 0
    settled_by: float = 0.0


def start_of_motion(at: SystemAt, inertia: Inertia, x: Floats, options: MotionOptions) -> Moment:
    """The moment at time 0 of a sheet that is let go at rest at x, shape (n,)."""
    _, gradient = at(0.0).gradient(x)
    acceleration = np.zeros_like(x)
    heavy = inertia.mass > 0.0
    if options.integrator is Integrator.TRAPEZOIDAL:
        acceleration[heavy] = -gradient[heavy] / inertia.mass[heavy]
    return Moment(0, 0.0, x, np.zeros_like(x), acceleration, options.time_step)


def move(
    at: SystemAt,
    static: SystemAt,
    inertia: Inertia,
    start: Moment,
    options: MotionOptions,
    *,
    account: Account,
    on_event: Listener = silent,
    on_moment: Callable[[Moment, Moment], None] | None = None,
) -> Motion:
    """Step through time until the sheet rests or the time is over.

    Each step depends on the moment before it alone, so a motion that was cut off goes on exactly
    as it would have. A step of implicit Euler is that of Zhang, Alon, Jawed, section Discrete
    Elastic Shells Method; as a minimisation it is that of Martin et al., Example-based elastic
    materials, ACM Transactions on Graphics 30, 2011. The trapezoidal rule is Newmark's, A method
    of computation for structural dynamics, Journal of the Engineering Mechanics Division 85, 1959.

    Args:
        at: the problem at a time.
        static: the same without rigid motions, to see whether the sheet rests.
        inertia: masses and damping.
        start: where to begin.
        options: steps, integrator, and ends.
        account: keeps the balance of energy.
        on_event: told of every step.
        on_moment: called with the moments before and after every step.

    Returns:
        How it ended. A failure is a status.
    """
    here = start
    deadline = perf_counter() + options.time_limit
    options = replace(options, newton=replace(options.newton, deadline=deadline))
    runs_away = options.integrator is Integrator.TRAPEZOIDAL
    quiet = options.corners[-1] if options.corners else 0.0
    try:
        while here.time < options.end_time:
            if here.index >= options.max_steps:
                return Motion(here, Status.TOO_MANY_STEPS, f"{options.max_steps} steps were made")
            taken = _step(at, inertia, here, options, account, on_event)
            if isinstance(taken, Motion):
                return taken
            before, here = here, taken
            account.enter(before, here)
            if on_moment is not None:
                on_moment(before, here)
            if runs_away and account.made > GAIN * account.largest:
                gain = f"{account.made:.2g} J of {account.largest:.2g} J came from nothing"
                return Motion(here, Status.ENERGY_GREW, gain)
            over = here.time >= options.end_time
            if over or (here.time >= quiet and here.index % LOOK_EVERY == 0):
                rest = _rest(static(here.time), inertia, here, options, account.largest)
                if rest is not None:
                    return rest
    except KeyboardInterrupt:
        return Motion(here, Status.INTERRUPTED, "stopped by the user")
    return Motion(here, Status.COMPLETED, f"still in motion at {options.end_time:g} s")


def _step(
    at: SystemAt,
    inertia: Inertia,
    here: Moment,
    options: MotionOptions,
    account: Account,
    on_event: Listener,
) -> Moment | Motion:
    """One accepted step, or how the motion ends because there is none."""
    planned, least = here.step, SHORTEST * options.time_step
    small = options.newton.residual_tolerance * float(np.ptp(here.x))
    while True:
        time = _landing(here.time, planned, options)
        size = time - here.time
        system = at(time)
        before = system.work.iterations, system.work.factorisations
        pull = Pull.of(system, inertia, here, size, options.integrator)
        found = _minimum(system, pull, options)
        if found.outcome is Outcome.OUT_OF_TIME:
            return Motion(here, Status.TIME_LIMIT, f"{options.time_limit:g} s have passed")
        factor, reason = 0.5, found.outcome.replace("_", " ")
        if found.outcome is Outcome.CONVERGED:
            moment, error = pull.arrival(found.x, found.residual, time)
            factor, reason = _factor(error, options), f"an error of {error:.2g} m"
            if error <= options.step_error:
                made, after = account.weigh(here, moment)
                allowed = STEP_GAIN * max(account.largest, after, small)
                if made <= allowed or options.integrator is Integrator.IMPLICIT_EULER:
                    break
                factor, reason = 0.5, f"{made:.2g} J out of nothing"
        on_event(TimeStepRejected(time, size, reason))
        planned = factor * size
        if planned < least:
            endless = found.outcome is Outcome.NOT_FINITE
            status = Status.NOT_FINITE if endless else Status.STEP_TOO_SMALL
            return Motion(here, status, f"a step from {here.time:.6g} s ended with {reason}")
    cost = system.work.iterations - before[0], system.work.factorisations - before[1]
    on_event(MomentReached(moment.index, time, size, moment.residual, *cost))
    # A step that a corner cut short says nothing against the one that was planned.
    longer = max(factor * size, planned if size < planned else 0.0)
    return replace(moment, step=min(longer, options.time_step))


def _factor(error: float, options: MotionOptions) -> float:
    """By how much the step may change, given its estimated error."""
    if not error > 0.0 or not np.isfinite(options.step_error):
        return LONGER
    power = 1.0 / (options.integrator.order + 1)
    return float(min(max(MARGIN * (options.step_error / error) ** power, SHORTER), LONGER))


def _landing(now: float, size: float, options: MotionOptions) -> float:
    """When a step ends: at the next corner, where that is near or passed."""
    end = min(t for t in (*options.corners, options.end_time, float("inf")) if t > now)
    return end if now + 1.001 * size >= end else now + size


def _minimum(system: System, pull: Pull, options: MotionOptions) -> Minimum:
    """The end of a step, from the better of two guesses.

    Where rounding stops the search short of its tolerance, that of equilibria is good enough.
    """
    moving = replace(system, energy=Moving(system.energy, pull))
    start = pull.start.x
    rounding = ROUNDING * float(pull.diagonal.max(initial=0.0)) * float(np.abs(start).max())
    tolerance = max(options.tolerance, rounding)
    guess = min((moving.toward(start, pull.guess()), start), key=moving.value)
    found = minimise(moving, guess, replace(options.newton, residual_tolerance=tolerance))
    enough = found.residual <= max(options.newton.residual_tolerance, rounding)
    stuck = (Outcome.LINE_SEARCH_FAILED, Outcome.TOO_MANY_ITERATIONS)
    if found.outcome in stuck and enough:
        return replace(found, outcome=Outcome.CONVERGED)
    return found


def _rest(
    system: System, inertia: Inertia, here: Moment, options: MotionOptions, scale: float
) -> Motion | None:
    """The equilibrium, when what the sheet still has to lose is next to nothing.

    That is its kinetic energy and, to second order, the height of the energy above the
    equilibrium, ½ gᵀ H⁻¹ g.
    """
    kinetic = inertia.kinetic(here.velocity)
    if kinetic > options.rest * scale:
        return None
    try:
        _, gradient, data = system.hessian(here.x)
        if not system.factorise(data):
            return _saddle(system, here, options)
        if kinetic + 0.5 * float(gradient @ system.solve(gradient)) > options.rest * scale:
            return None
        found = minimise(system, here.x, options.newton)
        if found.outcome is not Outcome.CONVERGED:
            return None
        pivots, x, gradient = negative_pivots(system, found.x)
    except SingularMatrixError:
        return None
    still = np.zeros_like(x)
    residual = float(np.abs(gradient).max(initial=0.0))
    return Motion(
        replace(here, x=x, velocity=still, acceleration=still, residual=residual),
        Status.COMPLETED if pivots == 0 else Status.UNSTABLE,
        at_rest=True,
        negative_pivots=pivots,
        settled_by=float(np.abs((x - here.x)[inertia.mass > 0.0]).max(initial=0.0)),
    )


def _saddle(system: System, here: Moment, options: MotionOptions) -> Motion | None:
    """The end on a saddle, where no force is left that could carry the sheet off it."""
    _, gradient = system.gradient(here.x)
    if np.abs(gradient).max(initial=0.0) > 10.0 * options.newton.residual_tolerance:
        return None
    pivots, x, _ = negative_pivots(system, here.x)
    return Motion(
        replace(here, x=x),
        Status.UNSTABLE,
        f"{pivots} negative pivots",
        at_rest=True,
        negative_pivots=pivots,
    )
