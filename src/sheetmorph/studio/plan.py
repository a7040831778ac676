"""The flat pattern of a design as the browser draws it: rings of points, handles, supports."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import shapely

from sheetmorph.studio.handles import handles

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design

SIMPLE = 2e-5
"""How far the drawn lines may be from the true ones [m]."""

Points = list[list[float]]


def plan(design: Design) -> dict[str, Any]:
    """The plan of a design, ready for JSON; lengths in mm, y upward."""
    layout = design.layout
    low_x, low_y, high_x, high_y = layout.sheet.bounds
    return {
        "box": [1e3 * value for value in (low_x, low_y, high_x, high_y)],
        "sheet": _rings(layout.sheet),
        "parts": {name: _rings(part) for name, part in layout.parts.items()},
        "slits": [_points(line) for line in layout.slits.geoms],
        "supports": [
            [1e3 * value for value in (*support.x, *support.y)]
            for support in design.supports
            if support.kind in ("box", "pattern_in_box")
        ],
        "handles": handles(design),
        "pattern_area_mm2": 1e6 * layout.pattern.area,
        "sheet_area_mm2": 1e6 * layout.sheet.area,
    }


def _rings(shape: Any) -> list[Points]:
    """Every ring of a shape, boundaries and holes alike; to be filled by the even-odd rule."""
    simple = shapely.simplify(shape, SIMPLE)
    return [
        _points(ring)
        for polygon in shapely.get_parts(simple)
        for ring in (polygon.exterior, *polygon.interiors)
    ]


def _points(line: Any) -> Points:
    return [[round(1e3 * x, 3), round(1e3 * y, 3)] for x, y in shapely.get_coordinates(line)]
