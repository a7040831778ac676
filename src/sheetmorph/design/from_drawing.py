"""A first design file for a drawing: which of its layers are what, and a mesh that suits them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from sheetmorph.core.errors import InputError

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

    from sheetmorph.drawing.model import Drawing

SHEET_NAMES = ("sheet", "outline", "film")
PATTERN_NAMES = ("pattern", "ribs", "inert")
SLIT_NAMES = ("slits", "slit", "cuts", "cut")

WANTED_NODES = 1500
RIB_SHARE = 1.0
"""Edge length of the mesh, as a share of the mean width of the ribs, where that is smaller."""
WIDE_STROKE = 0.3e-3
"""A stroke of at least this width [m] is meant as a rib, a thinner one as a contour."""

_TEMPLATE = """\
# A design that follows a drawing, {file}: change the drawing and run it again.
#
# Quantities carry their unit: "0.3 mm", "0.9 MPa", "150 degC". Change a value here, or for
# one run with --set, such as --set actuation.eps_pre=-0.3
name = "{name}"
model = "published" # the reduced model of Zhang, Alon and Jawed

[outline]
kind = "drawing"
file = {file} # beside this file; .dxf, .svg, .stl or .3mf
{outline}
[[pattern]]
kind = "drawing"
file = {file}
{pattern}clip = true # cut off what reaches past the sheet

"""


@dataclass(frozen=True)
class Roles:
    """Names in a drawing of what is to be the sheet, the pattern and the slits."""

    sheet: str
    pattern: str
    slits: str | None


def design_text(
    path: Path,
    name: str,
    sheet: str | None = None,
    pattern: str | None = None,
    slits: str | None = None,
    unit: str | None = None,
    gap: float | None = None,
) -> str:
    """TOML text of a design for a drawing, with comments.

    Layers, materials and actuation are those of the preset "blank".

    Args:
        path: the drawing.
        name: of the design.
        sheet, pattern, slits: layers of a DXF, ids, labels, classes or colours of an SVG; by
            default the usual names are looked for.
        unit: of the drawing's numbers, where it names none or the wrong one.
        gap: ends of lines closer than this are joined [m].

    Raises:
        InputError: the drawing is broken, or a name is not in it.
    """
    from sheetmorph.design.presets import preset_text
    from sheetmorph.drawing.read import read_drawing

    if path.suffix.lower() == ".stl":
        raise InputError(
            "an STL file has no layers: it can be the sheet or the pattern of a design, not both; "
            'write kind = "drawing" and its name into the one table or the other',
            file=path,
            allowed="for a whole design: .dxf, .svg, .3mf",
        )
    drawing = read_drawing(path, unit=unit, **({} if gap is None else {"gap": gap}))
    roles = _roles(drawing, sheet, pattern, slits)
    try:
        strokes = _drawn_as_strokes(drawing, roles.pattern)
        outline = drawing.area(roles.sheet)
        ribs = drawing.area(roles.pattern, strokes=strokes, overlaps="union")
    except InputError as error:
        raise error.located(path) from None
    blank = preset_text("blank", name)
    rest = blank[blank.index("# The layers") :]
    size = f"{1e3 * _mesh_size(outline, ribs):.2g} mm"
    rest = rest.replace('size = "4 mm"', f'size = "{size}"', 1)
    slit_line = f"slit_select = {_quoted(roles.slits)}\n" if roles.slits else ""
    reading = f"unit = {_quoted(unit)}\n" if unit else ""
    reading += f'gap = "{1e3 * gap:g} mm"\n' if gap is not None else ""
    stroke_line = "strokes = true # strokes are ribs as wide as they are drawn\n" if strokes else ""
    return (
        _TEMPLATE.format(
            name=name,
            file=_quoted(path.name),
            outline=f"select = {_quoted(roles.sheet)}\n{slit_line}{reading}",
            pattern=(
                f'select = {_quoted(roles.pattern)}\n{stroke_line}{reading}overlaps = "union"\n'
            ),
        )
        + rest
    )


def _roles(drawing: Drawing, sheet: str | None, pattern: str | None, slits: str | None) -> Roles:
    names = {name.lower(): name for name in drawing.layers}

    def find(given: str | None, usual: tuple[str, ...]) -> str | None:
        return given or next((names[name] for name in usual if name in names), None)

    found = find(sheet, SHEET_NAMES), find(pattern, PATTERN_NAMES), find(slits, SLIT_NAMES)
    for role, name, usual in zip(
        ("sheet", "pattern"), found[:2], (SHEET_NAMES, PATTERN_NAMES), strict=True
    ):
        if name is None:
            listed = ", ".join(list(drawing.layers)[:12])
            raise InputError(
                f"no layer, id or label is called {usual[0].upper()}; name one with --{role}",
                file=drawing.file,
                allowed=listed,
            )
    return Roles(str(found[0]), str(found[1]), found[2])


def _drawn_as_strokes(drawing: Drawing, select: str) -> bool:
    """True when a selection has open or unfilled lines with pens as wide as ribs."""
    for item in drawing.layers[select].items if select in drawing.layers else ():
        pen = item.pen
        if item.fill is not None or pen is None:
            continue
        (a, b, _), (c, d, _) = pen.matrix
        if pen.width * math.sqrt(abs(a * d - b * c)) >= WIDE_STROKE:
            return True
    return False


def _mesh_size(outline: BaseGeometry, ribs: BaseGeometry) -> float:
    """Edge length that makes about `WANTED_NODES` nodes and fits the ribs [m]."""
    by_area = math.sqrt(outline.area / WANTED_NODES / (math.sqrt(3) / 2))
    mean_width = 2 * ribs.area / ribs.length
    return float(min(by_area, RIB_SHARE * mean_width))


def _quoted(text: str | None) -> str:
    import json

    return json.dumps(text, ensure_ascii=False)
