"""Scans as they come from strangers: a bounded reader of STL, OBJ and PLY."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.compare.scanfiles import READERS, Triangles
from sheetmorph.compare.topology import weld
from sheetmorph.core import strangers
from sheetmorph.core.errors import InputError
from sheetmorph.geometry.topology import MAX_COORDINATE

if TYPE_CHECKING:
    from sheetmorph.compare.surface import Surface

MAX_BYTES = 500_000_000
MAX_TRIANGLES = 5_000_000
# Lengths that files are written in [m]; a fitted scale this close to one of them is told.
UNITS = {"um": 1e-6, "mm": 1e-3, "cm": 1e-2, "in": 0.0254, "ft": 0.3048, "m": 1.0}
UNIT_TOLERANCE = 0.05


@dataclass(frozen=True, eq=False)
class Scan:
    """A surface from a file and what there is to say about it.

    Attributes:
        surface: its points are in metres when `unit` is known, else in the file's unit.
        name: the file's name, for titles and tables.
        notes: sentences on what was found and what was done, in the order of doing.
        unit: length of one unit of the file [m]; None when it is not known.
    """

    surface: Surface
    name: str
    notes: tuple[str, ...] = ()
    unit: float | None = None


def read_surface(path: str | Path, *, unit: float | None = None) -> Scan:
    """Read a triangle surface from an STL, OBJ or PLY file, text or binary.

    Polygons are cut into triangles and several objects are joined. Colours, materials and
    textures are not read, and no other file is opened, whatever the file names. Points that
    coincide to single precision become one (STL files repeat every corner); all other
    cleaning is done by `sheetmorph.compare.clean.prepare`.

    Args:
        path: the file, at most 500 MB and 5 million triangles.
        unit: length of one unit of the file [m], such as 0.001 for millimetres; when None
            the points stay in the file's unit and its length is found by fitting.

    Raises:
        InputError: the file cannot be read, is cut off, holds points without triangles or
            numbers that are not finite; names the file.
    """
    file = Path(path)
    if unit is not None and not (math.isfinite(unit) and unit > 0.0):
        raise InputError("the length unit must be a positive number", file=file, value=unit)
    ending = strangers.ending_of(file, READERS, "format of a scan")
    with strangers.reading(file, "the scan"):
        data = strangers.read_bytes(file, MAX_BYTES, "reduce the scan in the program that made it")
        read = READERS[ending](data, MAX_TRIANGLES)
        del data
        return _checked(read, file.name, unit)


def unit_of_scale(scale: float) -> str | None:
    """The unit whose length is a fitted scale [m per unit] to within 5 %, such as `"in"`."""
    for unit, length in UNITS.items():
        if abs(scale / length - 1.0) <= UNIT_TOLERANCE:
            return unit
    return None


def _checked(read: Triangles, name: str, unit: float | None) -> Scan:
    from sheetmorph.compare.surface import Surface

    points, triangles = read.points, read.triangles
    if not len(triangles):
        raise InputError(
            f"the file has {len(points)} points but no triangles: it is a cloud of points; "
            "make a triangle mesh of it in the scanner's program first"
            if len(points)
            else "the file has no triangles"
        )
    if len(triangles) > MAX_TRIANGLES:
        raise InputError(
            "the scan has too many triangles; reduce it in the program that made it",
            value=len(triangles),
            allowed=f"≤ {MAX_TRIANGLES}",
        )
    if triangles.min() < 0 or triangles.max() >= len(points):
        bad = int(np.argmax(((triangles < 0) | (triangles >= len(points))).any(axis=1)))
        raise InputError(
            f"triangle {bad} refers to a point that does not exist",
            value=triangles[bad].tolist(),
            allowed=f"0 to {len(points) - 1}",
        )
    limit = MAX_COORDINATE / max(unit or 1.0, 1.0)
    sound = (np.abs(points) <= limit).all(axis=1)
    if not sound.all():
        raise InputError(
            f"point {int(np.argmin(sound))} has a coordinate that is not a finite number "
            f"below {limit:.0e} ({int((~sound).sum())} such points)"
        )
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    if not size > 1e-9:
        raise InputError("the scan has no extent: all its points coincide", value=size)
    points, triangles = weld(points, triangles)
    notes = []
    if read.objects > 1:
        notes.append(f"The file holds {read.objects} objects; they were joined.")
    away = float(np.linalg.norm(points.mean(axis=0))) / size
    if away > 1e4:
        notes.append(
            f"The scan lies {away:.1e} times its own size away from the origin; single "
            "precision leaves few digits there: move it to the origin before saving it."
        )
    return Scan(Surface(points * (unit or 1.0), triangles), name, tuple(notes), unit)
