"""Slits: cuts of zero width along which a mesh opens."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.features import place_name
from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from shapely import Geometry, Polygon

# In units of the wanted edge length:
TOUCH = 0.01  # ends closer than this to a line are brought onto it
SHORTEST = 0.3  # shorter slits and shorter distances between lines are errors
# In units of the edge itself:
END = 0.03  # ends of an edge on a slit are this close to it
MIDDLE = 0.12  # and its midpoint is this close: a chord leaves a curved slit a little


def open_slits(
    nodes: Floats, triangles: NDArray[np.integer[Any]], slits: Geometry
) -> tuple[Floats, NDArray[np.integer[Any]]]:
    """Open a mesh along slits: its nodes there are repeated so that the two sides part.

    The corners of triangles at a node stay together exactly when they are connected
    through edges that are on no slit. Ends of slits inside the sheet stay one node, a node
    where two slits cross becomes four, and a slit that ends on the rim opens there.

    Args:
        nodes: positions, shape (V, 2) or (V, 3).
        triangles: node indices, shape (T, 3).
        slits: lines that the edges follow, in the same unit.

    Returns:
        The nodes, the repeated ones after the old ones, and the triangles.
    """
    if slits.is_empty:
        return nodes, triangles
    count = len(nodes)
    sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1).reshape(-1, 2)
    corners = np.arange(len(sides)).reshape(-1, 3)
    ends = np.stack([corners, np.roll(corners, -1, axis=1)], axis=-1).reshape(-1, 2)
    swapped = sides[:, 0] > sides[:, 1]
    sides[swapped], ends[swapped] = sides[swapped, ::-1], ends[swapped, ::-1]
    order = np.lexsort((sides[:, 1], sides[:, 0]))
    twin = np.flatnonzero((sides[order][1:] == sides[order][:-1]).all(axis=1))
    first, second = order[twin], order[twin + 1]
    shared = ~_on_slits(nodes[:, :2], sides[first], slits)
    rows, cols = ends[first[shared]].ravel(), ends[second[shared]].ravel()
    graph = coo_array((np.ones(len(rows), dtype=np.int8), (rows, cols)), shape=(len(sides),) * 2)
    label = connected_components(graph, directed=False)[1]
    # The first group of corners at a node keeps its number.
    groups, corner, group = np.unique(label, return_index=True, return_inverse=True)
    owner = triangles.ravel()[corner]
    placed = np.lexsort((groups, owner))
    extra = np.zeros(len(groups), dtype=bool)
    extra[placed[1:]] = owner[placed[1:]] == owner[placed[:-1]]
    number = owner.astype(np.intp)
    repeated = placed[extra[placed]]
    number[repeated] = count + np.arange(len(repeated))
    return (
        np.concatenate([nodes, nodes[owner[repeated]]]),
        number[group].reshape(-1, 3).astype(triangles.dtype),
    )


def _on_slits(nodes: Floats, edges: NDArray[np.integer[Any]], slits: Geometry) -> NDArray[np.bool_]:
    """Which edges lie on slits, by position alone, shape (E,)."""
    import shapely

    ends = nodes[edges]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    shapely.prepare(slits)
    found = np.ones(len(edges), dtype=bool)
    for place, reach in (
        (ends[:, 0], END),
        (ends[:, 1], END),
        (ends.mean(axis=1), MIDDLE),
    ):
        left = np.flatnonzero(found)
        found[left] = shapely.dwithin(slits, shapely.points(place[left]), reach * length[left])
    return found


def checked_slits(
    slits: Geometry,
    outline: Polygon,
    regions: Sequence[Geometry],
    size: float,
    locked: Geometry,
) -> Geometry:
    """Slits noded with each other, their ends brought onto what they touch.

    Args:
        slits: lines [m].
        outline: boundary of the sheet [m].
        regions: regions of the pattern [m].
        size: wanted edge length at the slits [m].
        locked: sides of a wedge [m]; slits on them are left to what lies beyond.

    Returns:
        Lines that meet only at their ends.

    Raises:
        InputError: a slit lies outside the sheet, is too short or too close to another
            line, or slits cut the sheet into pieces.
    """
    import shapely

    if slits.is_empty:
        return slits
    touch = TOUCH * size
    outside = shapely.difference(slits, outline.buffer(touch))
    _refuse(outside, "a slit reaches outside the sheet", "shorten it or clip it to the outline")
    rims = shapely.union_all([outline.boundary, *(region.boundary for region in regions)])
    lines = [_attached(line, outline, rims, slits, touch) for line in shapely.get_parts(slits)]
    for line in lines:
        if line.length < SHORTEST * size:
            _refuse(
                line,
                f"a slit is only {line.length * 1e3:.3g} mm long",
                f"slits must be at least {SHORTEST * size * 1e3:.3g} mm long for this size",
            )
    noded = shapely.line_merge(shapely.union_all(lines, grid_size=1e-7 * size))
    parts = [part for part in shapely.get_parts(noded) if part.length > 1.5 * touch]
    merged = shapely.line_merge(shapely.multilinestrings(parts))
    on_rim = shapely.intersection(merged, outline.boundary.buffer(touch))
    along = shapely.difference(on_rim, locked.buffer(touch))
    if along.length > SHORTEST * size:
        _refuse(along, "a slit runs along the rim of the sheet", "remove it or move it inside")
    merged = shapely.multilinestrings(list(shapely.get_parts(merged)))
    _check_distances(merged, outline, rims, size)
    _check_whole(merged, outline, locked, touch)
    return merged


def _attached(
    line: Geometry, outline: Polygon, rims: Geometry, slits: Geometry, touch: float
) -> Geometry:
    """A line whose ends reach the rim, a region's boundary or another slit where they touch it."""
    import shapely

    inside = shapely.intersection(line, outline)
    parts = [part for part in shapely.get_parts(inside) if part.geom_type == "LineString"]
    merged = shapely.line_merge(shapely.multilinestrings(parts)) if parts else line
    line = merged if merged.geom_type == "LineString" else line
    others = [other for other in shapely.get_parts(slits) if not other.equals(line)]
    xy = shapely.get_coordinates(line)
    for end, ring in ((0, outline.boundary), (-1, outline.boundary)):
        tip = shapely.Point(xy[end])
        near = shapely.MultiLineString(others) if others else shapely.LineString()
        for target in (ring, near, rims):
            if target.is_empty or shapely.distance(tip, target) > touch:
                continue
            place = shapely.get_coordinates(shapely.shortest_line(target, tip))[0]
            xy[end] = place
            break
    return shapely.LineString(xy)


def _check_distances(slits: Geometry, outline: Polygon, rims: Geometry, size: float) -> None:
    """Tips must be clear of other lines, and no strip beside a slit too thin to mesh."""
    import shapely

    from sheetmorph.geometry.cells import BLUR, thin_parts

    near, touch = SHORTEST * size, TOUCH * size
    advice = f"join them or keep them {near * 1e3:.3g} mm apart for this size"
    parts = list(shapely.get_parts(slits))
    for k, part in enumerate(parts):
        others = shapely.union_all([rims, *parts[:k], *parts[k + 1 :]])
        for tip in shapely.get_parts(part.boundary):
            gap = shapely.distance(tip, others)
            if touch < gap < near:
                _refuse(tip, "a slit ends too close to another line", advice)
        if part.length < near:
            _refuse(part, "two slits end or cross too close to each other", advice)
    # In edge lengths, because the offsets there are.
    lines = shapely.transform(shapely.union(rims, slits), lambda xy: xy / size)
    sheet = shapely.transform(outline, lambda xy: xy / size)
    cuts = shapely.transform(slits, lambda xy: xy / size)
    for strip in thin_parts(sheet.difference(lines.buffer(BLUR, cap_style="flat")), 1.0):
        if strip.area > 0.25 and shapely.dwithin(strip, cuts, 3.0 * BLUR):
            place = shapely.transform(strip, lambda xy: xy * size)
            _refuse(place, "a slit runs too close to another line", advice)


def _check_whole(slits: Geometry, outline: Polygon, locked: Geometry, touch: float) -> None:
    import shapely

    parts = [part for part in shapely.get_parts(slits) if not locked.buffer(touch).contains(part)]
    lines = shapely.union_all([outline.boundary, *parts], grid_size=1e-9 * outline.length)
    faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(lines)))
    inside = faces[shapely.contains(outline, shapely.point_on_surface(faces))]
    if len(inside) > 1:
        smallest = inside[int(np.argmin(shapely.area(inside)))]
        _refuse(smallest, "slits cut the sheet into separate pieces", "shorten one of them")


def _refuse(shape: Geometry, problem: str, advice: str) -> None:
    """Raise an InputError that names a place in a shape, unless the shape is empty."""
    if not shape.is_empty:
        at = shape.representative_point()
        raise InputError(f"{problem} near {place_name(at.x, at.y)}; {advice}", key="slits")
