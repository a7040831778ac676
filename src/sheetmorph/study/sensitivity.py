"""Derivatives of a function of the final shape with respect to everything that led to it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from pydantic import BaseModel

from sheetmorph.core.errors import ComputationError, InputError, nearest
from sheetmorph.design.spec import Design
from sheetmorph.energy.hinge import CoupledHinge
from sheetmorph.energy.laminate import LaminateShell
from sheetmorph.energy.shape_measures import measures_at
from sheetmorph.energy.stretch import EdgeStretch
from sheetmorph.geometry import surface
from sheetmorph.geometry.mesh import Floats
from sheetmorph.solve.adjoint import adjoint_state
from sheetmorph.solve.constraints import HeldDofs
from sheetmorph.solve.linear import make_solver
from sheetmorph.solve.system import System
from sheetmorph.study.model import Problem, build_problem
from sheetmorph.study.published_model import SIGNS
from sheetmorph.study.result import Result

Objective = Callable[[Floats], tuple[float, Floats]]
"""From node positions (V, 3) [m] to a value and its derivative with respect to them (V, 3)."""

STEP = 1e-5
"""Relative step of the central differences of forces and strains, at fixed positions."""

UNCHANGED = ("outline", "pattern", "mesh", "supports")
"""Tables of the design that decide on the mesh and on what is held: not differentiated."""


@dataclass(frozen=True, eq=False)
class Sensitivities:
    """A function of the final shape and its derivatives.

    Attributes:
        value: of the function.
        keys: derivative by design key, in SI units, at a fixed mesh.
        fields: derivatives by field. "eigenstrain": of the edges, shape (E,), or with the
            laminate model (e11, e22, e12) of the triangles, shape (T, 3), at full actuation.
            Published model: "stretch_stiffness" K (E,), "bending_stiffness" k_b and
            "coupling" (H,). e12 counts once for both of its places in the tensor.
    """

    value: float
    keys: Mapping[str, float]
    fields: Mapping[str, Floats]


def sensitivities(result: Result, objective: Objective, keys: Sequence[str] = ()) -> Sensitivities:
    """Differentiate a function of the final shape of a run, by the adjoint method.

    One factorisation serves all parameters. Fields follow exactly from the energy; for a key
    the energy is set up twice at the same mesh and its forces are differenced, nothing is solved
    again. On a free sheet only functions that no rigid motion changes have a meaning.

    Args:
        result: a completed run; its last state is the shape.
        objective: see `Objective`.
        keys: dotted keys of numbers in the design, such as "actuation.eps_pre" or
            "layers.0.thickness".

    Raises:
        InputError: a key is no number of the design, or belongs to its geometry.
        ComputationError: the last state is no stable equilibrium.
    """
    if result.status != "completed":
        raise ComputationError(
            f"the run ended with {result.status}, so its last state has no sensitivities"
        )
    problem = build_problem(result.design, result.mesh)
    x = np.concatenate([result.positions[-1].ravel(), result.scalars[-1]])
    ramp, load = float(result.ramp[-1]), float(result.load_fraction[-1])
    pattern = problem.total.pattern
    linear = make_solver(pattern, result.design.solver.linear_solver)
    held = HeldDofs.of(pattern, problem.held_dofs)
    system = System(problem.total.at(ramp, load), held, linear)
    value, slope = objective(result.positions[-1])
    whole = np.concatenate([np.asarray(slope).ravel(), np.zeros(len(result.scalars[-1]))])
    adjoint = adjoint_state(system, x, whole, 10.0 * problem.residual_tolerance)
    return Sensitivities(
        value=float(value),
        keys={key: _by_key(problem, key, x, adjoint, ramp, load) for key in keys},
        fields=_by_field(problem, x, adjoint, ramp),
    )


def _by_key(
    problem: Problem, key: str, x: Floats, adjoint: Floats, ramp: float, load: float
) -> float:
    """−λᵀ ∂g/∂p by a central difference of the forces at fixed positions."""
    value = number_at(problem.design, key)
    step = STEP * (abs(value) or 1.0)
    forces = []
    for moved in (value + step, value - step):
        design = with_number(problem.design, key, moved)
        total = build_problem(design, problem.mesh).total.at(ramp, load)
        forces.append(total.evaluate(x, 1)[1])
    ahead, behind = forces
    assert ahead is not None and behind is not None  # noqa: S101  order 1 gives them
    return float(-adjoint @ (ahead - behind) / (2.0 * step))


def _by_field(problem: Problem, x: Floats, adjoint: Floats, ramp: float) -> dict[str, Floats]:
    """−λᵀ ∂g/∂p for the fields of the model."""
    shell = problem.model.terms[0]
    if isinstance(shell, LaminateShell):
        return {"eigenstrain": _laminate_eigenstrain(shell.at(ramp, 0.0), x, adjoint)}
    stretch, bend = problem.model.terms
    assert isinstance(stretch, EdgeStretch)  # noqa: S101  the order of published_parts
    assert isinstance(bend, CoupledHinge)  # noqa: S101
    mesh = problem.mesh
    here, along = problem.positions(x), problem.positions(adjoint)
    strain = surface.edge_strain(here, mesh.edges, mesh.edge_lengths)
    ends, ways = here[mesh.edges], along[mesh.edges]
    sides = ends[:, 1] - ends[:, 0]
    lengths = np.linalg.norm(sides, axis=1)
    turn = ((ways[:, 1] - ways[:, 0]) * sides).sum(axis=1) / (lengths * mesh.edge_lengths)
    misfit = strain - ramp * stretch.eigenstrain
    around = mesh.hinge_edges[:, 1:]
    difference, moved = misfit[around] @ SIGNS, turn[around] @ SIGNS
    angle = surface.dihedral_angles(here, mesh.hinges) - bend.coupling * difference
    swing = _along(lambda p: surface.dihedral_angles(p, mesh.hinges), here, along)
    swing = swing - bend.coupling * moved
    by_hinge = -ramp * bend.stiffness * bend.coupling * swing
    eigen = ramp * stretch.stiffness * turn
    np.add.at(eigen, around, by_hinge[:, None] * SIGNS)
    return {
        "eigenstrain": eigen,
        "stretch_stiffness": -misfit * turn,
        "bending_stiffness": -angle * swing,
        "coupling": bend.stiffness * (difference * swing + angle * moved),
    }


def _laminate_eigenstrain(shell: LaminateShell, x: Floats, adjoint: Floats) -> Floats:
    """By the free strain of every triangle, shape (T, 3)."""
    measures = measures_at(x.reshape(-1, 3), shell.patch)
    change = _along(
        lambda rows: measures_at(rows, shell.patch), x.reshape(-1, 3), adjoint.reshape(-1, 3)
    )
    found = np.empty_like(shell.lamination.eigenstrains)
    for component in range(3):
        works = []
        for sign in (1.0, -1.0):
            strains = shell.lamination.eigenstrains.copy()
            strains[:, component] += sign * STEP
            rest = replace(shell.lamination, eigenstrains=strains).rest_at(shell.rest.ramp)
            stress = np.einsum("tij,tj->ti", rest.stiffness, measures - rest.natural)
            works.append((stress * change).sum(axis=1))
        found[:, component] = -(works[0] - works[1]) / (2.0 * STEP)
    return found


def _along(function: Callable[[Floats], Floats], x: Floats, direction: Floats) -> Floats:
    """Derivative of a function of positions along a direction, by a central difference."""
    largest = float(np.abs(direction).max())
    if largest == 0.0:
        return np.zeros_like(function(x))
    h = STEP * float(np.ptp(x)) / largest
    return np.asarray((function(x + h * direction) - function(x - h * direction)) / (2.0 * h))


def number_at(design: Design, key: str) -> float:
    """The number at a dotted key of the checked design, in SI units.

    Raises:
        InputError: there is no such key, it holds no number, or it belongs to the geometry.
    """
    parts = key.split(".")
    if parts[0] in UNCHANGED:
        raise InputError(
            "belongs to the geometry of the sheet, whose mesh is held fixed here",
            key=key,
            allowed="keys of layers, actuation, published, laminate, loads",
        )
    value: Any = design.spec
    for part in parts:
        value = _part(value, part, key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError("holds no number", key=key, value=value)
    return float(value)


def with_number(design: Design, key: str, value: float) -> Design:
    """The same design with another number at a key, in SI units; its text is left as it is."""

    def changed(table: Any, parts: list[str]) -> Any:
        if not parts:
            return value
        inner = changed(_part(table, parts[0], key), parts[1:])
        if isinstance(table, tuple):
            index = _index(table, parts[0])
            return (*table[:index], inner, *table[index + 1 :])
        return table.model_copy(update={parts[0]: inner})

    return replace(design, spec=changed(design.spec, key.split(".")))


def _part(value: Any, part: str, key: str) -> Any:
    if isinstance(value, tuple) and -1 < _index(value, part) < len(value):
        return value[_index(value, part)]
    if isinstance(value, BaseModel) and part in type(value).model_fields:
        return getattr(value, part)
    names = list(type(value).model_fields) if isinstance(value, BaseModel) else []
    guess = nearest(part, names)
    raise InputError(
        f"the design has no such key{f'; did you mean {guess}?' if guess else ''}", key=key
    )


def _index(table: tuple[Any, ...], part: str) -> int:
    """Place of an entry by its number or its name; −1 where there is none."""
    names = [getattr(entry, "name", None) for entry in table]
    return int(part) if part.isdigit() else names.index(part) if part in names else -1


def distance_to(target: Floats, weights: Floats) -> Objective:
    """½ Σ w |x − x*|² over the nodes [m² × weight]: how far the sheet is from a wanted shape.

    Args:
        target: wanted positions x* [m], shape (V, 3).
        weights: of the nodes, such as `mesh.node_areas`, shape (V,).
    """

    def objective(positions: Floats) -> tuple[float, Floats]:
        away = positions - target
        return 0.5 * float(weights @ (away**2).sum(axis=1)), weights[:, None] * away

    return objective
