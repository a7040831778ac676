"""Derivatives of a function of the final shape with respect to everything that led to it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from pydantic import BaseModel

from sheetmorph.core.errors import ComputationError, InputError, nearest
from sheetmorph.design.laminate import stack_of
from sheetmorph.design.regions import Regions
from sheetmorph.design.spec import Design
from sheetmorph.energy.guard import TriangleGuard
from sheetmorph.energy.loads import NodalLoad
from sheetmorph.geometry.mesh import Floats
from sheetmorph.solve.adjoint import adjoint_state
from sheetmorph.solve.constraints import HeldDofs
from sheetmorph.solve.linear import make_solver
from sheetmorph.solve.system import System
from sheetmorph.study.laminate_slopes import laminate_fields
from sheetmorph.study.model import Problem, build_problem
from sheetmorph.study.parameters import model_arrays
from sheetmorph.study.pattern_slopes import PatternSlopes
from sheetmorph.study.published_slopes import layer_fields, published_fields, published_rest
from sheetmorph.study.result import Result

Objective = Callable[[Floats], tuple[float, Floats]]
"""From node positions (V, 3) [m] to a value and its derivative with respect to them (V, 3)."""

STEP = 1e-5
"""Relative step of the central differences of forces and strains, at fixed positions."""

SMALL_STEP = 1e-7
"""Relative step by which corners of the pattern are moved, to one side."""

UNCHANGED = ("outline", "mesh", "supports")
"""Tables of the design that decide on the mesh and on what is held: not differentiated."""

DISCRETE = ("random_polygons", "drawing")
"""Kinds of shapes that do not follow their numbers smoothly."""

FROM_ZERO = ("fillet", "corner_radius", "hub_radius", "disc_radius")
"""Sizes in a pattern that are nothing at 0."""

LAYER_FIELDS = frozenset({"thickness", "young_modulus", "poisson_ratio"})
PUBLISHED_FIELDS = (
    "eigenstrain",
    "stretch_stiffness",
    "bending_stiffness",
    "coupling",
    "rest_length",
    *sorted(LAYER_FIELDS),
    "rest_positions",
)
LAMINATE_FIELDS = ("eigenstrain", "eigenstrain_factor", *sorted(LAYER_FIELDS), "rest_positions")
"""Names of the fields of each model."""


@dataclass(frozen=True, eq=False)
class Sensitivities:
    """A function of the final shape and its derivatives.

    V nodes, E edges, H hinges, T triangles, L layers.

    Attributes:
        value: of the function.
        keys: derivative by design key, in SI units, at a fixed mesh.
        fields: derivatives by field, each with all others held fixed. Both models:
            "rest_positions" (V, 3), positions before actuation, while layers and free strains
            stay with edges and triangles; "thickness", "young_modulus", "poisson_ratio" of each
            layer at each edge (L, E) or, with the laminate model, triangle (L, T), also where it
            has thickness 0 because it does not lie there.
            Published model: "eigenstrain" (E,), "stretch_stiffness" K (E,), "rest_length" (E,),
            "bending_stiffness" k_b and "coupling" (H,).
            Laminate model: "eigenstrain" (T, 3), (e11, e22, e12) in the triangle's frame at full
            actuation, where e12 counts once for both of its places in the tensor;
            "eigenstrain_factor" (L, T).
        boundary: of a pattern with a smeared boundary, by part: derivatives by the corners of its
            drawn outline, shape (M, 2), see `corners`.
        corners: these corners [m], shape (M, 2), ring by ring, the first of each repeated.
    """

    value: float
    keys: Mapping[str, float]
    fields: Mapping[str, Floats]
    boundary: Mapping[str, Floats]
    corners: Mapping[str, Floats]


def sensitivities(
    result: Result,
    objective: Objective,
    keys: Sequence[str] = (),
    *,
    fields: Collection[str] | None = None,
) -> Sensitivities:
    """Differentiate a function of the final shape of a run, by the adjoint method.

    One factorisation serves all parameters; nothing is solved again. Keys follow from the fields
    by the chain rule: what a key does to the arrays of the model is differenced, at a fixed mesh.
    Keys of the pattern need a smeared boundary (`mesh.pattern_smoothing`). On a free sheet only
    functions that no rigid motion changes have a meaning.

    Args:
        result: a completed run; its last state is the shape.
        objective: see `Objective`.
        keys: dotted keys of numbers in the design, such as "actuation.eps_pre",
            "layers.0.thickness" or "pattern.0.arm_length".
        fields: names of the fields wanted, see `Sensitivities`; all by default.

    Raises:
        InputError: a key is no number of the design, or belongs to its geometry; or there is no
            such field.
        ComputationError: the last state is no stable equilibrium.
    """
    if result.status != "completed":
        raise ComputationError(
            f"the run ended with {result.status}, so its last state has no sensitivities"
        )
    values = {key: number_at(result.design, key) for key in keys}
    problem = build_problem(result.design, result.mesh)
    wanted = _wanted(problem, fields)
    _check_open(problem, result.positions[-1])
    state = _State.of(problem, result)
    value, slope = objective(result.positions[-1])
    slope = np.asarray(slope, dtype=np.float64)
    adjoint = state.adjoint(slope)
    found = _fields(problem, state, adjoint, slope, wanted)
    smeared = problem.regions.smooth is not None
    pattern = PatternSlopes.of(problem, found) if smeared and (values or fields is None) else None
    return Sensitivities(
        value=float(value),
        keys={key: _by_key(state, key, values[key], adjoint, found, pattern) for key in values},
        fields={name: array for name, array in found.items() if name in wanted},
        boundary={} if pattern is None else pattern.by_corner,
        corners={} if pattern is None else {k: b.corners for k, b in pattern.boundaries.items()},
    )


def _check_open(problem: Problem, positions: Floats) -> None:
    """Refuse a shape in which triangles would collapse if nothing held them open."""
    for term in problem.model.terms:
        if isinstance(term, TriangleGuard) and len(held := term.held_open(positions)):
            raise ComputationError(
                f"the shape leans on the guard that keeps triangles from collapsing ({len(held)} "
                "of them), which is no property of the sheet, so it has no sensitivities; refine "
                "the mesh there or actuate less"
            )


@dataclass(frozen=True, eq=False)
class _State:
    """The last state of a run as the solver sees it."""

    problem: Problem
    system: System
    x: Floats
    ramp: float
    load: float

    @classmethod
    def of(cls, problem: Problem, result: Result) -> _State:
        x = np.concatenate([result.positions[-1].ravel(), result.scalars[-1]])
        ramp, load = float(result.ramp[-1]), float(result.load_fraction[-1])
        pattern = problem.total.pattern
        growth = problem.total.growth
        linear = make_solver(pattern, result.design.solver.linear_solver, growth=growth)
        held = HeldDofs.of(pattern, problem.held_dofs)
        return cls(problem, System(problem.total.at(ramp, load), held, linear), x, ramp, load)

    def adjoint(self, slope: Floats) -> Floats:
        """λ, shape (n,)."""
        whole = np.concatenate([slope.ravel(), np.zeros(len(self.x) - slope.size)])
        return adjoint_state(self.system, self.x, whole, 10.0 * self.problem.residual_tolerance)

    def forces(self, x: Floats) -> Floats:
        """Forces of all terms, those at held degrees of freedom too [N], shape (n,)."""
        _, gradient, _ = self.system.energy.evaluate(x, 1)
        assert gradient is not None  # noqa: S101  order 1 gives it
        return gradient


def _wanted(problem: Problem, fields: Collection[str] | None) -> Collection[str]:
    """Names of the fields to return, checked."""
    known = LAMINATE_FIELDS if problem.design.laminate else PUBLISHED_FIELDS
    if fields is None:
        return known
    for name in fields:
        if name not in known:
            raise InputError(
                "the model has no such field", key="fields", value=name, allowed=", ".join(known)
            )
    return fields


def _fields(
    problem: Problem, state: _State, adjoint: Floats, slope: Floats, wanted: Collection[str]
) -> dict[str, Floats]:
    """The fields of the model; those that cost much only where wanted."""
    rest = "rest_positions" in wanted
    if problem.design.laminate:
        found = laminate_fields(problem, state.x, adjoint, state.ramp, rest)
    else:
        found = published_fields(problem, state.x, adjoint, state.ramp)
        if not LAYER_FIELDS.isdisjoint(wanted):
            found |= layer_fields(problem, found)
        if rest:
            found["rest_positions"] = published_rest(problem, found)
    if rest and len(problem.held_nodes):
        found["rest_positions"] += _held_rest(state, adjoint, slope)
    return found


def _held_rest(state: _State, adjoint: Floats, slope: Floats) -> Floats:
    """Through the held coordinates, which stay where they were before actuation, shape (V, 3).

    They follow a rest position, so dJ/dX = ∂J/∂x − H λ there.
    """
    largest = float(np.abs(adjoint).max())
    h = STEP * float(np.ptp(state.x)) / largest if largest else 1.0
    ahead, behind = (state.forces(state.x + step * adjoint) for step in (h, -h))
    count = slope.size
    through = slope.ravel() - (ahead - behind)[:count] / (2.0 * h)
    through[~state.problem.held_dofs[:count]] = 0.0
    return np.asarray(through.reshape(-1, 3))


def _by_key(
    state: _State,
    key: str,
    value: float,
    adjoint: Floats,
    fields: Mapping[str, Floats],
    pattern: PatternSlopes | None,
) -> float:
    """By the chain rule, with central differences of what the key does to the arrays."""
    problem = state.problem
    table = key.split(".")[0]
    size = abs(value) or 1.0
    if table == "pattern" and _only_loads(problem, table):
        assert pattern is not None  # noqa: S101  number_at refuses patterns with a sharp boundary
        step, shape = SMALL_STEP * size, _index(problem.design.pattern, key.split(".")[1])
        return pattern.towards(with_number(problem.design, key, value + step), shape) / step
    step = STEP * size
    ahead, behind = (with_number(problem.design, key, value + s) for s in (step, -step))
    if not _only_loads(problem, table):
        return _by_forces(state, ahead, behind, adjoint) / (2.0 * step)
    ends = [
        model_arrays(one, problem.mesh, _restacked(problem, one), table) for one in (ahead, behind)
    ]
    motion = problem.positions(adjoint)
    weights = {**fields, "applied": state.ramp * motion, "weight": motion}
    total = sum(float((weights[k] * (ends[0][k] - ends[1][k])).sum()) for k in ends[0])
    return total / (2.0 * step)


def _restacked(problem: Problem, design: Design) -> Regions:
    """The regions of a problem with the layers of a changed design, nothing moved."""
    cells, smooth = problem.regions.cells, problem.regions.smooth
    return replace(
        problem.regions,
        cells=tuple(replace(cell, stack=stack_of(design, cell.parts)) for cell in cells),
        smooth=None if smooth is None else smooth.with_layers(design),
    )


def _only_loads(problem: Problem, table: str) -> bool:
    """True where no term beside the model and dead loads depends on the design's numbers."""
    terms = problem.total.terms[len(problem.model.terms) :]
    weighty = len(terms) > 1 and table == "pattern"
    return all(isinstance(term, NodalLoad) for term in terms) and not weighty


def _by_forces(state: _State, ahead: Design, behind: Design, adjoint: Floats) -> float:
    """−λᵀ of the change of the forces at fixed positions, with the energy set up anew."""
    changed = []
    for design in (ahead, behind):
        total = build_problem(design, state.problem.mesh).total.at(state.ramp, state.load)
        changed.append(replace(state, system=replace(state.system, energy=total)).forces(state.x))
    return float(-adjoint @ (changed[0] - changed[1]))


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
            allowed="keys of layers, actuation, pattern, published, laminate, loads, gravity",
        )
    value: Any = design.spec
    for part in parts:
        value = _part(value, part, key)
    if parts[0] == "pattern":
        _check_pattern(design, key, value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError("holds no number", key=key, value=value)
    return float(value)


def _check_pattern(design: Design, key: str, value: object) -> None:
    """Refuse keys of a pattern with which its boundary does not move smoothly."""
    if design.spec.mesh.pattern_smoothing is None:
        raise InputError(
            "moves the boundary of the pattern, which is sharp: on a mesh the shape jumps with it",
            key=key,
            allowed="pattern keys of designs with mesh.pattern_smoothing, such as an edge length",
        )
    shape = design.pattern[_index(design.pattern, key.split(".")[1])]
    if shape.kind in DISCRETE or isinstance(value, int):
        what = "a whole number" if isinstance(value, int) else f"a key of the shape {shape.kind}"
        raise InputError(f"is {what}, which cannot change a little", key=key, value=value)
    if value == 0.0 and key.split(".")[-1] in FROM_ZERO:
        raise InputError(
            "is 0, the end of its range, where the shape begins to have it", key=key, value=value
        )


def with_number(design: Design, key: str, value: float) -> Design:
    """The same design with another number at a key, in SI units; its text is left as it is."""

    def changed(table: Any, parts: list[str]) -> Any:
        if not parts:
            return value
        inner = changed(_part(table, parts[0], key), parts[1:])
        if isinstance(table, tuple):
            index = _index(table, parts[0])
            return (*table[:index], inner, *table[index + 1 :])
        copied = table.model_copy(update={parts[0]: inner})
        copied.__dict__.pop("layout", None)  # drawn anew where the pattern moves
        return copied

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
