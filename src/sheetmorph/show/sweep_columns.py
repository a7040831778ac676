"""Columns of a sweep's table as people read them: scaled, labelled, numbers or names."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sheetmorph.core.errors import InputError, nearest
from sheetmorph.geometry.mesh import Floats
from sheetmorph.sweep.dataset import Sweep

SHOWN = {"m": (1e3, "mm"), "Pa": (1e-6, "MPa"), "rad": (180.0 / np.pi, "°")}
MOST_NAMES = 12
"""Different texts of a column that can still be told apart in a picture."""


@dataclass(frozen=True, eq=False)
class Column:
    """A column.

    Attributes:
        name: of the column.
        label: with the unit.
        unit: in which the values are; empty for plain numbers and texts.
        values: one per row, NaN where there is none; places in `names` where it holds texts.
        names: the different texts; empty for numbers.
    """

    name: str
    label: str
    unit: str
    values: Floats
    names: tuple[str, ...] = ()

    def text(self, row: int) -> str:
        """A value for people."""
        value = self.values[row]
        if np.isnan(value):
            return "–"
        return self.names[int(value)] if self.names else f"{value:.4g}".replace("-", "−")


def read_column(sweep: Sweep, name: str) -> Column:
    """A column of the table.

    Raises:
        InputError: there is no such column, it is empty, or has too many different texts.
    """
    known = sweep.table.column_names
    if name not in known:
        guess = nearest(name, known)
        hint = f"; did you mean {guess}?" if guess else ""
        raise InputError(
            f"the sweep has no such column{hint}", value=name, allowed=", ".join(known)
        )
    cells = sweep.table[name].to_pylist()
    unit = sweep.units.get(name, "")
    factor, shown = SHOWN.get(unit, (1.0, unit))
    label = f"{name}  [{shown}]" if shown else name
    present = [cell for cell in cells if cell is not None]
    if not present:
        raise InputError("no design has a value of this column", value=name)
    if not any(isinstance(cell, str) for cell in present):
        numbers = [np.nan if cell is None else factor * float(cell) for cell in cells]
        return Column(name, label, shown, np.array(numbers))
    names = tuple(sorted(set(present)))
    if len(names) > MOST_NAMES:
        raise InputError(
            f"has {len(names)} different texts; choose a column of numbers", value=name
        )
    places = [np.nan if cell is None else float(names.index(cell)) for cell in cells]
    return Column(name, label, shown, np.array(places), names)


def input_names(sweep: Sweep) -> list[str]:
    """The columns that the sweep varied."""
    return [str(name) for name in sweep.about["inputs"]]
