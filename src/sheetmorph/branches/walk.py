"""The path of the sheet without perturbation, and where it bifurcates."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from sheetmorph.core.errors import ComputationError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.solve.critical import stationary
from sheetmorph.solve.stability import negative_eigenvalues
from sheetmorph.solve.system import System
from sheetmorph.study.model import Problem
from sheetmorph.study.stability import modes_at

FIRST_STEP, LARGEST_STEP, SMALLEST_STEP, GROWTH = 1e-3, 0.05, 1e-5, 1.3
"""Of the ramp; beginning at the first, each step is longer by the last."""

MOST_NEGATIVE = 12
"""Negative eigenvalues beyond which the path is of no more use."""

ACCURACY = 1e-4
"""Of the ramp at a bifurcation, as a fraction of it."""


@dataclass(frozen=True, eq=False)
class Station:
    """An equilibrium without perturbation load, stable or not.

    Attributes:
        ramp: fraction of the actuation.
        x: the state, shape (n,).
        negative: its negative eigenvalues.
    """

    ramp: float
    x: Floats
    negative: int


@dataclass(frozen=True, eq=False)
class Bifurcation:
    """A place on the path where eigenvalues go below zero.

    Attributes:
        ramp: where the first of them is zero.
        beyond: the first station behind it.
        modes: of the eigenvalues that have passed zero, displacements of all degrees of
            freedom at `beyond`, the largest 1, shape (k, n).
        before: negative eigenvalues ahead of it.
    """

    ramp: float
    beyond: Station
    modes: Floats
    before: int


def unperturbed_path(problem: Problem, system: System) -> list[Station]:
    """Equilibria from flat, without leaving the path where it becomes unstable.

    Returns:
        The stations up to full actuation, or as far as there are equilibria and their negative
        eigenvalues are few.
    """
    start = system.at(0.0, 0.0)
    path = [Station(0.0, problem.start, negative_eigenvalues(start, problem.start))]
    step = FIRST_STEP
    while path[-1].ramp < 1.0 and path[-1].negative <= MOST_NEGATIVE:
        last = path[-1]
        ramp = min(last.ramp + step, 1.0)
        found = station(problem, system, ramp, _guess(path, ramp), last.x)
        if found is None:
            step = 0.5 * (ramp - last.ramp)
            if step < SMALLEST_STEP:
                break
            continue
        path.append(found)
        step = min(GROWTH * step, LARGEST_STEP)
    return path


def station(
    problem: Problem, system: System, ramp: float, guess: Floats, last: Floats
) -> Station | None:
    """The equilibrium next to a guess; None where there is none on the same path."""
    here = system.at(ramp, 0.0)
    x = stationary(here, guess, problem.residual_tolerance)
    if x is None:
        return None
    # A correction longer than the step that led here tells of another path.
    moved, corrected = (float(np.abs(x - other).max()) for other in (last, guess))
    if corrected > 0.6 * moved and corrected > 1e-3 * problem.mesh.mean_edge_length:
        return None
    return Station(ramp, x, negative_eigenvalues(here, x))


def bifurcations(
    problem: Problem, system: System, path: list[Station], most: int = 6
) -> list[Bifurcation]:
    """The first places on a path at which eigenvalues go below zero."""
    found: list[Bifurcation] = []
    for before, beyond in pairwise(path):
        if beyond.negative <= before.negative or len(found) >= most:
            continue
        modes = modes_at(problem, system.at(beyond.ramp, 0.0), beyond.x, beyond.negative)
        new = modes.vectors[before.negative :]
        new = new / np.abs(new[:, : problem.mesh.nodes.size]).max(axis=1, keepdims=True)
        ramp = _located(problem, system, before, beyond)
        found.append(Bifurcation(ramp, beyond, new, before.negative))
    return found


def _located(problem: Problem, system: System, before: Station, beyond: Station) -> float:
    """Where the first of the eigenvalues that pass zero between two stations is zero."""
    from scipy.optimize import brentq

    index = before.negative

    def eigenvalue(ramp: float) -> float:
        share = (ramp - before.ramp) / (beyond.ramp - before.ramp)
        here = system.at(ramp, 0.0)
        x = stationary(here, before.x + share * (beyond.x - before.x), problem.residual_tolerance)
        if x is None:
            raise ComputationError(f"no equilibrium was found at the ramp {ramp:g}")
        return float(modes_at(problem, here, x, index + 1).eigenvalues[index])

    try:
        return float(brentq(eigenvalue, before.ramp, beyond.ramp, xtol=ACCURACY * beyond.ramp))
    except (ComputationError, ValueError):
        return 0.5 * (before.ramp + beyond.ramp)


def _guess(path: list[Station], ramp: float) -> Floats:
    last = path[-1]
    if len(path) < 2:
        return last.x
    past = path[-2]
    return last.x + (ramp - last.ramp) / (last.ramp - past.ramp) * (last.x - past.x)
