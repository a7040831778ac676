"""The oven: which temperature gives a design's free strain, and the weight for the glue."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from sheetmorph.design.shrinkage import ShrinkCurve
    from sheetmorph.design.spec import Design

PAPER_TEMPERATURE = (300.0 - 32.0) / 1.8 + 273.15
"""Oven of the paper's protocol, 300 degrees Fahrenheit [K]."""

PAPER_SECONDS = 15.0
CURE_PRESSURE = 6.8e2
"""Distributed weight on the glue of the paper's protocol [N/m²]."""

CURE_HOURS = 10.0
ADHESIVE_THICKNESS = 0.1e-3
"""Upper bound on the cured adhesive in the paper [m]."""

STANDARD_GRAVITY = 9.80665

_LEVEL = 0.99

Reach = Literal["given", "reached", "beyond", "swells", "none"]


@dataclass(frozen=True)
class OvenSetting:
    """What the shrink curve says about a design.

    Attributes:
        reach: "given" when the design names the temperature, "reached" when the curve has
            its strain (to 1 % on the plateau), "beyond" when it shrinks more than the curve
            ever does, "swells" when it grows and the curve never does, "none" when it does
            not move.
        eps_pre: free strain of the design.
        temperature: at which a free sheet has that strain [K]; None when there is none.
        plateau: the curve's strain that comes nearest to the design's.
        plateau_temperature: the lowest at which the curve has 99 % of that strain [K].
        sensitivity: by how much the strain changes per kelvin there; 0 on a plateau.
        curve: name of the curve.
    """

    reach: Reach
    eps_pre: float
    temperature: float | None
    plateau: float
    plateau_temperature: float
    sensitivity: float
    curve: str


def oven_setting(design: Design) -> OvenSetting:
    """Find the temperature for a design.

    Raises:
        InputError: the design's curve is not usable.
    """
    from sheetmorph.design.shrinkage import load_curve

    curve = load_curve(design)
    eps_pre = design.eps_pre
    nearest_ratio = float(np.clip(1.0 + eps_pre, *_range(curve)))
    at_nearest = _lowest_temperature(curve, nearest_ratio)
    levels_off = _lowest_temperature(curve, 1.0 + _LEVEL * (nearest_ratio - 1.0))
    given = design.actuation.temperature
    reach: Reach
    if given is not None:
        reach, temperature = "given", given
    elif eps_pre == 0.0:
        reach, temperature = "none", None
    elif abs(nearest_ratio - 1.0 - eps_pre) < 1e-9:
        # On the plateau the curve creeps: its very end is no better than where it levels off.
        extreme = (_range(curve)[0] if eps_pre < 0.0 else _range(curve)[1]) - 1.0
        level = abs(eps_pre) >= _LEVEL * abs(extreme)
        reach, temperature = "reached", levels_off if level else at_nearest
    else:
        reach, temperature = ("beyond" if eps_pre < 0.0 else "swells"), None
    return OvenSetting(
        reach,
        eps_pre,
        temperature,
        nearest_ratio - 1.0,
        levels_off,
        0.0 if temperature is None else _slope(curve, temperature),
        curve.name,
    )


def cure_mass(area: float) -> float:
    """Mass [kg] whose weight on an area [m²] makes the paper's pressure."""
    return CURE_PRESSURE * area / STANDARD_GRAVITY


def degrees(temperature: float) -> str:
    """A temperature [K] in whole degrees Celsius and Fahrenheit."""

    return f"{round(temperature - 273.15)} °C ({round(1.8 * (temperature - 273.15) + 32)} °F)"


def sentences_of(setting: OvenSetting) -> list[str]:
    """What the curve says, for people."""
    asked = f"eps_pre = {setting.eps_pre:+.3g}".replace("-", "−")
    best = f"{setting.plateau:+.3g}".replace("-", "−")
    curve = f"the shrink curve “{setting.curve}”"
    if setting.reach == "none":
        return ["The design has eps_pre = 0: no heat is needed and nothing will move."]
    if setting.reach == "beyond":
        return [
            (
                f"The design asks for {asked}, more than {curve} reaches: it levels off at {best}, "
                f"from {degrees(setting.plateau_temperature)} on. No temperature gives the strain "
                "of the design; expect the real sheet to shrink less than computed, or set "
                f"actuation.eps_pre to {best} and compute again."
            )
        ]
    if setting.reach == "swells":
        return [
            (
                f"The design swells ({asked}), and {curve} has no more than {best}: no oven "
                "temperature follows from it. Actuate the film as its own data sheet says; the "
                "oven of the paper is for polystyrene that shrinks."
            )
        ]
    temperature = setting.temperature or 0.0
    if setting.reach == "given":
        told = [
            f"The design names {degrees(temperature)}; by {curve}, a free sheet has {asked} there."
        ]
    else:
        told = [f"By {curve}, a free sheet reaches {asked} at {degrees(temperature)}."]
    if setting.sensitivity > 2e-4:
        told.append(
            f"The curve is steep there: 5 °C more or less change the strain by about "
            f"{5 * setting.sensitivity:.2g}. Check the oven with a thermometer, and try a scrap "
            "of film first."
        )
    if setting.curve == "polystyrene":
        told.append(
            "Between its ends (no shrinkage below 93 °C, about −0.6 above 148 °C) the built-in "
            "curve is a smooth guess: measure your own film for quantitative work."
        )
    return told


def _range(curve: ShrinkCurve) -> tuple[float, float]:
    """Least and greatest length ratio; the cubics keep to the range of the data."""
    return float(curve.length_ratios.min()), float(curve.length_ratios.max())


def _lowest_temperature(curve: ShrinkCurve, ratio: float) -> float:
    """The lowest temperature [K] with a length ratio within the range of the curve.

    Where the curve stays level at 1 before it moves, the end of that level is meant.
    """
    from scipy.interpolate import PchipInterpolator

    temperatures, ratios = curve.temperatures, curve.length_ratios
    exact = np.flatnonzero(np.isclose(ratios, ratio, rtol=0.0, atol=1e-12))
    roots = PchipInterpolator(temperatures, ratios).solve(ratio, extrapolate=False)
    found = np.concatenate([temperatures[exact], roots[np.isfinite(roots)]])
    return float(found.min())


def _slope(curve: ShrinkCurve, temperature: float) -> float:
    from scipy.interpolate import PchipInterpolator

    slope = PchipInterpolator(curve.temperatures, curve.length_ratios).derivative()
    return abs(float(slope(temperature)))
