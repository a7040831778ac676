"""The plan of a sheet: its outline, its slits and the parts of its pattern, as drawn."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal

from pydantic_core import PydanticCustomError

from sheetmorph.design.fields import PROBLEM, problem
from sheetmorph.design.sections import EVERYWHERE

if TYPE_CHECKING:
    from shapely import MultiLineString, MultiPolygon, Polygon
    from shapely.geometry.base import BaseGeometry

    from sheetmorph.design.outlines import OutlineShape
    from sheetmorph.design.piece import Piece
    from sheetmorph.design.schema import DesignSchema

MAX_VERTICES = 100_000
NOTED = 1e-5
"""Slits may reach past the sheet by this length without a note [m]."""
EDGE_TOLERANCE = 2e-4
"""How far a pattern may reach past the sheet, as a fraction of the sheet's diagonal."""


@dataclass(frozen=True, eq=False)
class Layout:
    """The plan of a sheet.

    Attributes:
        sheet: the sheet with its holes [m], circles as inscribed polygons.
        slits: lines along which it is cut [m].
        drawn: each part of the pattern as it is drawn [m], not cut off at the rim of the sheet:
            nodes of a curved rim lie a little outside the polygon that stands for it, and
            still belong to the part.
        notes: what was cut off, in sentences with coordinates.
    """

    sheet: Polygon
    slits: MultiLineString
    drawn: Mapping[str, MultiPolygon]
    notes: tuple[str, ...] = ()

    @cached_property
    def parts(self) -> Mapping[str, MultiPolygon]:
        """Each part of the pattern within the sheet [m]."""
        import shapely

        return {
            name: polygons(shapely.intersection(self.sheet, part))
            for name, part in self.drawn.items()
        }

    @cached_property
    def pattern(self) -> MultiPolygon:
        """The union of all parts within the sheet [m]; empty without a pattern."""
        import shapely

        return polygons(shapely.union_all(list(self.parts.values())))


def lay_out(outline: OutlineShape, pattern: Iterable[Piece]) -> Layout:
    """Draw the pieces one after the other, and check that they fit the sheet.

    Raises:
        PydanticCustomError: a problem for people, with the key of the table that has it.
    """
    import shapely

    with _below("outline"):
        sheet = outline.sheet()
    low_x, low_y, high_x, high_y = sheet.bounds
    reach = EDGE_TOLERANCE * math.hypot(high_x - low_x, high_y - low_y)
    with _below("outline"):
        slits, notes = _to_the_rim(outline.cuts(), sheet, max(reach, outline.joins()))
        slits, more = _within(slits, sheet)
        notes += more
    grown = sheet.buffer(reach, join_style="mitre")
    shapely.prepare(grown)
    drawn: dict[str, BaseGeometry] = {}
    for index, piece in enumerate(pattern):
        key = f"pattern[{index}]"
        with _below(key):
            region = piece.region(sheet)
        if piece.operation == "union":
            _check_place(region, piece.clip, sheet, grown, key)
            notes += _lost(region, sheet, key)
        before = drawn.get(piece.part)
        if before is None and piece.operation != "union":
            raise problem(
                f"the part {piece.part} has nothing yet from which to take; "
                "put a shape to join before it",
                key=f"{key}.operation",
                value=piece.operation,
                allowed="union",
            )
        if before is None:
            drawn[piece.part] = region
        else:
            drawn[piece.part] = getattr(shapely, piece.operation)(before, region)
        if drawn[piece.part].area < 1e-12:
            raise problem(f"nothing is left of the part {piece.part}", key=key)
        if shapely.get_num_coordinates(drawn[piece.part]) > MAX_VERTICES:
            raise problem("has too many corners", key=key, allowed=f"≤ {MAX_VERTICES}")
    layout = Layout(
        sheet, slits, {name: polygons(shape) for name, shape in drawn.items()}, tuple(notes)
    )
    if layout.pattern.area > 0.999 * sheet.area:
        raise problem("covers the whole sheet, so nothing is free to shrink", key="pattern")
    return layout


def joined(pieces: Iterable[Piece], regions: Iterable[BaseGeometry]) -> dict[str, MultiPolygon]:
    """The parts that pieces with these regions make, as `lay_out` draws them [m]; unchecked."""
    import shapely

    drawn: dict[str, BaseGeometry] = {}
    for piece, region in zip(pieces, regions, strict=True):
        before = drawn.get(piece.part)
        join = getattr(shapely, piece.operation)
        drawn[piece.part] = region if before is None else join(before, region)
    return {name: polygons(shape) for name, shape in drawn.items()}


def polygons(shape: BaseGeometry) -> MultiPolygon:
    """The parts of a shape that have an area, as one object."""
    import shapely

    parts = shapely.get_parts(shape)
    return shapely.MultiPolygon(
        [part for part in parts if isinstance(part, shapely.Polygon) and part.area > 0]
    )


def _to_the_rim(
    slits: MultiLineString, sheet: Polygon, reach: float
) -> tuple[MultiLineString, list[str]]:
    """The slits with ends that fall short of the rim by no more than `reach` [m] moved onto it."""
    import shapely

    rim, lines, notes = sheet.boundary, [], []
    for line in slits.geoms:
        points = list(line.coords)
        for end in (0, -1) if points[0] != points[-1] else ():
            tip = shapely.Point(points[end])
            short = rim.distance(tip)
            if 0.0 < short <= reach and sheet.contains(tip):
                foot = rim.interpolate(rim.project(tip))
                points[end] = (foot.x, foot.y)
                if short > NOTED:
                    notes.append(
                        f"outline.slits: an end {1e3 * short:.3g} mm short of the edge of the "
                        f"sheet is drawn to it, near {place(foot.x, foot.y)}"
                    )
        lines.append(points)
    return shapely.MultiLineString(lines), notes


def _within(slits: MultiLineString, sheet: Polygon) -> tuple[MultiLineString, list[str]]:
    """The slits as far as they lie on the sheet, and a note on what was cut off."""
    import shapely

    if slits.is_empty or sheet.covers(slits):
        return slits, []
    outside = shapely.difference(slits, sheet)
    rest = [
        line
        for line in shapely.get_parts(shapely.line_merge(shapely.intersection(slits, sheet)))
        if isinstance(line, shapely.LineString)
    ]
    if not rest:
        raise problem("lie outside the sheet", key="slits")
    if outside.length < NOTED:
        return shapely.MultiLineString(rest), []
    at = shapely.get_parts(outside)[0].interpolate(0.5, normalized=True)
    note = (
        f"outline.slits: {1e3 * outside.length:.3g} mm past the edge of the sheet are cut off, "
        f"near {place(at.x, at.y)}"
    )
    return shapely.MultiLineString(rest), [note]


def _lost(region: BaseGeometry, sheet: Polygon, key: str) -> list[str]:
    """A note on the pieces of a shape that lie beside the sheet altogether."""
    import shapely

    away = [piece for piece in shapely.get_parts(region) if not piece.intersects(sheet)]
    if not away:
        return []
    at, area = away[0].representative_point(), sum(piece.area for piece in away)
    what = "1 piece" if len(away) == 1 else f"{len(away)} pieces"
    near = place(at.x, at.y)
    return [f"{key}: {what} of {1e6 * area:.3g} mm² beside the sheet left out, near {near}"]


def place(x: float, y: float) -> str:
    """A place in the plan, for people."""
    return f"({1e3 * x:.4g}, {1e3 * y:.4g}) mm"


def _check_place(
    region: BaseGeometry, clip: bool, sheet: Polygon, grown: BaseGeometry, key: str
) -> None:
    import shapely

    if not region.intersects(sheet) or region.intersection(sheet).area < 1e-12:
        at = region.representative_point()
        raise problem(f"lies outside the sheet, near {place(at.x, at.y)}", key=key)
    if not clip and not grown.covers(region):
        excess = shapely.hausdorff_distance(shapely.union(region, sheet), sheet)
        raise problem(
            f"reaches {1e3 * excess:.3g} mm past the edge of the sheet",
            key=key,
            allowed="a shape inside the outline, or clip = true to cut it off there",
        )


@contextmanager
def _below(key: str) -> Iterator[None]:
    """Problems within are told as those of the table `key`."""
    try:
        yield
    except PydanticCustomError as error:
        told = error.context
        if error.type != PROBLEM or told is None:
            raise
        inner = f"{key}.{told['key']}" if told["key"] else key
        raise problem(
            told["text"], key=inner, value=told["value"], allowed=told["allowed"]
        ) from None


@dataclass(frozen=True, eq=False)
class InertPart:
    """One inert layer of a part of the pattern: a thing to make and to glue on.

    Attributes:
        name: of the layer.
        part: of the pattern in which it lies.
        region: its plan [m], within the sheet.
        thickness: [m].
        density: [kg/m³].
        face: "top" when it lies above the active film, "bottom" when it lies below.
    """

    name: str
    part: str
    region: MultiPolygon
    thickness: float
    density: float
    face: Literal["top", "bottom"]


def find_inert_parts(design: DesignSchema) -> tuple[InertPart, ...]:
    """The inert layers of the parts of the pattern, in the order of the layers."""
    active = [k for k, layer in enumerate(design.layers) if layer.role == "active"]
    first = active[0] if active else 0
    return tuple(
        InertPart(
            layer.name,
            layer.where,
            design.layout.parts[layer.where],
            layer.thickness,
            layer.density,
            "bottom" if index < first else "top",
        )
        for index, layer in enumerate(design.layers)
        if layer.where != EVERYWHERE and layer.role == "inert"
    )
