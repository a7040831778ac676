"""Reading drawings: from the ending of a file to its reader."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from types import MappingProxyType

import numpy as np

from sheetmorph.core import strangers
from sheetmorph.core.errors import InputError
from sheetmorph.drawing.dxf import read_dxf
from sheetmorph.drawing.model import Drawing
from sheetmorph.drawing.request import UNITS, Contents, Request, check_extent, unit_name
from sheetmorph.drawing.solid import read_3mf, read_stl
from sheetmorph.drawing.svg import read_svg

MAX_BYTES = 20_000_000

READERS: dict[str, Callable[[bytes, Request], tuple[Contents, float]]] = {
    ".dxf": read_dxf,
    ".svg": read_svg,
    ".stl": read_stl,
    ".3mf": read_3mf,
}


def read_drawing(
    path: str | Path, *, unit: str | None = None, flatness: float = 5e-6, gap: float = 1e-5
) -> Drawing:
    """Read a flat drawing from a file; the ending says which format it has.

    `.dxf`: the layers of the model space. `.svg`: elements by id, label, class and colour;
    the origin is the lower left corner of the page, y is upward, so that
    y = page height − (user y). `.stl` and `.3mf`: the plan of a flat surface or a plate,
    as seen from above. A file is never read beyond itself: links and references to other
    files are left out.

    Args:
        path: the file, at most 20 MB.
        unit: what a unit of the file is; by default what the file says (DXF, 3MF), a user
            unit of the page (SVG), millimetres (STL).
        flatness: how far a chord may be from the curve it stands for [m].
        gap: the widest gap between ends of lines that is closed [m].

    Returns:
        The drawing in metres, with notes of what was mended and left out.

    Raises:
        InputError: the file cannot be read; names the file, and coordinates in mm.
    """
    file = Path(path)
    ending = strangers.ending_of(file, READERS, "format of drawings")
    if unit is not None and unit not in UNITS:
        raise InputError("no such unit", key="unit", value=unit, allowed=", ".join(UNITS))
    for name, value, least, most in (("flatness", flatness, 1e-8, 1e-3), ("gap", gap, 0.0, 1e-2)):
        if not (math.isfinite(value) and least <= value <= most):
            raise InputError(
                "is out of bounds", key=name, value=value, allowed=f"{least:g} to {most:g} m"
            )
    request = Request(unit, flatness, gap)
    with strangers.reading(file, "the drawing"):
        # Numbers that overflow are refused by the readers, not warned of.
        with np.errstate(over="ignore", invalid="ignore"):
            contents, length = READERS[ending](strangers.read_bytes(file, MAX_BYTES), request)
        check_extent(contents.items, length)
    return Drawing(
        items=tuple(contents.items),
        layers=MappingProxyType(contents.layers),
        notes=request.notes.texts,
        unit=unit_name(length),
        gap=gap,
        flatness=flatness,
        file=str(file),
    )
