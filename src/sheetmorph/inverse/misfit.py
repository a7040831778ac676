"""How far a design's shape is from the target: a number, and the residuals that make it up."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np

from sheetmorph.compare.align import Effort, best_pose
from sheetmorph.compare.fit import Pair, refine
from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import InputError
from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.surface import aspect_ratio, in_plane_width
from sheetmorph.inverse.families import Space
from sheetmorph.inverse.limits import measured
from sheetmorph.study.result import Result
from sheetmorph.study.simulate import simulate

FAILED = 1.0
"""Misfit of a design that does not reach its end; far above that of any shape."""
QUICK = Effort(starts=32, kept=3, points=400, gain=1e-4)
THOROUGH = Effort(starts=192, kept=8, points=2000)
POINTS = 400
"""Points of the target that are measured from."""
OF_PROPORTIONS = 0.1
"""Weight of the proportions: a deviation by 1 % counts as a distance of 0.1 % of the size."""
OF_LIMITS = 0.5
"""Weight of what breaks the limits of fabrication."""


@dataclass(frozen=True)
class Job:
    """A design to simulate and to measure.

    Attributes:
        family: name of the family.
        point: of its parameters, in their own units.
        coarse: on a coarse mesh.
        near: numbers of the pose to begin with; all poses are tried when empty.
        residuals: whether these are wanted too.
        slopes: with a smeared pattern, and derivatives in the place of residuals.
    """

    family: str
    point: tuple[float, ...]
    coarse: bool = True
    near: tuple[float, ...] = ()
    residuals: bool = False
    slopes: bool = False


@dataclass(frozen=True)
class Evaluation:
    """A design of the search, simulated and measured.

    Attributes:
        family: name of its family.
        point: of the parameters, in their own units.
        misfit: what the search makes small, without unit: root of the sum of squares of
            distance, proportions and broken limits.
        distance: root mean square distance both ways over the size of the target.
        aspect_ratio: height over largest width of the shape.
        pose: of the target on the shape: scale, rotation by rows, translation; 13 numbers.
        status: how the simulation ended.
        seconds: it took.
        residuals: their squares add up to that of the misfit; empty where not asked for.
    """

    family: str
    point: tuple[float, ...]
    misfit: float
    distance: float = FAILED
    aspect_ratio: float = 0.0
    pose: tuple[float, ...] = ()
    status: str = "completed"
    seconds: float = 0.0
    residuals: tuple[float, ...] = field(default=(), repr=False)

    @property
    def completed(self) -> bool:
        """Whether the simulation reached its end."""
        return self.status == "completed"


@dataclass(frozen=True, eq=False)
class Measure:
    """What a process needs to measure designs; goes to other processes as it is.

    Attributes:
        target: the wanted surface [m].
        spaces: of the designs, by the name of their family.
        scale: 1, or None where the target may be scaled freely.
        run: simulates.
    """

    target: Surface
    spaces: Mapping[str, Space]
    scale: float | None = 1.0
    run: Callable[[Design], Result] = simulate

    def evaluate(self, job: Job) -> Evaluation:
        """Simulate the design of a job, and measure it.

        Raises:
            KeyboardInterrupt: the simulation was interrupted.
        """
        if job.slopes:
            from sheetmorph.inverse.search_gradient import slopes_of

            return slopes_of(self, job)
        began = perf_counter()
        space = self.spaces[job.family]
        given = (job.family, job.point)
        try:
            design = space.design(job.point, "candidate", coarse=job.coarse)
            broken = OF_LIMITS * measured(design, space.limits).excess(space.limits)
            result = self.run(design)
        except InputError:
            return Evaluation(*given, 2.0 * FAILED, status="not_allowed")
        if result.status == "interrupted":
            raise KeyboardInterrupt
        if result.status != "completed":
            missing = 1.0 - float(result.summary["actuation_reached"])
            seconds = perf_counter() - began
            return Evaluation(*given, FAILED + missing, status=result.status, seconds=seconds)
        near = pose_of(job.near) if job.near else None
        laid = lay(self.target, shape_of(result), self.scale, near)
        rows = (laid.distance, *OF_PROPORTIONS * laid.proportions, broken)
        parts: tuple[float, ...] = ()
        if job.residuals:
            offsets = self._offsets(laid, result, space.spread(job.point))
            parts = (*offsets.tolist(), *rows[1:])
        return Evaluation(
            *given,
            float(np.linalg.norm(rows)),
            laid.distance,
            float(aspect_ratio(result.positions[-1])),
            pose_numbers(laid.pose),
            seconds=perf_counter() - began,
            residuals=tuple(map(float, parts)),
        )

    def _offsets(self, laid: Laid, result: Result, plan: Floats) -> Floats:
        """From points of the target and of the sheet to the other; shares of the size."""
        from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

        size = self.target.size * laid.pose.scale
        there = laid.pose.apply(self.target.sample(POINTS).points)
        nodes, shape = result.mesh.nodes[:, :2], result.positions[-1]
        on_sheet = LinearNDInterpolator(nodes, shape)(plan)
        beyond = ~np.isfinite(on_sheet).all(axis=1)
        if beyond.any():
            on_sheet[beyond] = NearestNDInterpolator(nodes, shape)(plan[beyond])
        back = laid.target.nearest(on_sheet)
        forth = shape_of(result).nearest(there)
        rows = (
            (there - forth.point) / (size * np.sqrt(2.0 * len(there))),
            (on_sheet - back.point) / (size * np.sqrt(2.0 * len(on_sheet))),
        )
        return np.concatenate([row.ravel() for row in rows])


@dataclass(frozen=True, eq=False)
class Laid:
    """A target laid on a shape.

    Attributes:
        pose: from the target to the shape.
        target: in that pose [m].
        distance: root mean square distance both ways over the size of the target.
        proportions: logarithms of the shape's over the target's height over length, and width
            over length, both as they lie, shape (2,).
    """

    pose: Similarity
    target: Surface
    distance: float
    proportions: Floats


def lay(
    target: Surface,
    shape: Surface,
    scale: float | None,
    near: Similarity | None = None,
    effort: Effort = QUICK,
) -> Laid:
    """Lay a target on a shape, so that they are as close as can be.

    Turned over and turned about, but never mirrored.

    Args:
        target: [m].
        shape: [m].
        scale: of the target; found when None.
        near: a pose to begin with; all are tried when None.
        effort: how many.
    """
    pose = best_pose(target, shape, scale, 0, effort) if near is None else near
    pair = Pair(
        target,
        shape,
        target.sample(effort.points),
        shape.sample(effort.points, 1),
        scale,
        way_back=1.0,
    )
    fit = refine(pair, pose)
    laid = target.moved(fit.pose)
    logs = np.log(_proportions(shape.points) / _proportions(laid.points[laid.used]))
    return Laid(fit.pose, laid, fit.misfit / (fit.pose.scale * target.size), logs)


def _proportions(points: Floats) -> Floats:
    """Height and smallest width over the largest width, shape (2,); no less than a hundredth."""
    length = float(in_plane_width(points))
    width = float(in_plane_width(points, "feret_min"))
    height = float(np.ptp(points[:, 2]))
    return np.maximum(np.array([height, width]) / length, 0.01)


def shape_of(result: Result) -> Surface:
    """The final shape of a run."""
    return Surface(result.positions[-1], result.mesh.triangles.astype(np.int64))


def pose_numbers(pose: Similarity) -> tuple[float, ...]:
    """A pose as 13 plain numbers."""
    numbers: list[Any] = [pose.scale, *pose.rotation.ravel(), *pose.translation]
    return tuple(float(number) for number in numbers)


def pose_of(numbers: tuple[float, ...]) -> Similarity:
    """The pose that 13 numbers stand for."""
    return Similarity(numbers[0], np.array(numbers[1:10]).reshape(3, 3), np.array(numbers[10:]))
