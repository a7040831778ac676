"""Round patterns of the library: lotus, ring, concentric rings, spiral."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from sheetmorph.design.fields import Angle, Number, Point, Size, Whole, problem
from sheetmorph.design.library_tools import CHORD_ERROR, chord_angle, tidy, turned
from sheetmorph.design.piece import Piece
from sheetmorph.design.shapes import ORIGIN, ellipse

if TYPE_CHECKING:
    from shapely import Polygon
    from shapely.geometry.base import BaseGeometry

MAX_RINGS = 200
MAX_SPOKES = 60
OVERLAP = 1e-3
"""A petal reaches into the disc by at least this fraction of the disc's radius."""


class Lotus(Piece):
    """A disc with equal petals around it.

    Attributes:
        petals: how many.
        disc_radius: of the disc in the middle [m].
        radius: from the centre to the tips of the petals [m].
        petal_length: from the tip of a petal to its other end [m]; `radius` by default, so that
            the petals begin at the centre.
        petal_half_width: half the largest width of a petal [m].
        form: ellipses, or petals pointed at both ends (where two equal circles overlap).
        centre: of the disc [m].
        rotation: direction of the first petal, from the x-axis.
    """

    kind: Literal["lotus"]
    petals: Annotated[Whole, Field(ge=1, le=60)]
    disc_radius: Size
    radius: Size
    petal_length: Size | None = None
    petal_half_width: Size
    form: Literal["ellipse", "pointed"] = "ellipse"
    centre: Point = ORIGIN
    rotation: Angle = 0.0

    @model_validator(mode="after")
    def _petals_fit(self) -> Self:
        length = self.petal_length or self.radius
        if self.radius <= self.disc_radius:
            raise problem(
                "the petals end inside the disc",
                key="radius",
                value=_mm(self.radius),
                allowed=f"above disc_radius, {_mm(self.disc_radius)}",
            )
        least = self.radius - (1 - OVERLAP) * self.disc_radius
        if length < least:
            raise problem(
                "the petals do not reach the disc",
                key="petal_length",
                value=_mm(length),
                allowed=f"≥ {_mm(least)}, or a larger disc_radius",
            )
        if length > self.radius:
            raise problem(
                "the petals reach past the centre",
                key="petal_length",
                value=_mm(length),
                allowed=f"≤ radius, {_mm(self.radius)}",
            )
        if self.petal_half_width > length / 2:
            raise problem(
                "the petals are wider than long",
                key="petal_half_width",
                value=_mm(self.petal_half_width),
                allowed=f"≤ {_mm(length / 2)}",
            )
        return self

    def polygon(self) -> BaseGeometry:
        """The union of the disc and the petals [m]."""
        import shapely

        length = self.petal_length or self.radius
        middle, w = self.radius - length / 2, self.petal_half_width
        if self.form == "ellipse":
            flat = shapely.get_coordinates(ellipse((middle, 0.0), length / 2, w, 0.0))[:-1]
        else:
            flat = _pointed(middle, length / 2, w)
        corners = [(float(x), float(y)) for x, y in flat]
        parts = turned(corners, self.centre, self.rotation, self.petals)
        disc = ellipse(self.centre, self.disc_radius, self.disc_radius, self.rotation)
        return tidy(shapely.union_all([disc, *parts]))


class Ring(Piece):
    """A ring about `centre`.

    Attributes:
        radius: of its outer circle [m].
        width: from the inner to the outer circle [m].
    """

    kind: Literal["ring"]
    radius: Size
    width: Size
    centre: Point = ORIGIN

    @model_validator(mode="after")
    def _has_a_hole(self) -> Self:
        if self.width >= self.radius:
            raise problem(
                "the ring has no hole; use a disc",
                key="width",
                value=_mm(self.width),
                allowed=f"less than radius, {_mm(self.radius)}",
            )
        return self

    def polygon(self) -> BaseGeometry:
        """The ring [m]."""
        return _ring(self.centre, self.radius, self.width)


class Rings(Piece):
    """Concentric rings at equal distances, and spokes that join them.

    Attributes:
        count: of the rings.
        spacing: from one ring to the next [m].
        width: of a ring [m].
        first_radius: outer radius of the innermost ring [m]; `spacing` by default.
        spokes: how many join the rings, from the innermost to the outermost; 0 for none.
        spoke_half_width: [m]; half of `width` by default.
        centre: of the rings [m].
        rotation: direction of the first spoke, from the x-axis.
    """

    kind: Literal["rings"]
    count: Annotated[Whole, Field(ge=1, le=MAX_RINGS)]
    spacing: Size
    width: Size
    first_radius: Size | None = None
    spokes: Annotated[Whole, Field(ge=0, le=MAX_SPOKES)] = 0
    spoke_half_width: Size | None = None
    centre: Point = ORIGIN
    rotation: Angle = 0.0

    @model_validator(mode="after")
    def _rings_are_apart(self) -> Self:
        first = self.first_radius or self.spacing
        for key, limit in (("spacing", self.spacing), ("first_radius", first)):
            if self.width >= limit:
                raise problem(
                    "the rings have no gap between them"
                    if key == "spacing"
                    else "the innermost ring has no hole",
                    key="width",
                    value=_mm(self.width),
                    allowed=f"less than {key}, {_mm(limit)}",
                )
        if self.spokes and self.count == 1:
            raise problem("a single ring needs no spokes", key="spokes", allowed="0")
        return self

    def polygon(self) -> BaseGeometry:
        """The rings and the spokes [m]."""
        import shapely

        first = self.first_radius or self.spacing
        radii = [first + k * self.spacing for k in range(self.count)]
        parts = [_ring(self.centre, radius, self.width) for radius in radii]
        low, high = radii[0] - self.width / 2, radii[-1] - self.width / 2
        w = self.spoke_half_width or self.width / 2
        corners = [(low, -w), (high, -w), (high, w), (low, w)]
        if self.spokes:
            parts += turned(corners, self.centre, self.rotation, self.spokes)
        return tidy(shapely.union_all(parts))


class Spiral(Piece):
    """A ribbon along a spiral of Archimedes, with flat ends, turning to the left.

    Its middle line has the radius `inner_radius` + `pitch`·(angle/360°).

    Attributes:
        turns: how many.
        pitch: from one turn to the next [m].
        half_width: of the ribbon [m].
        inner_radius: where the middle line begins [m]; `pitch` by default.
        centre: of the spiral [m].
        rotation: direction of the inner end as seen from the centre, from the x-axis.
    """

    kind: Literal["spiral"]
    turns: Annotated[Number, Field(ge=0.05, le=50)]
    pitch: Size
    half_width: Size
    inner_radius: Size | None = None
    centre: Point = ORIGIN
    rotation: Angle = 0.0

    @model_validator(mode="after")
    def _turns_are_apart(self) -> Self:
        start = self.inner_radius or self.pitch
        growth = self.pitch / (2 * math.pi)
        if self.turns > 1:
            gap = self.pitch * start / math.hypot(start, growth)
            if 2 * self.half_width >= 0.999 * gap:
                raise problem(
                    "the turns of the spiral have no gap between them",
                    key="half_width",
                    value=_mm(self.half_width),
                    allowed=f"less than half of pitch, {_mm(0.4995 * gap)}",
                )
        square = start**2 + growth**2
        bend = square**1.5 / (square + growth**2)
        if self.half_width > 0.95 * bend:
            raise problem(
                "the spiral is too narrow inside for the width of its ribbon",
                key="inner_radius",
                value=_mm(start),
                allowed=f"≥ about {_mm(1.1 * self.half_width)}, or a smaller half_width",
            )
        return self

    def polygon(self) -> BaseGeometry:
        """The ribbon [m]."""
        import shapely

        start = self.inner_radius or self.pitch
        growth, end = self.pitch / (2 * math.pi), 2 * math.pi * self.turns
        step = chord_angle(start + growth * end + self.half_width)
        angle = np.linspace(0.0, end, max(2, math.ceil(end / step)) + 1)
        radius = start + growth * angle
        turn = angle + self.rotation
        c, s = np.cos(turn), np.sin(turn)
        middle = np.column_stack([radius * c, radius * s]) + self.centre
        across = np.column_stack([growth * s + radius * c, radius * s - growth * c])
        across *= self.half_width / np.hypot(growth, radius)[:, None]
        return tidy(shapely.Polygon(np.concatenate([middle + across, (middle - across)[::-1]])))


def _ring(centre: tuple[float, float], radius: float, width: float) -> Polygon:
    import shapely

    inner = ellipse(centre, radius - width, radius - width, 0.0)
    outer = ellipse(centre, radius, radius, 0.0)
    return shapely.Polygon(outer.exterior.coords, [inner.exterior.coords])


def _pointed(middle: float, half_length: float, w: float) -> list[tuple[float, float]]:
    """Corners of a petal on the x-axis whose two sides are arcs of equal circles."""
    radius = (half_length**2 + w**2) / (2 * w)
    opening = math.asin(min(1.0, half_length / radius))
    count = max(4, math.ceil(2 * opening / math.sqrt(8 * CHORD_ERROR / radius)))
    angles = [opening * (2 * k / count - 1) for k in range(count)]
    upper = [(radius * math.sin(a), radius * (math.cos(a) - 1) + w) for a in angles]
    return [(middle + sign * x, sign * y) for sign in (-1.0, 1.0) for x, y in upper]


def _mm(length: float) -> str:
    return f"{1e3 * length:.4g} mm"
