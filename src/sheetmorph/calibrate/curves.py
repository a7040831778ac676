"""Measured curves of h/d against the actuation, as a fit reads them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from sheetmorph.core.columns import Table, parse_table, read_text
from sheetmorph.core.errors import InputError
from sheetmorph.core.units import Kind
from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.surface import Width
from sheetmorph.measure.film_history import read_table
from sheetmorph.study.result import Result

MAX_ROWS = 20_000
AXES = ("actuation", "eps_pre", "time")


@dataclass(frozen=True, eq=False)
class Curve:
    """Height over width of a sheet while it morphs.

    Attributes:
        name: the file's name.
        axis: what `at` is: "actuation", a fraction from 0 to 1, or "eps_pre", the free
            strain reached.
        at: shape (n,).
        aspect_ratio: h/d there, shape (n,).
        deviation: its standard deviation, shape (n,); None when not known.
        notes: what the reader should know.
        width: which width of the shape d is.
    """

    name: str
    axis: str
    at: Floats
    aspect_ratio: Floats
    deviation: Floats | None = None
    notes: tuple[str, ...] = ()
    width: Width = "feret_max"

    @property
    def size(self) -> float:
        """The largest h/d."""
        return float(np.abs(self.aspect_ratio).max())

    @property
    def weights(self) -> Floats:
        """Share of each point in the mean of squares, shape (n,): 1 over its variance."""
        if self.deviation is None:
            return np.full(len(self.at), 1.0 / len(self.at))
        share = self.deviation**-2.0
        return np.asarray(share / share.sum())

    def differences(self, result: Result) -> Floats:
        """Computed less measured h/d, shape (n,), along the actuation under its load.

        Between two states h/d is interpolated; beyond the last one it is held.
        """
        from scipy.interpolate import PchipInterpolator

        loaded = result.load_fraction == 1.0
        along = result.ramp[loaded] if self.axis == "actuation" else -result.actuation[loaded]
        values = result.aspect_ratios(self.width)[loaded]
        along, first = np.unique(along, return_index=True)
        wanted = self.at if self.axis == "actuation" else -self.at
        wanted = np.clip(wanted, along[0], along[-1])
        if len(along) == 1:
            return np.asarray(values[0] - self.aspect_ratio)
        return np.asarray(PchipInterpolator(along, values[first])(wanted) - self.aspect_ratio)


def read_curve(path: str | Path) -> Curve:
    """Read a CSV file with the columns `actuation` (or `eps_pre`, or `time`), `h/d`, and `std`.

    `time` is counted from its least value (no actuation) to its greatest (full actuation),
    as if the sheet were actuated evenly in time. The table of a film (`time_s`, `h_over_d`)
    is read, too, without the frames that are in doubt; its d is the width seen from the side.

    Raises:
        InputError: the file cannot be read, lacks a column, or holds a number out of range;
            names the file, the line and the column.
    """
    file = Path(path)
    text = read_text(file)
    try:
        table = parse_table(text, max_rows=MAX_ROWS)
        if "time_s" in table and "h_over_d" in table:
            film = read_table(file)
            curve = _checked(file.name, "time", film.time[film.good], film.ratio[film.good], None)
            return replace(curve, width="side")
        return _curve(file.name, table)
    except InputError as error:
        raise error.located(file) from None


def _curve(name: str, table: Table) -> Curve:
    axis = next((title for title in AXES if title in table), None)
    if axis is None:
        raise InputError(
            "has no column that says how far the sheet was actuated",
            value=", ".join(table.titles),
            allowed=", ".join(AXES),
        )
    ratio = table.numbers("h/d", "dimensionless", least=0.0, limits="≥ 0")
    deviation = None
    if "std" in table:
        deviation = table.numbers("std", "dimensionless", above=0.0, limits="> 0")
    if axis == "time":
        kind: Kind = "time" if table.units[table.titles.index("time")] else "dimensionless"
        at = table.numbers(axis, kind)
    elif axis == "actuation":
        at = table.numbers(axis, "dimensionless", least=0.0, most=1.0, limits="0 to 1")
    else:
        at = table.numbers(axis, "dimensionless")
    return _checked(name, axis, at, ratio, deviation)


def _checked(name: str, axis: str, at: Floats, ratio: Floats, deviation: Floats | None) -> Curve:
    if len(at) < 2 or np.ptp(at) <= 0.0 or ratio.max() <= 0.0:
        raise InputError("the curve has no extent: nothing changes in it")
    if axis != "time":
        return Curve(name, axis, at, ratio, deviation)
    note = f"{name}: time is taken as even actuation from its first to its last row."
    return Curve(name, "actuation", (at - at.min()) / np.ptp(at), ratio, deviation, (note,))
