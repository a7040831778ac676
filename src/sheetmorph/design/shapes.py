"""Flat shapes that serve as the outline of a sheet and as pieces of a pattern alike.

What belongs to outlines alone is in `outlines`, what belongs to pieces alone in `piece`, and the
shapes that only patterns use in `library` and `kirigami`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from sheetmorph.core.errors import InputError
from sheetmorph.core.units import scale_of
from sheetmorph.design.fields import Angle, Point, Section, Size, Whole, problem
from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from shapely import Polygon as ShapelyPolygon
    from shapely.geometry.base import BaseGeometry

MAX_POINTS = 50_000
"""Corners of a shape; a design file of 5 MB has room for them."""
MAX_RINGS = 10_000
CIRCLE_SEGMENTS = 240
"""Sides of the polygon that stands for a circle: chord error 8.6e-5 of the radius."""

ORIGIN = (0.0, 0.0)


class Shape(Section):
    """A flat shape in the plane of the sheet."""

    def polygon(self) -> BaseGeometry:
        """The shape as a shapely polygon [m]; circles as inscribed polygons."""
        raise NotImplementedError


class Disc(Shape):
    """A disc about `centre`."""

    kind: Literal["disc"]
    radius: Size
    centre: Point = ORIGIN

    def polygon(self) -> BaseGeometry:
        """The disc as an inscribed regular polygon [m]."""
        return ellipse(self.centre, self.radius, self.radius, 0.0)


class Ellipse(Shape):
    """An ellipse about `centre` with half-axes along x and y before its rotation."""

    kind: Literal["ellipse"]
    half_width: Size
    half_height: Size
    centre: Point = ORIGIN
    rotation: Angle = 0.0

    def polygon(self) -> BaseGeometry:
        """The ellipse as an inscribed polygon [m]."""
        return ellipse(self.centre, self.half_width, self.half_height, self.rotation)


class Rectangle(Shape):
    """A rectangle about `centre`, turned by `rotation`."""

    kind: Literal["rectangle"]
    width: Size
    height: Size
    centre: Point = ORIGIN
    rotation: Angle = 0.0

    def polygon(self) -> BaseGeometry:
        """The rectangle [m]."""
        x, y = self.width / 2, self.height / 2
        return placed([(-x, -y), (x, -y), (x, y), (-x, y)], self.centre, self.rotation)


class RegularPolygon(Shape):
    """A regular polygon; its first corner lies along `rotation` from the x-axis.

    Attributes:
        radius: from the centre to the corners [m].
    """

    kind: Literal["regular_polygon"]
    sides: Annotated[Whole, Field(ge=3, le=100)]
    radius: Size
    centre: Point = ORIGIN
    rotation: Angle = 0.0

    def polygon(self) -> BaseGeometry:
        """The polygon [m]."""
        angles = [2 * math.pi * k / self.sides for k in range(self.sides)]
        corners = [(self.radius * math.cos(a), self.radius * math.sin(a)) for a in angles]
        return placed(corners, self.centre, self.rotation)


class Polygon(Shape):
    """A polygon by its corners, with holes if wanted.

    With `unit` the coordinates are plain numbers in that unit, as in
    `unit = "mm"` and `points = [[0, 0], [50, 0], [50, 30]]`.
    """

    kind: Literal["polygon"]
    unit: str | None = None
    points: Annotated[tuple[Point, ...], Field(min_length=3, max_length=MAX_POINTS)]
    holes: Annotated[
        tuple[Annotated[tuple[Point, ...], Field(min_length=3, max_length=MAX_POINTS)], ...],
        Field(max_length=MAX_RINGS),
    ] = ()

    @model_validator(mode="before")
    @classmethod
    def _apply_unit(cls, data: Any) -> Any:
        return in_unit(data, ("points", "holes"))

    @model_validator(mode="after")
    def _is_simple(self) -> Self:

        if len(self.points) + sum(map(len, self.holes)) > MAX_POINTS:
            raise problem("has too many corners", key="points", allowed=f"≤ {MAX_POINTS}")
        _check_simple(self.polygon(), "points")
        return self

    def polygon(self) -> BaseGeometry:
        """The polygon with its holes [m]."""
        import shapely

        return shapely.Polygon(self.points, self.holes)


Ring = Annotated[tuple[Point, ...], Field(min_length=3, max_length=MAX_POINTS)]


class Polygons(Shape):
    """Several polygons, each a list of rings: its boundary, then its holes.

    With `unit` the coordinates are plain numbers in that unit, as for `polygon`.
    """

    kind: Literal["polygons"]
    unit: str | None = None
    polygons: Annotated[
        tuple[Annotated[tuple[Ring, ...], Field(min_length=1, max_length=MAX_RINGS)], ...],
        Field(min_length=1, max_length=MAX_RINGS),
    ]

    @model_validator(mode="before")
    @classmethod
    def _apply_unit(cls, data: Any) -> Any:
        return in_unit(data, ("polygons",))

    @model_validator(mode="after")
    def _are_simple(self) -> Self:
        if sum(len(ring) for rings in self.polygons for ring in rings) > MAX_POINTS:
            raise problem("has too many corners", key="polygons", allowed=f"≤ {MAX_POINTS}")
        _check_simple(self.polygon(), "polygons")
        return self

    def polygon(self) -> BaseGeometry:
        """The polygons with their holes [m]."""
        import shapely

        parts = [shapely.Polygon(rings[0], rings[1:]) for rings in self.polygons]
        return parts[0] if len(parts) == 1 else shapely.MultiPolygon(parts)


def in_unit(data: Any, keys: tuple[str, ...]) -> Any:
    """A table whose plain numbers below some keys have got the unit that its `unit` names.

    Raises:
        PydanticCustomError: `unit` is no unit of length.
    """
    if not isinstance(data, dict) or data.get("unit") is None:
        return data
    if "file" in data and not any(key in data for key in keys):
        return data  # the unit is that of a drawing, which knows more of them
    try:
        scale_of(data["unit"], "length")
    except InputError as error:
        raise problem(error.message, key="unit", value=error.value) from None
    suffix = f" {data['unit']}"
    return {**data, **{key: _with_unit(data[key], suffix) for key in keys if key in data}}


def placed(
    corners: Sequence[tuple[float, float]] | Floats,
    centre: tuple[float, float],
    rotation: float,
) -> ShapelyPolygon:
    """The polygon with these corners, turned about the origin and then moved to `centre` [m]."""
    import shapely

    c, s = math.cos(rotation), math.sin(rotation)
    x, y = np.asarray(corners, dtype=np.float64).T
    moved = np.column_stack([centre[0] + c * x - s * y, centre[1] + s * x + c * y])
    polygon: ShapelyPolygon = shapely.polygons(moved)
    return polygon


def ellipse(
    centre: tuple[float, float], half_width: float, half_height: float, rotation: float
) -> ShapelyPolygon:
    """An inscribed polygon of an ellipse [m], see `CIRCLE_SEGMENTS`."""
    return placed(_circle() * np.array([half_width, half_height]), centre, rotation)


@cache
def _circle() -> Floats:
    """Corners of the polygon that stands for a circle of radius 1."""
    angles = [2 * math.pi * k / CIRCLE_SEGMENTS for k in range(CIRCLE_SEGMENTS)]
    return np.array([(math.cos(a), math.sin(a)) for a in angles])


def rounded(shape: BaseGeometry, inner: float, outer: float) -> BaseGeometry:
    """A shape with rounded corners.

    Args:
        shape: polygon or polygons [m].
        inner: radius of its re-entrant corners [m]: the shape closed by a disc.
        outer: radius of its salient corners [m]: the shape opened by a disc.
    """
    import shapely

    if inner:
        closed = _offset(_offset(shape, inner), -inner)
        shape = shapely.union(shape, _specks_off(shapely.difference(closed, shape), inner))
    if outer:
        opened = _offset(_offset(shape, -outer), outer)
        shape = shapely.difference(shape, _specks_off(shapely.difference(shape, opened), outer))
    return shape


def _offset(shape: BaseGeometry, distance: float) -> BaseGeometry:
    import shapely

    return shapely.buffer(shape, distance, quad_segs=CIRCLE_SEGMENTS // 4)


def _specks_off(shape: BaseGeometry, radius: float) -> BaseGeometry:
    """A shape without the parts that are but the noise of offsetting by a radius and back."""
    import shapely

    parts = [part for part in shapely.get_parts(shape) if part.area > 1e-5 * radius**2]
    return shapely.union_all(parts)


def _with_unit(value: Any, suffix: str) -> Any:
    """Nested lists of plain numbers, each with a unit behind it."""
    if isinstance(value, list | tuple):
        return [_with_unit(item, suffix) for item in value]
    if isinstance(value, int | float) and not isinstance(value, bool):
        return f"{value!r}{suffix}"
    return value


def _check_simple(shape: BaseGeometry, key: str) -> None:
    import shapely

    if not shapely.is_valid(shape):
        reason = shapely.is_valid_reason(shape)
        raise problem(
            f"the polygon is not simple ({_in_millimetres(reason)})",
            key=key,
            allowed="a closed line that does not cross or touch itself, holes inside it",
        )
    if shape.area < 1e-12:
        raise problem("the polygon has no area", key=key)


def _in_millimetres(reason: str) -> str:
    """`Self-intersection[0.05 0.02]` as `self-intersection at (50, 20) mm`."""
    what, _, where = reason.rstrip("]").partition("[")
    try:
        x, y = (1e3 * float(number) for number in where.split())
    except ValueError:
        return what.lower()
    return f"{what.lower()} at ({x:.4g}, {y:.4g}) mm"
