"""Designs that need nothing beside them: drawings as polygons, materials as their values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import shapely

from sheetmorph.design import drawn
from sheetmorph.design.materials import find_material, layer_values

if TYPE_CHECKING:
    from sheetmorph.design.sections import Layer
    from sheetmorph.design.spec import Design

_OF_DRAWINGS = ("file", "select", "strokes", "overlaps", "gap", "slit_select")


def portable_text(design: Design) -> str:
    """TOML text of a design in which polygons in metres stand for its drawings.

    The values of a material stand in its place. The plan of the sheet is the same to the last
    bit. Mesh and curve files stay named.
    """
    shapes = [design.outline, *design.pattern]
    drawings = any(isinstance(shape, drawn.Drawing) for shape in shapes)
    if not drawings and all(layer.material is None for layer in design.layers):
        return design.to_toml()
    import tomlkit

    document: Any = tomlkit.parse(design.to_toml())
    tables = [document["outline"], *document.get("pattern", [])]
    for shape, table in zip(shapes, tables, strict=True):
        if not isinstance(shape, drawn.Drawing):
            continue
        for key in _OF_DRAWINGS:
            table.pop(key, None)
        table["unit"] = "m"
        polygons = [_rings(polygon) for polygon in shapely.get_parts(shape.polygon())]
        if shape is design.outline:
            table["kind"] = "polygon"
            table["points"], table["holes"] = polygons[0][0], polygons[0][1:]
            table["slits"] = [_points(slit) for slit in design.layout.slits.geoms]
        else:
            table["kind"] = "polygons"
            table["polygons"] = polygons
    for layer, table in zip(design.layers, document["layers"], strict=True):
        if layer.material is not None:
            _write_out(layer, table)
    return tomlkit.dumps(document)


def _write_out(layer: Layer, table: Any) -> None:
    """Put the values of a layer's material where its name stands."""
    values = layer_values(layer.material or "")
    del table["material"]
    for key, value in values.items():
        if key not in table:
            table[key] = value
            table[key].comment(f"of the material {find_material(layer.material or '').name}")


def _rings(polygon: shapely.Polygon) -> list[list[list[float]]]:
    return [_points(ring)[:-1] for ring in (polygon.exterior, *polygon.interiors)]


def _points(line: shapely.LineString) -> list[list[float]]:
    points: list[list[float]] = shapely.get_coordinates(line).tolist()
    return points
