"""What it takes to get from the lowest shape to the others."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from sheetmorph.branches.result import Barrier, Branches
from sheetmorph.branches.seeds import KICK
from sheetmorph.core.errors import ComputationError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.solve.constraints import align_to_reference
from sheetmorph.solve.minimise import NewtonOptions, Outcome, minimise
from sheetmorph.solve.string import Passage, StringOptions, passage
from sheetmorph.solve.system import System
from sheetmorph.study.model import Problem, build_problem
from sheetmorph.study.stability import modes_at, system_of

FRONT = 1.5
"""Width of a front, over the width of the sheet."""


def with_barriers(found: Branches, most: int = 1) -> Branches:
    """The same with the barriers between the lowest stable shape and the next ones.

    Args:
        found: the shapes.
        most: barriers; other positions of a shape count as shapes, those of the lowest first.
    """
    problem = build_problem(found.result.design, found.result.mesh)
    system = system_of(problem)
    stable = [one for one in found.branches if one.stable]
    if not stable:
        return found
    lowest = stable[0]
    pairs = [
        (other.number, image, x)
        for other in stable
        for image, x in sorted(other.positions_found.items())
        if other is not lowest or image
    ]
    barriers = [
        barrier_between(problem, system, (lowest.number, lowest.x), pair) for pair in pairs[:most]
    ]
    return found.with_barriers([one for one in barriers if one is not None])


def barrier_between(
    problem: Problem,
    system: System,
    first: tuple[int, Floats],
    second: tuple[int, str, Floats],
    images: int = 15,
) -> Barrier | None:
    """The lowest barrier found between two stable states; None where none is finite.

    Strings that start straight, where all of the sheet changes at once, and as fronts, where
    the change passes over the sheet along x or y; the lowest saddle among them counts.

    Args:
        problem: the problem.
        system: its system.
        first: number of a branch, and its state.
        second: number of a branch, its position, and its state.
        images: states on the string.
    """
    number, start = first
    other, image, end = second
    if not len(problem.held_nodes):
        end = _laid_over(problem, end, start)
    scalars = len(problem.model.held_scalars)
    weights = np.concatenate([np.repeat(problem.mesh.node_areas, 3), np.zeros(scalars)])
    options = StringOptions(problem.residual_tolerance, images=images)
    here = system.at(1.0, 0.0)
    ways = []
    for shares in (None, *(_front(problem, axis, images) for axis in (0, 1))):
        with suppress(ComputationError):
            ways.append(passage(here, start, end, options, weights, shares))
    if not ways:
        return None
    way = min(ways, key=lambda one: (not one.converged, one.energy))
    connects = way.converged and _falls_into(problem, here, way)
    return Barrier(
        number, other, image, way.height, way.back, way.negative, way.converged, connects
    )


def _front(problem: Problem, axis: int, images: int) -> Floats:
    """Shares of the second shape while a front passes over the sheet, shape (images, n)."""
    mesh = problem.mesh
    place = mesh.nodes[:, axis] - mesh.nodes[:, axis].min()
    late = place / place.max()
    time = np.linspace(0.0, 1.0, images)[:, None]
    share = np.clip((time * (1.0 + FRONT) - late) / FRONT, 0.0, 1.0)
    smooth = share * share * (3.0 - 2.0 * share)
    scalars = np.broadcast_to(time, (images, len(problem.model.held_scalars)))
    return np.hstack([np.repeat(smooth, 3, axis=1), scalars])


def _falls_into(problem: Problem, system: System, way: Passage) -> bool:
    """Whether the minima on both sides of the saddle have the energies of the two ends."""
    mode = modes_at(problem, system, way.top, 1).vectors[0]
    kick = KICK * problem.mesh.size * mode / np.abs(mode[: problem.mesh.nodes.size]).max()
    options = NewtonOptions(problem.residual_tolerance, max_iterations=500)
    sides = [minimise(system, way.top + sign * kick, options) for sign in (1.0, -1.0)]
    if any(side.outcome is not Outcome.CONVERGED for side in sides):
        return False
    found, ends = sorted(side.energy for side in sides), sorted(way.energies[[0, -1]])
    return bool(np.abs(np.subtract(found, ends)).max() <= 1e-3 * way.height)


def _laid_over(problem: Problem, x: Floats, onto: Floats) -> Floats:
    """A free state moved rigidly to lie closest to another."""
    moved = align_to_reference(problem.positions(x)[None], problem.positions(onto))[0]
    return np.concatenate([moved.ravel(), x[problem.mesh.nodes.size :]])
