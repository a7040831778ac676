"""Lines to cut: contours moved by half the kerf, and marks by which drawings are laid together."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.fabricate.names import distinct

if TYPE_CHECKING:
    from shapely import MultiLineString, MultiPolygon, Polygon
    from shapely.geometry.base import BaseGeometry

    from sheetmorph.design.spec import Design
    from sheetmorph.drawing.ink import Ink

MARK_DISTANCE = 10e-3
"""From the sheet's bounding box to the centres of the registration marks [m]."""

MARK_SIZE = 5e-3
"""Length of the arms of a registration mark, tip to tip [m]."""

SLITS, HOLES, SHEET, MARKS, STOCK = "SLITS", "HOLES", "SHEET", "MARKS", "STOCK"
COLOURS = {
    SLITS: "#00a000",
    HOLES: "#0000ff",
    SHEET: "#ff0000",
    MARKS: "#808080",
    STOCK: "#c0c0c0",
}
_PART_COLOURS = ("#ff0000", "#0000ff", "#00a000", "#ff8000", "#a000a0", "#008080")


def cut_region(region: BaseGeometry, kerf: float, name: str) -> MultiPolygon:
    """What the middle of the cut must run around, so that `region` is left.

    Outer contours lie half a kerf outside, holes half a kerf smaller. Corners stay sharp.

    Args:
        region: polygons [m].
        kerf: width of what the cutter takes away [m].
        name: of the region, for messages.

    Raises:
        InputError: a hole is narrower than the kerf, or two pieces are closer than it.
    """
    import shapely

    parts = shapely.MultiPolygon(list(shapely.get_parts(region)))
    if not kerf:
        return parts
    grown = parts.buffer(0.5 * kerf, join_style="mitre", mitre_limit=5.0)
    cut = shapely.MultiPolygon(list(shapely.get_parts(grown)))
    holes = [shapely.Polygon(ring) for part in parts.geoms for ring in part.interiors]
    lost = [hole for hole in holes if hole.buffer(-0.5 * kerf, join_style="mitre").is_empty]
    if lost:
        raise InputError(
            f"the hole of {name} at {_at(lost[0])} is narrower than the kerf and cannot be cut; "
            "make the hole wider or the kerf smaller",
            key="kerf",
            value=f"{1e3 * kerf:g} mm",
        )
    if len(cut.geoms) != len(parts.geoms) or _count_holes(cut) != len(holes):
        raise InputError(
            f"contours of {name} lie closer to each other than the kerf, so one cut would run "
            "into the next; move them apart or make the kerf smaller",
            key="kerf",
            value=f"{1e3 * kerf:g} mm",
        )
    return cut


def sheet_inks(design: Design, kerf: float) -> list[Ink]:
    """The film to cut, in the order in which to cut it: slits, holes, outline.

    Raises:
        InputError: as for `cut_region`.
    """
    from sheetmorph.drawing.ink import Ink

    inks = contour_inks(cut_region(design.outline_polygon(), kerf, "the sheet"))
    if not design.layout.slits.is_empty:
        inks.insert(0, Ink(SLITS, (design.layout.slits,), COLOURS[SLITS]))
    return [*inks, Ink(MARKS, (marks_around(design),), COLOURS[MARKS])]


def pattern_inks(design: Design, kerf: float) -> tuple[list[Ink], list[str]]:
    """The parts of the pattern, a layer each, seen from above; with the marks of the sheet.

    Returns:
        The drawing, empty if it would hold no part; and in sentences the parts that cannot be
        cut with this kerf: they are left out, for they can still be printed.
    """
    from sheetmorph.drawing.ink import Ink

    layers = pattern_layers(design)
    inks, left_out = [], []
    for index, (part, region) in enumerate(design.layout.parts.items()):
        try:
            contours = cut_region(region, kerf, f"the part {part}")
        except InputError as error:
            left_out.append(
                f"cut/pattern leaves out the part {part}: {error.message}. To print the part, "
                "this does not matter."
            )
            continue
        inks.append(Ink(layers[part], (contours,), _PART_COLOURS[index % len(_PART_COLOURS)]))
    if inks:
        inks.append(Ink(MARKS, (marks_around(design),), COLOURS[MARKS]))
    return inks, left_out


def pattern_layers(design: Design) -> dict[str, str]:
    """From the parts of the pattern to the names of their layers in the drawing."""
    parts = list(design.layout.parts)
    wanted = ["PATTERN" if part == "pattern" else part for part in parts]
    return dict(zip(parts, distinct(wanted, taken=(MARKS, "0", "DEFPOINTS")), strict=True))


def contour_inks(region: BaseGeometry) -> list[Ink]:
    """Holes and outer contours of a region on their two layers."""
    import shapely

    from sheetmorph.drawing.ink import Ink

    parts = shapely.get_parts(region)
    holes = [shapely.Polygon(ring) for part in parts for ring in part.interiors]
    outer = [shapely.Polygon(part.exterior) for part in parts]
    inks = [Ink(HOLES, tuple(holes), COLOURS[HOLES])] if holes else []
    return [*inks, Ink(SHEET, tuple(outer), COLOURS[SHEET])]


def marks_around(design: Design) -> MultiLineString:
    """Crosses at the corners of a frame about the sheet [m], the same in every drawing.

    They lie in the waste beside the sheet, where a cut or a score changes nothing. The cross
    at the lower left has a second bar, so that a drawing turned or mirrored is noticed.
    """
    import shapely

    low_x, low_y, high_x, high_y = design.outline_polygon().bounds
    d, arm = MARK_DISTANCE, 0.5 * MARK_SIZE
    corners = [(x, y) for y in (low_y - d, high_y + d) for x in (low_x - d, high_x + d)]
    bars = [
        bar
        for x, y in corners
        for bar in ([(x - arm, y), (x + arm, y)], [(x, y - arm), (x, y + arm)])
    ]
    x, y = corners[0]
    bars.append([(x + 0.4 * arm, y + 0.6 * arm), (x + arm, y + 0.6 * arm)])
    return shapely.MultiLineString(bars)


def describe_kerf(kerf: float) -> str:
    """On which side of the parts the cut lines run, for people."""
    if not kerf:
        return (
            "Cut lines are the true contours, without kerf compensation: switch it on at the "
            "machine (outside outer contours, inside holes), or give a kerf when making the files."
        )
    half = f"{0.5e3 * kerf:.3g} mm"
    return (
        f"Cut lines are compensated for a kerf of {1e3 * kerf:.3g} mm: they run {half} outside "
        f"outer contours and {half} inside holes; slits are not moved. Leave the machine's own "
        "compensation off."
    )


def _count_holes(region: MultiPolygon) -> int:
    return sum(len(part.interiors) for part in region.geoms)


def _at(shape: Polygon) -> str:
    x, y = np.round([1e3 * shape.centroid.x, 1e3 * shape.centroid.y], 1) + 0.0
    return f"({x:g}, {y:g}) mm"
