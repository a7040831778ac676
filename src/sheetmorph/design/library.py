"""The library of parametric patterns: each is one small class with its own `kind`.

A new one is a `Piece` with its `polygon()`, or with `drawn(sheet)` if it fills the sheet, and its
name in the union `PatternShape` in `outlines`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator

from sheetmorph.design.fields import Angle, Point, Quantity, Size, Whole, problem
from sheetmorph.design.piece import Piece
from sheetmorph.design.shapes import ORIGIN, ellipse, placed

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry


class Bar(Piece):
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
        return placed(corners, self.start, math.atan2(dy, dx))


class Star(Piece):
    """Equal straight arms that radiate from `centre`, and a hub disc.

    The first arm points along `rotation` from the x-axis; four arms make a cross.
    """

    kind: Literal["star"]
    arms: Annotated[Whole, Field(ge=1, le=60)]
    arm_length: Size
    half_width: Size
    hub_radius: Annotated[float, Quantity("length", "0 mm", "10 m")] = 0.0
    centre: Point = ORIGIN
    rotation: Angle = 0.0

    def polygon(self) -> BaseGeometry:
        """The union of the arms and the hub [m]."""
        import shapely

        length, w = self.arm_length, self.half_width
        corners = [(0.0, -w), (length, -w), (length, w), (0.0, w)]
        turn = 2 * math.pi / self.arms
        parts = [placed(corners, self.centre, self.rotation + k * turn) for k in range(self.arms)]
        if self.hub_radius > 0:
            parts.append(ellipse(self.centre, self.hub_radius, self.hub_radius, 0.0))
        return shapely.union_all(parts)
