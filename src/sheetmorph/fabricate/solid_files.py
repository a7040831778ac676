"""Bodies as the bytes of 3MF and STL files, in millimetres; the same bodies, the same bytes."""

from __future__ import annotations

import ctypes
import importlib.util
import re
import uuid
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.fabricate.print3d import Body

DECIMALS = 7
"""Decimals of the millimetres in a 3MF file."""

_NOT_XML = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def writes_3mf() -> bool:
    """Whether lib3mf is installed: it has no wheels for some machines (Linux on ARM)."""
    return importlib.util.find_spec("lib3mf") is not None


def bytes_3mf(bodies: Sequence[Body], metadata: Mapping[str, str]) -> bytes:
    """A 3MF package: one object for each body, all placed, unit millimetre.

    Args:
        bodies: what to print, in its place on the bed.
        metadata: well-known names of the 3MF core specification, such as Title, Designer,
            Description, Application; and their text.

    Raises:
        InputError: there is nothing to write.
    """
    import lib3mf

    _check_some(bodies)
    library = lib3mf.get_wrapper()
    model = library.CreateModel()
    model.SetUnit(lib3mf.ModelUnit.MilliMeter)
    group = model.GetMetaDataGroup()
    for name, text in metadata.items():
        group.AddMetaData("", name, _printable(text), "xs:string", True)
    model.SetBuildUUID(_identity("build"))
    for number, body in enumerate(bodies):
        thing = model.AddMeshObject()
        thing.SetName(_printable(body.name))
        thing.SetUUID(_identity(f"object {number}"))
        thing.SetGeometry(
            _structures(lib3mf.Position, 1e3 * body.points, ctypes.c_float),
            _structures(lib3mf.Triangle, body.triangles, ctypes.c_uint32),
        )
        placed = model.AddBuildItem(thing, library.GetIdentityTransform())
        placed.SetUUID(_identity(f"item {number}"))
    writer = model.QueryWriter("3mf")
    writer.SetDecimalPrecision(DECIMALS)
    return bytes(writer.WriteToBuffer())


def bytes_stl(bodies: Sequence[Body]) -> bytes:
    """A binary STL file of all bodies, in millimetres.

    Raises:
        InputError: there is nothing to write.
    """
    from trimesh import Trimesh
    from trimesh.exchange.stl import export_stl

    _check_some(bodies)
    corners = np.concatenate([1e3 * body.points[body.triangles] for body in bodies])
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    data: bytes = export_stl(Trimesh(corners.reshape(-1, 3), faces, process=False))
    return data


def _check_some(bodies: Sequence[Body]) -> None:
    if not bodies:
        raise InputError("there is no part to write")


def _identity(name: str) -> str:
    """An identifier that the name decides: the library's own would differ with every file."""
    return str(uuid.uuid5(uuid.NAMESPACE_URL, f"sheetmorph {name}"))


def _structures(kind: Any, rows: np.ndarray[Any, Any], number: Any) -> list[Any]:
    """Rows of a table as the structures of three numbers that lib3mf takes."""
    three = number * 3
    return [kind(three(*row)) for row in rows.tolist()]


def _printable(text: str) -> str:
    """Text without the characters that XML cannot carry."""
    return _NOT_XML.sub("\ufffd", text)
