"""Flat shapes: the outline of the sheet and the pieces of its pattern.

A new shape is one small class with its own `kind` and a `polygon()`, and its name in the
union `Outline` or `PatternShape` below.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from sheetmorph.core.errors import InputError
from sheetmorph.core.units import scale_of
from sheetmorph.design.fields import (
    Angle,
    Flag,
    Point,
    Quantity,
    Section,
    Size,
    Whole,
    problem,
)

if TYPE_CHECKING:
    from shapely import Polygon as ShapelyPolygon
    from shapely.geometry.base import BaseGeometry

MAX_POINTS = 10_000
CIRCLE_SEGMENTS = 240
"""Sides of the polygon that stands for a circle: chord error 8.6e-5 of the radius."""

_ORIGIN = (0.0, 0.0)


class Shape(Section):
    """A flat shape in the plane of the sheet."""

    clip: Flag = False

    def polygon(self) -> BaseGeometry:
        """The shape as a shapely polygon [m]; circles as inscribed polygons."""
        raise NotImplementedError


class Disc(Shape):
    """A disc about `centre`."""

    kind: Literal["disc"]
    radius: Size
    centre: Point = _ORIGIN

    def polygon(self) -> BaseGeometry:
        """The disc as an inscribed regular polygon [m]."""
        return _ellipse(self.centre, self.radius, self.radius, 0.0)


class Ellipse(Shape):
    """An ellipse about `centre` with half-axes along x and y before its rotation."""

    kind: Literal["ellipse"]
    half_width: Size
    half_height: Size
    centre: Point = _ORIGIN
    rotation: Angle = 0.0

    def polygon(self) -> BaseGeometry:
        """The ellipse as an inscribed polygon [m]."""
        return _ellipse(self.centre, self.half_width, self.half_height, self.rotation)


class Rectangle(Shape):
    """A rectangle about `centre`, turned by `rotation`."""

    kind: Literal["rectangle"]
    width: Size
    height: Size
    centre: Point = _ORIGIN
    rotation: Angle = 0.0

    def polygon(self) -> BaseGeometry:
        """The rectangle [m]."""
        x, y = self.width / 2, self.height / 2
        return _placed([(-x, -y), (x, -y), (x, y), (-x, y)], self.centre, self.rotation)


class Bar(Shape):
    """A straight bar from `start` to `end` with square ends."""

    kind: Literal["bar"]
    start: Point
    end: Point
    half_width: Size

    @model_validator(mode="after")
    def _has_length(self) -> Self:
        if math.dist(self.start, self.end) < 1e-6:
            raise problem("the bar has no length: end is the same point as start", key="end")
        return self

    def polygon(self) -> BaseGeometry:
        """The bar as a rectangle [m]."""
        dx, dy = self.end[0] - self.start[0], self.end[1] - self.start[1]
        length, w = math.hypot(dx, dy), self.half_width
        corners = [(0.0, -w), (length, -w), (length, w), (0.0, w)]
        return _placed(corners, self.start, math.atan2(dy, dx))


class Star(Shape):
    """Equal straight arms that radiate from `centre`, and a hub disc.

    The first arm points along `rotation` from the x-axis; four arms make a cross.
    """

    kind: Literal["star"]
    arms: Annotated[Whole, Field(ge=1, le=60)]
    arm_length: Size
    half_width: Size
    hub_radius: Annotated[float, Quantity("length", "0 mm", "10 m")] = 0.0
    centre: Point = _ORIGIN
    rotation: Angle = 0.0

    def polygon(self) -> BaseGeometry:
        """The union of the arms and the hub [m]."""
        import shapely

        length, w = self.arm_length, self.half_width
        corners = [(0.0, -w), (length, -w), (length, w), (0.0, w)]
        turn = 2 * math.pi / self.arms
        parts = [_placed(corners, self.centre, self.rotation + k * turn) for k in range(self.arms)]
        if self.hub_radius > 0:
            parts.append(_ellipse(self.centre, self.hub_radius, self.hub_radius, 0.0))
        return shapely.union_all(parts)


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
        Field(max_length=200),
    ] = ()

    @model_validator(mode="before")
    @classmethod
    def _apply_unit(cls, data: Any) -> Any:
        if not isinstance(data, dict) or data.get("unit") is None:
            return data
        try:
            scale_of(data["unit"], "length")
        except InputError as error:
            raise problem(error.message, key="unit", value=error.value) from None
        suffix = f" {data['unit']}"
        given = {key: _with_unit(data[key], suffix) for key in ("points", "holes") if key in data}
        return {**data, **given}

    @model_validator(mode="after")
    def _is_simple(self) -> Self:
        import shapely

        if len(self.points) + sum(map(len, self.holes)) > MAX_POINTS:
            raise problem("has too many corners", key="points", allowed=f"≤ {MAX_POINTS}")
        shape = self.polygon()
        if not shapely.is_valid(shape):
            reason = shapely.is_valid_reason(shape)
            raise problem(
                f"the polygon is not simple ({_in_millimetres(reason)})",
                key="points",
                allowed="a closed line that does not cross or touch itself, holes inside it",
            )
        if shape.area < 1e-12:
            raise problem("the polygon has no area", key="points")
        return self

    def polygon(self) -> BaseGeometry:
        """The polygon with its holes [m]."""
        import shapely

        return shapely.Polygon(self.points, self.holes)


Outline = Annotated[Disc | Rectangle | Ellipse | Polygon, Field(discriminator="kind")]
PatternShape = Annotated[
    Star | Bar | Disc | Rectangle | Ellipse | Polygon, Field(discriminator="kind")
]


def _placed(
    corners: list[tuple[float, float]], centre: tuple[float, float], rotation: float
) -> ShapelyPolygon:
    import shapely

    c, s = math.cos(rotation), math.sin(rotation)
    return shapely.Polygon(
        [(centre[0] + c * x - s * y, centre[1] + s * x + c * y) for x, y in corners]
    )


def _ellipse(
    centre: tuple[float, float], half_width: float, half_height: float, rotation: float
) -> ShapelyPolygon:
    angles = [2 * math.pi * k / CIRCLE_SEGMENTS for k in range(CIRCLE_SEGMENTS)]
    corners = [(half_width * math.cos(a), half_height * math.sin(a)) for a in angles]
    return _placed(corners, centre, rotation)


def _with_unit(value: Any, suffix: str) -> Any:
    """Nested lists of plain numbers, each with a unit behind it."""
    if isinstance(value, list | tuple):
        return [_with_unit(item, suffix) for item in value]
    if isinstance(value, int | float) and not isinstance(value, bool):
        return f"{value!r}{suffix}"
    return value


def _in_millimetres(reason: str) -> str:
    """`Self-intersection[0.05 0.02]` as `self-intersection at (50, 20) mm`."""
    what, _, where = reason.rstrip("]").partition("[")
    try:
        x, y = (1e3 * float(number) for number in where.split())
    except ValueError:
        return what.lower()
    return f"{what.lower()} at ({x:.4g}, {y:.4g}) mm"
