"""Curves of equilibria through limit points: arc-length control and displacement control."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import ComputationError
from sheetmorph.core.sparse import SymmetricPattern
from sheetmorph.solve.system import Energy, System, allowed

Floats = NDArray[np.float64]

Loading = Callable[[float], System]
"""The problem at a value of the parameter that drives it, such as the size of a force."""


@dataclass(frozen=True, eq=False)
class Pushed:
    """An energy under one more dead force: E − a f·x.

    Attributes:
        energy: without it.
        force: f at the amount 1 [N], shape (n,).
        amount: a.
    """

    energy: Energy
    force: Floats
    amount: float

    @property
    def pattern(self) -> SymmetricPattern:
        """Pattern of the Hessian."""
        return self.energy.pattern

    @property
    def linear_in_ramp(self) -> bool:
        """As without the force."""
        return bool(getattr(self.energy, "linear_in_ramp", True))

    def at(self, ramp: float, load: float) -> Self:
        """The same force at another point of the path."""
        return replace(self, energy=self.energy.at(ramp, load))

    def reach(self, x: Floats, step: Floats) -> float:
        """As without the force."""
        return allowed(self.energy, x, step)

    def evaluate(self, x: Floats, order: int) -> tuple[float, Floats | None, Floats | None]:
        """See `Energy.evaluate`."""
        energy, gradient, data = self.energy.evaluate(x, order)
        if gradient is not None:
            gradient = gradient - self.amount * self.force
        return energy - self.amount * float(self.force @ x), gradient, data


def pushed(system: System, force: Floats) -> Loading:
    """A system under a force whose amount is the parameter.

    Args:
        system: the problem, at its ramp and load.
        force: at the amount 1 [N], shape (n,).
    """
    return lambda amount: replace(system, energy=Pushed(system.energy, force, amount))


def actuated(system: System, load: float = 0.0) -> Loading:
    """A system whose parameter is the ramp, at a fraction of the perturbation load."""
    return lambda ramp: system.at(ramp, load)


@dataclass(frozen=True, eq=False)
class CurvePoint:
    """An equilibrium on a curve.

    Attributes:
        x: the state, shape (n,) [m].
        parameter: value of the parameter there.
        negative_pivots: of the Hessian; 0 where the state is stable while the parameter is held.
    """

    x: Floats
    parameter: float
    negative_pivots: int


@dataclass(frozen=True, eq=False)
class LimitPoint(CurvePoint):
    """A place where the parameter turns round: there a sheet under that load snaps.

    Attributes:
        kind: "maximum" or "minimum" of the parameter along the curve.
    """

    kind: Literal["maximum", "minimum"]


@dataclass(frozen=True, eq=False)
class Curve:
    """Equilibria in the order in which they lie on a curve, and its limit points."""

    points: tuple[CurvePoint, ...]
    limits: tuple[LimitPoint, ...]


@dataclass(frozen=True)
class ArcOptions:
    """How a curve is followed.

    Attributes:
        tolerance: largest residual force [N].
        length: a displacement that counts as much as `amount` [m].
        amount: a change of the parameter that counts as 1.
        first_step, max_step, min_step: of the arc length, whose square is the mean square
            displacement over `length` squared and the change over `amount` squared.
        max_points: most points.
        corrections: most Newton steps for a point.
        accuracy: of limit points, as a fraction of a step.
    """

    tolerance: float
    length: float
    amount: float
    first_step: float = 0.1
    max_step: float = 1.0
    min_step: float = 1e-6
    max_points: int = 200
    corrections: int = 8
    accuracy: float = 1e-9


def trace(
    loading: Loading,
    x: Floats,
    parameter: float,
    options: ArcOptions,
    stop: Callable[[CurvePoint], bool],
    *,
    direction: float = 1.0,
) -> Curve:
    """Follow a curve of equilibria by arc length, stable or not.

    The step along the tangent is corrected at right angles to it, with the Hessian's factor
    and two right-hand sides (Keller 1977; Crisfield 1981). Limit points, where the parameter turns
    round, are located by Brent's method on the last step.

    Args:
        loading: the problem by parameter.
        x: an equilibrium at the first parameter, shape (n,).
        parameter: where the curve begins.
        options: steps and limits.
        stop: ends the curve at the first point for which it is true.
        direction: sign of the change of the parameter at the beginning.

    Returns:
        The curve from its first point to that where it was stopped, or of `max_points`.

    Raises:
        ComputationError: the curve cannot be followed even in steps of `min_step`.
    """
    from scipy.optimize import brentq

    walk = _Walk(loading, options)
    here = walk.located(x, parameter, None, direction)
    points, limits = [here], []
    step = options.first_step
    while len(points) < options.max_points and not stop(here.point):
        found = walk.ahead(here, step)
        if found is None:
            step *= 0.5
            if step < options.min_step:
                raise ComputationError(
                    f"the curve of equilibria cannot be followed beyond {here.point.parameter:g}"
                )
            continue
        after, cost = found
        if here.rate * after.rate < 0.0:
            seen = {0.0: here, step: after}

            def turning(
                s: float, base: _Located = here, seen: dict[float, _Located] = seen
            ) -> float:
                if s not in seen:
                    nearer = walk.ahead(base, s)
                    if nearer is None:
                        raise ComputationError("a limit point cannot be located")
                    seen[s] = nearer[0]
                return seen[s].rate

            place = brentq(turning, 0.0, step, xtol=options.accuracy * step)
            at = seen[place].point
            kind: Literal["maximum", "minimum"] = "maximum" if here.rate > 0.0 else "minimum"
            limits.append(LimitPoint(at.x, at.parameter, at.negative_pivots, kind))
        points.append(after)
        here = after
        step = min(step * (1.5 if cost <= 3 else 0.6 if cost >= 6 else 1.0), options.max_step)
    return Curve(tuple(p.point for p in points), tuple(limits))


def displaced(
    loading: Loading,
    x: Floats,
    parameter: float,
    row: Floats,
    distances: Sequence[float],
    tolerance: float,
    *,
    corrections: int = 20,
) -> list[CurvePoint]:
    """Equilibria at prescribed values of a linear measure of displacement.

    Args:
        loading: the problem by the parameter that brings the displacement about.
        x: an equilibrium at the first parameter, shape (n,).
        parameter: its value there.
        row: r, shape (n,); the displacement is r·(x − x at the beginning).
        distances: the displacements, one after the other, in steps that Newton's method can take.
        tolerance: largest residual force [N].
        corrections: most Newton steps for each.

    Raises:
        ComputationError: there is no equilibrium near the last one with the next displacement.
    """
    origin = float(row @ x)
    size = float(np.linalg.norm(row))
    found: list[CurvePoint] = []
    for distance in distances:
        constraint = _Constraint(row / size, 0.0, (origin + distance) / size)
        solved = _correct(loading, x, parameter, constraint, tolerance, corrections)
        if solved is None:
            raise ComputationError(f"no equilibrium was found at the displacement {distance:g}")
        x, parameter, _ = solved
        negative, _ = _factored(loading(parameter), x)
        found.append(CurvePoint(x, parameter, negative))
    return found


@dataclass(frozen=True, eq=False)
class _Constraint:
    """row·x + slope × parameter = value."""

    row: Floats
    slope: float
    value: float

    def miss(self, x: Floats, parameter: float) -> float:
        return float(self.row @ x) + self.slope * parameter - self.value


@dataclass(frozen=True, eq=False)
class _Located:
    """A point with its unit tangent (along, rate) in scaled coordinates."""

    point: CurvePoint
    along: Floats
    rate: float


class _Walk:
    """Points of a curve, in coordinates scaled by length and amount."""

    def __init__(self, loading: Loading, options: ArcOptions) -> None:
        self._loading, self._options = loading, options

    def located(
        self, x: Floats, parameter: float, before: _Located | None, direction: float = 1.0
    ) -> _Located:
        """The point with its tangent, which goes on from that before."""
        unit = self._unit(x)
        negative, system = _factored(self._loading(parameter), x)
        along = -system.solve(_rate(self._loading, x, parameter, self._options.amount))
        along = along * self._options.amount / unit
        size = float(np.sqrt(1.0 + along @ along))
        along, rate = along / size, 1.0 / size
        ahead = direction * rate if before is None else along @ before.along + rate * before.rate
        if ahead < 0.0:
            along, rate = -along, -rate
        return _Located(CurvePoint(x, parameter, negative), along, rate)

    def ahead(self, here: _Located, step: float) -> tuple[_Located, int] | None:
        """The point of the curve a step ahead, and what it took; None where there is none."""
        options, start = self._options, here.point
        unit = self._unit(start.x)
        x = start.x + step * unit * here.along
        parameter = start.parameter + step * options.amount * here.rate
        row, slope = here.along / unit, here.rate / options.amount
        value = float(row @ x) + slope * parameter
        found = _correct(
            self._loading,
            x,
            parameter,
            _Constraint(row, slope, value),
            options.tolerance,
            options.corrections,
        )
        if found is None:
            return None
        after = self.located(found[0], found[1], here)
        bend = float(after.along @ here.along + after.rate * here.rate)
        # A curve that turns by more than 45° in a step may be another one.
        return (after, found[2]) if bend > 0.7 or step <= options.min_step else None

    def _unit(self, x: Floats) -> float:
        return self._options.length * float(np.sqrt(len(x)))


def _correct(
    loading: Loading,
    x: Floats,
    parameter: float,
    constraint: _Constraint,
    tolerance: float,
    most: int,
) -> tuple[Floats, float, int] | None:
    """Newton's method on equilibrium and constraint together, by block elimination."""
    for step in range(most + 1):
        system = loading(parameter)
        _, gradient, data = system.hessian(x)
        residual = float(np.abs(gradient).max(initial=0.0))
        if not np.isfinite(residual):
            return None
        miss = constraint.miss(x, parameter)
        if residual <= tolerance and step > 0:
            return x, parameter, step
        _factorise(system, data)
        scale = max(1.0, abs(parameter)) * 1e-3
        a = -system.solve(gradient)
        b = -system.solve(_rate(loading, x, parameter, scale))
        denominator = constraint.slope + float(constraint.row @ b)
        if denominator == 0.0:
            return None
        change = -(miss + float(constraint.row @ a)) / denominator
        x, parameter = x + a + change * b, parameter + change
        if not (np.isfinite(parameter) and np.isfinite(x).all()):
            return None
    return None


def _rate(loading: Loading, x: Floats, parameter: float, scale: float) -> Floats:
    """Derivative of the forces by the parameter, by a central difference."""
    reach = 1e-3 * scale
    ahead, behind = (loading(parameter + part).gradient(x)[1] for part in (reach, -reach))
    return np.asarray((ahead - behind) / (2.0 * reach))


def _factored(system: System, x: Floats) -> tuple[int, System]:
    _, _, data = system.hessian(x)
    return _factorise(system, data), system


def _factorise(system: System, data: Floats) -> int:
    """Factorise; where singular to working accuracy, with a trace of the identity."""
    negative = system.factorise_indefinite(data)
    shift = 1e-14 * float(np.abs(data[system.held.diagonal]).max()) or 1.0
    while negative is None:
        negative = system.factorise_indefinite(data, shift)
        shift *= 10.0
    return negative
