"""What may be fitted: names of parameters, their bounds, and the keys of a design they set."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sheetmorph.core.errors import InputError, nearest
from sheetmorph.design.spec import Design

_SHOWN = {"m": (1e3, "mm"), "Pa": (1e-6, "MPa"), "rad": (180.0 / math.pi, "deg")}
INDEX = re.compile(r"\[(\d+)\]")


@dataclass(frozen=True)
class Parameter:
    """A number that is fitted, between two bounds.

    Attributes:
        name: as the user writes it: `eps_pre`, or a key such as `layers.1.thickness`.
        low, high: the bounds, in SI units.
        logarithmic: True where ratios of it matter, not differences.
        unit: its SI unit, as text; empty for a plain number.
        meaning: one line for people.
    """

    name: str
    low: float
    high: float
    logarithmic: bool = False
    unit: str = ""
    meaning: str = ""

    @property
    def shown(self) -> tuple[float, str]:
        """How people read it: a factor on the SI value, and the unit that this gives."""
        return _SHOWN.get(self.unit, (1.0, self.unit))

    def values(self, design: Design, value: float) -> dict[str, object]:
        """The keys of the design that give it this value, as for `Design.with_values`."""
        if self.name in NAMED:
            return NAMED[self.name].values(design, value)
        return {self.name: f"{value!r} {self.unit}" if self.unit else value}

    def own(self, design: Design) -> float:
        """The value that the design has.

        Raises:
            InputError: it has none, or it is no number.
        """
        if self.name in NAMED:
            return NAMED[self.name].own(design)
        return number_at(design, self.name)

    def to_share(self, value: float) -> float:
        """Where a value lies between the bounds: 0 at the low one, 1 at the high one."""
        if self.logarithmic:
            share = math.log(value / self.low) / math.log(self.high / self.low)
        else:
            share = (value - self.low) / (self.high - self.low)
        return min(1.0, max(0.0, share))

    def from_share(self, share: float) -> float:
        """The value at a place between the bounds; the inverse of `to_share`."""
        if share <= 0.0:
            return self.low
        if share >= 1.0:
            return self.high
        if self.logarithmic:
            value = self.low * (self.high / self.low) ** share
        else:
            value = self.low + (self.high - self.low) * share
        # Nine digits are enough for a fit, and can be read in the design file that it writes.
        return min(self.high, max(self.low, float(f"{value:.9g}")))


def with_parameters(
    design: Design, parameters: Sequence[Parameter], values: Sequence[float]
) -> Design:
    """A copy of the design in which the parameters have these values.

    Raises:
        InputError: the design does not allow them.
    """
    keys: dict[str, object] = {}
    for parameter, value in zip(parameters, values, strict=True):
        keys |= parameter.values(design, float(value))
    return design.with_values(keys)


@dataclass(frozen=True)
class Named:
    """A parameter with a name of its own: its default bounds, how it is read and set."""

    meaning: str
    bounds: Callable[[Design], tuple[float, float]]
    logarithmic: bool
    own: Callable[[Design], float]
    values: Callable[[Design, float], dict[str, object]]


def _around_zero(design: Design) -> tuple[float, float]:
    return (-0.9, -0.02) if design.eps_pre <= 0 else (0.02, 0.9)


def _gamma(design: Design) -> float:
    if design.actuation.profile == "step":
        raise InputError(
            "gamma of the step profile is infinite; write profile = exponential with a gamma",
            key="actuation.profile",
            value="step",
        )
    return design.actuation.gamma or 0.0  # the linear profile is the limit of gamma to 0


def _moduli_ratio(design: Design) -> float:
    moduli = {
        role: next((layer.young_modulus for layer in design.layers if layer.role == role), None)
        for role in ("inert", "active")
    }
    if moduli["inert"] is None or moduli["active"] is None:
        raise InputError("the design has no inert layer, and so no ratio", key="--fit moduli_ratio")
    return moduli["inert"] / moduli["active"]


def _scaled_inert_moduli(design: Design, ratio: float) -> dict[str, object]:
    factor = ratio / _moduli_ratio(design)
    return {
        f"layers.{index}.young_modulus": f"{layer.young_modulus * factor!r} Pa"
        for index, layer in enumerate(design.layers)
        if layer.role == "inert"
    }


def _published(key: str) -> Callable[[Design, float], dict[str, object]]:
    return lambda design, value: {f"published.{key}": value}


NAMED: dict[str, Named] = {
    "eps_pre": Named(
        "free strain of the active layers, negative is shrinkage",
        _around_zero,
        False,
        lambda design: design.eps_pre,
        lambda design, value: {"actuation.eps_pre": value},
    ),
    "gamma": Named(
        "steepness of the exponential profile of the strain, 0 is linear",
        lambda design: (0.0, 6.0),
        False,
        _gamma,
        lambda design, value: {"actuation.profile": "exponential", "actuation.gamma": value},
    ),
    "moduli_ratio": Named(
        "modulus of the inert layers over that of the active ones",
        lambda design: (_moduli_ratio(design) / 10, _moduli_ratio(design) * 10),
        True,
        _moduli_ratio,
        _scaled_inert_moduli,
    ),
    "stretch_factor": Named(
        "factor on the stretching stiffness of the published model",
        lambda design: (design.published.stretch_factor / 10, design.published.stretch_factor * 10),
        True,
        lambda design: design.published.stretch_factor,
        _published("stretch_factor"),
    ),
    "coupling": Named(
        "natural dihedral angle per strain difference, beta times l0",
        lambda design: (-1.0, 4.0),
        False,
        lambda design: design.published.coupling,
        _published("coupling"),
    ),
}


def number_at(design: Design, key: str) -> float:
    """The number that the checked design has at a dotted key, in SI units."""
    value: Any = design.spec.model_dump(mode="python")
    for part in INDEX.sub(r".\1", key).split("."):
        if isinstance(value, Sequence) and not isinstance(value, str):
            names = [entry.get("name") for entry in value if isinstance(entry, Mapping)]
            index = int(part) if part.isdigit() else names.index(part) if part in names else -1
            value = value[index] if 0 <= index < len(value) else None
        else:
            if isinstance(value, Mapping) and part not in value:
                guess = nearest(part, [str(name) for name in value])
                hint = f"; did you mean {guess}?" if guess else ""
                raise InputError(f"the design has no such key{hint}", key=f"--fit {key}")
            value = value[part] if isinstance(value, Mapping) else None
    if value is None:
        raise InputError(
            "the design gives no such number; write it there first", key=f"--fit {key}"
        )
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(
            "is not a number in this design, and cannot be fitted",
            key=f"--fit {key}",
            value=value,
        )
    if isinstance(value, int):
        raise InputError("is a whole number, and cannot be fitted", key=f"--fit {key}", value=value)
    return float(value)
