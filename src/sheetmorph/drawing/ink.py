"""What is written into a drawing: shapes under one name and colour."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.colours import colour_hex
from sheetmorph.drawing.model import Curve, Floats

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

MAX_COORDINATE = 100.0
_NAME = re.compile(r"[^\x00-\x1f<>/\\\":;?*|=`'&,\s][^\x00-\x1f<>/\\\":;?*|=`'&,]{0,79}")


@dataclass(frozen=True)
class Ink:
    """Shapes [m] that are drawn alike: one layer of a DXF, one group of an SVG.

    Attributes:
        name: up to 80 characters that a layer may have.
        shapes: polygons, lines and collections of them; anything else is refused.
        colour: as CSS writes it.

    Raises:
        InputError: the name or the colour cannot be written, or a shape is neither an area
            nor a line.
    """

    name: str
    shapes: tuple[BaseGeometry, ...]
    colour: str = "#e01b24"

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name) or self.name != self.name.strip():
            raise InputError(
                "no name for a layer",
                value=self.name,
                allowed="1 to 80 characters without < > / \\ \" ' : ; ? * | = ` & or commas",
            )
        if not colour_hex(self.colour):
            raise InputError("no such colour", key=self.name, value=self.colour, allowed="#rrggbb")
        for shape in self.shapes:
            for part in parts_of(shape):
                if part.geom_type not in ("Polygon", "LineString", "LinearRing"):
                    raise InputError(
                        "only areas and lines can be drawn", key=self.name, value=part.geom_type
                    )
            box = np.array(shape.bounds)
            if not shape.is_empty and not (np.abs(box) <= MAX_COORDINATE).all():
                raise InputError(
                    "a shape lies out of bounds", key=self.name, allowed="within 100 m"
                )

    @property
    def outlines(self) -> Iterator[list[Curve]]:
        """The rings of each polygon, outer first, and each line by itself [m]."""
        for shape in self.shapes:
            for part in parts_of(shape):
                if part.is_empty:
                    continue
                if part.geom_type == "Polygon":
                    rings = (part.exterior, *part.interiors)
                    yield [Curve(_points(ring)[:-1], True) for ring in rings]
                elif part.is_ring:
                    yield [Curve(_points(part)[:-1], True)]
                else:
                    yield [Curve(_points(part), False)]


def parts_of(shape: BaseGeometry) -> list[BaseGeometry]:
    """The simple geometries of a shape, collections within collections unfolded."""
    parts = [shape]
    while any(hasattr(part, "geoms") for part in parts):
        parts = [inner for part in parts for inner in getattr(part, "geoms", [part])]
    return parts


def check_names(inks: Sequence[Ink]) -> None:
    """Refuse two inks of one name, which no layer could tell apart.

    Raises:
        InputError: names the first that comes twice.
    """
    seen: set[str] = set()
    for ink in inks:
        if ink.name.casefold() in seen:
            raise InputError("two inks have the same name", value=ink.name)
        seen.add(ink.name.casefold())


def _points(line: BaseGeometry) -> Floats:
    import shapely

    return np.asarray(shapely.get_coordinates(line), dtype=np.float64)
