"""Newton's method with line search, convexified where needed, and re-used factors."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from sheetmorph.solve.linear import SingularMatrixError
from sheetmorph.solve.system import System

Floats = NDArray[np.float64]


ROUNDING = 1e-15
"""Size of a Newton step over that of x which rounding makes: some units in the last place."""


class Outcome(StrEnum):
    """How a minimisation ended."""

    CONVERGED = "converged"
    TOO_MANY_ITERATIONS = "too_many_iterations"
    LINE_SEARCH_FAILED = "line_search_failed"
    SINGULAR = "singular"
    NOT_FINITE = "not_finite"
    OUT_OF_TIME = "out_of_time"


@dataclass(frozen=True)
class NewtonOptions:
    """When to stop and when to factorise.

    Attributes:
        residual_tolerance: largest residual force that counts as equilibrium [N].
        max_iterations: Newton steps, re-used factors not counted.
        chord_ratio: a factor is used again while the residual falls below this ratio per step.
        max_chords: at most so many steps with a re-used factor in a row.
        max_halvings: of a step in the line search.
        deadline: `time.perf_counter()` at which to give up.
        max_shifts: attempts to make even the convex part positive definite by a shift.
    """

    residual_tolerance: float
    max_iterations: int = 60
    chord_ratio: float = 0.2
    max_chords: int = 8
    max_halvings: int = 30
    deadline: float = float("inf")
    max_shifts: int = 20


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where a minimisation ended.

    Attributes:
        outcome: how it ended.
        x: the degrees of freedom, shape (n,).
        energy: there [J].
        gradient: there, zero at held degrees of freedom [N], shape (n,).
        iterations: Newton steps taken.
        stable: True when the last Hessian on the way was positive definite.
    """

    outcome: Outcome
    x: Floats
    energy: float
    gradient: Floats
    iterations: int
    stable: bool

    @property
    def residual(self) -> float:
        """Largest force on a free degree of freedom [N]."""
        return float(np.abs(self.gradient).max(initial=0.0))


@dataclass(frozen=True, eq=False)
class Point:
    """A place, with energy and gradient."""

    x: Floats
    energy: float
    gradient: Floats

    @property
    def residual(self) -> float:
        """Largest component of the gradient [N]."""
        return float(np.abs(self.gradient).max(initial=0.0))


def minimise(system: System, start: Floats, options: NewtonOptions) -> Minimum:
    """Find a local minimum of the energy from a starting point.

    Newton steps with the exact Hessian; where it is not positive definite, its positive
    semidefinite part is mixed in until it is, so that every step descends. Steps are halved
    until the energy decreases enough (Armijo), beginning with the part that the energy allows
    (contact). While the residual falls fast, the last factor is used again (chord steps), because
    a back-substitution costs a tenth of a factorisation.
    Reference: Nocedal and Wright, Numerical Optimization, chapters 3 and 11.

    Returns:
        The place reached, with how it ended; nothing is raised for a failed search.
    """
    try:
        return _minimise(system, start, options)
    except SingularMatrixError:
        # The library failed, or the numbers did: the caller goes back and takes a shorter step.
        nowhere = np.full_like(start, np.nan)
        return Minimum(Outcome.SINGULAR, start, np.nan, nowhere, 0, False)


def _minimise(system: System, start: Floats, options: NewtonOptions) -> Minimum:
    energy, gradient, data = system.hessian(start)
    point = Point(start, energy, gradient)
    level, iterations = 0, 0

    def end(outcome: Outcome) -> Minimum:
        return Minimum(outcome, point.x, point.energy, point.gradient, iterations, level == 0)

    while True:
        if not np.isfinite(point.energy) or not np.isfinite(point.residual):
            return end(Outcome.NOT_FINITE)
        if point.residual <= options.residual_tolerance and iterations > 0:
            return end(Outcome.CONVERGED)
        if perf_counter() > options.deadline:
            return end(Outcome.OUT_OF_TIME)
        if iterations >= options.max_iterations:
            return end(Outcome.TOO_MANY_ITERATIONS)
        if iterations > 0:
            _, _, data = system.hessian(point.x)
        taken = _factorise_positive(system, point.x, data, max(0, level - 1), options)
        if taken is None:
            return end(Outcome.SINGULAR)
        level = taken
        iterations += 1
        system.work.iterations += 1
        step = -system.solve(point.gradient)
        if level == 0 and iterations > 1 and _drowns(step, point.x):
            return end(Outcome.CONVERGED)
        found = _line_search(system, point, step, options)
        if found is None:
            if point.residual <= options.residual_tolerance:
                return end(Outcome.CONVERGED)
            return end(Outcome.LINE_SEARCH_FAILED)
        before, point = point, found
        if level == 0:
            point = _chords(system, before, point, options)


def _drowns(step: Floats, x: Floats) -> bool:
    """True for a step that is lost in the rounding of x: x is as good as its digits allow."""
    return float(np.abs(step).max(initial=0.0)) <= ROUNDING * float(np.abs(x).max(initial=0.0))


CONVEXITY = (0.0, 0.1, 0.3, 0.6, 1.0)
"""Shares of the convex part that are mixed into an indefinite Hessian, in turn."""


def _factorise_positive(
    system: System, x: Floats, data: Floats, level: int, options: NewtonOptions
) -> int | None:
    """Factorise the mix of Hessian and convex part with the least convexity that is positive.

    Mixing weakens exactly the terms that destabilise and leaves the rest, whatever their
    scales; a multiple of the identity that outweighs compressed edges would freeze bending.

    Args:
        system: the problem.
        x: where the Hessian was taken.
        data: its entries.
        level: index into CONVEXITY to begin with.
        options: how many shifts to try at the end.

    Returns:
        The index that was taken; None when not even shifts of the convex part helped.
    """
    convex: Floats | None = None
    for index in range(level, len(CONVEXITY)):
        share = CONVEXITY[index]
        mixed = data
        if share > 0.0:
            if convex is None:
                _, _, convex = system.hessian(x, convex=True)
            mixed = data + share * (convex - data)
        if system.factorise(mixed):
            return index
    assert convex is not None or level == 0  # noqa: S101
    shift = 1e-12 * float(np.abs(data[system.held.diagonal]).mean())
    for _ in range(options.max_shifts):
        if convex is not None and system.factorise(convex, shift):
            return len(CONVEXITY) - 1
        shift *= 10.0
    return None


def _line_search(
    system: System, point: Point, step: Floats, options: NewtonOptions
) -> Point | None:
    """The first of the halved steps that decreases the energy enough, with its gradient."""
    slope = float(point.gradient @ step)
    noise = 1e-13 * abs(point.energy)
    length = system.reach(point.x, step)
    for _ in range(options.max_halvings):
        x = point.x + length * step
        energy, gradient = system.gradient(x)
        trial = Point(x, energy, gradient)
        if energy <= point.energy + 1e-4 * length * slope:
            return trial
        # Near the minimum the decrease drowns in rounding: judge by the residual instead.
        if abs(energy - point.energy) <= noise and trial.residual < point.residual:
            return trial
        length *= 0.5
    return None


def _chords(system: System, before: Point, point: Point, options: NewtonOptions) -> Point:
    """Go on with the last factor while that pays."""
    for _ in range(options.max_chords):
        if point.residual <= options.residual_tolerance:
            break
        if not point.residual < options.chord_ratio * before.residual:
            break
        step = -system.solve(point.gradient)
        if system.reach(point.x, step) < 1.0:
            break
        x = point.x + step
        energy, gradient = system.gradient(x)
        trial = Point(x, energy, gradient)
        if not trial.residual < point.residual:
            break
        before, point = point, trial
    return point
