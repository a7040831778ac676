"""Shrink curves: length against temperature, measured, as a CSV file.

A curve file has a header line of two column titles and one row per point. The titles are
`temperature [degC], L/L0` (any unit of temperature in the brackets), or `T/Tg, L/L0` with a
comment line `# Tg = 366.5 K` above. Lines that begin with `#` are comments.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.core.units import format_si, to_si
from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design

BUILT_IN = ("polystyrene",)
MAX_ROWS = 100_000
_HEADERS = '"temperature [degC], L/L0", or "T/Tg, L/L0" below a line "# Tg = 366.5 K"'


@dataclass(frozen=True, eq=False)
class ShrinkCurve:
    """Length of a free sheet over its first length, against temperature; n points.

    Attributes:
        name: for messages.
        temperatures: [K], increasing, shape (n,).
        length_ratios: L/L0, shape (n,).
    """

    name: str
    temperatures: Floats
    length_ratios: Floats

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
    if path.stat().st_size > 5_000_000:
        raise InputError("the curve is too large", file=path, allowed="≤ 5 MB")
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError):
        raise InputError("cannot be read as UTF-8 text", file=path) from None
    try:
        return parse_curve(text, name)
    except InputError as error:
        raise error.located(path) from None


@lru_cache(maxsize=8)
def built_in_curve(name: str) -> ShrinkCurve:
    """One of the curves that come with the program, see `BUILT_IN`."""
    folder = resources.files("sheetmorph.design") / "data"
    return parse_curve((folder / f"{name}.csv").read_text(encoding="utf-8"), name)


def parse_curve(text: str, name: str) -> ShrinkCurve:
    """Read a curve from the text of a CSV file.

    Raises:
        InputError: no header, no numbers, temperatures that do not increase, or lengths
            outside 0.05 to 3; the message names the line.
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
    rows = [_row(number, line) for number, line in lines[1:]]
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
    return ShrinkCurve(name, temperatures, ratios)


class _Reader:
    """Turns the first column into kelvin."""

    def __init__(self, factor: float, offset: float) -> None:
        self.factor, self.offset = factor, offset

    def __call__(self, number: float) -> float:
        return number * self.factor + self.offset


def _temperature_reader(header: tuple[int, str], glass: str | None) -> _Reader:
    number, line = header
    titles = [title.strip().lower() for title in line.split(",")]
    unit = re.fullmatch(r"temperature\s*\[\s*([^\]]{1,20}?)\s*\]", line.split(",")[0].strip(), re.I)
    if len(titles) != 2 or titles[1] != "l/l0" or not (unit or titles[0] == "t/tg"):
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


def _row(number: int, line: str) -> tuple[float, float]:
    try:
        first, second = (float(cell) for cell in line.split(","))
    except ValueError:
        raise InputError(f"line {number}: write two numbers with a comma", value=line) from None
    if not (np.isfinite(first) and np.isfinite(second)):
        raise InputError(f"line {number}: not a finite number", value=line)
    return first, second
