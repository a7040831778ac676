"""Taylor tests: how fast the remainders of an energy's expansions vanish."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sheetmorph.energy.total import Total
from sheetmorph.geometry.mesh import Floats


@dataclass(frozen=True)
class TaylorSlopes:
    """Orders of the remainders in the step size h.

    Attributes:
        gradient: of E(x + h v) − E − h g·v; 2 when the gradient is right.
        hessian: of E(x + h v) − E − h g·v − h²/2 v·Hv; 3 when the Hessian is right too.
            Infinity where a remainder vanishes to rounding (an energy of lower degree).
    """

    gradient: float
    hessian: float


def taylor_slopes(total: Total, x: Floats, direction: Floats, sizes: Floats) -> TaylorSlopes:
    """Fit the orders of the Taylor remainders at x along a direction.

    A finite-difference check with one step size passes by luck or fails by rounding; the
    slope over several sizes does neither.

    Args:
        total: the energy.
        x: where [m], shape (3 V,).
        direction: along which, shape (3 V,).
        sizes: step sizes h, each a constant factor below the last, shape (k,).

    Returns:
        The fitted orders.
    """
    energy, gradient, data = total.evaluate(x, 2)
    assert gradient is not None and data is not None  # noqa: S101
    slope = float(gradient @ direction)
    curvature = float(direction @ (total.matrix(data) @ direction))
    first, second = np.empty(len(sizes)), np.empty(len(sizes))
    for k, h in enumerate(sizes):
        ahead, _, _ = total.evaluate(x + h * direction, 0)
        first[k] = ahead - energy - h * slope
        second[k] = first[k] - 0.5 * h * h * curvature
    floor = 1e-13 * max(abs(energy), abs(sizes[0] * slope))
    return TaylorSlopes(_order(sizes, first, floor), _order(sizes, second, floor))


def _order(sizes: Floats, remainders: Floats, floor: float) -> float:
    above = np.abs(remainders) > floor
    if above.sum() < 3:
        return float("inf")
    return float(np.polyfit(np.log(sizes[above]), np.log(np.abs(remainders[above])), 1)[0])
