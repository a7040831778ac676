"""Large deflections of a cantilever that is clamped level: by its weight, or a force at its tip.

The slope θ, downward, of a beam of stiffness EI obeys θ″ = −Γ u cos θ under its own weight q per
length and θ″ = −Γ cos θ under a force P at its tip; u is the distance from the tip over the
length L, Γ = q L³/(EI) or P L²/(EI), θ′ = 0 at the tip and θ = 0 at the clamp. Measured in
Γ^(1/3) u (or Γ^(1/2) u) the equation has no parameter: integrated from the tip with a tip slope,
it reaches the clamp where θ = 0, and Γ is read off there. No shooting is needed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Literal

import numpy as np

from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

Loading = Literal["self_weight", "end_load"]

LARGEST = 0.9
"""Greatest tip deflection over length that is solved; beyond, the beam hangs."""

_SMALL_LIMIT = {"self_weight": 8.0, "end_load": 3.0}
_POWER = {"self_weight": 3, "end_load": 2}
_SLOPES = 60


@dataclass(frozen=True, eq=False)
class _Table:
    """ln of Γ over its small-deflection value, as a spline of the square of δ/L."""

    spline: CubicSpline


def load_number(deflection_ratio: Floats, loading: Loading) -> Floats:
    """Γ of a cantilever whose tip hangs down by a fraction of its length, any shape.

    Exact but for the tolerance of the integration (1e-10) and an interpolation (1e-6); tends to
    8 δ/L for self-weight and 3 δ/L for an end load.

    Args:
        deflection_ratio: δ/L, 0 to `LARGEST`.
        loading: "self_weight" gives q L³/(EI), "end_load" P L²/(EI).
    """
    ratio = np.asarray(deflection_ratio, dtype=np.float64)
    return np.asarray(_SMALL_LIMIT[loading] * ratio * np.exp(_table(loading).spline(ratio**2)))


def load_exponent(deflection_ratio: Floats, loading: Loading) -> Floats:
    """d ln Γ / d ln (δ/L), any shape: 1 for small deflections, more for large ones."""
    ratio = np.asarray(deflection_ratio, dtype=np.float64)
    return np.asarray(1.0 + 2.0 * ratio**2 * _table(loading).spline(ratio**2, 1))


@lru_cache(maxsize=2)
def _table(loading: Loading) -> _Table:
    from scipy.interpolate import CubicSpline

    # Denser toward level tips, where Γ over its limit tends to one with the slope squared.
    slopes = 0.4999 * math.pi * np.sin(np.linspace(0.0, 0.5 * math.pi, _SLOPES + 1))[1:]
    points = np.array([_from_tip(float(slope), loading) for slope in slopes])
    ratio, number = points[points[:, 0] < LARGEST + 0.08].T
    excess = np.log(number / (_SMALL_LIMIT[loading] * ratio))
    return _Table(CubicSpline(np.append(0.0, ratio**2), np.append(0.0, excess)))


def _from_tip(slope: float, loading: Loading) -> tuple[float, float]:
    """δ/L and Γ of the beam with a slope [rad] at its tip."""
    from scipy.integrate import solve_ivp

    weight = 1.0 if loading == "self_weight" else 0.0

    def rate(v: float, state: Floats) -> list[float]:
        angle, turn, _height = state
        pull = v if weight else 1.0
        return [turn, -pull * math.cos(angle), math.sin(angle)]

    def level(_v: float, state: Floats) -> float:
        return float(state[0])

    level.terminal = True  # type: ignore[attr-defined]
    level.direction = -1.0  # type: ignore[attr-defined]
    path = solve_ivp(
        rate, (0.0, 60.0), [slope, 0.0, 0.0], method="DOP853", events=level, rtol=1e-11, atol=1e-13
    )
    reach, height = float(path.t_events[0][0]), float(path.y_events[0][0][2])
    return height / reach, reach ** _POWER[loading]
