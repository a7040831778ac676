"""Following equilibria along the actuation with a predictor and adaptive steps."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import StrEnum
from time import perf_counter
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.events import Listener, StateReached, StepRejected, silent
from sheetmorph.solve.linear import SingularMatrixError
from sheetmorph.solve.minimise import Minimum, NewtonOptions, Outcome, minimise
from sheetmorph.solve.predict import predict, tangent_of
from sheetmorph.solve.stability import escape_saddle, negative_pivots
from sheetmorph.solve.system import System

Floats = NDArray[np.float64]

JUMPS = (1.0, 10.0, 40.0)
"""Steps over the smallest one that are tried where the branch ends, from its last state."""

LONG = 10
"""Newton steps of such a jump to another branch, over those of other steps."""

SHAKES = 4
"""How often a jump that stops at an edge of the energy is shaken loose."""


class Status(StrEnum):
    """How a path ended."""

    COMPLETED = "completed"
    UNSTABLE = "unstable"
    STEP_TOO_SMALL = "step_too_small"
    TOO_MANY_STEPS = "too_many_steps"
    TIME_LIMIT = "time_limit"
    NOT_FINITE = "not_finite"
    ENERGY_GREW = "energy_grew"
    INTERRUPTED = "interrupted"

    @property
    def remedy(self) -> str:
        """What to try next, for people; empty when all is well."""
        return _REMEDIES[self]


_REMEDIES = {
    Status.COMPLETED: "",
    Status.UNSTABLE: (
        "the final state is an equilibrium but not a minimum; try another perturbation load or "
        "smaller steps (solver.max_step)"
    ),
    Status.STEP_TOO_SMALL: (
        "the last state that converged is kept; try a smaller actuation.eps_pre, a smaller "
        "solver.min_step, a finer mesh.size or a larger perturbation load"
    ),
    Status.TOO_MANY_STEPS: (
        "the last state that converged is kept; raise solver.max_steps or solver.max_step"
    ),
    Status.TIME_LIMIT: (
        "the last state that converged is kept; continue with --resume, or raise solver.time_limit"
    ),
    Status.NOT_FINITE: (
        "the energy is not a finite number; check moduli and thicknesses for extreme values"
    ),
    Status.ENERGY_GREW: (
        "the steps in time made energy out of nothing; try a smaller solver.dynamic.time_step, "
        "some solver.dynamic.retardation, or the integrator implicit_euler"
    ),
    Status.INTERRUPTED: "the last state that converged is kept; continue with --resume",
}


@dataclass(frozen=True)
class Waypoint:
    """A point of the loading path: fractions of the actuation and of the perturbation load."""

    ramp: float
    load: float


@dataclass(frozen=True)
class PathOptions:
    """How the path is divided and when to give up.

    Attributes:
        newton: options of the minimisation at each point.
        initial_step: first step, as a fraction of a leg of the path.
        max_step: largest step.
        min_step: smallest step before the path is given up.
        max_steps: most states.
        time_limit: wall seconds.
        stops: fractions of a leg at which there shall be a state, increasing.
        stops_leg: index of that leg.
    """

    newton: NewtonOptions
    initial_step: float = 0.1
    max_step: float = 0.2
    min_step: float = 1e-5
    max_steps: int = 1000
    time_limit: float = float("inf")
    stops: tuple[float, ...] = ()
    stops_leg: int = 0


@dataclass(frozen=True, eq=False)
class PathState:
    """An equilibrium, and all that the next step needs to know.

    Attributes:
        x: degrees of freedom [m], shape (n,).
        tangent: dx/ds along the leg, shape (n,); zero at the start of a leg.
        leg: index of the leg of the path (from waypoint `leg` to waypoint `leg + 1`).
        s: fraction of the leg that is done.
        step: size of the next step.
        ramp: fraction of the actuation.
        load: fraction of the perturbation load.
        residual: largest residual force [N].
        negative_pivots: of the Hessian: 0 at a minimum. Counted at the state itself at the end
            of the path and where there was doubt, else on the last Newton step to it.
    """

    x: Floats
    tangent: Floats
    leg: int
    s: float
    step: float
    ramp: float
    load: float
    residual: float
    negative_pivots: int


@dataclass(frozen=True, eq=False)
class Path:
    """States that were reached, in order, and how the path ended."""

    states: tuple[PathState, ...]
    status: Status
    detail: str


def start_of_path(x: Floats, waypoints: Sequence[Waypoint], options: PathOptions) -> PathState:
    """The flat, unloaded state from which a path starts."""
    return PathState(
        x=x,
        tangent=np.zeros_like(x),
        leg=0,
        s=0.0,
        step=options.initial_step,
        ramp=waypoints[0].ramp,
        load=0.0,
        residual=0.0,
        negative_pivots=0,
    )


def follow(
    system: System,
    waypoints: Sequence[Waypoint],
    states: Sequence[PathState],
    options: PathOptions,
    *,
    equal_steps: Mapping[int, int] = MappingProxyType({}),
    on_event: Listener = silent,
    on_state: Callable[[int, PathState], None] | None = None,
) -> Path:
    """Go from the last of the given states to the last waypoint.

    Each step depends only on the last two states, so a path that was cut off goes on exactly
    as it would have.

    Args:
        system: the problem.
        waypoints: corners of the loading path; between them both fractions are linear.
        states: what is already known, at least the state of `start_of_path`.
        options: step sizes and limits.
        equal_steps: legs to walk in so many equal steps, instead of adaptive ones; halved
            where they do not converge.
        on_event: told of every state and every rejected step.
        on_state: called with index and state as soon as a state is reached, to keep it.

    Returns:
        The path. A failure is a status; all states before it are kept.
    """
    known = list(states)
    deadline = perf_counter() + options.time_limit
    options = replace(options, newton=replace(options.newton, deadline=deadline))
    try:
        while known[-1].leg < len(waypoints) - 1:
            if len(known) > options.max_steps:
                return _end(known, Status.TOO_MANY_STEPS, f"{options.max_steps} states were made")
            taken = _step(system, waypoints, known, options, equal_steps, on_event)
            if isinstance(taken, str):
                if taken == Outcome.OUT_OF_TIME:
                    return _end(known, Status.TIME_LIMIT, f"{options.time_limit:g} s have passed")
                status = Status.NOT_FINITE if taken == Outcome.NOT_FINITE else Status.STEP_TOO_SMALL
                return _end(known, status, f"Newton's method ended with {taken.replace('_', ' ')}")
            known.append(taken)
            if on_state is not None:
                on_state(len(known) - 1, taken)
    except KeyboardInterrupt:
        return _end(known, Status.INTERRUPTED, "stopped by the user")
    final = known[-1]
    status = Status.COMPLETED if final.negative_pivots == 0 else Status.UNSTABLE
    detail = "" if final.negative_pivots == 0 else f"{final.negative_pivots} negative pivots"
    return _end(known, status, detail)


def _end(states: list[PathState], status: Status, detail: str) -> Path:
    return Path(tuple(states), status, detail)


def _step(
    system: System,
    waypoints: Sequence[Waypoint],
    known: list[PathState],
    options: PathOptions,
    equal_steps: Mapping[int, int],
    on_event: Listener,
) -> PathState | str:
    """One accepted step, or the outcome of the last attempt when steps become too small."""
    last = known[-1]
    first, second = waypoints[last.leg], waypoints[last.leg + 1]
    size = last.step if last.leg not in equal_steps else 1.0 / equal_steps[last.leg]
    planned, newton, jumps = size, options.newton, list(JUMPS)
    failure = Outcome.CONVERGED
    while True:
        s = _landing(last, size, options)
        ramp = first.ramp + s * (second.ramp - first.ramp)
        load = first.load + s * (second.load - first.load)
        here = system.at(ramp, load)
        before = system.work.iterations, system.work.factorisations
        jumping = newton is not options.newton
        guess = last.x if jumping else here.toward(last.x, predict(here, known, s))
        found = minimise(here, guess, newton)
        for seed in range(SHAKES if jumping else 0):
            if found.outcome is Outcome.LINE_SEARCH_FAILED:
                found = minimise(here, here.toward(found.x, _shaken(here, found.x, seed)), newton)
        if found.outcome is Outcome.CONVERGED:
            break
        if found.outcome is Outcome.OUT_OF_TIME:
            return str(found.outcome)
        on_event(StepRejected(ramp, load, found.outcome.replace("_", " ")))
        failure = failure if jumping else found.outcome
        size = 0.5 * (s - last.s)
        if jumping or size < options.min_step:
            if not jumps:
                return str(failure)
            size = jumps.pop(0) * options.min_step
            newton = _patient(options.newton)
        planned = size
    at_end = s == 1.0
    pivots = 0
    if not found.stable or (at_end and last.leg == len(waypoints) - 2):
        try:
            found, pivots = _settle(here, found, options)
        except SingularMatrixError:
            pivots = 1  # not even its Hessian can be factorised: no proof of a minimum
    cost = system.work.factorisations - before[1]
    # No prediction across a corner, nor for the small steps of a leg walked in equal ones.
    tangent = np.zeros_like(found.x)
    if not at_end and last.leg not in equal_steps:
        with suppress(SingularMatrixError):
            rise, drop = second.ramp - first.ramp, second.load - first.load
            tangent = tangent_of(here, (ramp, load), (rise, drop), found)
    state = PathState(
        x=found.x,
        tangent=tangent,
        leg=last.leg + 1 if at_end else last.leg,
        s=0.0 if at_end else s,
        step=options.initial_step
        if at_end
        else _next_step(max(planned, s - last.s), cost, options),
        ramp=ramp,
        load=load,
        residual=found.residual,
        negative_pivots=pivots,
    )
    on_event(
        StateReached(
            len(known), ramp, load, state.residual, system.work.iterations - before[0], cost
        )
    )
    return state


def _patient(newton: NewtonOptions) -> NewtonOptions:
    """The same search with more iterations."""
    return replace(newton, max_iterations=LONG * newton.max_iterations)


def _shaken(here: System, x: Floats, seed: int) -> Floats:
    """A place beside x, by a thousandth of its extent, shape (n,); the same for the same seed."""
    push = np.random.default_rng(seed).standard_normal(len(x))
    push[here.held.held] = 0.0
    return x + 1e-3 * float(np.ptp(x)) * push


def _landing(last: PathState, size: float, options: PathOptions) -> float:
    """Where a step ends: the next stop or the end of the leg, where that is near or passed."""
    s = last.s + size
    ends = (*options.stops, 1.0) if last.leg == options.stops_leg else (1.0,)
    end = next(stop for stop in ends if stop > last.s + 1e-9)
    return end if s > end - 1e-9 or end - s < 0.2 * size else s


def _next_step(size: float, cost: int, options: PathOptions) -> float:
    """A longer step after a cheap one, a shorter one after a dear one.

    The counts and factors are those that needed the fewest factorisations over the three
    published designs, with a little growth at three factorisations for stiffer ones.
    """
    if cost <= 2:
        size *= 1.5
    elif cost == 3:
        size *= 1.2
    elif cost >= 6:
        size *= 0.7
    return min(max(size, options.min_step), options.max_step)


def _settle(here: System, found: Minimum, options: PathOptions) -> tuple[Minimum, int]:
    """Count the negative pivots at the state itself, leave a saddle, and use the factor that
    this takes for one last correction."""
    for _ in range(5):
        pivots, x, gradient = negative_pivots(here, found.x)
        found = replace(found, x=x, gradient=gradient)
        if pivots == 0:
            break
        lower = minimise(here, escape_saddle(here, found.x), _patient(options.newton))
        if lower.outcome is not Outcome.CONVERGED or not lower.energy < found.energy:
            break
        found = lower
    else:
        pivots, x, gradient = negative_pivots(here, found.x)
        found = replace(found, x=x, gradient=gradient)
    return found, pivots
