"""Drawings that were dropped on the studio: what is in them, and a design with them.

A drawing becomes polygons in the design's own text, so that the text needs no file beside it and
the name that a file had elsewhere is never used as a path.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from sheetmorph.core.errors import InputError
from sheetmorph.design.files import edit_design_text
from sheetmorph.design.from_drawing import PATTERN_NAMES, SHEET_NAMES, SLIT_NAMES, WIDE_STROKE
from sheetmorph.design.spec import Design
from sheetmorph.drawing.read import read_drawing

if TYPE_CHECKING:
    from sheetmorph.drawing.model import Drawing
    from sheetmorph.studio.worker import Desk

WANTED_NODES = 1200
MAX_SHOWN = 20_000
"""Points of the picture of a drawing."""
MAX_NAMES = 60
FREE = {
    "supports": None,
    "perturbation": {"shape": "bowl", "total_force": "0.1 mN", "direction": "up"},
}
"""A sheet of another form is free: what held the old one does not fit it."""


def look_at_drawing(job: dict[str, Any], desk: Desk, memory: Any) -> None:
    """Tell what a drawing holds: its layers and names, a picture, and what is probably what."""
    drawing = read_drawing(job["path"], unit=job.get("unit"))
    names = list(drawing.layers)[:MAX_NAMES]
    lower = {name.lower(): name for name in drawing.layers}

    def find(usual: tuple[str, ...]) -> str | None:
        return next((lower[name] for name in usual if name in lower), None)

    desk.answer(
        "drawing",
        {
            "names": [{"name": name, "kind": drawing.layers[name].kind} for name in names],
            "guess": {
                "sheet": find(SHEET_NAMES),
                "pattern": find(PATTERN_NAMES),
                "slits": find(SLIT_NAMES),
            },
            "unit": drawing.unit,
            "notes": list(drawing.notes),
            "lines": _lines(drawing),
        },
    )


def _lines(drawing: Drawing) -> list[list[list[float]]]:
    """Curves of a drawing [mm], thinned to `MAX_SHOWN` points."""
    curves = [curve.path for item in drawing.items for curve in item.curves]
    total = sum(map(len, curves))
    step = max(1, math.ceil(total / MAX_SHOWN))
    return [
        [[round(1e3 * x, 3), round(1e3 * y, 3)] for x, y in (*curve[:-1:step], curve[-1])]
        for curve in curves
    ]


def use_drawing(job: dict[str, Any], desk: Desk, memory: Any) -> None:
    """Answer with the text of the design that has a drawing as its sheet, pattern or both."""
    folder = None if not job.get("folder") else Path(job["folder"])
    text = Design.from_toml(job["text"], folder).to_portable_toml()
    desk.answer("opened", {"text": with_drawing(text, Path(job["path"]), job["roles"])})


def with_drawing(text: str, file: Path, roles: dict[str, Any]) -> str:
    """The text of a design with parts of a drawing in it, as polygons.

    Args:
        text: a design that names no files.
        file: the drawing.
        roles: `sheet`, `pattern`, `slits`: names in the drawing, or None to keep what the
            design has; "" takes all of the drawing. `unit`: of its numbers, or None.

    Raises:
        InputError: a name is not in the drawing, or the drawing cannot be used so.
    """
    sheet, pattern, slits = (roles.get(role) for role in ("sheet", "pattern", "slits"))
    if sheet is None and pattern is None:
        raise InputError("choose what the drawing is to be: the sheet, the pattern, or both")
    drawing = read_drawing(file, unit=roles.get("unit"))
    before = Design.from_toml(text)
    middle = before.layout.sheet.envelope.centroid
    values: dict[str, object] = {}
    plan = before.layout.sheet
    if sheet is not None:
        plan = _one_piece(drawing.area(sheet or None, overlaps="union"))
        cuts = drawing.lines(slits) if slits else shapely.MultiLineString()
        if pattern is None:  # a drawing has its own origin, often the corner of a page
            plan, cuts = (_centred(shape, middle, plan) for shape in (plan, cuts))
        values |= {"outline": _outline(plan, cuts), **FREE}
    if pattern is not None:
        strokes = _has_ribs(drawing, pattern)
        ribs = drawing.area(pattern or None, strokes=strokes, overlaps="union")
        if sheet is None:
            ribs = _centred(ribs, middle, ribs)
        polygons = [_rings(part) for part in ribs.geoms]
        values["pattern"] = [{"kind": "polygons", "unit": "m", "polygons": polygons, "clip": True}]
    else:
        values |= {f"pattern.{k}.clip": True for k in range(len(before.pattern))}
        ribs = before.layout.pattern
    values["mesh"] = {"size": f"{1e3 * _mesh_size(plan, ribs):.3g} mm"}
    return edit_design_text(text, values)


def _one_piece(area: Any) -> Any:
    """The polygon of a sheet.

    Raises:
        InputError: the area is in several pieces.
    """
    if len(area.geoms) != 1:
        raise InputError(
            f"the sheet would be in {len(area.geoms)} pieces; choose the layer of its outline alone"
        )
    return area.geoms[0]


def _centred(shape: Any, goal: Any, of: Any) -> Any:
    """A shape moved as much as takes the middle of another one to a point."""
    from shapely.affinity import translate

    middle = of.envelope.centroid
    return translate(shape, goal.x - middle.x, goal.y - middle.y)


def _outline(plan: Any, slits: Any) -> dict[str, Any]:
    points, *holes = _rings(plan)
    table: dict[str, Any] = {"kind": "polygon", "unit": "m", "points": points}
    if holes:
        table["holes"] = holes
    if not slits.is_empty:
        table["slits"] = [shapely.get_coordinates(line).tolist() for line in slits.geoms]
    return table


def _rings(polygon: Any) -> list[list[list[float]]]:
    """Boundary and holes of a polygon [m], to a tenth of a micrometre."""
    rings = (polygon.exterior, *polygon.interiors)
    return [np.round(shapely.get_coordinates(ring)[:-1], 7).tolist() for ring in rings]


def _mesh_size(sheet: Any, ribs: Any) -> float:
    """Edge length that suits a plan [m]."""
    size = math.sqrt(sheet.area / WANTED_NODES / (math.sqrt(3) / 2))
    return min(size, 2 * ribs.area / ribs.length) if ribs.length > 0 else size


def _has_ribs(drawing: Drawing, name: str) -> bool:
    """True where lines are drawn with a pen as wide as a rib, and nothing is filled."""
    items = drawing.layers[name].items if name in drawing.layers else drawing.items
    return any(
        item.fill is None
        and item.pen is not None
        and item.pen.width * math.sqrt(abs(float(_determinant(item.pen.matrix)))) >= WIDE_STROKE
        for item in items
    )


def _determinant(matrix: Any) -> Any:
    return matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0]
