"""`result.h5`: one HDF5 file that holds a whole result, read back without trust."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.core.hdf5 import open_hdf5, writing_hdf5
from sheetmorph.geometry.topology import MAX_COORDINATE
from sheetmorph.study.motion_record import COLUMNS, MotionRecord

if TYPE_CHECKING:
    from sheetmorph.study.result import Result

FORMAT = "sheetmorph result"
FORMAT_VERSION = 1
MAX_VALUES = 500_000_000
"""Most numbers of one array that a file may announce."""

MOST_PACKED = 300
"""Most bytes of an array per byte of it in a file: LZF packs zeros by less."""

FIELDS: dict[str, tuple[str, str]] = {
    "dihedral": ("rad", "signed dihedral angle θ, per state and hinge"),
    "strain": ("1", "edge strain e = l/l0 − 1, per state and edge"),
    "thermal_strain": ("1", "eigenstrain eth, per state and edge"),
    "stretch_energy_density": (
        "J/m^2",
        "stretching energy per area, per state and edge (laminate: triangle)",
    ),
    "bend_energy_density": (
        "J/m^2",
        "bending energy per area, per state and hinge (laminate: triangle)",
    ),
    "height": ("m", "height z, per state and node"),
    "mean_curvature": ("1/m", "mean curvature, per state and node"),
    "gaussian_curvature": ("1/m^2", "Gaussian curvature, per state and node"),
    "aspect_ratio": ("1", "h/d, per state"),
}
"""Derived fields: written for other programs, computed anew when read."""

_STATES = ("positions", "ramp", "load_fraction", "residual")
_SCALARS = "states/scalars"
_MODEL = (
    "thermal_strain_full",
    "edge_in_pattern",
    "triangle_in_pattern",
    "stretch_stiffness",
    "bending_stiffness",
    "coupling",
    "held_nodes",
)
_MOTION = ("time", "loads", "velocity")
_MESH = ("nodes", "triangles", "edges", "hinges", "hinge_edges")


def write_result(result: Result, path: Path) -> None:
    """Write a result, whole or not at all.

    Raises:
        OutputError: it cannot be written.
    """
    with writing_hdf5(path) as (file, _):
        file.attrs["format"] = FORMAT
        file.attrs["format_version"] = FORMAT_VERSION
        file.attrs["version"] = result.summary["version"]
        file.attrs["design_hash"] = result.summary["design_hash"]
        file.attrs["solver"] = result.summary["solver"]
        _write_text(file, "design", result.design.to_portable_toml())
        _write_text(file, "summary", json.dumps(result.summary))
        for name in _MESH:
            _write(file, f"mesh/{name}", getattr(result.mesh, name))
        for name in _STATES:
            _write(file, f"states/{name}", getattr(result, name))
        _write(file, _SCALARS, result.scalars)
        if result.motion is not None:
            _write_motion(file, result.motion)
        for name in _MODEL:
            _write(file, f"model/{name}", getattr(result, name))
        for name, (unit, text) in FIELDS.items():
            dataset = _write(file, f"fields/{name}", getattr(result, name))
            dataset.attrs["unit"] = unit
            dataset.attrs["description"] = text


def _write_motion(file: Any, motion: MotionRecord) -> None:
    for name in _MOTION:
        _write(file, f"motion/{name}", getattr(motion, name))
    for name, (unit, text) in COLUMNS.items():
        dataset = _write(file, f"motion/history/{name}", motion.history[name])
        dataset.attrs["unit"] = unit
        dataset.attrs["description"] = text


def _write_text(file: Any, name: str, text: str) -> None:
    """Text of a fixed length: that of a variable one is announced where nothing checks it."""
    import h5py

    data = text.encode()
    file.create_dataset(name, data=data, dtype=h5py.string_dtype("utf-8", len(data)))


def _write(file: Any, name: str, data: NDArray[Any]) -> Any:
    packed = {"compression": "lzf", "shuffle": True} if data.size > 100_000 else {}
    return file.create_dataset(name, data=data, **packed)


def read_result(path: Path) -> dict[str, Any]:
    """Read the parts of a result file, checked for shape and size.

    Returns:
        "design" (TOML text), "summary", "mesh" (arrays by name), "motion" (None for equilibria)
        and the arrays of the states and of the model by their names.

    Raises:
        InputError: the file is not there, is truncated, or is no result of sheetmorph.
    """
    if not path.is_file():
        raise InputError("there is no such result file", file=path)
    try:
        with open_hdf5(path) as file:
            if file.attrs.get("format") != FORMAT:
                raise InputError("this HDF5 file is no result of sheetmorph", file=path)
            if int(file.attrs["format_version"]) > FORMAT_VERSION:
                raise InputError(
                    "this result was written by a newer sheetmorph; update to read it", file=path
                )
            parts: dict[str, Any] = {
                "design": _read_text(file, "design", path),
                "summary": json.loads(_read_text(file, "summary", path)),
                "mesh": {name: _read(file, f"mesh/{name}") for name in _MESH},
            }
            parts |= {name: _read(file, f"states/{name}") for name in _STATES}
            parts |= {name: _read(file, f"model/{name}") for name in _MODEL}
            # Files of the first version have no scalar unknowns.
            none = np.zeros((len(parts["ramp"]), 0))
            parts["scalars"] = _read(file, _SCALARS) if _SCALARS in file else none
            parts["motion"] = _read_motion(file) if "motion" in file else None
            if not isinstance(parts["summary"], dict):
                raise InputError("summary is no table; the file is damaged")
    except InputError as error:
        raise error.located(path) from None
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError) as error:
        reason = " ".join(str(error).split())
        raise InputError(f"this result cannot be read ({reason})", file=path) from None
    _check_shapes(parts, path)
    return parts


def _read_text(file: Any, name: str, path: Path) -> str:
    """A text; one that announces more bytes than the file has is refused before it is read."""
    dataset = file[name]
    announced = dataset.dtype.itemsize
    if dataset.dtype.kind == "O":  # of variable length, as they were written once
        place = dataset.id.get_offset()
        with path.open("rb") as stream:
            stream.seek(place or 0)
            announced = int.from_bytes(stream.read(4), "little")
    if announced > path.stat().st_size or dataset.shape != ():
        raise InputError(f"{name} announces {announced} bytes; the file is damaged", file=path)
    return str(dataset.asstr()[()])


def _read(file: Any, name: str) -> NDArray[Any]:
    dataset = file[name]
    if dataset.size * dataset.dtype.itemsize > MOST_PACKED * dataset.id.get_storage_size() + 4096:
        raise InputError(f"{name} announces more than the file holds; the file is damaged")
    if dataset.size > MAX_VALUES:
        raise InputError(f"{name} announces {dataset.size} values", allowed=f"≤ {MAX_VALUES}")
    if dataset.dtype.kind not in "fiub":
        raise InputError(f"{name} does not hold numbers")
    if not dataset.shape:
        raise InputError(f"{name} is one number; the file is damaged")
    return np.asarray(dataset[()])


def _read_motion(file: Any) -> MotionRecord:
    time, loads, velocity = (_read(file, f"motion/{name}") for name in _MOTION)
    history = {name: _read(file, f"motion/history/{name}") for name in COLUMNS}
    return MotionRecord(time, loads, velocity, history)


def _check_shapes(parts: dict[str, Any], path: Path) -> None:
    mesh = parts["mesh"]
    v, e, t, h = (len(mesh[name]) for name in ("nodes", "edges", "triangles", "hinges"))
    s = len(parts["ramp"])
    laminate = parts["summary"].get("model") == "laminate"
    scalars = -(-e // 3) * 3 if laminate else 0
    expected: dict[str, tuple[int, ...]] = {
        "positions": (s, v, 3),
        "ramp": (s,),
        "load_fraction": (s,),
        "residual": (s,),
        "thermal_strain_full": (e,),
        "edge_in_pattern": (e,),
        "triangle_in_pattern": (t,),
        "stretch_stiffness": (0 if laminate else e,),
        "bending_stiffness": (0 if laminate else h,),
        "coupling": (0 if laminate else h,),
        "scalars": (s, scalars),
        "held_nodes": parts["held_nodes"].shape[:1],
    }
    shapes = {name: parts[name].shape for name in expected}
    motion = parts["motion"]
    if motion is not None:
        steps = motion.history["time_s"].shape[:1]
        expected |= {"time": (s,), "loads": (s,), "velocity": (s, v, 3)}
        expected |= dict.fromkeys(COLUMNS, steps)
        shapes |= {name: getattr(motion, name).shape for name in _MOTION}
        shapes |= {name: motion.history[name].shape for name in COLUMNS}
    expected_mesh = {
        "nodes": (v, 3),
        "triangles": (t, 3),
        "edges": (e, 2),
        "hinges": (h, 4),
        "hinge_edges": (h, 5),
    }
    shapes |= {name: mesh[name].shape for name in expected_mesh}
    for name, shape in {**expected, **expected_mesh}.items():
        if shapes[name] != shape:
            raise InputError(
                f"{name} has the shape {shapes[name]} instead of {shape}; the file is damaged",
                file=path,
            )
    if s < 1:
        raise InputError("the file holds no state", file=path)
    for name, places in (("nodes", mesh["nodes"]), ("positions", parts["positions"])):
        if not (np.abs(places) <= MAX_COORDINATE).all():
            raise InputError(
                f"{name} has a coordinate that is not a finite number below "
                f"{MAX_COORDINATE:.0e} m; the file is damaged",
                file=path,
            )
    for name, limit in (("triangles", v), ("edges", v), ("hinges", v), ("hinge_edges", e)):
        indices = mesh[name]
        if indices.size and (indices.min() < 0 or indices.max() >= limit):
            raise InputError(f"{name} has indices out of range; the file is damaged", file=path)
