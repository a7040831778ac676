"""`states.h5`: meshes and states of all designs, end to end in a few chunked arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sheetmorph import __version__
from sheetmorph.core.errors import InputError
from sheetmorph.core.hdf5 import open_hdf5, writing_hdf5

FILE = "states.h5"
FORMAT = "sheetmorph sweep states"
BUFFER = 200
"""Designs that are in memory at once."""

_CHUNK = 16_384
_ARRAYS: dict[str, tuple[str, str, str]] = {
    "nodes": ("node", "m", "reference positions, (V, 3)"),
    "triangles": ("triangle", "", "node indices from 0 within the design, (T, 3)"),
    "in_pattern": ("triangle", "", "triangles of the pattern, (T,)"),
    "positions": (
        "position",
        "m",
        "positions of the nodes, the S states one after the other, (S V, 3)",
    ),
    "ramp": ("state", "1", "fraction of the actuation, (S,)"),
}
"""Arrays: which offsets cut them into designs, unit, meaning."""
_OFFSETS = ("node", "triangle", "position", "state")

Arrays = dict[str, NDArray[Any]]


def write_states(
    designs: Iterable[tuple[int, Arrays | None]], count: int, fingerprint: str, path: Path
) -> None:
    """Write the states of a sweep, whole or not at all.

    Args:
        designs: number and arrays of every design, in order; None where there is no shape.
        count: how many designs the sweep has.
        fingerprint: of the sweep.
        path: of the file.

    Raises:
        OutputError: it cannot be written.
    """
    with writing_hdf5(path) as (file, check):
        file.attrs["format"] = FORMAT
        file.attrs["version"] = __version__
        file.attrs["fingerprint"] = fingerprint
        _fill(file, check, designs, count)


def _fill(
    file: Any,
    check: Callable[[], None],
    designs: Iterable[tuple[int, Arrays | None]],
    count: int,
) -> None:
    sizes = {name: np.zeros(count + 1, dtype=np.int64) for name in _OFFSETS}
    waiting: list[Arrays] = []
    for number, arrays in designs:
        if arrays is None:
            continue
        flat = {**arrays, "positions": arrays["positions"].reshape(-1, 3)}
        for name, (offset, _, _) in _ARRAYS.items():
            sizes[offset][number + 1] = len(flat[name])
        waiting.append(flat)
        if len(waiting) == BUFFER:
            _append(file, waiting)
            check()
            waiting = []
    _append(file, waiting)
    for name, lengths in sizes.items():
        dataset = file.create_dataset(f"{name}_start", data=np.cumsum(lengths))
        dataset.attrs["description"] = f"design i has {name}_start[i] to {name}_start[i + 1]"


def _append(file: Any, waiting: list[Arrays]) -> None:
    for name, (_, unit, text) in _ARRAYS.items():
        if not waiting:
            continue
        data = np.concatenate([arrays[name] for arrays in waiting])
        if name in file:
            dataset = file[name]
            start = len(dataset)
            dataset.resize(start + len(data), axis=0)
            dataset[start:] = data
            continue
        dataset = file.create_dataset(
            name,
            data=data,
            maxshape=(None, *data.shape[1:]),
            chunks=(_CHUNK, *data.shape[1:]),
            compression="gzip",
            compression_opts=1,
            shuffle=True,
        )
        dataset.attrs["unit"], dataset.attrs["description"] = unit, text


def open_states(path: Path) -> Any:
    """The open file of the states.

    Raises:
        InputError: it is not there, or is none.
    """
    try:
        file = open_hdf5(path)
    except OSError as error:
        reason = " ".join(str(error).split())
        raise InputError(f"the states cannot be read ({reason})", file=path) from None
    if file.attrs.get("format") != FORMAT:
        file.close()
        raise InputError("this HDF5 file does not hold the states of a sweep", file=path)
    return file


def read_states(file: Any, number: int) -> Arrays:
    """Mesh and states of one design; arrays of length zero where it has no shape.

    Args:
        file: from `open_states`.
        number: of the design.

    Returns:
        `nodes` (V, 3), `triangles` (T, 3), `in_pattern` (T,), `positions` (S, V, 3) [m],
        `ramp` (S,).
    """
    found: Arrays = {}
    for name, (offset, _, _) in _ARRAYS.items():
        start, end = file[f"{offset}_start"][number : number + 2]
        found[name] = file[name][start:end] if name in file else np.zeros(0)
    states = len(found["ramp"])
    nodes = len(found["nodes"])
    found["positions"] = found["positions"].reshape(states, nodes, 3)
    return found
