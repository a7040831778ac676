"""The area that a selection encloses: nesting, fill-rules, crossings."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.contours import joined, open_contour
from sheetmorph.drawing.model import Curve, DrawnItem, FillRule, Floats, Overlaps, Region
from sheetmorph.drawing.notes import Notes, at

if TYPE_CHECKING:
    from shapely import MultiPolygon
    from shapely.geometry.base import BaseGeometry

MAX_WORK = 2_000_000_000
MAX_PAIRS = 5_000_000
MAX_CROSSINGS = 100_000
MAX_CORNERS = 200_000
MAX_TANGLED = 20_000
_CHUNK = 4_000_000
_LEAST_AREA = 1e-12
_SLIVER = 1e-9
_POINT = re.compile(r"\[(\S+) (\S+?)\]")


def region_of(
    items: Sequence[DrawnItem], gap: float, flatness: float, *, strokes: bool, overlaps: Overlaps
) -> Region:
    """The area of some items [m]: what is filled, what contours enclose, and ribs if wanted.

    Raises:
        InputError: a contour is open, crosses itself or another, or there is no area.
    """
    import shapely

    from sheetmorph.drawing.ribs import rib

    notes = Notes()
    painted: list[BaseGeometry] = []
    contours: list[Curve] = []
    for item in items:
        as_rib = strokes and item.pen is not None
        if item.fill is not None:
            rings = [curve.points for curve in item.curves if len(curve.points) > 2]
            painted += [filled(rings, item.fill)] if rings else []
        if as_rib and item.pen is not None:
            painted.append(rib(item.pen, flatness))
        if item.fill is None and not as_rib:
            contours += item.curves
    painted = [shape for shape in painted if not shape.is_empty]
    _note_overlaps(painted, notes)
    if contours:
        has_pens = any(item.pen is not None for item in items if item.fill is None)
        hint = ", or read its stroke as a rib (strokes)" if has_pens else ""
        painted.append(_enclosed(contours, gap, overlaps, hint, notes))
    shape = as_multipolygon(shapely.union_all(painted))
    if shape.is_empty:
        raise InputError(
            "nothing closed is drawn here, so there is no area; draw closed contours or filled "
            "shapes" + ("" if strokes else ", or read the strokes of an SVG as ribs (strokes)")
        )
    return Region(shape, notes.texts)


def filled(rings: Sequence[Floats], rule: FillRule) -> BaseGeometry:
    """The area that closed rings paint under a fill-rule; they may cross.

    Args:
        rings: corners of each ring, shape (N ≥ 3, 2) [m], the first not repeated.
        rule: "evenodd" or "nonzero", as SVG defines them.
    """
    import shapely

    corners = sum(map(len, rings))
    if corners > MAX_CORNERS:
        raise InputError("a shape has too many corners", allowed=f"≤ {MAX_CORNERS}")
    polygons = shapely.polygons([shapely.linearrings(ring) for ring in rings])
    borders = shapely.boundary(polygons)
    contact = _pairs(borders, borders, "intersects", MAX_PAIRS)
    if (contact[0] == contact[1]).all() and shapely.is_valid(polygons).all():
        return _nested(polygons, rule)
    if corners > MAX_TANGLED:
        raise InputError(
            "a shape that crosses or touches itself has too many corners; simplify it",
            allowed=f"≤ {MAX_TANGLED}",
        )
    # Split the plane along all rings, and ask for the winding number of every face.
    faces = shapely.get_parts(shapely.polygonize([shapely.union_all(borders)]))
    if not len(faces):
        return shapely.MultiPolygon()
    inside = shapely.get_coordinates(shapely.point_on_surface(faces))
    winding = _winding(rings, inside, rule)
    return shapely.union_all(faces[winding])


def as_multipolygon(shape: BaseGeometry) -> MultiPolygon:
    """The polygons of a shape, without crumbs below 1 µm²."""
    import shapely

    parts = shapely.get_parts(shapely.get_parts(shape))
    keep = [part for part in parts if part.geom_type == "Polygon" and part.area > _LEAST_AREA]
    return shapely.MultiPolygon(keep)


def _enclosed(
    curves: Sequence[Curve], gap: float, overlaps: Overlaps, hint: str, notes: Notes
) -> BaseGeometry:
    """The even-odd area of contours that must close and may not cross."""
    import shapely

    closed = joined(curves, gap, notes)
    error = open_contour(closed, gap, hint)
    if error is not None:
        raise error
    rings = [ring for curve in closed for ring in _simple_rings(curve.points)]
    polygons = shapely.polygons([shapely.linearrings(ring) for ring in rings])
    for polygon in polygons[~shapely.is_valid(polygons)]:
        _refuse_crossing_itself(polygon)
    pairs = _pairs(polygons, polygons, "overlaps", MAX_CROSSINGS)
    crossing = [
        (i, j) for i, j in pairs.T.tolist() if i < j and _really_overlap(polygons[i], polygons[j])
    ]
    if not crossing:
        return filled(rings, "evenodd")
    place = _first_point(polygons[crossing[0][0]], polygons[crossing[0][1]])
    if overlaps == "error":
        more = f" ({len(crossing) - 1} more pairs cross)" if len(crossing) > 1 else ""
        raise InputError(
            f"two contours cross at {at(place)}{more}; pull them apart or unite them in the "
            'drawing, or set overlaps = "union"'
        )
    notes.add("crossing", f"{len(crossing)} pairs of contours cross, one at {at(place)}: united")
    united = _united_groups(polygons, crossing)
    borders = [
        shapely.get_coordinates(ring)[:-1]
        for part in shapely.get_parts(united)
        for ring in shapely.get_rings(part)
    ]
    return filled(borders, "evenodd")


def _united_groups(polygons: NDArray[np.object_], pairs: list[tuple[int, int]]) -> list[object]:
    """Polygons united with all they overlap, directly or through others."""
    import shapely
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    index = np.array(pairs).T
    graph = coo_array((np.ones(len(pairs)), index), shape=(len(polygons),) * 2)
    count, group = connected_components(graph, directed=False)
    order = np.argsort(group, kind="stable")
    members = np.split(order, np.searchsorted(group[order], np.arange(1, count)))
    return [shapely.union_all(polygons[member]) for member in members]


def _nested(polygons: NDArray[np.object_], rule: FillRule) -> BaseGeometry:
    """The area of rings that do not meet, from the number of rings about each."""
    import shapely

    area = shapely.area(polygons)
    sign = np.where(shapely.is_ccw(shapely.get_exterior_ring(polygons)), 1, -1)
    corner = shapely.get_point(shapely.get_exterior_ring(polygons), 0)
    inner, outer = _pairs(polygons, corner, "within", MAX_PAIRS)
    strict = area[outer] > area[inner]
    inner, outer = inner[strict], outer[strict]
    depth = np.bincount(inner, minlength=len(polygons))
    winding = sign + np.bincount(inner, sign[outer], len(polygons))
    solid = winding != 0 if rule == "nonzero" else depth % 2 == 0
    children: list[list[int]] = [[] for _ in polygons]
    direct = depth[inner] == depth[outer] + 1
    for child, parent in zip(inner[direct].tolist(), outer[direct].tolist(), strict=True):
        children[parent].append(child)
    rings = shapely.get_exterior_ring(polygons)
    faces = [
        shapely.Polygon(rings[i], [rings[child] for child in children[i]])
        for i in np.flatnonzero(solid)
    ]
    return shapely.union_all(faces)


def _winding(rings: Sequence[Floats], points: Floats, rule: FillRule) -> NDArray[np.bool_]:
    """Whether each point is painted, shape (P,): its winding number, by counting crossings."""
    start = np.vstack(rings)
    end = np.vstack([np.roll(ring, -1, axis=0) for ring in rings])
    if len(start) * len(points) > MAX_WORK:
        raise InputError("the drawing crosses itself too often; simplify it")
    painted = np.empty(len(points), dtype=np.bool_)
    step = max(_CHUNK // len(start), 1)
    d = end - start
    for first in range(0, len(points), step):
        x, y = points[first : first + step, :1], points[first : first + step, 1:]
        left = d[:, 0] * (y - start[:, 1]) - (x - start[:, 0]) * d[:, 1] > 0.0
        up = (start[:, 1] <= y) & (y < end[:, 1]) & left
        down = (end[:, 1] <= y) & (y < start[:, 1]) & ~left
        number = up.sum(axis=1) - down.sum(axis=1)
        painted[first : first + step] = number != 0 if rule == "nonzero" else number % 2 != 0
    return painted


def _simple_rings(points: Floats) -> list[Floats]:
    """Split a contour where it comes back to one of its own points."""
    rings: list[Floats] = []
    seen: dict[tuple[float, float], int] = {}
    path: list[tuple[float, float]] = []
    for x, y in points.tolist():
        if (x, y) in seen:
            cut = seen[x, y]
            rings.append(np.array(path[cut:]))
            for point in path[cut + 1 :]:
                del seen[point]
            del path[cut + 1 :]
            continue
        seen[x, y] = len(path)
        path.append((x, y))
    rings.append(np.array(path))
    return [ring for ring in rings if len(ring) > 2]


def _refuse_crossing_itself(polygon: BaseGeometry) -> None:
    import shapely

    match = _POINT.search(shapely.is_valid_reason(polygon))
    corner = shapely.get_coordinates(polygon)[0]
    place = [float(number) for number in match.groups()] if match else corner
    raise InputError(f"a contour crosses itself at {at(place)}; untangle it in the drawing")


def _really_overlap(a: BaseGeometry, b: BaseGeometry) -> bool:
    """Whether two polygons cross by more than the rounding of a shared border."""
    import shapely

    least = _SLIVER * min(a.length, b.length)
    common = shapely.area(shapely.intersection(a, b))
    return bool(min(common, a.area - common, b.area - common) > least)


def _first_point(a: BaseGeometry, b: BaseGeometry) -> Floats:
    import shapely

    meeting = shapely.get_coordinates(shapely.intersection(a.boundary, b.boundary))
    return np.asarray(meeting[np.lexsort(meeting.T)[0]], dtype=np.float64)


def _note_overlaps(painted: Sequence[BaseGeometry], notes: Notes) -> None:
    import shapely

    if len(painted) < 2:
        return
    shapes = np.array(painted, dtype=object)
    twice = float(shapely.area(shapes).sum()) - float(shapely.union_all(shapes).area)
    if twice <= _LEAST_AREA:
        return
    tree = shapely.STRtree(shapes)
    for k in range(min(len(shapes), 1000)):
        others = tree.query(shapes[k], predicate="intersects")
        common = shapely.intersection(shapes[k], shapes[others[others != k]])
        over = common[shapely.area(common) > _LEAST_AREA]
        if len(over):
            place = shapely.get_coordinates(shapely.point_on_surface(over[0]))[0]
            notes.add(
                "united",
                f"painted shapes overlap, first at {at(place)}, by {1e6 * twice:.3g} mm² in all: "
                "united",
            )
            return


def _pairs(
    shapes: NDArray[np.object_], asked: NDArray[np.object_], predicate: str, limit: int
) -> NDArray[np.intp]:
    """Pairs (asked, shape) for which a predicate holds, shape (2, P), at most `limit`."""
    import shapely

    tree = shapely.STRtree(shapes)
    found: list[NDArray[np.intp]] = []
    count = 0
    for first in range(0, len(asked), 256):
        pairs = tree.query(asked[first : first + 256], predicate=predicate)
        found.append(np.stack([pairs[0] + first, pairs[1]]))
        count += pairs.shape[1]
        if count > limit:
            raise InputError("too many contours cross or lie within each other; simplify them")
    return np.concatenate(found, axis=1)
