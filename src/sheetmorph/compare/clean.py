"""Making a stranger's scan fit for comparison, and saying what was done to it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sheetmorph.compare.crop import CropOptions, floor_of, inside_box
from sheetmorph.compare.reduce import reduced
from sheetmorph.compare.scan import Scan
from sheetmorph.compare.surface import Surface
from sheetmorph.compare.topology import (
    Edges,
    components,
    edges_of,
    enclosed_volume,
    is_closed,
    loop_lengths,
    orient,
    sound_triangles,
    weld_seams,
)
from sheetmorph.core.errors import InputError

__all__ = ["CropOptions", "prepare"]

ENOUGH = 150_000  # triangles; a scan with more is reduced
DEBRIS = 0.02  # a piece with less of the largest piece's area is debris


def prepare(scan: Scan, *, crop: CropOptions | None = None, shape: Surface | None = None) -> Scan:
    """Clean a scan: close cracks, drop what is broken or not the sheet, turn it one way.

    In this order: the box of `crop`; triangles without area or there twice; cracks; the
    floor; debris; directions of the triangles (a closed body's normals point outwards);
    what is left open or branches is counted; more than 150 000 triangles are reduced.
    Every step that changed anything adds a note.

    Args:
        scan: as it was read.
        crop: what to cut off.
        shape: the shape that the scan will be compared with: where it has itself a flat part
            that looks like a floor, such as a flat frame, "auto" cuts no floor off.

    Raises:
        InputError: nothing is left, such as a box beside the scan; names the file.
    """
    try:
        return _prepared(scan, crop or CropOptions(), shape)
    except InputError as error:
        raise error.located(scan.name) from error


def _prepared(scan: Scan, crop: CropOptions, shape: Surface | None) -> Scan:
    notes = list(scan.notes)
    surface = scan.surface
    if crop.box is not None:
        surface = _cropped(surface, inside_box(surface, crop.box, scan.unit or 1.0), notes)
    surface = _sound(surface, notes)
    surface = _closed_cracks(surface, notes)
    if crop.floor != "none":
        surface = _without_floor(surface, crop.floor == "auto", shape, notes)
    surface = _without_debris(surface, crop.keep, notes)
    surface, edges = _oriented(surface, notes)
    _tell_edges(surface, edges, notes)
    surface = _reduced(surface, notes)
    return replace(scan, surface=surface, notes=tuple(notes))


def _cropped(surface: Surface, inside: np.ndarray, notes: list[str]) -> Surface:
    if inside.all():
        return surface
    kept = float(surface.areas[inside].sum()) / surface.area
    notes.append(f"The box keeps {kept:.0%} of the scan's area.")
    return surface.part(inside)


def _sound(surface: Surface, notes: list[str]) -> Surface:
    flat, again = sound_triangles(surface.points, surface.triangles)
    again &= ~flat
    good = ~(flat | again)
    if good.all():
        return surface
    if not good.any():
        raise InputError("no triangle of the scan has an area")
    parts = []
    if flat.any():
        parts.append(f"{flat.sum()} without area")
    if again.any():
        parts.append(f"{again.sum()} there twice")
    notes.append(f"Triangles were dropped: {', '.join(parts)}.")
    return surface.part(good)


def _closed_cracks(surface: Surface, notes: list[str]) -> Surface:
    triangles, gone = weld_seams(surface.points, surface.triangles)
    if not gone:
        return surface
    notes.append(f"Cracks were closed: {gone} points on open edges nearly coincided with others.")
    narrow = (triangles == triangles[:, [1, 2, 0]]).any(axis=1)
    return Surface(surface.points, triangles).part(~narrow)


def _without_floor(
    surface: Surface, certain: bool, shape: Surface | None, notes: list[str]
) -> Surface:
    floor, hint = floor_of(surface, certain=certain)
    if hint:
        notes.append(hint)
    if not floor.any():
        return surface
    share = float(surface.areas[floor].sum()) / surface.area
    if certain and shape is not None and floor_of(shape, certain=False)[0].any():
        notes.append(
            f"{share:.0%} of the area is flat like a floor; it was left, since the shape has such "
            "a part, too."
        )
        return surface
    notes.append(
        f"A flat floor was cut off, {share:.0%} of the scan's area; if it belongs to the sheet, "
        "switch this off."
    )
    return surface.part(~floor)


def _without_debris(surface: Surface, keep: str, notes: list[str]) -> Surface:
    piece = components(surface.triangles, len(surface.points))
    areas = np.bincount(piece, surface.areas)
    if keep == "all" or len(areas) == 1:
        return surface
    large = areas >= (1.0 if keep == "largest" else DEBRIS) * areas.max()
    if keep == "largest":
        large = np.arange(len(areas)) == np.argmax(areas)
    if not large.all():
        gone = int((~large).sum())
        share = float(areas[~large].sum() / areas.sum())
        notes.append(
            f"{gone} loose {'piece was' if gone == 1 else 'pieces were'} dropped, "
            f"{share:.2%} of the area."
        )
    if large.sum() > 1:
        notes.append(f"The scan is in {large.sum()} pieces; all of them are compared.")
    return surface.part(large[piece])


def _reduced(surface: Surface, notes: list[str]) -> Surface:
    small, cell = reduced(surface, ENOUGH)
    if not cell:
        return surface
    flat, again = sound_triangles(small.points, small.triangles)
    small = small.part(~(flat | again))
    notes.append(
        f"{len(surface.triangles)} triangles were reduced to {len(small.triangles)} by averaging "
        f"points closer than {cell / surface.size:.2%} of the size."
    )
    return small


def _oriented(surface: Surface, notes: list[str]) -> tuple[Surface, Edges]:
    count = len(surface.points)
    edges = edges_of(surface.triangles, count)
    triangles, turned = orient(surface.triangles, surface.areas, edges)
    if turned.any():
        share = float(surface.areas[turned].sum()) / surface.area
        notes.append(f"{turned.sum()} triangles were turned over, {share:.1%} of the area.")
        edges = edges_of(triangles, count)
    closed = is_closed(loop_lengths(surface.points, edges), surface.area)
    if closed and enclosed_volume(surface.points, triangles) < 0.0:
        triangles = triangles[:, ::-1]
        notes.append("The normals of the closed surface pointed inwards and were turned.")
    return Surface(surface.points, triangles), edges


def _tell_edges(surface: Surface, edges: Edges, notes: list[str]) -> None:
    lengths = loop_lengths(surface.points, edges)
    if len(lengths) > 1:
        small = float(lengths[1:].sum() / lengths.sum())
        notes.append(
            f"The scan has {len(lengths)} rims; the longest has {1.0 - small:.0%} of their length, "
            f"the other {len(lengths) - 1} may be holes."
        )
    branching = int((edges.uses > 2).sum())
    if branching:
        notes.append(f"At {branching} edges more than two triangles meet.")
    if edges.turned.any():
        notes.append(
            f"At {int(edges.turned.sum())} edges the surface cannot be turned one way, as on a "
            "Möbius strip."
        )
