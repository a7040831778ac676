"""Displacements from the result files of CalculiX (.frd, text)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.twin.solid import Ids

MOST_BYTES = 4_000_000_000
_FIELD, _COLUMN = 10, 12


@dataclass(frozen=True, eq=False)
class Displacements:
    """Displacements of one increment.

    Attributes:
        time: of the solver, all steps together.
        nodes: numbers of the nodes, counted from 1, shape (n,).
        values: [m], shape (n, 3).
    """

    time: float
    nodes: Ids
    values: Floats


def read_displacements(path: Path) -> list[Displacements]:
    """Every whole block of displacements of a file; one that is cut off is left out.

    The file may still be growing, or have been left by a program that was stopped.

    Raises:
        InputError: there is no such file, it is larger than `MOST_BYTES`, or it is not such a
            file.
    """
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise InputError(
                "too large", file=path, value=f"{size} bytes", allowed=f"≤ {MOST_BYTES} bytes"
            )
        with path.open("r", encoding="latin-1", newline=None) as stream:
            return _blocks(stream, path)
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", file=path) from None


def _blocks(lines: Iterable[str], path: Path) -> list[Displacements]:
    found: list[Displacements] = []
    time: float | None = None
    inside = False
    nodes: list[int] = []
    values: list[tuple[float, float, float]] = []
    for number, line in enumerate(lines, 1):
        if inside:
            try:
                if line.startswith(" -1"):
                    cells = [line[13 + 12 * k : 25 + 12 * k] for k in range(3)]
                    values.append((float(cells[0]), float(cells[1]), float(cells[2])))
                    nodes.append(int(line[3:13]))
                    continue
            except ValueError:
                raise InputError(
                    "no displacement on this line", file=path, key=f"line {number}"
                ) from None
            if line.startswith(" -3") and time is not None:
                found.append(Displacements(time, np.array(nodes), np.array(values)))
                inside = False
        elif line.startswith("  100C"):
            time = float(line[12:24])
        elif line.startswith(" -4  DISP"):
            inside, nodes, values = True, [], []
    return found
