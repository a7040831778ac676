"""A library of materials, each value with its source, for the key `material` of a layer."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from typing import Any

from sheetmorph.core.errors import InputError, nearest
from sheetmorph.core.units import Kind, to_si

KINDS: dict[str, Kind] = {
    "young_modulus_room": "pressure",
    "young_modulus": "pressure",
    "poisson_ratio": "dimensionless",
    "density": "density",
    "glass_temperature": "temperature",
}
"""The values of a material, and the kinds of their units."""

LAYER_KEYS = ("young_modulus", "poisson_ratio", "density")
"""Keys of a layer that a material fills where the design leaves them out."""


@dataclass(frozen=True)
class Sourced:
    """A number and where it comes from.

    Attributes:
        value: [SI].
        text: the value as the library writes it, with its unit.
        low, high: range that the source gives [SI]; None where it gives none.
        source: who says so, and "assumed" where it is an assumption.
    """

    value: float
    text: str
    low: float | None
    high: float | None
    source: str

    @property
    def assumed(self) -> bool:
        """True when the value is an assumption, nobody's measurement."""
        return self.source.startswith("assumed")


@dataclass(frozen=True)
class Material:
    """What a layer may be made of. Values that have no source are None.

    Attributes:
        name: for `material =` in a layer.
        title: in words.
        role: that it usually has, "active" or "inert".
        young_modulus_room: at room temperature [Pa].
        young_modulus: at the temperature of actuation [Pa]; what designs use.
        poisson_ratio: at both.
        density: [kg/m³].
        glass_temperature: Tg [K].
        shrink_curve: name of its curve for `actuation.shrink_curve`; None for inert ones.
    """

    name: str
    title: str
    role: str
    young_modulus_room: Sourced | None
    young_modulus: Sourced | None
    poisson_ratio: Sourced | None
    density: Sourced | None
    glass_temperature: Sourced | None
    shrink_curve: str | None

    def values(self) -> dict[str, Sourced]:
        """The values that are there, by their names in `KINDS`."""
        found = {name: getattr(self, name) for name in KINDS}
        return {name: value for name, value in found.items() if value is not None}


@lru_cache(maxsize=1)
def library() -> Mapping[str, Material]:
    """The materials that come with the program, by name."""
    folder = resources.files("sheetmorph.design") / "data"
    tables = tomllib.loads((folder / "materials.toml").read_text(encoding="utf-8"))
    return {name: _material(name, table) for name, table in tables.items()}


def find_material(name: str) -> Material:
    """A material by its name; capital letters do not matter.

    Raises:
        InputError: there is none of that name; the nearest one is named.
    """
    known = library()
    for material in known.values():
        if material.name.lower() == name.strip().lower():
            return material
    guess = nearest(name.lower(), [other.lower() for other in known])
    like = next((other for other in known if other.lower() == guess), None)
    raise InputError(
        "is not in the library of materials" + (f"; did you mean {like}?" if like else ""),
        value=name,
        allowed=", ".join(known),
    )


def layer_values(name: str) -> dict[str, str | float]:
    """What a material gives a layer, as a design file would write it.

    Raises:
        InputError: as for `find_material`.
    """
    values = find_material(name).values()
    return {
        key: values[key].value if KINDS[key] == "dimensionless" else values[key].text
        for key in LAYER_KEYS
        if key in values
    }


def _material(name: str, table: Mapping[str, Any]) -> Material:
    sourced = {key: _sourced(table[key], KINDS[key]) for key in KINDS if key in table}
    return Material(
        name=name,
        title=table["title"],
        role=table["role"],
        shrink_curve=table.get("shrink_curve"),
        **{key: sourced.get(key) for key in KINDS},
    )


def _sourced(table: Mapping[str, Any], kind: Kind) -> Sourced:
    low, high = (to_si(text, kind) for text in table["range"]) if "range" in table else (None, None)
    return Sourced(to_si(table["value"], kind), table["value"], low, high, table["source"])
