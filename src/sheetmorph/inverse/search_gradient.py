"""The way down by exact derivatives: a smeared pattern on a mesh that stays."""

from __future__ import annotations

from time import perf_counter

import numpy as np

from sheetmorph.compare.pose import Similarity
from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.surface import aspect_ratio
from sheetmorph.inverse.evaluations import Evaluations
from sheetmorph.inverse.families import SIZE, Space
from sheetmorph.inverse.misfit import FAILED, Evaluation, Job, Measure, pose_numbers, pose_of
from sheetmorph.inverse.objective import apart
from sheetmorph.study.sensitivity import sensitivities

STEPS = 8
"""Iterations at most."""
FEWEST = 2
"""Parameters with a derivative below which the stage is left out."""
_INSIDE = 1e-3


def followed(space: Space) -> list[int]:
    """Which parameters have a derivative while the mesh stays: those of pattern and actuation."""
    return [k for k, one in enumerate(space.parameters) if one.key]


def slide(evaluations: Evaluations, space: Space, start: Evaluation) -> Evaluation:
    """Follow the squared distance downhill, by SLSQP (Kraft 1988) with exact derivatives.

    The boundary of the pattern is smeared over a triangle, so that its parameters act smoothly on a
    mesh that stays the same; the adjoint method gives all derivatives for a fraction of a run. The
    sheet and whole numbers stay. The limit on the area of inert material is a constraint.

    Args:
        evaluations: measure designs.
        space: of the designs.
        start: where to begin.

    Returns:
        The best point, not measured yet on its own mesh; `start` where nothing was better.
    """
    from scipy.optimize import minimize

    free = np.array(followed(space), dtype=np.int64)
    if len(free) < FEWEST or not start.completed:
        return start
    low, reach = space.low, space.high - space.low

    def point_of(unit: Floats) -> tuple[float, ...]:
        point = np.array(start.point)
        point[free] = low[free] + np.clip(unit, 0.0, 1.0) * reach[free]
        return tuple(float(f"{x:.8g}") for x in point)

    def job(unit: Floats) -> Job:
        return Job(start.family, point_of(unit), coarse=False, near=start.pose, slopes=True)

    begin = np.clip((np.array(start.point)[free] - low[free]) / reach[free], _INSIDE, 1 - _INSIDE)
    first = evaluations(job(begin))
    if not first.completed:
        return start
    seen = [first]

    def objective(unit: Floats) -> tuple[float, Floats]:
        found = evaluations(job(unit))
        seen.append(found)
        if not found.completed:
            return FAILED / first.misfit, np.zeros(len(free))
        return found.misfit / first.misfit, np.array(found.residuals) * reach[free] / first.misfit

    def room(unit: Floats) -> float:
        return space.limits.most_inert - inert_share(space.design(point_of(unit), "area"))

    minimize(
        objective,
        begin,
        jac=True,
        method="SLSQP",
        bounds=[(0.0, 1.0)] * len(free),
        constraints=[{"type": "ineq", "fun": room}],
        options={"maxiter": STEPS, "ftol": 1e-2},
    )
    best = min((one for one in seen if one.completed), key=lambda one: one.misfit)
    return start if best is first else best


def inert_share(design: Design) -> float:
    """Share of the sheet that the pattern covers."""
    return float(design.layout.pattern.area / design.layout.sheet.area)


def slopes_of(measure: Measure, job: Job) -> Evaluation:
    """A smeared design, simulated, with the squared distance and its derivatives.

    Returns:
        `misfit` is the squared distance over the size squared; `residuals` are its derivatives by
        the parameters of `followed`, in their own units.

    Raises:
        KeyboardInterrupt: the simulation was interrupted.
    """
    began = perf_counter()
    space = measure.spaces[job.family]
    given = (job.family, job.point)
    parameters = [space.parameters[k] for k in followed(space)]
    try:
        design = smeared(space.design(job.point, "candidate"))
        result = measure.run(design)
    except InputError:
        return Evaluation(*given, 2.0 * FAILED, status="not_allowed")
    if result.status == "interrupted":
        raise KeyboardInterrupt
    near = pose_of(job.near) if job.near else None
    poses: list[Similarity] = []

    def objective(positions: Floats) -> tuple[float, Floats]:
        found = apart(measure.target, positions, result.mesh.triangles, near)
        poses.append(found.pose)
        return found.square, found.slope

    try:
        found = sensitivities(result, objective, [one.key for one in parameters], fields=())
    except ComputationError:
        status = result.status if result.status != "completed" else "unstable"
        return Evaluation(*given, FAILED, status=status)
    half = 0.5 * space.values(job.point)[SIZE]
    factors = [half if one.unit == "share" else one.factor for one in parameters]
    slopes = [found.keys[one.key] * by for one, by in zip(parameters, factors, strict=True)]
    return Evaluation(
        *given,
        found.value,
        float(np.sqrt(found.value)),
        float(aspect_ratio(result.positions[-1])),
        pose_numbers(poses[0]),
        seconds=perf_counter() - began,
        residuals=tuple(map(float, slopes)),
    )


def smeared(design: Design) -> Design:
    """The design with its pattern smeared over about a triangle."""
    size = design.spec.mesh.size or 0.0
    return design.with_values({"mesh.pattern_smoothing": f"{1e3 * size:.6g} mm"})
