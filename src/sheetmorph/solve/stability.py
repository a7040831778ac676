"""Is an equilibrium a minimum, and which way does a saddle fall?"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sheetmorph.solve.system import System

Floats = NDArray[np.float64]


def negative_pivots(system: System, x: Floats) -> tuple[int, Floats, Floats]:
    """Count the negative eigenvalues of the Hessian at x, and correct x with its factor.

    Returns:
        The number of negative pivots on the free degrees of freedom (Sylvester's law; a
        singular Hessian counts as one); the better of x and x after one Newton step; and the
        gradient there [N].
    """
    _, gradient, data = system.hessian(x)
    if not system.factorise(data):
        return max(1, system.factorise_indefinite(data) or 0), x, gradient
    moved = system.toward(x, x - system.solve(gradient))
    _, after = system.gradient(moved)
    if np.abs(after).max(initial=0.0) < np.abs(gradient).max(initial=0.0):
        return 0, moved, after
    return 0, x, gradient


def escape_saddle(system: System, x: Floats, size: float = 1e-3) -> Floats:
    """Step off a saddle along a direction of negative curvature, downhill.

    The direction comes from inverse iteration with the indefinite factor, started from a
    fixed pseudo-random vector.

    Args:
        system: the problem; its Hessian at x has a negative eigenvalue.
        x: the saddle, shape (n,).
        size: largest displacement of the step, as a fraction of the extent of x.

    Returns:
        The place after the step, shape (n,).
    """
    _, gradient, data = system.hessian(x)
    shift = 0.0
    while system.factorise_indefinite(data, shift) is None:
        shift = max(10.0 * shift, 1e-12 * float(np.abs(data).max()))
    direction = np.random.default_rng(0).standard_normal(len(x))
    direction[system.held.held] = 0.0
    for _ in range(12):
        direction = system.solve(direction)
        direction[system.held.held] = 0.0
        direction /= np.linalg.norm(direction)
    if direction @ gradient > 0:
        direction = -direction
    reach = size * (float(np.ptp(x)) or 1.0) / float(np.abs(direction).max())
    options = [system.toward(x, x + part * direction) for part in (reach, -reach)]
    return min(options, key=system.value)


def negative_eigenvalues(system: System, x: Floats) -> int:
    """The number of negative eigenvalues of the Hessian at any state x, stable or not.

    Where the Hessian is singular to working accuracy, a trace of stiffness is added.
    """
    _, _, data = system.hessian(x)
    shift = 0.0
    while (count := system.factorise_indefinite(data, shift)) is None:
        shift = max(10.0 * shift, 1e-14 * float(np.abs(data[system.held.diagonal]).max()))
    return count
