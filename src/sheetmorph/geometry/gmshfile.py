"""Gmsh's .msh files, versions 2.2 and 4.1, text and binary: nodes and triangles alone.

Written here because the general readers trust the numbers in the file: a damaged tag makes
them allocate without bound.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats

TRIANGLE = 2
# Nodes of the element types that may occur: those of the sheet's rim and corners are skipped.
NODES_OF = {1: 2, TRIANGLE: 3, 15: 1}


@dataclass
class _Cursor:
    """Reads numbers from a section and never beyond its end."""

    data: bytes
    binary: bool
    place: int = 0
    words: list[bytes] = field(default_factory=list)

    def __post_init__(self) -> None:
        if not self.binary:
            self.words = self.data.split()

    def take(self, count: int, kind: str) -> NDArray[np.generic]:
        """The next `count` numbers of a NumPy type."""
        dtype = np.dtype(kind)
        if self.binary:
            end = self.place + count * dtype.itemsize
            if count < 0 or end > len(self.data):
                raise InputError("the file is cut off or damaged")
            part = np.frombuffer(self.data[self.place : end], dtype=dtype)
            self.place = end
            return part
        end = self.place + count
        if count < 0 or end > len(self.words):
            raise InputError("the file is cut off or damaged")
        words = self.words[self.place : end]
        self.place = end
        try:
            return np.array(words, dtype=np.float64 if dtype.kind == "f" else np.int64)
        except (ValueError, OverflowError) as error:
            raise InputError("a number in the file cannot be read") from error

    def integers(self, count: int, kind: str) -> list[int]:
        """The next whole numbers."""
        return [int(value) for value in self.take(count, kind)]


def read_gmsh(path: Path) -> tuple[Floats, NDArray[np.int64]]:
    """Nodes in the units of the file, shape (V, 3), and triangles, shape (T, 3).

    Raises:
        InputError: no such file, a damaged one, or one with other faces than triangles.
    """
    data = path.read_bytes()
    words = _section(data, b"MeshFormat").split(None, 3)[:3]
    try:
        version, binary = words[0].decode(), words[1] == b"1"
    except (IndexError, UnicodeDecodeError) as error:
        raise InputError("the header $MeshFormat is damaged") from error
    if version not in ("2", "2.2", "4.1"):
        raise InputError("no such version of Gmsh's format", value=version, allowed="2.2, 4.1")
    if binary and b"\1\0\0\0" not in data[:64]:
        raise InputError("the binary file has big-endian numbers; save it as text")
    old = version.startswith("2")
    nodes = _Cursor(_section(data, b"Nodes"), binary)
    elements = _Cursor(_section(data, b"Elements"), binary)
    tags, points = _nodes_2(nodes) if old else _nodes_4(nodes)
    corners = _elements_2(elements) if old else _elements_4(elements)
    if not len(corners):
        raise InputError("the file has no triangles")
    order = np.argsort(tags, kind="stable")
    if len(np.unique(tags)) < len(tags) or not len(tags):
        raise InputError("a node tag is used twice" if len(tags) else "the file has no nodes")
    found = order[np.minimum(np.searchsorted(tags[order], corners), len(tags) - 1)]
    unknown = (tags[found] != corners).any(axis=1)
    if unknown.any():
        bad = int(np.argmax(unknown))
        raise InputError(
            f"triangle {bad} refers to a node that does not exist", value=corners[bad].tolist()
        )
    return points, found


def _section(data: bytes, name: bytes) -> bytes:
    """What stands between $Name and $EndName, without the line end after $Name."""
    start = data.find(b"$" + name)
    end = data.find(b"$End" + name, start)
    if start < 0 or end < 0:
        raise InputError(f"section ${name.decode()} is missing or cut off")
    line = data.find(b"\n", start)
    return data[line + 1 : end] if 0 <= line < end else b""


def _count_line(cursor: _Cursor) -> int:
    """The number of entries, a line of text in version 2, in binary files too."""
    if not cursor.binary:
        return cursor.integers(1, "i8")[0]
    line, _, cursor.data = cursor.data.partition(b"\n")
    if not line.strip().isdigit() or len(line) > 12:
        raise InputError("the file is cut off or damaged")
    return int(line)


def _nodes_2(cursor: _Cursor) -> tuple[NDArray[np.int64], Floats]:
    count = _count_line(cursor)
    if cursor.binary:
        raw = cursor.take(28 * count, "u1")
        rows = raw.view(np.dtype([("tag", "<i4"), ("x", "<f8", 3)]))
        return rows["tag"].astype(np.int64), rows["x"].astype(np.float64)
    table = np.asarray(cursor.take(4 * count, "f8"), dtype=np.float64).reshape(-1, 4)
    return _whole(table[:, 0]), table[:, 1:]


def _nodes_4(cursor: _Cursor) -> tuple[NDArray[np.int64], Floats]:
    blocks = cursor.integers(4, "<u8")[0]
    tags: list[NDArray[np.int64]] = [np.empty(0, np.int64)]
    points: list[Floats] = [np.empty((0, 3))]
    for _ in range(blocks):
        dimension, _, parametric = cursor.integers(3, "<i4")
        count = cursor.integers(1, "<u8")[0]
        width = 3 + (dimension if parametric else 0)
        if not 3 <= width <= 6:
            raise InputError("the file is cut off or damaged")
        tags.append(cursor.take(count, "<i8").astype(np.int64))
        rows = cursor.take(count * width, "<f8").astype(np.float64)
        points.append(rows.reshape(-1, width)[:, :3])
    return np.concatenate(tags), np.concatenate(points)


def _elements_2(cursor: _Cursor) -> NDArray[np.int64]:
    count = _count_line(cursor)
    found: list[NDArray[np.int64]] = [np.empty((0, 3), np.int64)]
    if not cursor.binary:
        # Rows have as many numbers as their type and number of tags say.
        lines = cursor.data.splitlines()[1 : count + 1]
        if len(lines) < count:
            raise InputError("the file is cut off or damaged")
        rows = []
        for line in lines:
            try:
                row = [int(word) for word in line.split()]
                kind, tags = row[1], row[2]
            except (ValueError, IndexError) as error:
                raise InputError("a number in the file cannot be read") from error
            if tags < 0 or len(row) != 3 + tags + _nodes_of(kind):
                raise InputError("the file is cut off or damaged")
            if kind == TRIANGLE:
                rows.append(row[-3:])
        return _bounded(rows)
    seen = 0
    while seen < count:
        kind, size, tags = cursor.integers(3, "<i4")
        if size < 1 or tags < 0:
            raise InputError("the file is cut off or damaged")
        width = 1 + tags + _nodes_of(kind)
        part = cursor.take(size * width, "<i4").astype(np.int64).reshape(-1, width)
        if kind == TRIANGLE:
            found.append(part[:, -3:])
        seen += size
    return np.concatenate(found)


def _elements_4(cursor: _Cursor) -> NDArray[np.int64]:
    blocks = cursor.integers(4, "<u8")[0]
    found: list[NDArray[np.int64]] = [np.empty((0, 3), np.int64)]
    for _ in range(blocks):
        kind = cursor.integers(3, "<i4")[2]
        count = cursor.integers(1, "<u8")[0]
        width = 1 + _nodes_of(kind)
        part = cursor.take(count * width, "<i8").astype(np.int64).reshape(-1, width)
        if kind == TRIANGLE:
            found.append(part[:, 1:])
    return np.concatenate(found)


def _nodes_of(kind: int) -> int:
    if kind not in NODES_OF:
        raise InputError(
            "the mesh must have triangles only",
            value=f"element type {kind}",
            allowed="types 2 (triangle), 1 (line) and 15 (point)",
        )
    return NODES_OF[kind]


def _whole(values: Floats) -> NDArray[np.int64]:
    if not (np.isfinite(values).all() and (np.abs(values) < 2**53).all()):
        raise InputError("a node tag in the file is no whole number")
    return values.astype(np.int64)


def _bounded(rows: list[list[int]]) -> NDArray[np.int64]:
    try:
        return np.array(rows, dtype=np.int64).reshape(-1, 3)
    except OverflowError as error:
        raise InputError("a number in the file cannot be read") from error
