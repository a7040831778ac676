"""Tables of readings: CSV text with a title and a unit over each column, read into SI.

The first line that is no comment holds the titles, such as `length [mm], force [N], sample`;
lines that begin with `#` are comments, and `# Tg = 366.5 K` among them is a named remark.
Where the titles are separated by semicolons or tabs so are the rows, as spreadsheets write
them where the comma is the decimal sign; then numbers may be written with it.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core import strangers
from sheetmorph.core.errors import InputError, nearest, shorten
from sheetmorph.core.units import Kind, to_si

MAX_BYTES = 5_000_000
MAX_ROWS = 100_000
MAX_COLUMNS = 50
MAX_TITLE = 120

_TITLE = re.compile(r"([^\[\]]{1,60}?)\s*(?:\[\s*([^\[\]]{0,40}?)\s*\])?")
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?")
_WITH_COMMA = re.compile(r"[+-]?[0-9]*,[0-9]*(?:[eE][+-]?[0-9]{1,3})?")


@dataclass(frozen=True)
class Table:
    """Rows of text under titles; n rows.

    Attributes:
        titles: of the columns, in small letters, units left off.
        units: the text in the brackets of each, None where there are none.
        lines: number of each row's line in the file, n of them.
        rows: the cells of each row, as many as there are titles.
        remarks: the comments, without their `#`.
        head: number of the line of the titles.
        comma: whether numbers have a decimal comma, "no", "yes", or "mixed" where there are
            points as well, so that 1,234 may be a thousand or one.
    """

    titles: tuple[str, ...]
    units: tuple[str | None, ...]
    lines: tuple[int, ...]
    rows: tuple[tuple[str, ...], ...]
    remarks: tuple[str, ...]
    head: int
    comma: Literal["no", "yes", "mixed"] = "no"

    def __contains__(self, title: str) -> bool:
        return title.lower() in self.titles

    def __len__(self) -> int:
        return len(self.rows)

    def only(self, known: Sequence[str]) -> None:
        """Refuse columns that nobody reads.

        Raises:
            InputError: a title that is not among the known ones; the nearest one is named.
        """
        lower = [title.lower() for title in known]
        for title in self.titles:
            if title not in lower:
                guess = nearest(title, lower)
                hint = f"; did you mean {known[lower.index(guess)]}?" if guess else ""
                raise InputError(
                    f"line {self.head}: the column {shorten(title, 40)[1:-1]} is not known{hint}",
                    allowed=", ".join(known),
                )

    def words(self, title: str) -> tuple[str, ...]:
        """The cells of a column as text; all empty when there is no such column."""
        if title.lower() not in self.titles:
            return ("",) * len(self.rows)
        place = self.titles.index(title.lower())
        return tuple(row[place] for row in self.rows)

    def numbers(
        self,
        title: str,
        kind: Kind,
        *,
        above: float | None = None,
        least: float | None = None,
        most: float | None = None,
        limits: str | None = None,
    ) -> NDArray[np.float64]:
        """The numbers of a column in SI, shape (n,).

        Args:
            title: of the column.
            kind: of its unit; a "dimensionless" column has none, or `[%]`.
            above: what each number must exceed [SI].
            least: what each number must reach [SI].
            most: what no number may exceed [SI].
            limits: those limits in words.

        Raises:
            InputError: no such column, no unit of that kind, or a cell that is no finite
                number within the limits; the message names line and column.
        """
        if title.lower() not in self.titles:
            unit = "" if kind == "dimensionless" else " [unit]"
            raise InputError(
                f"line {self.head}: there is no column {title}{unit}",
                value=", ".join(self.titles),
            )
        place = self.titles.index(title.lower())
        factor, offset = self._scale(place, title, kind)
        values = np.array([self._cell(row, place, title) for row in range(len(self.rows))])
        values = values * factor + offset
        wrong = ~np.isfinite(values)
        wrong |= False if above is None else values <= above
        wrong |= False if least is None else values < least
        wrong |= False if most is None else values > most
        if wrong.any():
            row = int(np.flatnonzero(wrong)[0])
            raise InputError(
                f"line {self.lines[row]}, column {title}: is out of range",
                value=self.rows[row][place],
                allowed=limits,
            )
        return values

    def remark(self, name: str) -> str | None:
        """What follows `name =` in a comment, or None when no comment says so."""
        for text in self.remarks:
            key, equals, value = text.partition("=")
            if equals and key.strip().lower() == name.lower():
                return value.strip()
        return None

    def _scale(self, place: int, title: str, kind: Kind) -> tuple[float, float]:
        unit = self.units[place]
        if kind == "dimensionless" and not unit:
            return 1.0, 0.0
        if not unit:
            raise InputError(
                f"line {self.head}, column {title}: write the unit in brackets, "
                f"as in {title} [{_EXAMPLES[kind]}]"
            )
        try:
            zero, one = (to_si(f"{number} {unit}", kind) for number in (0, 1))
        except InputError as error:
            raise InputError(f"line {self.head}, column {title}: {error}") from None
        return one - zero, zero

    def _cell(self, row: int, place: int, title: str) -> float:
        text = self.rows[row][place].replace("−", "-")
        if self.comma == "mixed" and _WITH_COMMA.fullmatch(text):
            raise InputError(
                f"line {self.lines[row]}, column {title}: the table has decimal commas and "
                "decimal points; write all numbers with one of them",
                value=text,
            )
        if self.comma == "yes":
            text = text.replace(",", ".")
        if not _NUMBER.fullmatch(text):
            what = (
                "the cell is empty"
                if not text
                else "write a finite number, with a decimal point, or with a decimal comma in "
                "a table that is separated by semicolons"
            )
            raise InputError(f"line {self.lines[row]}, column {title}: {what}", value=text or None)
        return float(text)


_EXAMPLES: dict[str, str] = {
    "length": "mm",
    "pressure": "GPa",
    "density": "kg/m^3",
    "force": "N",
    "force per length": "N/m",
    "acceleration": "m/s^2",
    "temperature": "degC",
    "angle": "deg",
    "time": "s",
    "rate": "1/s",
    "dimensionless": "%",
}


def read_text(path: Path) -> str:
    """The text of a file of readings, at most `MAX_BYTES` long.

    Raises:
        InputError: no such file, not a file, too large, or not UTF-8.
    """
    return strangers.read_text(path, MAX_BYTES, "a CSV file")


def parse_table(text: str, *, max_rows: int = MAX_ROWS) -> Table:
    """Read the text of a CSV file.

    Raises:
        InputError: no titles, a title twice, no rows or too many, or a row with more or
            fewer cells than titles; the message names the line.
    """
    remarks: list[str] = []
    kept: list[tuple[int, str]] = []
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("#"):
            remarks.append(line.strip().lstrip("#").strip())
        elif line.strip(" \t,;"):
            kept.append((number, line))
    if not kept:
        raise InputError("has no line of titles, such as length [mm], force [N]")
    if len(kept) - 1 > max_rows:
        raise InputError("has too many rows", value=len(kept) - 1, allowed=f"≤ {max_rows}")
    head, heading = kept[0]
    separator = separator_of(heading)
    titles, units = _titles(head, _split(head, heading, separator))
    rows = tuple(_cells(number, line, len(titles), separator) for number, line in kept[1:])
    if not rows:
        raise InputError(f"has no rows below the titles in line {head}")
    lines = tuple(n for n, _ in kept[1:])
    comma = "no" if separator == "," else _decimal_comma(rows)
    return Table(titles, units, lines, rows, tuple(remarks), head, comma)


def separator_of(heading: str) -> str:
    """What separates the columns: what separates the titles."""
    if "," in heading:
        return ","
    return next((mark for mark in ";\t" if mark in heading), ",")


def _decimal_comma(rows: tuple[tuple[str, ...], ...]) -> Literal["no", "yes", "mixed"]:
    cells = [cell.replace("−", "-") for row in rows for cell in row]
    if not any(_WITH_COMMA.fullmatch(cell) for cell in cells):
        return "no"
    return "mixed" if any("." in cell and _NUMBER.fullmatch(cell) for cell in cells) else "yes"


def _titles(head: int, cells: list[str]) -> tuple[tuple[str, ...], tuple[str | None, ...]]:
    if len(cells) > MAX_COLUMNS:
        raise InputError(f"line {head}: has too many columns", allowed=f"≤ {MAX_COLUMNS}")
    titles: list[str] = []
    units: list[str | None] = []
    for cell in cells:
        match = _TITLE.fullmatch(cell) if len(cell) <= MAX_TITLE else None
        if match is None:
            raise InputError(
                f"line {head}: is no title of a column", value=cell, allowed="as in length [mm]"
            )
        title = " ".join(match[1].lower().replace("+-", "±").replace("±", "± ").split())
        if title in titles:
            raise InputError(f"line {head}: the column {title} is there twice")
        titles.append(title)
        units.append(match[2])
    return tuple(titles), tuple(units)


def _cells(number: int, line: str, count: int, separator: str) -> tuple[str, ...]:
    cells = _split(number, line, separator)
    if len(cells) != count:
        raise InputError(f"line {number}: has {len(cells)} cells under {count} titles", value=line)
    return tuple(cells)


def _split(number: int, line: str, separator: str) -> list[str]:
    try:
        found = next(csv.reader([line], skipinitialspace=True, delimiter=separator))
    except (csv.Error, StopIteration):
        raise InputError(f"line {number}: cannot be read as CSV", value=line) from None
    return [cell.strip() for cell in found]
