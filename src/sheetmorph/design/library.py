"""The library of parametric patterns: each is one small class with its own `kind`.

Here are those of straight arms; round ones are in `library_round`, those that fill the sheet in
`library_fills`, random ones in `kirigami`. A new one is a `Piece` with its `polygon()`, or with
`drawn(sheet)` if it fills the sheet, and its name in the union `PatternShape` in `outlines`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator

from sheetmorph.design.fields import Angle, Point, Quantity, Size, Whole, problem
from sheetmorph.design.library_tools import bar, tidy, turned
from sheetmorph.design.piece import Piece
from sheetmorph.design.shapes import ORIGIN, ellipse

if TYPE_CHECKING:
    from shapely import Polygon
    from shapely.geometry.base import BaseGeometry

MAX_ARMS = 60


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
        return bar(self.start, self.end, self.half_width)


class Star(Piece):
    """Equal straight arms that radiate from `centre`, and a hub disc.

    Attributes:
        arms: how many; four make a cross.
        arm_length: from the centre to the end of an arm [m].
        half_width: of an arm [m].
        hub_radius: of the disc in the middle [m]; 0 for none.
        tip: whether an arm ends square or in a half circle.
        centre: where the arms meet [m].
        rotation: direction of the first arm, from the x-axis.
    """

    kind: Literal["star"]
    arms: Annotated[Whole, Field(ge=1, le=MAX_ARMS)]
    arm_length: Size
    half_width: Size
    hub_radius: Annotated[float, Quantity("length", "0 mm", "10 m")] = 0.0
    tip: Literal["square", "round"] = "square"
    centre: Point = ORIGIN
    rotation: Angle = 0.0

    @model_validator(mode="after")
    def _round_tips_fit(self) -> Self:
        if self.tip == "round" and self.arm_length <= self.half_width:
            raise problem(
                "is too short for a round tip",
                key="arm_length",
                value=f"{1e3 * self.arm_length:g} mm",
                allowed=f"above half_width, {1e3 * self.half_width:g} mm",
            )
        return self

    def polygon(self) -> BaseGeometry:
        """The union of the arms and the hub [m]."""
        import shapely

        w = self.half_width
        straight = self.arm_length - (w if self.tip == "round" else 0.0)
        parts = _arms(self.arms, straight, w, self.centre, self.rotation)
        if self.tip == "round":
            for k in range(self.arms):
                angle = self.rotation + 2 * math.pi * k / self.arms
                parts.append(ellipse(_along(self.centre, angle, straight), w, w, angle))
        if self.hub_radius > 0:
            parts.append(ellipse(self.centre, self.hub_radius, self.hub_radius, 0.0))
        return tidy(shapely.union_all(parts))


class TwinStar(Piece):
    """Two equal stars joined by a spine, as in the canoe of the paper.

    Attributes:
        arms: of each star.
        arm_length: from the centre of a star to the end of an arm [m].
        half_width: of an arm [m].
        spacing: distance of the two centres [m].
        spine_half_width: of the bar between the centres [m]; `half_width` by default.
        hub_radius: of the disc in the middle of each star [m]; 0 for none.
        centre: middle of the spine [m].
        rotation: direction of the spine and of the first arm of each star, from the x-axis.
    """

    kind: Literal["twin_star"]
    arms: Annotated[Whole, Field(ge=1, le=MAX_ARMS)] = 6
    arm_length: Size
    half_width: Size
    spacing: Size
    spine_half_width: Size | None = None
    hub_radius: Annotated[float, Quantity("length", "0 mm", "10 m")] = 0.0
    centre: Point = ORIGIN
    rotation: Angle = 0.0

    def polygon(self) -> BaseGeometry:
        """The union of both stars and the spine [m]."""
        import shapely

        ends = [_along(self.centre, self.rotation, side * self.spacing / 2) for side in (-1.0, 1.0)]
        w = self.half_width
        parts = [bar(ends[0], ends[1], self.spine_half_width or w)]
        for end in ends:
            parts += _arms(self.arms, self.arm_length, w, end, self.rotation)
            if self.hub_radius > 0:
                parts.append(ellipse(end, self.hub_radius, self.hub_radius, 0.0))
        return tidy(shapely.union_all(parts))


class Cross(Piece):
    r"""Straight arms, each with a right-angled triangle added at its end.

    The triangle is isosceles, its right angle is the tip of the arm and its long side, of length
    2·`chamfer`, crosses the end of the arm. So a tip lies `arm_length` + `chamfer` from the
    centre, and its sides run along those of a square sheet whose corner it fills. A chamfer equal
    to the half-width makes a pointed arm, a larger one an arrowhead.

    This is our reading of design C of the paper: arms that "extend 56.7 mm from the center",
    "spanning 99.99 mm along the principal diagonal", "chamfered at its end via the addition of a
    right-angled triangle". Both numbers hold when the straight arm is 56.7 mm long and the tips of
    neighbouring arms are 99.99 mm apart: (56.7 mm + 14.00 mm)·√2 = 99.99 mm. The tips then lie
    70.70 mm from the centre, which is the arm length of the released data. The text could also
    mean tips at 56.7 mm; then nothing in it measures 99.99 mm.

    Attributes:
        arms: how many.
        arm_length: of the straight arm, from the centre to its triangle [m].
        half_width: of an arm [m].
        chamfer: height of the triangle [m]; `half_width` by default.
        centre: where the arms meet [m].
        rotation: direction of the first arm, from the x-axis.
    """

    kind: Literal["cross"]
    arms: Annotated[Whole, Field(ge=2, le=MAX_ARMS)] = 4
    arm_length: Size
    half_width: Size
    chamfer: Size | None = None
    centre: Point = ORIGIN
    rotation: Angle = math.pi / 4

    @model_validator(mode="after")
    def _covers_the_end(self) -> Self:
        if self.chamfer is not None and self.chamfer < self.half_width:
            raise problem(
                "the triangle is narrower than the arm",
                key="chamfer",
                value=f"{1e3 * self.chamfer:g} mm",
                allowed=f"≥ half_width, {1e3 * self.half_width:g} mm",
            )
        return self

    def polygon(self) -> BaseGeometry:
        """The union of the arms with their triangles [m]."""
        import shapely

        length, w = self.arm_length, self.half_width
        c = self.chamfer or w
        arm = [(0.0, -w), (length, -w), (length, -c), (length + c, 0.0)]
        corners = [*arm, (length, c), (length, w), (0.0, w)]
        return tidy(shapely.union_all(turned(corners, self.centre, self.rotation, self.arms)))


def _arms(
    count: int, length: float, w: float, centre: tuple[float, float], rotation: float
) -> list[Polygon]:
    corners = [(0.0, -w), (length, -w), (length, w), (0.0, w)]
    return turned(corners, centre, rotation, count)


def _along(start: tuple[float, float], angle: float, distance: float) -> tuple[float, float]:
    return start[0] + distance * math.cos(angle), start[1] + distance * math.sin(angle)
