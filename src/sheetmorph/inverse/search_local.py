"""The way down from a good design: least squares on all distances, on the design's own mesh."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from sheetmorph.geometry.mesh import Floats
from sheetmorph.inverse.evaluations import Evaluations
from sheetmorph.inverse.families import Space
from sheetmorph.inverse.misfit import FAILED, Evaluation, Job

STEP = 0.02
"""Of the differences, as a share of the bounds: well above the noise of a mesh that changes."""
STEPS = 8
"""Points of the way down at most."""
_INSIDE = 1e-3


def descend(
    evaluations: Evaluations, space: Space, start: Evaluation, accuracy: float = 0.0
) -> Evaluation:
    """Follow the residuals downhill, by a trust region within the bounds (Branch et al. 1999).

    The derivatives by the parameters are differences of whole simulations, made side by side:
    they hold the pose of the target, which is found anew for each, and the change of the mesh.
    Whole numbers stay.

    Args:
        evaluations: measure designs.
        space: of the designs.
        start: where to begin.
        accuracy: distance, as a share of the size, at which it ends.

    Returns:
        The best that was measured on the way.
    """
    from scipy.optimize import least_squares

    free = np.array([not one.whole for one in space.parameters])
    low, reach = space.low, space.high - space.low
    first = evaluations(Job(start.family, start.point, coarse=False))
    seen = [first]
    if not first.completed:
        return first

    def job(unit: Floats) -> Job:
        point = np.array(start.point)
        point[free] = low[free] + np.clip(unit, 0.0, 1.0) * reach[free]
        rounded = tuple(float(f"{x:.8g}") for x in point)
        return Job(start.family, rounded, coarse=False, near=first.pose, residuals=True)

    def rows(found: Evaluation) -> Floats:
        return np.array(found.residuals) if found.completed else np.full(count, FAILED)

    def residuals(unit: Floats) -> Floats:
        if min(one.distance for one in seen) <= accuracy:
            raise _EnoughError
        found = evaluations(job(unit))
        seen.append(found)
        return rows(found)

    def slopes(unit: Floats) -> Floats:
        steps = np.where(unit + STEP <= 1.0, STEP, -STEP)
        moved = [unit + step * np.eye(len(unit))[k] for k, step in enumerate(steps)]
        here, *there = evaluations.many([job(unit), *(job(one) for one in moved)])
        seen.extend(there)
        columns = [
            (rows(one) - rows(here)) / step if one.completed else np.zeros(count)
            for one, step in zip(there, steps, strict=True)
        ]
        return np.stack(columns, axis=1)

    begin = (np.array(start.point)[free] - low[free]) / reach[free]
    begin = np.clip(begin, _INSIDE, 1.0 - _INSIDE)
    here = evaluations(job(begin))
    if not here.completed:
        return first
    count = len(here.residuals)
    seen.append(here)
    with suppress(_EnoughError):
        least_squares(
            residuals, begin, slopes, bounds=(0.0, 1.0), max_nfev=STEPS, xtol=2e-3, ftol=1e-3
        )
    return min(seen, key=lambda one: (one.misfit, one.point))


class _EnoughError(Exception):
    """Ends the way down where it is near enough."""
