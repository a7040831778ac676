"""From a design to a number: how far its computed shape is from what was measured."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from time import perf_counter
from typing import Any

import numpy as np

from sheetmorph.calibrate.curves import Curve
from sheetmorph.calibrate.parameters import Parameter, with_parameters
from sheetmorph.calibrate.repose import Fit, Points, repose
from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import InputError
from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats
from sheetmorph.study.result import Result
from sheetmorph.study.simulate import simulate

FEWEST = 2000
"""Points that stand for a scan that has fewer corners, and at least as many for the shape."""

ALIKE = 4.0
"""Mean squared correlation of about 2000 points, times their number, below which they are noise.

Estimated from white noise it is 0.8 to 2; where a shape is wrong by 5 % of its width, 130 and more.
"""

MOST = 100_000
"""Points that stand for a scan at most, unless asked otherwise."""

FAILED = 1.0
"""Misfit of a simulation that reached its end is below this; one that failed lies above."""


@dataclass(frozen=True, eq=False)
class ScanTarget:
    """A scan to come close to.

    Attributes:
        name: for people.
        points: of the face that is compared, in the scan's own unit, shape (V, 3).
        triangles: shape (T, 3).
        pose: from the scan to the shape, where the search for the pose begins.
        fixed_scale: True when the scan's unit of length is known.
        weight: in the mean of the squared misfits of all targets.
        most: points that stand for it at most.
        one_way: True to measure from the scan to the shape alone, see `where_noise_is_left`.
    """

    name: str
    points: Floats
    triangles: Any
    pose: Similarity
    fixed_scale: bool = False
    weight: float = 1.0
    most: int = MOST
    one_way: bool = False

    def __getstate__(self) -> dict[str, Any]:
        # The search tree of the surface cannot go to another process; it is built there.
        return {entry.name: getattr(self, entry.name) for entry in fields(self)}

    @cached_property
    def surface(self) -> Surface:
        """The scan as a surface."""
        return Surface(self.points, self.triangles)

    @cached_property
    def samples(self) -> Points:
        """Points that stand for it: its corners, or, where they are few or too many, a sample.

        Noise that differs from corner to corner averages out over all of them; a sample of a
        dense scan would throw that away.
        """
        corners = len(self.surface.used)
        if FEWEST <= corners <= self.most:
            return Points.corners(self.surface)
        return Points.sampled(self.surface, min(max(corners, FEWEST), self.most))

    def on(self, shape: Surface) -> Points | None:
        """Points that stand for a computed shape, a few because it is smooth; None one way."""
        return None if self.one_way else Points.on_triangles(shape, min(self.most, FEWEST))

    def lay_on(self, shape: Surface) -> Fit:
        """The scan in its best pose on a shape, near the pose that is known."""
        return repose(
            self.surface,
            self.samples,
            shape,
            self.on(shape),
            self.pose,
            fixed_scale=self.fixed_scale,
        )

    def by_points(self, result: Result) -> ScanTarget:
        """The same, measured from the scan to the shape alone, begun at the pose found now."""
        one_way = replace(self, one_way=True)
        return replace(one_way, pose=one_way.lay_on(shape_of(result)).pose)


@dataclass(frozen=True, eq=False)
class CurveTarget:
    """A curve of h/d to come close to.

    Attributes:
        curve: the measured one.
        weight: in the mean of the squared misfits of all targets.
    """

    curve: Curve
    weight: float = 1.0

    @property
    def name(self) -> str:
        """For people."""
        return self.curve.name


Target = ScanTarget | CurveTarget


@dataclass(frozen=True)
class Evaluation:
    """One design of the search, simulated and measured.

    Attributes:
        values: of the parameters, in SI units.
        misfit: weighted root mean square of the parts; above `FAILED` where the simulation
            did not reach its end, by as much as was missing.
        parts: of each target: the rms distance both ways over the size of the scan, without
            unit; or the rms difference of h/d over the curve's largest h/d.
        rms: of each target: the rms distance both ways [m], or the rms difference of h/d.
        scales: length of one unit of each scan [m]; 0 for a curve.
        status: how the simulation ended.
        seconds: it took.
    """

    values: tuple[float, ...]
    misfit: float
    parts: tuple[float, ...] = ()
    rms: tuple[float, ...] = ()
    scales: tuple[float, ...] = ()
    status: str = "completed"
    seconds: float = 0.0

    @property
    def completed(self) -> bool:
        """Whether the simulation reached its end."""
        return self.status == "completed"


@dataclass(frozen=True, eq=False)
class Task:
    """What a search needs to measure a candidate; goes to other processes as it is.

    Attributes:
        design: the design that is fitted.
        parameters: what is varied.
        targets: what is compared with.
    """

    design: Design
    parameters: tuple[Parameter, ...]
    targets: tuple[Target, ...]
    run: Callable[[Design], Result] = field(default=simulate)

    def evaluate(self, values: Sequence[float]) -> Evaluation:
        """Simulate the design with these values of the parameters, and measure it.

        Raises:
            KeyboardInterrupt: the simulation was interrupted.
        """
        began = perf_counter()
        given = tuple(float(value) for value in values)
        try:
            result = self.run(with_parameters(self.design, self.parameters, given))
        except InputError:
            # Bounds are each allowed by themselves; together they may not be.
            return Evaluation(given, 2.0 * FAILED, status="not_allowed")
        if result.status == "interrupted":
            raise KeyboardInterrupt
        if result.status != "completed":
            missing = 1.0 - float(result.summary["actuation_reached"])
            seconds = perf_counter() - began
            return Evaluation(given, FAILED + missing, status=result.status, seconds=seconds)
        measured = [_measure(target, result) for target in self.targets]
        parts, rms, scales = zip(*measured, strict=True)
        weights = np.array([target.weight for target in self.targets])
        square = float(weights @ np.square(parts) / weights.sum())
        return Evaluation(
            given,
            min(float(np.sqrt(square)), FAILED),
            parts,
            rms,
            scales,
            seconds=perf_counter() - began,
        )

    def own_values(self) -> tuple[float, ...]:
        """The values that the design has itself."""
        return tuple(parameter.own(self.design) for parameter in self.parameters)


def shape_of(result: Result) -> Surface:
    """The final shape of a simulation."""
    return Surface(result.positions[-1], result.mesh.triangles.astype(np.int64))


def _measure(target: Target, result: Result) -> tuple[float, float, float]:
    """Misfit without unit, rms, and scale."""
    if isinstance(target, CurveTarget):
        curve = target.curve
        rms = float(np.sqrt(curve.weights @ curve.differences(result) ** 2))
        return rms / curve.size, rms, 0.0
    fit = target.lay_on(shape_of(result))
    return fit.rms_in_scan / target.surface.size, fit.rms, fit.pose.scale


def independent_residuals(target: Target, result: Result) -> float:
    """How many independent numbers the residuals of a target are worth.

    Residuals of neighbouring points of a scan resemble each other where the model is wrong,
    and differ where the scanner is noisy. The number is that with which a sum of squares of
    independent residuals would vary as much: (Σ C_ii)² / Σ C_ij² (Satterthwaite 1946), with
    the correlations C estimated as a function of distance. Of noise alone all are independent.
    """
    if isinstance(target, CurveTarget):
        return float(len(target.curve.at))
    if target.one_way:
        return float(len(target.samples.points))
    likeness, _, total = _likeness(target, result)
    return float(np.clip(1.0 / (likeness + 1.0 / total), 2.0, total))


def where_noise_is_left(target: ScanTarget, result: Result) -> ScanTarget | None:
    """The target `by_points`, where its residuals differ from point to point as noise does.

    Then the points' own distances are all the information there is, and their least squares
    the most likely fit. The way back to a surface through noisy points is of no use then: it
    finds those of them that happen to be near, and dense ones crumple that surface.

    Returns:
        None where the residuals say that the model is wrong.
    """
    one_way = target.by_points(result)
    likeness, taken, _ = _likeness(one_way, result)
    return one_way if likeness < ALIKE / taken else None


def _likeness(target: ScanTarget, result: Result) -> tuple[float, int, int]:
    """Mean squared correlation of residuals of different points; points used, points in all."""
    fit = target.lay_on(shape_of(result))
    total = len(fit.signed)
    thin = max(1, round(total / FEWEST))  # memory grows with the square
    signed, points = fit.signed[::thin], target.samples.points[::thin]
    count = len(signed)
    square = float(np.mean(signed**2))
    if square <= 0.0:
        return 0.0, count, total
    distance = np.linalg.norm(points[:, None] - points[None], axis=2)
    products = np.outer(signed, signed) / square
    rings = (distance / (target.surface.size / 60)).astype(np.intp)
    np.fill_diagonal(rings, rings.max() + 1)  # every point with itself, a ring of its own
    pairs = np.bincount(rings.ravel())[:-1]
    sums = np.bincount(rings.ravel(), weights=products.ravel())[:-1]
    pairs, sums = pairs[pairs > 0], sums[pairs > 0]
    correlation = np.clip(sums / pairs, -1.0, 1.0)
    # By chance alone the square is 1 over the pairs, each of which is counted twice.
    likeness = float(pairs @ (correlation**2 - 2.0 / pairs)) / count**2
    return max(likeness, 0.0), count, total
