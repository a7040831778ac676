"""Poking a shape: the force at which it snaps, and where it is when the force is taken away."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.solve.arclength import ArcOptions, Curve, Loading, pushed, trace
from sheetmorph.solve.minimise import NewtonOptions, Outcome, minimise
from sheetmorph.solve.system import System
from sheetmorph.study.model import Problem
from sheetmorph.study.stability import system_of

BEYOND = 1.01
"""Force that is held after the snap, over that at which it snaps."""

UNLOADING = 10
"""Steps in which the force is taken away."""


@dataclass(frozen=True, eq=False)
class Poke:
    """What a force on a node does to a shape.

    Attributes:
        curve: equilibria under the force, its amount being the parameter [N].
        displacement: of the node along the force at the points of the curve [m], shape (P,).
        snap_force: the first force at which the shape gives way [N]; None where it holds as
            far as the curve goes.
        under: the state under a force 1 % larger, shape (n,); None as before.
        off: the state after that force has been taken away, shape (n,); None as before.
    """

    curve: Curve
    displacement: Floats
    snap_force: float | None
    under: Floats | None
    off: Floats | None


def poke(
    problem: Problem,
    x: Floats,
    node: int,
    direction: Floats,
    *,
    ramp: float = 1.0,
    reach: float | None = None,
    system: System | None = None,
) -> Poke:
    """Push a node of a stable shape with a growing dead force until the shape snaps.

    The curve of equilibria is followed by arc length through its first limit point; then the
    energy is minimised under a force 1 % beyond, and again as the force goes to zero.

    Args:
        problem: the problem.
        x: a stable state at the ramp without the perturbation load, shape (n,).
        node: where the force acts.
        direction: of the force, shape (3,); of any length.
        ramp: fraction of the actuation.
        reach: displacement of the node at which to stop [m]; half the extent when None.
        system: the system of the problem, where it is at hand.

    Raises:
        InputError: the node is held, or there is none of this number, or no direction.
        ComputationError: the state is unstable or an equilibrium cannot be found.
    """
    force = _force(problem, node, direction)
    here = (system_of(problem) if system is None else system).at(ramp, 0.0)
    _, gradient, data = here.hessian(x)
    tolerance = problem.residual_tolerance
    if np.abs(gradient).max() > 10.0 * tolerance or not here.factorise(data):
        raise ComputationError("only a shape in stable equilibrium can be poked")
    extent = float(np.ptp(problem.mesh.nodes, axis=0).max())
    length = 2e-3 * extent
    compliance = float(force @ here.solve(force))
    farthest = 0.5 * extent if reach is None else reach
    start = float(force @ x)
    loading = pushed(here, force)
    curve = trace(
        loading,
        x,
        0.0,
        ArcOptions(tolerance, length, length / compliance, first_step=0.2, max_step=2.0),
        # A negative pivot tells that the limit point has been passed.
        lambda point: point.negative_pivots > 0 or float(force @ point.x) - start > farthest,
    )
    displacement = np.array([float(force @ point.x) - start for point in curve.points])
    tops = [limit for limit in curve.limits if limit.kind == "maximum"]
    if curve.points[-1].negative_pivots == 0:
        return Poke(curve, displacement, None, None, None)
    # Without a limit point the shape gives way sideways, at a bifurcation of the curve.
    snap = tops[0].parameter if tops else curve.points[-1].parameter
    options = NewtonOptions(tolerance, max_iterations=500)
    under = _minimum(loading, BEYOND * snap, curve.points[-1].x, options)
    off = under
    for part in np.linspace(1.0, 0.0, UNLOADING + 1)[1:]:
        off = _minimum(loading, float(part) * snap, off, options)
    return Poke(curve, displacement, snap, under, off)


def _force(problem: Problem, node: int, direction: Floats) -> Floats:
    count = len(problem.mesh.nodes)
    if not 0 <= node < count:
        raise InputError("there is no such node", value=node, allowed=f"0 to {count - 1}")
    size = float(np.linalg.norm(direction))
    if not size > 0.0:
        raise InputError("a force needs a direction", value=list(direction))
    force = np.zeros(len(problem.held_dofs))
    force[3 * node : 3 * node + 3] = np.asarray(direction) / size
    if (problem.held_dofs & (force != 0.0)).any():
        raise InputError("this node is held in the direction of the force", value=node)
    return force


def _minimum(loading: Loading, amount: float, x: Floats, options: NewtonOptions) -> Floats:
    found = minimise(loading(amount), x, options)
    if found.outcome is not Outcome.CONVERGED:
        raise ComputationError(f"no equilibrium was found under {amount:.3g} N: {found.outcome}")
    return found.x
