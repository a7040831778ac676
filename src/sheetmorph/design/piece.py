"""What every shape of a pattern can be told: its part, how it joins, fillets, copies."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from sheetmorph.design.fields import (
    PART_PATTERN,
    Angle,
    Coordinate,
    Flag,
    Point,
    Quantity,
    Section,
    Whole,
    problem,
)
from sheetmorph.design.shapes import ORIGIN, Shape, rounded

if TYPE_CHECKING:
    from shapely import Polygon
    from shapely.geometry.base import BaseGeometry

DEFAULT_PART = "pattern"
MAX_COPIES = 1000

Radius = Annotated[float, Quantity("length", "0 mm", "10 m")]


class Mirror(Section):
    """A straight line: the shape and its mirror image in the line are drawn.

    Attributes:
        angle: of the line from the x-axis.
        point: a point on the line.
    """

    angle: Angle = math.pi / 2
    point: Point = ORIGIN


class GridArray(Section):
    """Copies in columns and rows; the first is the shape itself."""

    columns: Annotated[Whole, Field(ge=1, le=MAX_COPIES)] = 1
    rows: Annotated[Whole, Field(ge=1, le=MAX_COPIES)] = 1
    dx: Coordinate = 0.0
    dy: Coordinate = 0.0


class PolarArray(Section):
    """Copies turned about a point; the first is the shape itself.

    Attributes:
        count: number of copies.
        centre: what they turn about.
        step: from one copy to the next; a full turn divided by `count` by default.
    """

    count: Annotated[Whole, Field(ge=2, le=MAX_COPIES)]
    centre: Point = ORIGIN
    step: Angle | None = None


class Piece(Shape):
    """A shape of the pattern.

    Corners are rounded first, then mirror image, grid array and polar array are drawn, each of
    all that the ones before it drew; last comes the cut at the edge of the sheet.

    Attributes:
        part: which part of the pattern the shape belongs to; layers lie in parts.
        operation: how it joins the shapes of the same part that stand before it.
        fillet: radius of its re-entrant (inner) corners [m].
        corner_radius: radius of its salient (outer) corners [m].
        clip: cut off what reaches past the edge of the sheet.
    """

    part: Annotated[str, Field(min_length=1, max_length=60, pattern=PART_PATTERN)] = DEFAULT_PART
    operation: Literal["union", "difference", "intersection"] = "union"
    fillet: Radius = 0.0
    corner_radius: Radius = 0.0
    mirror: Mirror | None = None
    grid_array: GridArray | None = None
    polar_array: PolarArray | None = None
    clip: Flag = False

    def drawn(self, sheet: Polygon) -> BaseGeometry:
        """The shape before rounding and copying [m]; one that fills the sheet needs it."""
        return self.polygon()

    def region(self, sheet: Polygon) -> BaseGeometry:
        """The shape with its rounded corners and all copies, not yet cut off [m].

        Raises:
            PydanticCustomError: too many copies, or nothing is left after rounding.
        """
        import shapely

        shape = rounded(self.drawn(sheet), self.fillet, self.corner_radius)
        if shape.is_empty:
            raise problem(
                "nothing is left of the shape: it is narrower than its corner radius",
                key="corner_radius",
                value=f"{1e3 * self.corner_radius:g} mm",
            )
        moves = [(1.0, 0.0, 0.0, 1.0, 0.0, 0.0)]
        for copies in (self._reflected(), self._in_grid(), self._turned()):
            if copies:
                moves = [_after(copy, move) for copy in copies for move in moves]
            if len(moves) > MAX_COPIES:
                raise problem("has too many copies", key="array", allowed=f"≤ {MAX_COPIES}")
        if len(moves) == 1:
            return shape
        return shapely.union_all([_moved(shape, move) for move in moves])

    def _reflected(self) -> list[Affine]:
        if self.mirror is None:
            return []
        c, s = math.cos(2 * self.mirror.angle), math.sin(2 * self.mirror.angle)
        x, y = self.mirror.point
        return [_IDENTITY, (c, s, s, -c, x - c * x - s * y, y - s * x + c * y)]

    def _in_grid(self) -> list[Affine]:
        array = self.grid_array
        if array is None:
            return []
        if array.columns * array.rows > MAX_COPIES:
            raise problem("has too many copies", key="grid_array", allowed=f"≤ {MAX_COPIES}")
        return [
            (1.0, 0.0, 0.0, 1.0, column * array.dx, row * array.dy)
            for row in range(array.rows)
            for column in range(array.columns)
        ]

    def _turned(self) -> list[Affine]:
        array = self.polar_array
        if array is None:
            return []
        step = 2 * math.pi / array.count if array.step is None else array.step
        x, y = array.centre
        turns = [(math.cos(k * step), math.sin(k * step)) for k in range(array.count)]
        return [(c, -s, s, c, x - c * x + s * y, y - s * x - c * y) for c, s in turns]


Affine = tuple[float, float, float, float, float, float]
"""(a, b, d, e, x, y): x' = a x + b y + x0, y' = d x + e y + y0, as shapely writes it."""

_IDENTITY: Affine = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)


def _after(second: Affine, first: Affine) -> Affine:
    a, b, d, e, x, y = second
    p, q, r, s, u, v = first
    return (
        a * p + b * r,
        a * q + b * s,
        d * p + e * r,
        d * q + e * s,
        a * u + b * v + x,
        d * u + e * v + y,
    )


def _moved(shape: BaseGeometry, move: Affine) -> BaseGeometry:
    from shapely.affinity import affine_transform

    return affine_transform(shape, list(move))
