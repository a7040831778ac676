"""Steps of a search within bounds: spread points, choose the best apart, go downhill."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from sheetmorph.calibrate.evaluations import Evaluations
from sheetmorph.calibrate.misfit import Evaluation
from sheetmorph.calibrate.parameters import Parameter
from sheetmorph.geometry.mesh import Floats

APART = 0.15
"""Starts of two descents are at least this share of the bounds away from each other."""


def spread(parameters: Sequence[Parameter], count: int, seed: int) -> list[list[float]]:
    """Points evenly spread over the bounds (Sobol 1967, scrambled).

    Args:
        parameters: p of them.
        count: how many points.
        seed: of the scrambling.

    Returns:
        The values of the parameters at each point.
    """
    from scipy.stats import qmc

    if count == 0:
        return []
    power = int(np.ceil(np.log2(count)))
    sobol = qmc.Sobol(len(parameters), scramble=True, rng=np.random.default_rng(seed))
    return [
        [p.from_share(float(share)) for p, share in zip(parameters, point, strict=True)]
        for point in sobol.random_base2(power)[:count]
    ]


def apart(
    parameters: Sequence[Parameter], found: Sequence[Evaluation], most: int
) -> list[Evaluation]:
    """The best of the simulated designs that lie apart from each other, at most so many."""
    chosen: list[tuple[Evaluation, Floats]] = []
    for candidate in sorted(found, key=lambda evaluation: evaluation.misfit):
        place = shares(parameters, candidate)
        away = all(np.abs(place - other).max() >= APART for _, other in chosen)
        if candidate.completed and away and len(chosen) < most:
            chosen.append((candidate, place))
    return [candidate for candidate, _ in chosen]


def descend(
    evaluations: Evaluations, start: Evaluation, tolerance: float, radius: float = 0.1
) -> Evaluation:
    """Downhill from a simulated design, within the bounds.

    Args:
        evaluations: what measures a candidate.
        start: where to begin.
        tolerance: to what share of its bounds a parameter is found.
        radius: of the first steps, as a share of the bounds.

    Returns:
        The best design on the way.
    """
    parameters = evaluations.task.parameters
    scale = max(start.misfit, 1e-12) ** 2
    seen: list[Evaluation] = []

    def square(point: Floats) -> float:
        values = [p.from_share(float(s)) for p, s in zip(parameters, point, strict=True)]
        seen.append(evaluations(values))
        return seen[-1].misfit ** 2 / scale

    minimise(
        square,
        shares(parameters, start),
        radius=radius,
        final_radius=tolerance,
        max_evaluations=30 + 30 * len(parameters),
    )
    return min(seen, key=lambda evaluation: evaluation.misfit)


def shares(parameters: Sequence[Parameter], found: Evaluation) -> Floats:
    """Where a design lies between the bounds, shape (p,), 0 to 1."""
    return np.array([p.to_share(v) for p, v in zip(parameters, found.values, strict=True)])


def minimise(
    function: Callable[[Floats], float],
    start: Floats,
    *,
    radius: float,
    final_radius: float,
    max_evaluations: int,
) -> Floats:
    """The least value near a start, in the unit box, without derivatives.

    COBYQA (Ragonneau and Zhang 2022): a trust region with quadratic models of the function,
    which never leaves the bounds. On this problem it needed half the evaluations of the
    simplex of Nelder and Mead.

    Args:
        function: of a point of the unit box, shape (p,).
        start: shape (p,).
        radius: of the first trust region.
        final_radius: of the last one; as well as the optimum is known.
        max_evaluations: at most so many.
    """
    from scipy.optimize import Bounds, minimize

    first = np.clip(np.asarray(start, dtype=np.float64), 0.0, 1.0)
    kept: dict[float, Floats] = {}

    def remembered(point: Floats) -> float:
        place = np.clip(point, 0.0, 1.0)
        value = function(place)
        if not kept or value < min(kept):
            kept[value] = place
        return value

    minimize(
        remembered,
        first,
        method="COBYQA",
        bounds=Bounds(np.zeros(len(first)), np.ones(len(first))),
        options={
            "initial_tr_radius": radius,
            "final_tr_radius": min(final_radius, radius),
            "maxfev": max_evaluations,
        },
    )
    return kept[min(kept)]
