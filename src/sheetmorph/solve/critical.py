"""Where equilibria along a loading path lose their stability, and the shape they then take."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import ComputationError
from sheetmorph.solve.system import System

Floats = NDArray[np.float64]

Equilibrium = Callable[[System, Floats], "Floats | None"]
"""From a system and a guess to an equilibrium of it, stable or not; None where there is none."""

POWERS = 60
"""Most steps of inverse iteration."""


@dataclass(frozen=True, eq=False)
class Critical:
    """The first equilibrium on a path whose Hessian is not positive definite.

    Attributes:
        ramp: where the smallest eigenvalue is zero.
        x: the equilibrium there, shape (n,) [m].
        mode: its eigenvector, zero at held degrees of freedom; the largest component of the
            degrees of freedom is 1, shape (n,).
        eigenvalue: the one next to zero, of what is left there [N/m].
        negative_pivots: of the Hessian at the first of the given ramps beyond; more than 1 where
            several eigenvalues have passed zero, as those of a double mode do.
        steps: equilibria that were sought.
    """

    ramp: float
    x: Floats
    mode: Floats
    eigenvalue: float
    negative_pivots: int
    steps: int


@dataclass(frozen=True, eq=False)
class _Point:
    """An equilibrium, its negative eigenvalues, and the one next to zero with its vector."""

    ramp: float
    x: Floats
    negative: int
    eigenvalue: float
    mode: Floats

    @property
    def height(self) -> float:
        """Above zero where stable, below where not, and zero at the critical ramp alone."""
        size = abs(self.eigenvalue)
        return -max(size, np.finfo(float).tiny) if self.negative else size


def stationary(system: System, guess: Floats, tolerance: float, most: int = 20) -> Floats | None:
    """A stationary point of the energy near a guess, by Newton's method without safeguards.

    It does not mind whether the point is a minimum, so that it follows a path beyond the place
    where the path loses its stability.

    Args:
        system: the problem.
        guess: shape (n,) [m].
        tolerance: largest residual force [N].
        most: steps after which it gives up.

    Returns:
        The point, shape (n,); None where the steps do not converge or the Hessian is singular.
    """
    x = guess
    for _ in range(most + 1):
        _, gradient, data = system.hessian(x)
        residual = float(np.abs(gradient).max(initial=0.0))
        if not np.isfinite(residual):
            return None
        if residual <= tolerance:
            return x
        if system.factorise_indefinite(data) is None:
            return None
        x = x - system.solve(gradient)
    return None


def first_critical(
    system: System,
    start: Floats,
    ramps: Sequence[float],
    equilibrium: Equilibrium,
    *,
    load: float = 0.0,
    accuracy: float = 1e-8,
) -> Critical | None:
    """The first place on a path of equilibria where the Hessian loses its definiteness.

    The ramps are passed in turn until pivots of the Hessian are negative: by Sylvester's law
    of inertia as many as eigenvalues are. Between the last two, Brent's method finds the zero of
    the eigenvalue next to zero, with the sign that the pivots give it.

    Args:
        system: the problem; its energy may stand at any ramp.
        start: guess of the equilibrium at the first ramp, shape (n,) [m].
        ramps: fractions of the actuation, increasing. Eigenvalues that pass zero and come back
            between neighbours are not seen.
        equilibrium: finds the equilibria, such as `stationary` with a tolerance; its guess is
            the path so far, extrapolated.
        load: fraction of the perturbation load.
        accuracy: of the ramp, as a fraction of it.

    Returns:
        The place; None where the Hessian is positive definite at all ramps.

    Raises:
        ComputationError: the path has no equilibrium at one of the ramps, or begins unstable.
    """
    from scipy.optimize import brentq

    walk = _Walk(system, equilibrium, load)
    before = walk.at(float(ramps[0]), start)
    if before.height <= 0.0:
        raise ComputationError(f"the equilibrium at the first ramp, {ramps[0]:g}, is not stable")
    for ramp in ramps[1:]:
        beyond = walk.at(float(ramp))
        if beyond.height <= 0.0:
            break
        before = beyond
    else:
        return None
    seen = {point.ramp: point for point in (before, beyond)}

    def height(ramp: float) -> float:
        if ramp not in seen:
            seen[ramp] = walk.at(ramp)
        return seen[ramp].height

    found = seen[
        brentq(height, before.ramp, beyond.ramp, xtol=accuracy * beyond.ramp, rtol=accuracy)
    ]
    return Critical(found.ramp, found.x, found.mode, found.eigenvalue, beyond.negative, walk.steps)


class _Walk:
    """Equilibria at ramps asked for, each guessed from the last two."""

    def __init__(self, system: System, equilibrium: Equilibrium, load: float) -> None:
        self._system, self._equilibrium, self._load = system, equilibrium, load
        self._known: list[tuple[float, Floats]] = []
        self.steps = 0

    def at(self, ramp: float, guess: Floats | None = None) -> _Point:
        """The equilibrium, its pivots and the eigenvalue next to zero."""
        here = self._system.at(ramp, self._load)
        self.steps += 1
        x = self._equilibrium(here, self._guess(ramp) if guess is None else guess)
        if x is None:
            raise ComputationError(f"no equilibrium was found at the ramp {ramp:g}")
        self._known = [*self._known[-1:], (ramp, x)]
        _, _, data = here.hessian(x)
        negative = here.factorise_indefinite(data)
        if negative is not None:
            return _Point(ramp, x, negative, *_next_to_zero(here))
        # A zero to working accuracy; a little more stiffness, and the others can be counted.
        shift = 1e-14 * float(np.abs(data[here.held.diagonal]).max()) or 1.0
        while (negative := here.factorise_indefinite(data, shift)) is None:
            shift *= 10.0
        return _Point(ramp, x, negative, 0.0, _next_to_zero(here)[1])

    def _guess(self, ramp: float) -> Floats:
        last, x = self._known[-1]
        before, past = self._known[0]
        return x if last == before else x + (ramp - last) / (last - before) * (x - past)


def _next_to_zero(system: System) -> tuple[float, Floats]:
    """The smallest eigenvalue by size and its vector: inverse iteration with the last factor."""
    held = system.held.held
    vector = np.random.default_rng(0).standard_normal(len(held))
    vector[held] = 0.0
    vector /= np.linalg.norm(vector)
    value = np.inf
    for _ in range(POWERS):
        after = system.solve(vector)
        after[held] = 0.0
        before, value = value, 1.0 / float(vector @ after)
        vector = after / np.linalg.norm(after)
        if abs(value - before) <= 1e-9 * abs(value):
            break
    return value, vector / vector[np.abs(vector).argmax()]
