"""Derivatives of a function of the final shape with respect to everything that led to it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.solve.adjoint import adjoint_state
from sheetmorph.solve.constraints import HeldDofs
from sheetmorph.solve.linear import make_solver
from sheetmorph.solve.system import System
from sheetmorph.study.design_keys import number_at
from sheetmorph.study.key_slopes import KeySlopes
from sheetmorph.study.laminate_slopes import laminate_fields
from sheetmorph.study.model import Problem, build_problem
from sheetmorph.study.published_slopes import layer_fields, published_fields, published_rest
from sheetmorph.study.result import Result

Objective = Callable[[Floats], tuple[float, Floats]]
"""From node positions (V, 3) [m] to a value and its derivative with respect to them (V, 3)."""

STEP = 1e-5
"""Relative step of the central difference of forces along the adjoint."""

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
    by the chain rule, at a fixed mesh: those of a layer as sums, those of the pattern from what
    they do to the corners of their own shape, others from what they do to the arrays of the model.
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
    problem = build_problem(result.design, result.mesh, result.regions)
    wanted = _wanted(problem, fields)
    _check_open(problem, result.positions[-1])
    state = _State.of(problem, result)
    value, slope = objective(result.positions[-1])
    slope = np.asarray(slope, dtype=np.float64)
    adjoint = state.adjoint(slope)
    found = _fields(problem, state, adjoint, slope, wanted)
    slopes = None
    if values or (fields is None and problem.regions.smooth is not None):
        slopes = KeySlopes.of(problem, found, state.x, adjoint, state.ramp)
    pattern = None if slopes is None else slopes.pattern
    return Sensitivities(
        value=float(value),
        keys={} if slopes is None else {key: slopes.by_key(key, values[key]) for key in values},
        fields={name: array for name, array in found.items() if name in wanted},
        boundary={} if pattern is None else pattern.by_corner,
        corners={} if pattern is None else {k: b.corners for k, b in pattern.boundaries.items()},
    )


def _check_open(problem: Problem, positions: Floats) -> None:
    """Refuse a shape in which guards hold triangles open."""
    for what, places in problem.held_open(positions).items():
        raise ComputationError(
            f"the shape leans on the guard that keeps {what} ({places} places), which is no "
            "property of the sheet, so it has no sensitivities; refine the mesh there or actuate "
            "less"
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
