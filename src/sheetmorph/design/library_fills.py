"""Patterns of the library that fill the sheet: stripes, a grid of stripes, a honeycomb."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from sheetmorph.design.fields import Angle, Coordinate, Point, Quantity, Size, problem
from sheetmorph.design.library_tools import room, sheet_reach, tidy, without_slivers
from sheetmorph.design.piece import Piece
from sheetmorph.design.shapes import ORIGIN
from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from shapely import Polygon
    from shapely.geometry.base import BaseGeometry

MAX_STRIPES = 1000
MAX_CROSSED = 150
"""Stripes of one family, alone and crossed by another."""

MAX_CELLS = 5000
SLIVER = 0.5
"""What the rim leaves of a stripe or a wall is dropped where it is narrower than this fraction."""

Margin = Annotated[float, Quantity("length", "0 mm", "1 m")]


class Stripes(Piece):
    """Parallel stripes over the whole sheet.

    Attributes:
        spacing: from the middle of one stripe to the middle of the next [m].
        half_width: of a stripe [m].
        rotation: direction in which the stripes run, from the x-axis.
        offset: distance from the origin to the middle line of a stripe, to its left [m].
        margin: along the rim, free of stripes [m].
    """

    kind: Literal["stripes"]
    spacing: Size
    half_width: Size
    rotation: Angle = 0.0
    offset: Coordinate = 0.0
    margin: Margin = 0.0

    @model_validator(mode="after")
    def _have_gaps(self) -> Self:
        _check_gap(self.half_width, self.spacing)
        return self

    def drawn(self, sheet: Polygon) -> BaseGeometry:
        """The stripes, cut off at the margin [m]."""
        start = (-self.offset * math.sin(self.rotation), self.offset * math.cos(self.rotation))
        stripes = _stripes(sheet, start, self.rotation, self.spacing, self.half_width)
        return _fitted(stripes, sheet, self.margin, 2 * self.half_width)


class Grid(Piece):
    """Two families of parallel stripes that cross.

    Attributes:
        spacing: from the middle of one stripe to the middle of the next [m].
        half_width: of a stripe [m].
        angle: between the two families.
        rotation: direction in which the first family runs, from the x-axis.
        centre: a point where the middle lines of two stripes cross [m].
        margin: along the rim, free of stripes [m].
    """

    kind: Literal["grid"]
    spacing: Size
    half_width: Size
    angle: Annotated[float, Quantity("angle", "15 deg", "165 deg")] = math.pi / 2
    rotation: Angle = 0.0
    centre: Point = ORIGIN
    margin: Margin = 0.0

    @model_validator(mode="after")
    def _have_gaps(self) -> Self:
        _check_gap(self.half_width, self.spacing)
        return self

    def drawn(self, sheet: Polygon) -> BaseGeometry:
        """The stripes of both families, cut off at the margin [m]."""
        import shapely

        families = [
            _stripes(sheet, self.centre, direction, self.spacing, self.half_width, MAX_CROSSED)
            for direction in (self.rotation, self.rotation + self.angle)
        ]
        both = shapely.union_all(families)
        return _fitted(both, sheet, self.margin, 2 * self.half_width)


class Honeycomb(Piece):
    """The walls of hexagonal cells over the whole sheet.

    Attributes:
        cell_size: between opposite sides of an open cell [m].
        wall_width: between two cells [m].
        cells: only whole cells with a wall all around, or cells cut off at the margin.
        rotation: direction from a cell to one of its neighbours, from the x-axis.
        centre: of a cell [m].
        margin: along the rim, free of walls [m].
    """

    kind: Literal["honeycomb"]
    cell_size: Size
    wall_width: Size
    cells: Literal["whole", "cut"] = "whole"
    rotation: Angle = 0.0
    centre: Point = ORIGIN
    margin: Margin = 0.0

    def drawn(self, sheet: Polygon) -> BaseGeometry:
        """The walls, cut off at the margin [m]."""
        import shapely

        pitch = self.cell_size + self.wall_width
        reach = sheet_reach(sheet, self.centre) + pitch
        half = math.ceil(2 * reach / (math.sqrt(3) * pitch))
        if (2 * half + 1) ** 2 > 4 * MAX_CELLS:
            raise problem("makes too many cells", key="cell_size", allowed=f"≤ {MAX_CELLS} cells")
        i, j = np.meshgrid(np.arange(-2 * half, 2 * half + 1), np.arange(-half, half + 1))
        flat = np.column_stack([(i + 0.5 * j).ravel(), (math.sqrt(0.75) * j).ravel()]) * pitch
        flat = flat[np.hypot(flat[:, 0], flat[:, 1]) < reach + pitch]
        c, s = math.cos(self.rotation), math.sin(self.rotation)
        places = flat @ np.array([[c, s], [-s, c]]) + self.centre
        cells = _hexagons(places, self.cell_size, self.rotation)
        inner = room(sheet, self.margin)
        if self.cells == "cut":
            walls = shapely.difference(inner, shapely.MultiPolygon(list(cells)))
            return _fitted(walls, sheet, self.margin, self.wall_width)
        shapely.prepare(inner)
        grown = _hexagons(places, self.cell_size + 2 * self.wall_width, self.rotation)
        whole = shapely.contains_properly(inner, grown)
        if not whole.any():
            raise problem(
                "no whole cell fits on the sheet",
                key="cell_size",
                value=f"{1e3 * self.cell_size:g} mm",
                allowed='smaller cells, or cells = "cut"',
            )
        around = shapely.union_all(list(grown[whole]))
        return tidy(shapely.difference(around, shapely.MultiPolygon(list(cells[whole]))))


def _hexagons(places: Floats, width: float, rotation: float) -> NDArray[np.object_]:
    """Regular hexagons of a width between opposite sides about some places [m]."""
    import shapely

    corner = rotation + np.radians(30.0 + 60.0 * np.arange(6))
    steps = np.column_stack([np.cos(corner), np.sin(corner)]) * width / math.sqrt(3)
    return np.asarray(shapely.polygons(places[:, None] + steps))


def _check_gap(half_width: float, spacing: float) -> None:
    if 2 * half_width >= spacing:
        raise problem(
            "the stripes have no gap between them",
            key="half_width",
            value=f"{1e3 * half_width:g} mm",
            allowed=f"less than half of spacing, {5e2 * spacing:g} mm",
        )


def _stripes(
    sheet: Polygon,
    start: tuple[float, float],
    direction: float,
    spacing: float,
    w: float,
    most: int = MAX_STRIPES,
) -> BaseGeometry:
    """Stripes beside a first one through `start`, long enough to cross the sheet [m]."""
    import shapely

    reach = 1.01 * sheet_reach(sheet, start) + spacing
    half = math.ceil(reach / spacing)
    if 2 * half > most:
        raise problem("makes too many stripes", key="spacing", allowed=f"≤ {most} stripes")
    middle = spacing * np.arange(-half, half + 1)[:, None]
    along = np.array([-reach, reach, reach, -reach])
    across = middle + np.array([-w, -w, w, w])
    c, s = math.cos(direction), math.sin(direction)
    x = start[0] + c * along - s * across
    y = start[1] + s * along + c * across
    return shapely.MultiPolygon(list(shapely.polygons(np.stack([x, y], axis=-1))))


def _fitted(shape: BaseGeometry, sheet: Polygon, margin: float, width: float) -> BaseGeometry:
    """The shape cut off at the margin, without the slivers that the cut leaves [m]."""
    import shapely

    inner = room(sheet, margin)
    kept = without_slivers(shapely.intersection(shape, inner), SLIVER * width)
    kept = tidy(shapely.intersection(kept, inner))
    if kept.is_empty:
        raise problem("nothing of it lies on the sheet", key="margin" if margin else "")
    return kept
