"""How well a fit knows its parameters: profiles of the misfit, and the intervals they give."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sheetmorph.calibrate.evaluations import Evaluations
from sheetmorph.calibrate.misfit import Evaluation
from sheetmorph.calibrate.search import minimise
from sheetmorph.geometry.mesh import Floats

FIRST_STEP = 0.02
"""First step away from the optimum, as a share of the bounds."""

MAX_STEPS = 9
MAX_REFINEMENTS = 3


@dataclass(frozen=True)
class Interval:
    """Where a parameter may lie, given the data.

    Attributes:
        low, high: the ends.
        low_open, high_open: True where the misfit did not rise enough before the bound: the
            data does not limit the parameter there.
        profile: values of the parameter, increasing, each with the least misfit that the other
            parameters allow.
    """

    low: float
    high: float
    low_open: bool
    high_open: bool
    profile: tuple[tuple[float, float], ...]


def allowed_rise(residuals: float, parameters: int, confidence: float) -> float:
    """How much the squared misfit may rise, relative to its least value, within an interval.

    For independent residuals with normal errors of unknown size, the squared misfit of a
    parameter held at its true value exceeds the least one by less than F(1, n − p) / (n − p)
    with this confidence (Bates and Watts 1988, section 6.1).

    Args:
        residuals: number n of independent residuals.
        parameters: number p of fitted parameters.
        confidence: such as 0.95.
    """
    from scipy.stats import f

    freedom = max(1.0, residuals - parameters)
    return float(f.ppf(confidence, 1, freedom) / freedom)


def profile(
    evaluations: Evaluations, best: Evaluation, rise: float
) -> tuple[Interval, ...]:  # fmt: skip
    """An interval for every parameter, by profiles of the misfit.

    From the optimum outward a parameter is held at one value after the other, and the others
    are fitted anew from where they were, until the squared misfit has risen by `rise`. The
    profiles run beside each other where there are several workers.

    Args:
        evaluations: what measures a candidate.
        best: the optimum.
        rise: see `allowed_rise`.
    """
    count = len(best.values)
    sides = [(index, sign) for index in range(count) for sign in (-1, 1)]
    walks = [_Walk(evaluations, best, index, sign, rise) for index, sign in sides]
    ends = evaluations.chains([walk.run for walk in walks])
    intervals = []
    for index in range(count):
        (low, low_open), (high, high_open) = ends[2 * index : 2 * index + 2]
        points = {best.values[index]: best.misfit}
        for walk in walks[2 * index : 2 * index + 2]:
            points.update(walk.points)
        intervals.append(
            Interval(min(low, best.values[index]), max(high, best.values[index]), low_open,
                     high_open, tuple(sorted(points.items())))
        )  # fmt: skip
    return tuple(intervals)


class _Walk:
    """From the optimum along one parameter to one side."""

    def __init__(
        self, evaluations: Evaluations, best: Evaluation, index: int, sign: int, rise: float
    ) -> None:
        self._evaluations, self._best = evaluations, best
        self._index, self._sign, self._rise = index, sign, rise
        self._parameters = evaluations.task.parameters
        shares = [p.to_share(v) for p, v in zip(self._parameters, best.values, strict=True)]
        self._origin = np.array(shares)
        self._trail: list[tuple[float, Floats]] = [(0.0, self._origin)]
        self.points: dict[float, float] = {}

    def run(self) -> tuple[float, bool]:
        """The end of the interval, and whether it is the bound because the misfit stays low."""
        parameter, origin = self._parameters[self._index], float(self._origin[self._index])
        room = origin if self._sign < 0 else 1.0 - origin
        inside, rise_inside = 0.0, 0.0
        outside, rise_outside = room, float("nan")
        step = min(FIRST_STEP, room)
        for _ in range(MAX_STEPS):
            if room <= 0.0:
                break
            risen = self._risen(step)
            if risen >= self._rise:
                outside, rise_outside = step, risen
                break
            inside, rise_inside = step, max(risen, 0.0)
            if step >= room:
                break
            factor = float(np.sqrt(self._rise / risen)) if risen > 0 else 4.0
            step = min(room, step * min(4.0, max(1.3, 1.05 * factor)))
        if not np.isfinite(rise_outside):
            end = origin + self._sign * (room if step >= room else inside)
            return parameter.from_share(end), True
        for _ in range(MAX_REFINEMENTS):
            near = abs(rise_outside - self._rise) < 0.1 * self._rise
            if near or outside - inside < 0.1 * outside:
                break
            step = self._crossing(inside, rise_inside, outside, rise_outside)
            risen = self._risen(step)
            if risen >= self._rise:
                outside, rise_outside = step, risen
            else:
                inside, rise_inside = step, max(risen, 0.0)
        end = self._crossing(inside, rise_inside, outside, rise_outside)
        return parameter.from_share(origin + self._sign * end), False

    def _crossing(self, inside: float, low: float, outside: float, high: float) -> float:
        """Where the rise is the allowed one: its root grows evenly near an optimum."""
        if high > 100 * self._rise:  # a cliff, such as simulations that fail
            return 0.5 * (inside + outside)
        ends = np.sqrt([low, high])
        share = (np.sqrt(self._rise) - ends[0]) / (ends[1] - ends[0])
        return inside + (outside - inside) * float(np.clip(share, 0.05, 1.0))

    def _risen(self, step: float) -> float:
        """Relative rise of the squared misfit at a step, the other parameters fitted."""
        held = float(self._origin[self._index]) + self._sign * step
        others = [index for index in range(len(self._origin)) if index != self._index]

        def measured(free: Floats) -> float:
            point = self._origin.copy()
            point[self._index], point[others] = held, free
            values = [p.from_share(s) for p, s in zip(self._parameters, point, strict=True)]
            found = self._evaluations(values)
            value = values[self._index]
            self.points[value] = min(found.misfit, self.points.get(value, np.inf))
            return (found.misfit / self._best.misfit) ** 2 - 1.0

        if not others:
            return measured(np.zeros(0))
        guess = self._guess(step)[others]
        reach = max(0.3 * (step - self._trail[-1][0]), 4e-3)
        places: dict[float, Floats] = {}

        def noted(free: Floats) -> float:
            risen = measured(free)
            places[risen] = free
            return risen

        minimise(
            noted, guess, radius=reach, final_radius=reach / 10, max_evaluations=14 * len(others)
        )
        risen = min(places)
        point = self._origin.copy()
        point[self._index], point[others] = held, places[risen]
        if step > self._trail[-1][0]:
            self._trail.append((step, point))
        return risen

    def _guess(self, step: float) -> Floats:
        """Where the others will lie: straight on from the last two places."""
        if len(self._trail) < 2:
            return self._trail[-1][1]
        (before, first), (last, second) = self._trail[-2:]
        point = second + (second - first) * (step - last) / (last - before)
        return np.clip(point, 0.0, 1.0)
