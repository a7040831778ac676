"""The outlines a sheet can have, and the shapes a pattern can be drawn with.

Shapes that serve as both come from `shapes`; here they are told what an outline or a piece of a
pattern can have besides: cutouts and slits, or what `piece` lists.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import Field, PrivateAttr, ValidationInfo, model_validator

from sheetmorph.core.errors import InputError
from sheetmorph.design import drawn, kirigami, library, library_fills, library_round, shapes
from sheetmorph.design.fields import Point, problem
from sheetmorph.design.piece import Piece, Radius

if TYPE_CHECKING:
    from shapely import MultiLineString, Polygon

MAX_CUTOUTS = 500
MAX_SLITS = 5000
LEAST_SLIT = 1e-5
"""Shorter slits are points [m]."""

Slit = Annotated[tuple[Point, ...], Field(min_length=2, max_length=shapes.MAX_POINTS)]


class DiscPiece(Piece, shapes.Disc):
    """A disc in the pattern."""


class EllipsePiece(Piece, shapes.Ellipse):
    """An ellipse in the pattern."""


class RectanglePiece(Piece, shapes.Rectangle):
    """A rectangle in the pattern."""


class RegularPolygonPiece(Piece, shapes.RegularPolygon):
    """A regular polygon in the pattern."""


class PolygonPiece(Piece, shapes.Polygon):
    """A free polygon in the pattern."""


class PolygonsPiece(Piece, shapes.Polygons):
    """Several free polygons in the pattern."""


class DrawingPiece(Piece, drawn.Drawing):
    """A drawing in the pattern."""


PatternShape = Annotated[
    library.Star
    | library.TwinStar
    | library.Cross
    | library.Bar
    | library_round.Lotus
    | library_round.Ring
    | library_round.Rings
    | library_round.Spiral
    | library_fills.Stripes
    | library_fills.Grid
    | library_fills.Honeycomb
    | kirigami.RandomPolygons
    | DiscPiece
    | RectanglePiece
    | EllipsePiece
    | RegularPolygonPiece
    | PolygonPiece
    | PolygonsPiece
    | DrawingPiece,
    Field(discriminator="kind"),
]

Cutout = Annotated[
    DiscPiece | RectanglePiece | EllipsePiece | RegularPolygonPiece | PolygonPiece | PolygonsPiece,
    Field(discriminator="kind"),
]


class OutlineShape(shapes.Shape):
    """The outline of a sheet.

    Attributes:
        corner_radius: radius of its corners [m].
        cutouts: shapes cut out of it.
        slits: lines along which it is cut; the mesh opens there [m].
        unit: of the plain numbers in `slits`, and in the `points` of a polygon.
    """

    unit: str | None = None
    corner_radius: Radius = 0.0
    cutouts: Annotated[tuple[Cutout, ...], Field(max_length=MAX_CUTOUTS)] = ()
    slits: Annotated[tuple[Slit, ...], Field(max_length=MAX_SLITS)] = ()

    @model_validator(mode="before")
    @classmethod
    def _units_of_slits(cls, data: Any) -> Any:
        return shapes.in_unit(data, ("slits",))

    @model_validator(mode="after")
    def _slits_have_a_length(self) -> Self:
        if sum(map(len, self.slits)) > shapes.MAX_POINTS:
            raise problem("have too many points", key="slits", allowed=f"≤ {shapes.MAX_POINTS}")
        for index, slit in enumerate(self.slits):
            if sum(math.dist(a, b) for a, b in pairwise(slit)) < LEAST_SLIT:
                x, y = slit[0]
                raise problem(
                    f"has no length, at ({1e3 * x:.4g}, {1e3 * y:.4g}) mm", key=f"slits[{index}]"
                )
        return self

    def sheet(self) -> Polygon:
        """The sheet: the outline with rounded corners, without its cutouts [m].

        Raises:
            PydanticCustomError: a cutout cuts the sheet in two, or leaves nothing of it.
        """
        import shapely

        outline = shapes.rounded(self.polygon(), self.corner_radius, self.corner_radius)
        if isinstance(outline, shapely.MultiPolygon) and len(outline.geoms) == 1:
            outline = outline.geoms[0]
        if not isinstance(outline, shapely.Polygon) or outline.is_empty:
            raise problem(
                "the outline is not one piece",
                key="corner_radius" if self.corner_radius else "",
                allowed="one closed contour, holes inside it",
            )
        for index, cutout in enumerate(self.cutouts):
            rest = shapely.difference(outline, cutout.region(outline))
            if not isinstance(rest, shapely.Polygon) or rest.is_empty:
                raise problem("cuts the sheet into pieces", key=f"cutouts[{index}]")
            if rest.area > (1 - 1e-9) * outline.area:
                raise problem("cuts nothing out of the sheet", key=f"cutouts[{index}]")
            outline = rest
        return outline

    def joins(self) -> float:
        """Ends of slits closer to the rim than this are drawn to it [m]."""
        return 0.0

    def cuts(self) -> MultiLineString:
        """The slits [m]; empty without any."""
        import shapely

        return shapely.MultiLineString([list(slit) for slit in self.slits])


class DiscOutline(OutlineShape, shapes.Disc):
    """A round sheet."""


class EllipseOutline(OutlineShape, shapes.Ellipse):
    """An elliptic sheet."""


class RectangleOutline(OutlineShape, shapes.Rectangle):
    """A rectangular sheet."""


class RegularPolygonOutline(OutlineShape, shapes.RegularPolygon):
    """A sheet in the form of a regular polygon."""


class PolygonOutline(OutlineShape, shapes.Polygon):
    """A sheet of any form."""


class DrawingOutline(OutlineShape, drawn.Drawing):
    """A sheet whose outline stands in a drawing.

    Attributes:
        slit_select: layer, id, label, class or colour of the lines to slit.
    """

    slit_select: drawn.Selection | None = None

    _slits: Any = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _read_slits(self, info: ValidationInfo) -> Self:
        if self.slit_select is not None:
            try:
                self._slits = self._open(info).lines(self.slit_select)
            except InputError as error:
                raise drawn.told(error, self.file, "slit_select") from None
        return self

    def wkb(self) -> bytes:
        """What the drawing shows, slits included, as bytes that only change with it."""
        import shapely

        cuts: bytes = shapely.to_wkb(self.cuts(), byte_order=1)
        return super().wkb() + cuts

    def joins(self) -> float:
        """Ends of slits closer to the rim than this are drawn to it [m]: the drawing's gap."""
        return self.gap

    def cuts(self) -> MultiLineString:
        """The slits of the drawing and those of the design file [m]."""
        import shapely

        written = super().cuts()
        if self._slits is None:
            return written
        return shapely.MultiLineString([*shapely.get_parts(self._slits), *written.geoms])


Outline = Annotated[
    DiscOutline
    | RectangleOutline
    | EllipseOutline
    | RegularPolygonOutline
    | PolygonOutline
    | DrawingOutline,
    Field(discriminator="kind"),
]
