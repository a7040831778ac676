"""What a key of the design is set to in a sweep: values, ranges, and samples between bounds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sheetmorph.core.errors import InputError, nearest
from sheetmorph.core.units import KINDS, SI_UNITS, Kind, to_si

MOST = 1_000_000
"""Most designs of one sweep."""

_RANGE = "{ from = …, to = …, count = … } or { from = …, to = …, step = … }"
_BOUNDS = "{ from = …, to = … }"
_DIGITS = 12


@dataclass(frozen=True)
class Axis:
    """A key and the values that it takes, one after the other.

    Attributes:
        key: dotted key of the design, or `family.` and an argument of the family.
        unit: SI unit of the values; empty for plain numbers and for what is no number.
        values: numbers in SI units, or texts, booleans and lists as they were given.
    """

    key: str
    unit: str
    values: tuple[Any, ...]

    def written(self, value: object) -> object:
        """A value as a design file has it: a quantity with its unit."""
        return f"{value!r} {self.unit}" if self.unit else value


def read_axis(key: str, entry: object) -> Axis:
    """The values that a list or a range gives.

    Args:
        key: of the design.
        entry: a list of values, or a table with `from`, `to`, and `count` or `step`; with
            `spacing = "log"` the ratios between neighbours are equal.

    Raises:
        InputError: neither of them, no value, too many, quantities of several kinds.
    """
    if isinstance(entry, Mapping):
        return _range(key, entry)
    if not isinstance(entry, list):
        raise InputError(
            "wants a list of values or a range", key=key, value=entry, allowed=f"[…] or {_RANGE}"
        )
    if not 1 <= len(entry) <= MOST:
        raise InputError(f"has {len(entry)} values", key=key, allowed=f"1 to {MOST}")
    kind = _kind(entry)
    if kind is None:
        return Axis(key, "", tuple(entry))
    numbers = [value if _plain(value) else _si(value, kind, key) for value in entry]
    return Axis(key, SI_UNITS[kind], tuple(numbers))


def sampled_axis(key: str, entry: object, shares: Sequence[float]) -> Axis:
    """Values between two bounds.

    Args:
        key: of the design.
        entry: a table with `from` and `to`; `spacing = "log"` where ratios matter,
            `whole = true` for whole numbers, both bounds included.
        shares: where the values lie between the bounds, from 0 to 1.

    Raises:
        InputError: no such table, bounds of two kinds, or not in order.
    """
    table = _table(key, entry, ("from", "to", "spacing", "whole"), _BOUNDS)
    low, high, unit = _ends(key, table, _BOUNDS)
    if low >= high:
        raise InputError("from is not below to", key=key, value=[low, high])
    whole = table.get("whole", False)
    if not isinstance(whole, bool):
        raise InputError("must be true or false", key=f"{key}.whole", value=whole)
    if not whole:
        return Axis(key, unit, tuple(_between(table, key, low, high, share) for share in shares))
    if unit or low != int(low) or high != int(high) or "spacing" in table:
        raise InputError(
            "whole numbers want whole bounds without unit and spacing", key=key, value=[low, high]
        )
    count = int(high - low) + 1
    numbers = (int(low) + min(count - 1, math.floor(share * count)) for share in shares)
    return Axis(key, "", tuple(numbers))


def _range(key: str, entry: Mapping[str, object]) -> Axis:
    table = _table(key, entry, ("from", "to", "count", "step", "spacing"), _RANGE)
    low, high, unit = _ends(key, table, _RANGE)
    if ("count" in table) == ("step" in table):
        raise InputError("wants either count or step", key=key, allowed=_RANGE)
    if "step" in table:
        return Axis(key, unit, _steps(key, table, low, high, unit))
    count = table["count"]
    if not isinstance(count, int) or isinstance(count, bool) or not 2 <= count <= MOST:
        raise InputError(
            "must be a whole number", key=f"{key}.count", value=count, allowed=f"2 to {MOST}"
        )
    shares = np.linspace(0.0, 1.0, count)
    values = tuple(_between(table, key, low, high, float(share)) for share in shares)
    whole = not unit and isinstance(low, int) and isinstance(high, int)
    if whole and all(value == int(value) for value in values):
        return Axis(key, unit, tuple(int(value) for value in values))
    return Axis(key, unit, values)


def _steps(
    key: str, table: Mapping[str, object], low: float, high: float, unit: str
) -> tuple[float, ...]:
    if "spacing" in table:
        raise InputError("a range by step has no spacing", key=key)
    kind = next(kind for kind, si in SI_UNITS.items() if si == unit)
    if kind == "temperature":
        raise InputError("a range of temperatures wants count", key=key, allowed=_RANGE)
    given = table["step"]
    step = given if _plain(given) else _si(given, kind, f"{key}.step")  # type: ignore[arg-type]
    if not isinstance(step, int | float) or step == 0 or (high - low) / step < 0:
        raise InputError("leads away from `to`", key=f"{key}.step", value=given)
    count = math.floor((high - low) / step * (1 + 1e-12)) + 1
    if count > MOST:
        raise InputError(f"has {count} values", key=key, allowed=f"≤ {MOST}")
    values = (low + index * step for index in range(count))
    return tuple(v if isinstance(v, int) else float(f"{v:.{_DIGITS}g}") for v in values)


def _between(table: Mapping[str, object], key: str, low: float, high: float, share: float) -> float:
    """The value at a share of the way, with digits that can be read."""
    spacing = table.get("spacing", "linear")
    if spacing not in ("linear", "log"):
        raise InputError(
            "no such spacing", key=f"{key}.spacing", value=spacing, allowed="linear, log"
        )
    if spacing == "linear":
        return float(f"{low + (high - low) * share:.{_DIGITS}g}")
    if low * high <= 0:
        raise InputError("spacing log wants both ends on one side of zero", key=key)
    return float(f"{low * (high / low) ** share:.{_DIGITS}g}")


def _table(key: str, entry: object, names: Sequence[str], form: str) -> Mapping[str, Any]:
    if not isinstance(entry, Mapping):
        raise InputError("wants bounds", key=key, value=entry, allowed=form)
    for name in entry:
        if name not in names:
            guess = nearest(name, names)
            raise InputError(
                "is not known" + (f"; did you mean {guess}?" if guess else ""),
                key=f"{key}.{name}",
                allowed=", ".join(names),
            )
    return entry


def _ends(key: str, table: Mapping[str, object], form: str) -> tuple[float, float, str]:
    """Both ends in SI units, and the unit."""
    if "from" not in table or "to" not in table:
        raise InputError("wants from and to", key=key, allowed=form)
    ends = [table["from"], table["to"]]
    kind = _kind(ends)
    if kind is None:
        raise InputError("from and to are not two numbers of one kind", key=key, value=ends)
    low, high = (end if _plain(end) else _si(end, kind, key) for end in ends)
    return low, high, SI_UNITS[kind]  # type: ignore[return-value]  # plain ones are numbers


def _plain(value: object) -> bool:
    """Whether it is a finite number that needs no conversion."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return math.isfinite(value)


def _kind(values: Sequence[object]) -> Kind | None:
    """The kind of quantity that all the values are; None when they are none."""
    if all(_plain(value) for value in values):
        return "dimensionless"
    for kind in KINDS:
        try:
            for value in values:
                to_si(value, kind)
        except InputError:
            continue
        return kind
    return None


def _si(value: object, kind: Kind, key: str) -> float:
    try:
        return to_si(value, kind)
    except InputError as error:
        raise InputError(error.message, key=key, value=value, allowed=error.allowed) from None
