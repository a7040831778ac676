"""The search over a whole family, whole numbers included: evolution on coarse meshes."""

from __future__ import annotations

from itertools import islice, product

import numpy as np

from sheetmorph.inverse.evaluations import Evaluations
from sheetmorph.inverse.families import Space
from sheetmorph.inverse.misfit import Evaluation, Job

SIGMA = 0.3
"""First standard deviation, as a share of the bounds."""
POPULATION = 12
MOST_SIBLINGS = 24


def evolve(evaluations: Evaluations, space: Space, budget: int, seed: int) -> list[Evaluation]:
    """Minimise the misfit over a family by CMA-ES (Hansen and Ostermeier 2001), with whole numbers.

    Each generation is measured side by side. The course depends on the seed alone, so that a
    search that was cut off goes the same way again, through what its journal knows.

    Args:
        evaluations: measure designs.
        space: of the designs.
        budget: about how many designs.
        seed: of the random numbers.

    Returns:
        All that was measured, best first; equal points once.
    """
    import cma

    random = np.random.default_rng(seed)
    # Bounds become 0 and 1; a whole parameter becomes 0, 1, … with a step of 1 between choices.
    widths = np.array([one.choices - 1 if one.whole else 1.0 for one in space.parameters])
    whole = [k for k, one in enumerate(space.parameters) if one.whole]
    margin = np.array([0.49 if one.whole else 0.0 for one in space.parameters])
    options = {
        "bounds": [(-margin).tolist(), (widths + margin).tolist()],
        "integer_variables": whole,
        "CMA_stds": np.maximum(widths, 1e-9).tolist(),
        "popsize": POPULATION,
        "seed": np.nan,
        "randn": lambda *shape: random.standard_normal(shape),
        "verbose": -9,
        "tolx": 1e-4,
        "tolfun": 1e-6,
    }
    strategy = cma.CMAEvolutionStrategy((0.5 * widths).tolist(), SIGMA, options)
    found: dict[tuple[float, ...], Evaluation] = {}
    while not strategy.stop() and strategy.countevals + POPULATION <= max(budget, POPULATION):
        asked = strategy.ask()
        points = [_point(space, np.asarray(x) / np.maximum(widths, 1e-9)) for x in asked]
        answers = evaluations.many([Job(space.family.name, point) for point in points])
        strategy.tell(asked, [answer.misfit for answer in answers])
        found.update(zip(points, answers, strict=True))
    return sorted(found.values(), key=lambda one: (one.misfit, one.point))


def siblings(evaluations: Evaluations, space: Space, best: Evaluation) -> list[Evaluation]:
    """The best design with every other choice of its whole numbers, all else as it is.

    An evolution soon keeps to the whole numbers that did well first, though the others may do as
    well once all else fits them.
    """
    whole = [k for k, one in enumerate(space.parameters) if one.whole]
    ranges = [range(int(space.low[k]), int(space.high[k]) + 1) for k in whole]
    jobs = []
    for choice in islice(product(*ranges), MOST_SIBLINGS):
        point = list(best.point)
        for k, value in zip(whole, choice, strict=True):
            point[k] = float(value)
        if tuple(point) != best.point:
            jobs.append(Job(space.family.name, tuple(point)))
    return evaluations.many(jobs)


def _point(space: Space, unit: np.ndarray) -> tuple[float, ...]:
    """A point in the parameters' own units, rounded so that it does not depend on the machine."""
    inside = np.clip(unit, 0.0, 1.0)
    point = space.low + inside * (space.high - space.low)
    return tuple(
        float(round(x)) if one.whole else float(f"{x:.6g}")
        for x, one in zip(point, space.parameters, strict=True)
    )
