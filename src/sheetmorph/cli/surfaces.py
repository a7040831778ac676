"""Surfaces that a user names on the command line: a run, a mesh in space, a scan."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.core import strangers
from sheetmorph.core.errors import InputError

if TYPE_CHECKING:
    from sheetmorph.compare.scan import Scan
    from sheetmorph.compare.surface import Surface
    from sheetmorph.study.result import Result

SCANS = (".stl", ".obj", ".ply")
MESHES = (".vtu", ".msh", ".txt")
FORMATS = "a run's folder, .h5, " + ", ".join((*SCANS, *MESHES))
SMALL, LARGE = 1e-3, 3.0
"""Sizes of sheets [m] beyond which a mesh was probably read in the wrong unit."""
NEAR = 0.005
"""A state counts as that of an actuation when it is this near to it."""


@dataclass(frozen=True, eq=False)
class Shape:
    """What a scan is compared with.

    Attributes:
        surface: points in metres.
        name: for titles.
        flat: the undeformed sheet, where it is known.
        notes: what the user should know.
    """

    surface: Surface
    name: str
    flat: Surface | None = None
    notes: tuple[str, ...] = ()


def is_run(path: Path) -> bool:
    """Whether a path names a run: its folder, or an HDF5 file."""
    return path.is_dir() or path.suffix.lower() == ".h5"


def read_shape(path: Path, *, unit: float = 1.0, state: str | None = None) -> Shape:
    """The shape in a run's folder, a result.h5, or the file of a mesh.

    Args:
        path: the folder or file.
        unit: length of one unit of a mesh file [m].
        state: which state of a run: its number, or an actuation such as "-0.3"; the last
            when absent.

    Raises:
        InputError: it cannot be read, or there is no such state; names the file.
    """
    from sheetmorph.compare.surface import Surface

    if not is_run(path):
        if state is not None:
            raise InputError("--state is for runs; a mesh has one state", file=path, value=state)
        shape = _from_mesh(path, unit)
        return replace(shape, notes=(*shape.notes, *_size_notes(shape)))
    from sheetmorph.study.result import Result

    result = Result.load(path)
    try:
        index = state_index(result, state)
    except InputError as error:
        raise error.located(path) from None
    notes = []
    if result.status != "completed" and index == len(result.positions) - 1:
        notes.append(
            f"The run ended as {result.status.replace('_', ' ')}: its last state, at eps_pre "
            f"{result.actuation[index]:.3g}, is compared."
        )
    last = index == len(result.positions) - 1
    name = result.design.name
    triangles = result.mesh.triangles.astype(np.int64)
    return Shape(
        Surface(result.positions[index], triangles),
        name if last else f"{name} at eps_pre {result.actuation[index]:.3g}",
        Surface(result.mesh.nodes, triangles),
        tuple(notes),
    )


def read_scan(path: Path) -> Scan:
    """The scan in a file, in the unit of the file; or the shape of another run, in metres.

    Args:
        path: an STL, OBJ or PLY file, a mesh in another format, or a run.

    Raises:
        InputError: it cannot be read; names the file.
    """
    from sheetmorph.compare.scan import Scan, read_surface

    if is_run(path):
        shape = read_shape(path)
        return Scan(shape.surface, shape.name, shape.notes, 1.0)
    if path.suffix.lower() in MESHES:
        shape = _from_mesh(path, 1.0)
        return Scan(shape.surface, shape.name)
    _known_format(path)
    return read_surface(path)


def state_index(result: Result, state: str | None) -> int:
    """The number of a state, given as a number or as an actuation.

    Raises:
        InputError: there is no such state.
    """
    from sheetmorph.core.units import to_si

    count = len(result.positions)
    if state is None:
        return count - 1
    text = state.strip()
    if re.fullmatch(r"[0-9]{1,9}", text):
        if int(text) >= count:
            raise InputError(
                "no such state", key="--state", value=text, allowed=f"0 to {count - 1}"
            )
        return int(text)
    try:
        wanted = to_si(text, "dimensionless")
    except InputError as error:
        raise InputError(
            "wants the number of a state, or an actuation such as -0.3", key="--state", value=state
        ) from error
    away = np.abs(result.actuation - wanted)
    if not away.min() <= NEAR:
        reached = ", ".join(dict.fromkeys(f"{value + 0.0:.3g}" for value in result.actuation))
        raise InputError(
            "the run has no state of this actuation; take one of its states, or run the design "
            f"to it, with --set actuation.eps_pre={text}",
            key="--state",
            value=state,
            allowed=reached,
        )
    # Of several, the last: the load that started the bending is off by then.
    return int(np.flatnonzero(away <= away.min() + 1e-12)[-1])


def _from_mesh(path: Path, unit: float) -> Shape:
    from sheetmorph.compare.scan import MAX_BYTES, read_surface
    from sheetmorph.compare.surface import Surface
    from sheetmorph.geometry.files import READERS, read_mesh

    _known_format(path)
    ending = path.suffix.lower()
    if ending in SCANS:
        scan = read_surface(path, unit=unit)
        return Shape(scan.surface, scan.name, notes=scan.notes)
    if ending == ".txt":
        mesh = read_mesh(path, unit)
        return Shape(Surface(mesh.nodes, mesh.triangles.astype(np.int64)), path.name)
    with strangers.reading(path, "the mesh"):
        strangers.check_size(path, MAX_BYTES)
        nodes, triangles = READERS[ending](path)
        points = np.zeros((len(nodes), 3))
        points[:, : nodes.shape[1]] = unit * nodes
        return Shape(Surface(points, triangles), path.name)


def _size_notes(shape: Shape) -> tuple[str, ...]:
    size = shape.surface.size
    if SMALL <= size <= LARGE:
        return ()
    note = (
        f"{shape.name} is {size:.3g} m large as it was read; if it is in another unit, say so by "
        "--shape-unit, such as --shape-unit mm."
    )
    return (note,)


def _known_format(path: Path) -> None:
    if path.suffix.lower() not in (*SCANS, *MESHES):
        if not path.exists():
            raise InputError("there is no such file or folder", file=path)
        raise InputError(
            "no such format", file=path, value=path.suffix or "no ending", allowed=FORMATS
        )
