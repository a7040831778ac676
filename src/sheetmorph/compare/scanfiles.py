"""Points and triangles out of the bytes of STL, OBJ and PLY files, with lies found out."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats

_STL_HEADER, _STL_TRIANGLE = 84, 50
# A normal, which is not read (the corners tell it), three corners, and two bytes of anything.
_STL_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
# Words of a text STL between its numbers: three of a normal and nine of corners.
_STL_WORDS = (b"facet", b"normal", b"outer", b"loop", b"vertex", b"end")
_SOLID = re.compile(rb"solid[^\r\n]*")
_ELEMENT = re.compile(rb"^element[ \t]+(\w+)[ \t]+(\S+)", re.MULTILINE)
_MAX_PLY_HEADER = 2**16


@dataclass(frozen=True, eq=False)
class Triangles:
    """What a file holds: points (V, 3) in its unit, triangles (T, 3), number of objects."""

    points: Floats
    triangles: NDArray[np.int64]
    objects: int = 1


def read_stl(data: bytes, max_triangles: int) -> Triangles:
    """Triangle soup of an STL file: binary when its length is what its header announces.

    Raises:
        InputError: cut off, too large, or no STL file.
    """
    count = int.from_bytes(data[80:84], "little") if len(data) >= _STL_HEADER else -1
    if count >= 0 and len(data) == _STL_HEADER + _STL_TRIANGLE * count:
        _check_count(count, max_triangles, "triangles")
        return _read_binary_stl(data) if count else _nothing()
    start = data[:2000].lstrip().lower()
    if start.startswith(b"solid") and (b"facet" in start or b"endsolid" in start):
        return _read_text_stl(data, max_triangles)
    if count < 0 or start.startswith((b"<", b"{", b"#")) or _is_text(data):
        raise InputError("is no readable .stl file")
    raise InputError(
        f"the file is cut off or damaged: {count} triangles are announced, "
        f"{max(len(data) - _STL_HEADER, 0) // _STL_TRIANGLE} are there"
    )


def read_obj(data: bytes, max_triangles: int) -> Triangles:
    """Points and faces of an OBJ file; the materials it names are not looked for.

    Raises:
        InputError: damaged, too large, or no OBJ file.
    """
    _check_count(data.count(b"\nf "), max_triangles, "faces")
    if not data.startswith(b"v ") and b"\nv " not in data and b"\nv\t" not in data:
        raise InputError("is no readable .obj file: it has no lines of points (v x y z)")
    return _through_trimesh(data, "obj")


def read_ply(data: bytes, max_triangles: int) -> Triangles:
    """Points and faces of a PLY file, text or binary.

    Raises:
        InputError: cut off, too large, or no PLY file.
    """
    end = data.find(b"end_header", 0, _MAX_PLY_HEADER)
    if not data.startswith(b"ply") or end < 0:
        raise InputError("is no readable .ply file: it has no header from ply to end_header")
    announced = 0
    for name, number in _ELEMENT.findall(data[:end]):
        if not number.isdigit() or len(number) > 12:
            raise InputError(f"the header announces no sound number of {name.decode('ascii')}")
        _check_count(int(number), 3 * max_triangles, "elements")
        announced += int(number)
    # A text file has a line for each element; in a binary one trimesh checks the length.
    lines = max(data.count(b"\n", end), data.count(b"\r", end))
    if b"format ascii" in data[:end] and lines < announced:
        raise InputError(
            f"the file is cut off or damaged: {announced} points and faces are announced, "
            f"{max(lines - 1, 0)} are there"
        )
    return _through_trimesh(data, "ply")


def _through_trimesh(data: bytes, kind: str) -> Triangles:
    """What trimesh makes of the bytes; it never sees the disk, so it opens nothing else."""
    import trimesh

    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            # numpy stops at text that is no number and only warns: half a scan is no scan.
            warnings.filterwarnings("error", message=".*unmatched data.*")
            scene = trimesh.load_scene(
                io.BytesIO(data),
                file_type=kind,
                resolver=_Nowhere(),
                process=False,
                skip_materials=True,
            )
            parts = [
                (
                    np.asarray(part.vertices, dtype=np.float64).reshape(-1, 3),
                    np.asarray(getattr(part, "faces", ()), dtype=np.int64).reshape(-1, 3),
                )
                for part in scene.geometry.values()
            ]
    except MemoryError:
        raise
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        if kind == "ply" and "unexpected length" in reason:
            reason = "its length is not what its header says; polygons must be all of one size"
        raise InputError(f"is no readable .{kind} file, or is cut off ({reason[:100]})") from error
    if not parts:
        return _nothing()
    shifts = np.cumsum([0, *(len(points) for points, _ in parts[:-1])])
    return Triangles(
        np.concatenate([points for points, _ in parts]),
        np.concatenate([faces + shift for (_, faces), shift in zip(parts, shifts, strict=True)]),
        sum(len(faces) > 0 for _, faces in parts),
    )


def _read_binary_stl(data: bytes) -> Triangles:
    records = np.frombuffer(data, _STL_RECORD, offset=_STL_HEADER)
    points = records["corners"].astype(np.float64).reshape(-1, 3)
    return Triangles(points, np.arange(len(points)).reshape(-1, 3))


def _read_text_stl(data: bytes, max_triangles: int) -> Triangles:
    # trimesh needs 3 GB for 1.3 million triangles of text, this half of it.
    if b"endsolid" not in data[-400:].lower():
        raise InputError("the file is cut off or damaged: it does not end with endsolid")
    data, objects = _SOLID.subn(b"", data.lower())
    for word in _STL_WORDS:
        data = data.replace(word, b"")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            numbers = np.fromstring(data, sep=" ", dtype=np.float64)
    except (DeprecationWarning, ValueError) as error:
        raise InputError("is no readable .stl file: it holds words that do not belong") from error
    if len(numbers) % 12:
        raise InputError(
            "the file is cut off or damaged: a facet has a normal of 3 and corners of 9 numbers"
        )
    _check_count(len(numbers) // 12, max_triangles, "triangles")
    points = np.ascontiguousarray(numbers.reshape(-1, 12)[:, 3:]).reshape(-1, 3)
    return Triangles(points, np.arange(len(points)).reshape(-1, 3), max(objects // 2, 1))


class _Nowhere:
    """A resolver that refuses: a scan is one file."""

    def get(self, name: str) -> bytes:
        raise OSError(f"{name} is not opened")

    __getitem__ = get


def _check_count(count: int, limit: int, what: str) -> None:
    if count > limit:
        raise InputError(
            f"the scan has too many {what}; reduce it in the program that made it",
            value=count,
            allowed=f"≤ {limit}",
        )


def _is_text(data: bytes) -> bool:
    return b"\0" not in data[:2000]


def _nothing() -> Triangles:
    return Triangles(np.empty((0, 3)), np.empty((0, 3), dtype=np.int64), 0)


READERS: dict[str, Callable[[bytes, int], Triangles]] = {
    ".stl": read_stl,
    ".obj": read_obj,
    ".ply": read_ply,
}
