"""How stable the states of a result are: smallest eigenvalues, modes, the first bifurcation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.core.hdf5 import writing_hdf5
from sheetmorph.geometry.mesh import Floats
from sheetmorph.solve.constraints import HeldDofs
from sheetmorph.solve.critical import Critical, first_critical, stationary
from sheetmorph.solve.eigen import Modes, smallest_modes
from sheetmorph.solve.linear import make_solver
from sheetmorph.solve.system import System
from sheetmorph.study.model import Problem, build_problem
from sheetmorph.study.result import Result

MOST_MODES = 50
MODES_FORMAT = "sheetmorph modes"


@dataclass(frozen=True, eq=False)
class StateModes:
    """The softest modes of one state.

    Attributes:
        state: index of the state in the result.
        ramp: its fraction of the actuation.
        load_fraction: its fraction of the perturbation load.
        eigenvalues: increasing [N/m³], shape (k,): pressure per displacement of each mode, on
            the sheet before actuation. Below zero where the state is unstable.
        modes: displacements of the nodes, the largest 1, shape (k, V, 3).
        checked: see `sheetmorph.solve.eigen.Modes`.
    """

    state: int
    ramp: float
    load_fraction: float
    eigenvalues: Floats
    modes: Floats
    checked: bool


def modes_of(
    result: Result, states: Sequence[int] = (-1,), count: int = 4, problem: Problem | None = None
) -> list[StateModes]:
    """Smallest eigenvalues and their modes at states of a result.

    Rigid motions of a free sheet are left out.

    Args:
        result: what was computed.
        states: indices of the states.
        count: modes for each.
        problem: the problem of the result, where it is at hand.

    Raises:
        InputError: there is no such state, or the count is not from 1 to 50.
        ComputationError: see `smallest_modes`.
    """
    if not 1 <= count <= MOST_MODES:
        raise InputError(
            "so many modes are not computed", value=count, allowed=f"1 to {MOST_MODES}"
        )
    total = len(result.positions)
    for state in states:
        if not -total <= state < total:
            raise InputError("there is no such state", value=state, allowed=f"0 to {total - 1}")
    problem = build_problem(result.design, result.mesh) if problem is None else problem
    system = system_of(problem)
    found = []
    for state in states:
        index = state % total
        x = np.concatenate([result.positions[index].ravel(), result.scalars[index]])
        ramp, load = float(result.ramp[index]), float(result.load_fraction[index])
        modes = modes_at(problem, system.at(ramp, load), x, count)
        shapes = modes.vectors[:, : problem.mesh.nodes.size].reshape(-1, *problem.mesh.nodes.shape)
        sizes = np.linalg.norm(shapes, axis=2).max(axis=1)
        shapes = shapes / sizes[:, None, None]
        found.append(StateModes(index, ramp, load, modes.eigenvalues, shapes, modes.checked))
    return found


def modes_at(problem: Problem, system: System, x: Floats, count: int) -> Modes:
    """The softest modes of a state of a problem, weighted by area.

    Args:
        problem: the problem.
        system: its system at the ramp and load of the state.
        x: the state, shape (n,).
        count: how many.
    """
    nodes = problem.mesh.nodes
    weights = np.concatenate(
        [np.repeat(problem.mesh.node_areas, 3), np.zeros(len(problem.model.held_scalars))]
    )
    if not problem.floats:
        return smallest_modes(system, x, count, weights=weights)
    held = problem.held_dofs.copy()
    held[: nodes.size] = False
    free = replace(system, held=HeldDofs.of(system.energy.pattern, held))
    rigid = rigid_motions(problem.positions(x), len(problem.model.held_scalars))
    return smallest_modes(free, x, count, weights=weights, rigid=rigid)


def rigid_motions(positions: Floats, scalars: int = 0) -> Floats:
    """Three translations and three turns of a state, shape (6, 3 V + scalars)."""
    centred = positions - positions.mean(axis=0)
    motions = []
    for axis in np.eye(3):
        motions += [np.tile(axis, (len(positions), 1)), np.cross(axis, centred)]
    rows = np.array(motions).reshape(6, -1)
    return np.hstack([rows, np.zeros((6, scalars))])


def system_of(problem: Problem) -> System:
    """The problem with the linear solver that its design asks for."""
    pattern, solver = problem.total.pattern, problem.design.solver
    threads = max(1, solver.threads)
    linear = make_solver(pattern, solver.linear_solver, threads, problem.total.growth)
    return System(problem.total, HeldDofs.of(pattern, problem.held_dofs), linear)


def first_bifurcation(
    problem: Problem, ramps: Sequence[float] | None = None, system: System | None = None
) -> Critical | None:
    """The first loss of stability of the sheet without its perturbation load, from flat.

    Args:
        problem: the problem.
        ramps: fractions of the actuation that are passed; a series that grows by a quarter
            from a thousandth to 1 when None.
        system: its system, where it is at hand.

    Returns:
        The place; None where the sheet stays stable as far as its equilibrium can be followed.

    Raises:
        ComputationError: the flat sheet itself is not stable.
    """
    system = system_of(problem) if system is None else system
    passed = [float(t) for t in (growing_ramps() if ramps is None else ramps)]
    tolerance = problem.residual_tolerance
    reached = 0

    def equilibrium(here: System, guess: Floats) -> Floats | None:
        nonlocal reached
        found = stationary(here, guess, tolerance)
        reached += found is not None
        return found

    try:
        return first_critical(system, problem.start, passed, equilibrium, accuracy=1e-7)
    except ComputationError:
        if reached < 1:
            raise
        return None


def growing_ramps(first: float = 1e-3, factor: float = 1.25) -> Floats:
    """Zero, then a geometric series that ends at 1."""
    count = int(np.ceil(np.log(1.0 / first) / np.log(factor))) + 1
    return np.concatenate([[0.0], np.geomspace(first, 1.0, count)])


def stability_of(result: Result, count: int = 4) -> tuple[list[StateModes], dict[str, Any]]:
    """The softest modes of all states, and what the summary tells of them.

    Args:
        result: what was computed.
        count: modes for each state.

    Returns:
        The modes of every state; the smallest eigenvalues of the last state and of all states,
        and the first bifurcation of the sheet without its perturbation load.

    Raises:
        InputError, ComputationError: as for `modes_of`.
    """
    problem = build_problem(result.design, result.mesh)
    found = modes_of(result, range(len(result.positions)), count, problem)
    critical = first_bifurcation(problem)
    told = None
    if critical is not None:
        told = {
            "actuation": critical.ramp,
            "eps_pre": critical.ramp * problem.design.eps_pre,
            "negative_pivots_beyond": critical.negative_pivots,
        }
    return found, {
        "eigenvalues_N_per_m3": found[-1].eigenvalues.tolist(),
        "smallest_of_each_state_N_per_m3": [float(one.eigenvalues[0]) for one in found],
        "first_bifurcation": told,
    }


def write_modes(found: Sequence[StateModes], path: Path) -> None:
    """Write the modes of states as HDF5: `eigenvalues`, `modes`, `state`, `ramp`, `load_fraction`.

    Raises:
        OutputError: it cannot be written.
    """
    with writing_hdf5(path) as (file, _):
        file.attrs["format"] = MODES_FORMAT
        for name in ("state", "ramp", "load_fraction", "eigenvalues", "modes"):
            file.create_dataset(name, data=np.array([getattr(one, name) for one in found]))
        file["eigenvalues"].attrs["unit"] = "N/m^3"
