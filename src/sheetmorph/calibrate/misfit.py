"""From a design to a number: how far its computed shape is from what was measured."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
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

SAMPLES = 2000
"""Points that stand for a scan, and at least as many for the shape, unless asked otherwise."""

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
        count: number of points that stand for it.
    """

    name: str
    points: Floats
    triangles: Any
    pose: Similarity
    fixed_scale: bool = False
    weight: float = 1.0
    count: int = SAMPLES

    def __getstate__(self) -> dict[str, Any]:
        # The search tree of the surface cannot go to another process; it is built there.
        return {entry.name: getattr(self, entry.name) for entry in fields(self)}

    @cached_property
    def surface(self) -> Surface:
        """The scan as a surface."""
        return Surface(self.points, self.triangles)

    @cached_property
    def samples(self) -> Points:
        """Points that stand for it."""
        return Points.sampled(self.surface, self.count)

    def lay_on(self, shape: Surface) -> Fit:
        """The scan in its best pose on a shape, near the pose that is known."""
        return repose(
            self.surface,
            self.samples,
            shape,
            Points.on_triangles(shape, self.count),
            self.pose,
            fixed_scale=self.fixed_scale,
        )


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
    the correlations C estimated as a function of distance.
    """
    if isinstance(target, CurveTarget):
        return float(len(target.curve.at))
    fit = target.lay_on(shape_of(result))
    thin = max(1, round(target.count / SAMPLES))  # memory grows with the square
    signed, points = fit.signed[::thin], target.samples.points[::thin]
    square = float(np.mean(signed**2))
    if square <= 0.0:
        return float(target.count)
    distance = np.linalg.norm(points[:, None] - points[None], axis=2)
    products = np.outer(signed, signed) / square
    width = target.surface.size / 60
    rings = (distance / width).astype(np.intp)
    np.fill_diagonal(rings, rings.max() + 1)  # every point with itself, a ring of its own
    pairs = np.bincount(rings.ravel())
    sums = np.bincount(rings.ravel(), weights=products.ravel())
    known = pairs > 0
    correlation = np.clip(sums[known] / pairs[known], -1.0, 1.0)
    # The sum over all pairs of the full set: those of points with themselves do not thin out.
    count = len(signed)
    among = float(pairs[known][:-1] @ correlation[:-1] ** 2) / count**2 + 1.0 / target.count
    return float(np.clip(1.0 / among, 2.0, target.count))
