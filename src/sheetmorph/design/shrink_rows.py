"""Measured rows of a free sheet's length against temperature, from a CSV file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sheetmorph.core.columns import Table, parse_table, read_text
from sheetmorph.core.errors import InputError
from sheetmorph.core.units import to_si
from sheetmorph.geometry.mesh import Floats

DIRECTIONS = ("x", "y")
_COLUMNS = ("temperature", "T/Tg", "L/L0", "L", "L0", "direction", "sample", "note")
_RATIOS = "0.05 to 3"


@dataclass(frozen=True, eq=False)
class ShrinkData:
    """Measured rows; n rows.

    Attributes:
        name: for messages.
        temperatures: [K], shape (n,).
        length_ratios: L/L0, shape (n,).
        directions: "x", "y", or "" where none is given, n of them.
        glass_temperature: Tg [K], or None where the file names none.
    """

    name: str
    temperatures: Floats
    length_ratios: Floats
    directions: tuple[str, ...]
    glass_temperature: float | None


def read_shrinkage(path: str | Path, glass_temperature: float | None = None) -> ShrinkData:
    """Measured rows of a CSV file, see `parse_shrinkage`.

    Raises:
        InputError: the file cannot be read, or as for `parse_shrinkage`.
    """
    file = Path(path)
    text = read_text(file)
    try:
        return parse_shrinkage(text, file.name, glass_temperature)
    except InputError as error:
        raise error.located(file) from None


def parse_shrinkage(text: str, name: str, glass_temperature: float | None = None) -> ShrinkData:
    """Measured rows from the text of a CSV file.

    Columns: `temperature [degC]` (or any unit of temperature) or `T/Tg` with a comment
    `# Tg = 366.5 K`; `L/L0`, or `L [mm]` and `L0 [mm]`; and as one likes `direction` (x, y),
    `sample`, `note`. Rows in any order, any number of repeats.

    Args:
        text: the content of the file.
        name: for messages.
        glass_temperature: Tg [K], before that of the file.

    Raises:
        InputError: the table is not usable; the message names line and column.
    """
    table = parse_table(text)
    table.only(_COLUMNS)
    glass = _glass_temperature(table) if glass_temperature is None else glass_temperature
    return ShrinkData(name, _temperatures(table, glass), _ratios(table), _directions(table), glass)


def _glass_temperature(table: Table) -> float | None:
    text = table.remark("Tg")
    if text is None:
        return None
    try:
        glass = to_si(text, "temperature")
    except InputError as error:
        raise InputError(f"the comment # Tg = …: {error}") from None
    if glass <= 0.0:
        raise InputError("the comment # Tg = … is below absolute zero", value=text)
    return glass


def _temperatures(table: Table, glass: float | None) -> Floats:
    if "T/Tg" not in table:
        limits = "above 0 K, up to 3000 K"
        return table.numbers("temperature", "temperature", above=0.0, most=3000.0, limits=limits)
    if "temperature" in table:
        raise InputError(
            f"line {table.head}: temperature and T/Tg exclude each other; keep one of them"
        )
    if glass is None:
        raise InputError(f'line {table.head}: T/Tg needs a line "# Tg = 366.5 K"')
    return glass * table.numbers("T/Tg", "dimensionless", above=0.0, most=10.0, limits="0 to 10")


def _ratios(table: Table) -> Floats:
    if "L/L0" in table:
        if "L" in table or "L0" in table:
            raise InputError(f"line {table.head}: write L/L0, or L and L0, not both")
        return table.numbers("L/L0", "dimensionless", least=0.05, most=3.0, limits=_RATIOS)
    if "L" not in table and "L0" not in table:
        raise InputError(f"line {table.head}: there is no column L/L0, nor L [mm] and L0 [mm]")
    size: dict[str, float] = {"above": 0.0, "most": 100.0}
    limits = "above 0 m, up to 100 m"
    lengths = table.numbers("L", "length", **size, limits=limits)
    ratios: Floats = lengths / table.numbers("L0", "length", **size, limits=limits)
    wrong = np.flatnonzero((ratios < 0.05) | (ratios > 3.0))
    if len(wrong):
        row = int(wrong[0])
        raise InputError(
            f"line {table.lines[row]}, columns L and L0: L/L0 is out of range",
            value=float(ratios[row]),
            allowed=_RATIOS,
        )
    return ratios


def _directions(table: Table) -> tuple[str, ...]:
    words = tuple(word.lower() for word in table.words("direction"))
    for line, word in zip(table.lines, words, strict=True):
        if word not in ("", *DIRECTIONS):
            raise InputError(
                f"line {line}, column direction: is no direction", value=word, allowed="x or y"
            )
    return words
