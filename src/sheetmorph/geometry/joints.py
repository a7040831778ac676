"""Where boundary curves meet: corners and junctions that are too close become one node."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sheetmorph.geometry.features import TooCloseError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.plan import Plan
from sheetmorph.geometry.sizing import SizeField
from sheetmorph.geometry.triangulate import Indices

if TYPE_CHECKING:
    from shapely import Geometry, Polygon

CORNER = np.radians(25.0)  # a vertex that turns more than this is kept exactly
MERGE = 0.3  # corners and junctions closer than this, in wanted edge lengths, become one node
ON_LINE = 1e-5  # places closer to a line than this lie on it
GRID = 1e-7  # all lines are noded on this grid, so that shared edges coincide


def turns(line: Floats) -> Floats:
    """Angle by which a polyline turns at its inner vertices."""
    step = np.diff(line, axis=0)
    u, v = step[:-1], step[1:]
    cross = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    return np.asarray(np.abs(np.arctan2(cross, (u * v).sum(axis=1))))


def arc_lengths(line: Floats) -> Floats:
    """Arc length at each vertex of a polyline."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])


def lies_on(lines: Geometry, places: Floats) -> NDArray[np.bool_]:
    """Which places lie on lines, shape (N,)."""
    import shapely

    return np.asarray(shapely.dwithin(lines, shapely.points(places), ON_LINE))


def merged_places(
    places: Floats, ends: Indices, lengths: Floats, unit: Floats, plan: Plan
) -> tuple[Indices, Floats]:
    """One node for every group of places that are too close to each other.

    Args:
        places: ends of the pieces of boundary curves, shape (N, 2).
        ends: first and last place of each piece, shape (P, 2).
        lengths: lengths of the pieces in wanted edge lengths, shape (P,).
        unit: wanted edge length at each place, shape (N,).
        plan: the lines, of which some must not move.

    Returns:
        The group of each place, shape (N,), and the positions of the groups, shape (K, 2).
    """
    label = _clusters(places, ends, lengths, unit, lies_on(plan.locked, places))
    places = _off_grid(places, plan)
    rank = _ranks(places, plan)
    nodes = np.empty((int(label.max()) + 1, 2))
    order = np.argsort(label, kind="stable")
    for k, group in enumerate(np.split(order, np.flatnonzero(np.diff(label[order])) + 1)):
        best = group[rank[group] == rank[group].max()]
        nodes[k] = places[best].mean(axis=0)
    if not plan.slits.is_empty:
        _settle_slits(nodes, places, label, unit, plan)
    return label, nodes


def _off_grid(places: Floats, plan: Plan) -> Floats:
    """Ends of pieces where they were before noding moved them to the grid."""
    import shapely

    rim = shapely.points(places)
    along = shapely.line_locate_point(plan.outline.exterior, rim)
    exact = shapely.get_coordinates(shapely.line_interpolate_point(plan.outline.exterior, along))
    near = np.linalg.norm(exact - places, axis=1) < 10 * GRID
    places = np.where(near[:, None], exact, places)
    vertices = shapely.get_coordinates([plan.outline, *plan.regions, plan.slits])
    distance, nearest = cKDTree(vertices).query(places)
    return np.asarray(np.where((distance < 10 * GRID)[:, None], vertices[nearest], places))


def _clusters(
    places: Floats, ends: Indices, lengths: Floats, unit: Floats, locked: NDArray[np.bool_]
) -> Indices:
    """Label of each place; places that are too close share one while their group is small.

    Pairs of locked places come first, so that what lies beside a locked line changes nothing
    on it.
    """
    label = np.arange(len(places))
    near = cKDTree(places).query_pairs(MERGE * unit.max(), output_type="ndarray")
    pairs = np.concatenate([ends, near])
    apart = np.linalg.norm(places[near[:, 0]] - places[near[:, 1]], axis=1)
    distance = np.concatenate([lengths, apart / unit[near].min(axis=1)])
    loose = ~locked[pairs].all(axis=1)
    order = np.lexsort((np.arange(len(pairs)), np.round(distance, 6), loose))
    for k in order[distance[order] <= MERGE]:
        a, b = label[pairs[k]]
        if a == b:
            continue
        members = (label == a) | (label == b)
        if np.linalg.norm(np.ptp(places[members], axis=0)) <= MERGE * unit[members].min():
            label[label == max(a, b)] = min(a, b)
    return np.asarray(np.unique(label, return_inverse=True)[1])


def _ranks(places: Floats, plan: Plan) -> Indices:
    """Which place of a group decides on its position.

    The ends of locked lines come first, then these lines, corners of the outline, the outline.
    """
    import shapely

    rank = np.zeros(len(places), dtype=np.intp)
    rank[shapely.dwithin(plan.outline.boundary, shapely.points(places), 1e-6)] = 1
    rank[_at_corner(places, plan.outline)] = 2
    rank[lies_on(plan.locked, places)] = 3
    rank[lies_on(plan.locked.boundary, places)] = 4
    return rank


def _at_corner(places: Floats, outline: Polygon) -> NDArray[np.bool_]:
    import shapely

    found = np.zeros(len(places), dtype=bool)
    for ring in (outline.exterior, *outline.interiors):
        line = shapely.get_coordinates(ring)
        sharp = line[:-1][turns(np.vstack([line[-2:-1], line])) > CORNER]
        if len(sharp):
            found |= shapely.dwithin(shapely.multipoints(sharp), shapely.points(places), 1e-6)
    return found


def _settle_slits(nodes: Floats, places: Floats, label: Indices, unit: Floats, plan: Plan) -> None:
    """Bring groups with places on slits back onto the slits.

    Raises:
        TooCloseError: a group holds two ends or crossings of slits, or one of these and a
            corner of the outline.
    """
    import shapely

    on_slit = lies_on(plan.slits, places)
    ends = shapely.get_coordinates([line.boundary for line in shapely.get_parts(plan.slits)])
    hard = on_slit & lies_on(shapely.multipoints(ends), places)
    corner = _at_corner(places, plan.outline)
    locked = lies_on(plan.locked, places)
    for k in np.unique(label[on_slit]):
        group = np.flatnonzero(label == k)
        kept = group[hard[group] | (corner[group] & hard[group].any())]
        if len(kept) > 1:
            place = places[kept].mean(axis=0)
            raise TooCloseError("slits", (float(place[0]), float(place[1])), MERGE * unit[kept[0]])
        if locked[group].any():
            continue
        chosen = kept if len(kept) else group[on_slit[group]]
        middle = shapely.Point(places[chosen].mean(axis=0))
        nodes[k] = shapely.get_coordinates(shapely.shortest_line(plan.slits, middle))[0]


def closed_slivers(
    lines: list[Floats], ends: list[tuple[int, int]], plan: Plan, size: SizeField
) -> set[int]:
    """Short lines between the same nodes that nearly coincide: all but one of each, by index.

    They are the two sides of a sliver that merging nodes closed. One on the outline or on a
    slit stays.
    """
    import shapely

    groups: dict[tuple[int, int], list[int]] = {}
    for k, (a, b) in enumerate(ends):
        if a != b and len(lines[k]) > 1:
            groups.setdefault((min(a, b), max(a, b)), []).append(k)
    stays = shapely.union(plan.outline.boundary, plan.slits)
    twins: set[int] = set()
    for group in groups.values():
        if len(group) < 2:
            continue
        unit = float(size.at(lines[group[0]][:1])[0])
        shapes = {k: shapely.LineString(lines[k]) for k in group}
        middle = {k: shapes[k].interpolate(0.5, normalized=True) for k in group}
        group.sort(key=lambda k: (round(middle[k].distance(stays), 6), k))
        for place, k in enumerate(group):
            for other in group[:place]:
                close = shapes[k].hausdorff_distance(shapes[other]) < MERGE * unit
                if close and other not in twins and shapes[k].length < 2.0 * unit:
                    twins.add(k)
    return twins
