"""The adjoint of an equilibrium: how a function of the state feels a change of the forces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import ComputationError
from sheetmorph.solve.system import System

Floats = NDArray[np.float64]


def adjoint_state(system: System, x: Floats, slope: Floats, tolerance: float) -> Floats:
    """λ with H λ = ∂J/∂x, so that dJ/dp = −λᵀ ∂g/∂p for any parameter p of the energy.

    At an equilibrium g(x(p), p) = 0, hence H dx/dp = −∂g/∂p; H is symmetric, so one solution
    with its factor serves every parameter (Bryson and Ho, Applied optimal control, 1975).

    Args:
        system: the problem at the actuation of the state.
        x: the state, shape (n,).
        slope: ∂J/∂x, shape (n,).
        tolerance: largest residual force that counts as equilibrium [N].

    Raises:
        ComputationError: x is no equilibrium, or no minimum, so that J has no derivative that
            means anything there.
    """
    _, gradient, data = system.hessian(x)
    residual = float(np.abs(gradient).max(initial=0.0))
    if not residual <= tolerance:
        raise ComputationError(
            f"the state is no equilibrium (residual {residual:.2g} N, allowed {tolerance:.2g} N), "
            "so it has no sensitivities; finish the run first"
        )
    if not system.factorise(data):
        raise ComputationError(
            "the state is no stable equilibrium (its Hessian is not positive definite), so a small "
            "change of a parameter may move it anywhere; it has no sensitivities"
        )
    wanted = slope.copy()
    wanted[system.held.held] = 0.0
    solution = system.solve(wanted)
    solution[system.held.held] = 0.0
    return np.asarray(solution)
