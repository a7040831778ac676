"""The text format of the published meshes: `*shellNodes`, `*FaceNodes`, `*Edges`."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError, shorten
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.geometry.topology import build_mesh

# Numbers in a line of each section, the first being its id.
COLUMNS = {"*shellnodes": 4, "*facenodes": 4, "*edges": 3}
MAX_ID = 2**53


@dataclass
class _Section:
    name: str
    line: int
    rows: list[str] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)


def read_text_mesh(path: Path, unit: float, curved: bool = False) -> SheetMesh:
    """Read a mesh that lists its nodes, triangles and edges as comma-separated text.

    Nodes and edges keep the order and the direction of the file. Ids may be any distinct
    whole numbers.

    Args:
        path: the file.
        unit: length of one unit of the file [m].
        curved: True for a sheet that need not be flat.

    Raises:
        InputError: the file is not such a text, or its mesh is no sheet; the line is named.
    """
    sections = _sections(path)
    nodes = _table(path, sections["*shellnodes"])
    faces = _table(path, sections["*facenodes"])
    edges = _table(path, sections["*edges"])
    ids = _ids(path, sections["*shellnodes"], nodes[:, 0])
    _ids(path, sections["*facenodes"], faces[:, 0])
    _ids(path, sections["*edges"], edges[:, 0])
    return build_mesh(
        unit * nodes[:, 1:],
        _indices(path, sections["*facenodes"], faces[:, 1:], ids),
        _indices(path, sections["*edges"], edges[:, 1:], ids),
        curved=curved,
    )


def _sections(path: Path) -> dict[str, _Section]:
    try:
        lines = path.read_bytes().decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise InputError("is no text file", file=path) from error
    sections: dict[str, _Section] = {}
    current: _Section | None = None
    for number, raw in enumerate(lines, 1):
        line = raw.strip()
        if not line or line.startswith("**"):
            continue
        if line.startswith("*"):
            name = line.lower()
            if name not in COLUMNS:
                raise InputError(
                    "unknown section",
                    file=_at(path, number),
                    value=line,
                    allowed="*shellNodes, *FaceNodes, *Edges",
                )
            if name in sections:
                raise InputError(f"second section {shorten(line)}", file=_at(path, number))
            current = sections[name] = _Section(line, number)
        elif current is None:
            raise InputError(
                "the file must begin with *shellNodes", file=_at(path, number), value=line
            )
        else:
            current.rows.append(line)
            current.numbers.append(number)
    for name, label in zip(COLUMNS, ("*shellNodes", "*FaceNodes", "*Edges"), strict=True):
        if name not in sections:
            raise InputError(f"section {label} is missing", file=path)
        if not sections[name].rows:
            raise InputError(f"section {label} is empty", file=_at(path, sections[name].line))
    return sections


def _table(path: Path, section: _Section) -> Floats:
    """The numbers of a section, shape (rows, columns)."""
    width = COLUMNS[section.name.lower()]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            table = np.loadtxt(section.rows, delimiter=",", ndmin=2, comments=None)
    except ValueError:
        table = np.empty((0, 0))
    if table.shape == (len(section.rows), width) and np.isfinite(table).all():
        return table
    # Something is wrong: find the line.
    for number, row in zip(section.numbers, section.rows, strict=True):
        cells = row.split(",")
        if len(cells) != width:
            raise InputError(
                f"a line of {section.name} needs {width} numbers with commas between them",
                file=_at(path, number),
                value=row,
            )
        for cell in cells:
            try:
                value = float(cell)
            except ValueError:
                value = np.nan
            if not np.isfinite(value):
                raise InputError(
                    f"{shorten(cell.strip())} is not a finite number", file=_at(path, number)
                )
    raise InputError(f"section {section.name} cannot be read", file=path)


def _ids(path: Path, section: _Section, column: Floats) -> NDArray[np.int64]:
    whole = (column == np.round(column)) & (np.abs(column) < MAX_ID)
    if not whole.all():
        row = int(np.argmin(whole))
        raise InputError(
            "an id must be a whole number",
            file=_at(path, section.numbers[row]),
            value=section.rows[row],
        )
    ids = column.astype(np.int64)
    order = np.argsort(ids, kind="stable")
    repeated = np.flatnonzero(np.diff(ids[order]) == 0)
    if len(repeated):
        row = int(order[repeated + 1].min())
        raise InputError(
            f"id {ids[row]} is used twice in {section.name}",
            file=_at(path, section.numbers[row]),
        )
    return ids


def _indices(
    path: Path, section: _Section, table: Floats, ids: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Positions of node ids in the list of nodes, shape of the table."""
    order = np.argsort(ids)
    place = np.minimum(np.searchsorted(ids[order], table), len(ids) - 1)
    found = order[place]
    missing = (ids[found] != table).any(axis=1)
    if missing.any():
        row = int(np.argmax(missing))
        raise InputError(
            f"{section.name} refers to a node that does not exist",
            file=_at(path, section.numbers[row]),
            value=section.rows[row],
        )
    return found


def _at(path: Path, line: int) -> str:
    return f"{path}, line {line}"
