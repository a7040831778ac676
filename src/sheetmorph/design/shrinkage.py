"""Shrink curves: length against temperature, measured, as a CSV file.

A curve file has a header line of two column titles and one row per point. The titles are
`temperature [degC], L/L0` (any unit of temperature in the brackets), or `T/Tg, L/L0` with a
comment line `# Tg = 366.5 K` above; a third column `std` holds the scatter of L/L0. Lines that
begin with `#` are comments. A file with other columns, or with a temperature that is repeated,
holds raw rows, to which a curve is fitted: see `sheetmorph.design.shrink_rows`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.core.columns import read_text, separator_of
from sheetmorph.core.errors import InputError
from sheetmorph.core.units import format_si, to_si
from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design

BUILT_IN = ("polystyrene",)
MAX_ROWS = 100_000
_HEADERS = '"temperature [degC], L/L0", or "T/Tg, L/L0" below a line "# Tg = 366.5 K"'
_SCATTER = "std"
_MARKS = {",": "a comma", ";": "a semicolon", "\t": "a tab"}


@dataclass(frozen=True, eq=False)
class ShrinkCurve:
    """Length of a free sheet over its first length, against temperature; n points.

    Attributes:
        name: for messages.
        temperatures: [K], increasing, shape (n,).
        length_ratios: L/L0, shape (n,).
        scatter: standard deviation of L/L0 of single measurements, shape (n,), or None
            where it is not known.
    """

    name: str
    temperatures: Floats
    length_ratios: Floats
    scatter: Floats | None = None

    def length_ratio(self, temperature: float) -> float:
        """L/L0 at a temperature [K], by piecewise cubics that keep the data's monotony.

        Raises:
            InputError: outside the range of the curve.
        """
        from scipy.interpolate import PchipInterpolator

        low, high = float(self.temperatures[0]), float(self.temperatures[-1])
        if not low <= temperature <= high:
            degrees = [format_si(t, "temperature", "degC", 5) for t in (temperature, low, high)]
            raise InputError(
                f"the shrink curve {self.name} does not reach {degrees[0]}",
                key="actuation.temperature",
                allowed=f"{degrees[1]} to {degrees[2]}",
            )
        return float(PchipInterpolator(self.temperatures, self.length_ratios)(temperature))

    def eps_pre(self, temperature: float) -> float:
        """Free strain L/L0 − 1 at a temperature [K]; negative is shrinkage."""
        return self.length_ratio(temperature) - 1.0

    def eps_pre_scatter(self, temperature: float) -> float | None:
        """Standard deviation of the free strain at a temperature [K], linear between points."""
        if self.scatter is None:
            return None
        return float(np.interp(temperature, self.temperatures, self.scatter))


def load_curve(design: Design) -> ShrinkCurve:
    """The shrink curve that a design names.

    Raises:
        InputError: no such file, or no usable curve; the message names the line.
    """
    name, key = design.actuation.shrink_curve, "actuation.shrink_curve"
    if name in BUILT_IN:
        return built_in_curve(name)
    if not name.lower().endswith(".csv"):
        raise InputError(
            "is no shrink curve", key=key, value=name, allowed=f"{', '.join(BUILT_IN)}, or a .csv"
        )
    path = design.resolve_file(name, key)
    text = read_text(path)
    try:
        if holds_raw_rows(text):
            from sheetmorph.design.shrink_fit import fit_shrinkage
            from sheetmorph.design.shrink_rows import parse_shrinkage

            return fit_shrinkage(parse_shrinkage(text, name)).curve
        return parse_curve(text, name)
    except InputError as error:
        raise error.located(path) from None


def holds_raw_rows(text: str) -> bool:
    """True for text of measured rows, to be fitted; False for that of a curve."""
    lines = [line for line in text.splitlines() if line.strip() and line.lstrip()[0] != "#"]
    mark = separator_of(lines[0]) if lines else ","
    titles = [title.strip().lower() for title in lines[0].split(mark)] if lines else []
    if titles[1:] == ["l/l0", _SCATTER]:
        return False
    if len(titles) != 2:
        return len(titles) > 2
    temperatures = [line.split(mark)[0].strip() for line in lines[1:]]
    return titles[1] == "l/l0" and len(set(temperatures)) < len(temperatures)


@lru_cache(maxsize=8)
def built_in_curve(name: str) -> ShrinkCurve:
    """One of the curves that come with the program, see `BUILT_IN`."""
    folder = resources.files("sheetmorph.design") / "data"
    return parse_curve((folder / f"{name}.csv").read_text(encoding="utf-8"), name)


def parse_curve(text: str, name: str) -> ShrinkCurve:
    """Read a curve from the text of a CSV file.

    Raises:
        InputError: no header, no numbers, temperatures that do not increase, lengths
            outside 0.05 to 3, or scatter outside 0 to 1; the message names the line.
    """
    glass = re.search(r"^#\s*Tg\s*=\s*(.{1,40})$", text, re.MULTILINE)
    lines = [
        (number, line.strip())
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines:
        raise InputError("has no header line", allowed=_HEADERS)
    if len(lines) > MAX_ROWS:
        raise InputError("has too many rows", value=len(lines), allowed=f"≤ {MAX_ROWS}")
    scale = _temperature_reader(lines[0], None if glass is None else glass[1].strip())
    mark = separator_of(lines[0][1])
    wanted = len(lines[0][1].split(mark))
    rows = [_row(number, line, wanted, mark) for number, line in lines[1:]]
    if len(rows) < 2:
        raise InputError("needs at least two points")
    temperatures = np.array([scale(row[0]) for row in rows])
    ratios = np.array([row[1] for row in rows])
    falls = np.flatnonzero(np.diff(temperatures) <= 0)
    if len(falls):
        raise InputError(f"line {lines[int(falls[0]) + 2][0]}: the temperature must increase")
    if temperatures[0] <= 0:
        raise InputError(f"line {lines[1][0]}: the temperature is below absolute zero")
    wrong = np.flatnonzero((ratios < 0.05) | (ratios > 3.0))
    if len(wrong):
        index = int(wrong[0])
        raise InputError(
            f"line {lines[index + 1][0]}: L/L0 is out of range",
            value=float(ratios[index]),
            allowed="0.05 to 3",
        )
    if wanted == 2:
        return ShrinkCurve(name, temperatures, ratios)
    scatter = np.array([row[2] for row in rows])
    wrong = np.flatnonzero((scatter < 0.0) | (scatter > 1.0))
    if len(wrong):
        line = lines[int(wrong[0]) + 1][0]
        raise InputError(f"line {line}: {_SCATTER} is out of range", allowed="0 to 1")
    return ShrinkCurve(name, temperatures, ratios, scatter)


def curve_text(curve: ShrinkCurve, remarks: tuple[str, ...] = ()) -> str:
    """The text of a curve file; `parse_curve` reads the same curve back, to the last bit.

    Args:
        curve: the curve.
        remarks: comments to write above it.
    """
    numbers = [curve.temperatures, curve.length_ratios]
    numbers += [] if curve.scatter is None else [curve.scatter]
    titles = ["temperature [K]", "L/L0", _SCATTER][: len(numbers)]
    rows = [", ".join(repr(float(x)) for x in row) for row in zip(*numbers, strict=True)]
    return "\n".join([*(f"# {text}" for text in remarks), ", ".join(titles), *rows, ""])


class _Reader:
    """Turns the first column into kelvin."""

    def __init__(self, factor: float, offset: float) -> None:
        self.factor, self.offset = factor, offset

    def __call__(self, number: float) -> float:
        return number * self.factor + self.offset


def _temperature_reader(header: tuple[int, str], glass: str | None) -> _Reader:
    number, line = header
    cells = [cell.strip() for cell in line.split(separator_of(line))]
    titles = [cell.lower() for cell in cells]
    unit = re.fullmatch(r"temperature\s*\[\s*([^\]]{1,20}?)\s*\]", cells[0], re.I)
    lengths = titles[1:] in (["l/l0"], ["l/l0", _SCATTER])
    if not lengths or not (unit or titles[0] == "t/tg"):
        raise InputError(f"line {number}: the header is not known", value=line, allowed=_HEADERS)
    try:
        if unit:
            zero, one = (to_si(f"{n} {unit[1]}", "temperature") for n in (0, 1))
            return _Reader(one - zero, zero)
        if glass is None:
            raise InputError('T/Tg needs a line "# Tg = 366.5 K" above', allowed=_HEADERS)
        return _Reader(to_si(glass, "temperature"), 0.0)
    except InputError as error:
        raise InputError(f"line {number}: {error}") from None


def _row(number: int, line: str, wanted: int, mark: str) -> tuple[float, ...]:
    words = {2: "two", 3: "three"}[wanted]
    cells = line.split(mark)
    if mark != ",":
        cells = [cell.replace(",", ".") for cell in cells]  # a decimal comma
    try:
        row = tuple(float(cell) for cell in cells)
    except ValueError:
        row = ()
    if len(row) != wanted:
        raise InputError(f"line {number}: write {words} numbers with {_MARKS[mark]}", value=line)
    if not np.isfinite(row).all():
        raise InputError(f"line {number}: not a finite number", value=line)
    return row
