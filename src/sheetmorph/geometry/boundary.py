"""Boundary curves of an outline and a pattern: noded, split at corners, resampled."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.triangulate import Indices

if TYPE_CHECKING:
    from shapely import Geometry, Polygon

# All lengths here are in units of the wanted edge length.
CORNER = np.radians(25.0)  # a vertex that turns more than this is kept exactly
CHORD = 0.1  # corners that stand out less than this are noise of the polyline
SAGITTA = 0.05  # chords leave a curve by no more than this
MERGE = 0.3  # corners and junctions closer than this become one node
GRID = 1e-7  # outline and pattern are noded on this grid, so that shared edges coincide


@dataclass(frozen=True, eq=False)
class Curves:
    """Boundary curves between fixed nodes, one after the other on one arc-length axis.

    Attributes:
        nodes: positions of the fixed nodes (corners, junctions), shape (K, 2).
        ends: first and last node of each curve, shape (C, 2).
        spans: arc length at the start and the end of each curve, shape (C, 2).
        knots: arc length of the polyline vertices, increasing, shape (N,).
        vertices: positions of the polyline vertices, shape (N, 2).
        turning: total angle by which each curve turns [rad], shape (C,).
    """

    nodes: Floats
    ends: Indices
    spans: Floats
    knots: Floats
    vertices: Floats
    turning: Floats

    def at(self, stations: Floats) -> Floats:
        """Positions at arc lengths, shape (..., 2)."""
        return np.stack([np.interp(stations, self.knots, self.vertices[:, k]) for k in (0, 1)], -1)


@dataclass(frozen=True, eq=False)
class Sampling:
    """Nodes and segments on the boundary curves.

    Attributes:
        points: positions; the first K are the fixed nodes of the curves, shape (B, 2).
        segments: point indices, shape (M, 2).
        stations: arc length of the points that may slide, shape (B,); NaN for fixed ones.
        along: the points before and after each point that may slide, shape (B, 2).
    """

    points: Floats
    segments: Indices
    stations: Floats
    along: Indices


def trace(outline: Polygon, pattern: Geometry) -> Curves:
    """Curves that the boundaries of outline and pattern make together.

    Both boundaries are noded together first, so that curves meet only at their ends; then
    they are split at corners, and corners and junctions closer than `MERGE` become one.
    """
    import shapely

    rings = [outline.boundary] if pattern.is_empty else [outline.boundary, pattern.boundary]
    noded = shapely.unary_union([ring.simplify(1e-9) for ring in rings], grid_size=GRID)
    lines = [shapely.get_coordinates(line) for line in shapely.get_parts(shapely.line_merge(noded))]
    tips = np.array([end for line in lines if not _closed(line) for end in (line[0], line[-1])])
    pieces = [piece for line in lines for piece in _split(_rotated(line, tips))]
    return _joined(pieces, outline, pattern)


def _closed(line: Floats) -> bool:
    return bool((line[0] == line[-1]).all())


def _rotated(line: Floats, junctions: Floats) -> Floats:
    """A ring starts at its junction, else at its sharpest corner, else at its right-most point."""
    if not _closed(line) or (len(junctions) and (junctions == line[0]).all(axis=1).any()):
        return line
    ring = line[:-1]
    turning = _turning(np.vstack([ring[-1:], ring, ring[:1]]))
    if turning.max() > CORNER:
        start = int(np.argmax(turning))
    else:
        start = int(np.lexsort((np.abs(ring[:, 1]), -np.round(ring[:, 0], 6)))[0])
    ring = np.roll(ring, -start, axis=0)
    return np.vstack([ring, ring[:1]])


def _turning(line: Floats) -> Floats:
    """Angle by which a polyline turns at its inner vertices."""
    step = np.diff(line, axis=0)
    u, v = step[:-1], step[1:]
    cross = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    return np.asarray(np.abs(np.arctan2(cross, (u * v).sum(axis=1))))


def _total_turning(line: Floats) -> float:
    """Angle by which a curve turns in all, without the noise of its polyline."""
    import shapely

    course = shapely.simplify(shapely.LineString(line), 0.5 * SAGITTA, preserve_topology=False)
    return float(_turning(shapely.get_coordinates(course)).sum())


def _split(line: Floats) -> list[Floats]:
    """Cut a polyline at the corners that stand out."""
    import shapely

    corner = np.zeros(len(line), dtype=bool)
    corner[1:-1] = (_turning(line) > CORNER) | _rounded_corner(line)
    if corner.any():
        outstanding = shapely.get_coordinates(
            shapely.simplify(shapely.LineString(line), CHORD, preserve_topology=False)
        )
        keep = {tuple(point) for point in outstanding}
        corner &= np.fromiter((tuple(point) in keep for point in line), bool, len(line))
    cuts = [0, *np.flatnonzero(corner).tolist(), len(line) - 1]
    return [line[a : b + 1] for a, b in pairwise(cuts)]


def _rounded_corner(line: Floats) -> NDArray[np.bool_]:
    """Middle of each fillet that is much smaller than an edge: chords would cut it off."""
    window = 0.4
    s = _arc(line)
    if s[-1] < 4.0:
        return np.zeros(len(line) - 2, dtype=bool)
    inner = s[1:-1]

    def at(t: Floats) -> Floats:
        return np.stack([np.interp(t, s, line[:, k]) for k in (0, 1)], -1)

    before, after = line[1:-1] - at(inner - window), at(inner + window) - line[1:-1]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turn = np.abs(np.arctan2(cross, (before * after).sum(axis=1)))
    found = np.zeros(len(inner), dtype=bool)
    for k in np.flatnonzero(turn > np.radians(50.0)):
        near = np.abs(inner - inner[k]) < 2 * window
        rival = turn[near].max()
        found[k] = turn[k] == rival and not found[near].any()
    sharp = _turning(line) > CORNER
    for k in np.flatnonzero(found):
        found[k] = not sharp[np.abs(inner - inner[k]) < 2 * window].any()
    return found


def _arc(line: Floats) -> Floats:
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])


def _joined(pieces: list[Floats], outline: Polygon, pattern: Geometry) -> Curves:
    """Number the ends of the pieces, merge those that are too close, and chain the curves."""
    tips = np.array([end for piece in pieces for end in (piece[0], piece[-1])])
    places, ends = np.unique(tips, axis=0, return_inverse=True)
    ends = ends.reshape(-1, 2)
    lengths = np.array([_arc(piece)[-1] for piece in pieces])
    label = _clusters(places, ends, lengths)
    places = _off_grid(places, outline, pattern)
    nodes = _representatives(places, label, outline)
    lines: list[Floats] = []
    kept: list[tuple[int, int]] = []
    for piece, (a, b), length in zip(pieces, ends, lengths, strict=True):
        first, last = int(label[a]), int(label[b])
        if first == last and length < 2 * MERGE:
            continue
        line = _reattached(piece, nodes[first])
        lines.append(_reattached(line[::-1], nodes[last])[::-1])
        kept.append((first, last))
    twins = _twins(lines, kept, outline)
    lines = [line for k, line in enumerate(lines) if k not in twins]
    kept = [pair for k, pair in enumerate(kept) if k not in twins]
    arcs = [_arc(line) for line in lines]
    lengths = np.array([arc[-1] for arc in arcs])
    starts = np.concatenate([[0.0], np.cumsum(lengths[:-1] + 1.0)])
    used, ends = np.unique(np.array(kept), return_inverse=True)
    return Curves(
        nodes[used],
        ends.reshape(-1, 2),
        np.stack([starts, starts + lengths], axis=1),
        np.concatenate([start + arc for start, arc in zip(starts, arcs, strict=True)]),
        np.concatenate(lines),
        np.array([_total_turning(line) for line in lines]),
    )


def _twins(lines: list[Floats], ends: list[tuple[int, int]], outline: Polygon) -> set[int]:
    """Short lines between the same nodes that nearly coincide: all but one of each, by index.

    They are the two sides of a sliver that merging nodes closed. One on the outline stays.
    """
    import shapely

    groups: dict[tuple[int, int], list[int]] = {}
    for k, (a, b) in enumerate(ends):
        if a != b and len(lines[k]) > 1:
            groups.setdefault((min(a, b), max(a, b)), []).append(k)
    twins: set[int] = set()
    for group in groups.values():
        if len(group) < 2:
            continue
        shapes = {k: shapely.LineString(lines[k]) for k in group}
        middle = {k: shapes[k].interpolate(0.5, normalized=True) for k in group}
        group.sort(key=lambda k: (round(middle[k].distance(outline.boundary), 6), k))
        for place, k in enumerate(group):
            for other in group[:place]:
                close = shapes[k].hausdorff_distance(shapes[other]) < MERGE
                if close and other not in twins and shapes[k].length < 2.0:
                    twins.add(k)
    return twins


def _reattached(line: Floats, node: Floats) -> Floats:
    """A polyline that starts at a node near its first vertex and joins its course one edge on."""
    if np.abs(line[0] - node).max() <= 10 * GRID:
        return np.vstack([node, line[1:]])
    s = _arc(line)
    ahead = min(1.0, 0.5 * s[-1])
    joint = [np.interp(ahead, s, line[:, k]) for k in (0, 1)]
    return np.vstack([node, joint, line[s > ahead + 1e-9]])


def _off_grid(places: Floats, outline: Polygon, pattern: Geometry) -> Floats:
    """Ends of pieces where they were before noding moved them to the grid."""
    import shapely

    rim = shapely.points(places)
    along = shapely.line_locate_point(outline.exterior, rim)
    exact = shapely.get_coordinates(shapely.line_interpolate_point(outline.exterior, along))
    near = np.linalg.norm(exact - places, axis=1) < 10 * GRID
    places = np.where(near[:, None], exact, places)
    vertices = shapely.get_coordinates([outline, pattern])
    distance, nearest = cKDTree(vertices).query(places)
    return np.asarray(np.where((distance < 10 * GRID)[:, None], vertices[nearest], places))


def _clusters(places: Floats, ends: Indices, lengths: Floats) -> Indices:
    """Label of each place; places that are too close share one while their group is small."""
    label = np.arange(len(places))
    near = cKDTree(places).query_pairs(MERGE, output_type="ndarray")
    pairs = np.concatenate([ends, near])
    apart = np.linalg.norm(places[near[:, 0]] - places[near[:, 1]], axis=1)
    distance = np.concatenate([lengths, apart])
    for k in np.lexsort((np.arange(len(pairs)), np.round(distance, 6))):
        if distance[k] > MERGE:
            break
        a, b = label[pairs[k]]
        if a == b:
            continue
        group = places[(label == a) | (label == b)]
        if np.linalg.norm(np.ptp(group, axis=0)) <= MERGE:
            label[label == max(a, b)] = min(a, b)
    return np.asarray(np.unique(label, return_inverse=True)[1])


def _representatives(places: Floats, label: Indices, outline: Polygon) -> Floats:
    """Position of each group: its sharpest corner of the outline, else its mean on the outline."""
    import shapely

    rank = np.zeros(len(places), dtype=int)
    rank[shapely.dwithin(outline.boundary, shapely.points(places), 1e-6)] = 1
    for ring in (outline.exterior, *outline.interiors):
        line = shapely.get_coordinates(ring)
        sharp = line[:-1][_turning(np.vstack([line[-2:-1], line])) > CORNER]
        if len(sharp):
            near = shapely.dwithin(shapely.multipoints(sharp), shapely.points(places), 1e-6)
            rank[near] = 2
    nodes = np.empty((int(label.max()) + 1, 2))
    for k in range(len(nodes)):
        group = np.flatnonzero(label == k)
        best = group[rank[group] == rank[group].max()]
        nodes[k] = places[best].mean(axis=0)
    return nodes


def sample(curves: Curves, counts: Indices) -> Sampling:
    """Divide each curve into a number of equal parts.

    Args:
        counts: parts of each curve, shape (C,), each at least 1.
    """
    fixed = len(curves.nodes)
    inner = counts - 1
    total = int(inner.sum())
    owner = np.repeat(np.arange(len(counts)), inner)
    place = np.arange(total) - np.repeat(np.cumsum(inner) - inner, inner) + 1
    low, high = curves.spans[owner].T
    stations = low + (high - low) * place / counts[owner]
    index = fixed + np.arange(total)
    along = np.stack([index - 1, index + 1], axis=1)
    at_start, at_end = place == 1, place == counts[owner] - 1
    along[at_start, 0] = curves.ends[owner[at_start], 0]
    along[at_end, 1] = curves.ends[owner[at_end], 1]
    single = counts == 1
    segments = np.concatenate(
        [
            curves.ends[single],
            np.stack([along[:, 0], index], axis=1),
            np.stack([index, along[:, 1]], axis=1)[at_end],
        ]
    )
    return Sampling(
        np.concatenate([curves.nodes, curves.at(stations)]),
        segments,
        np.concatenate([np.full(fixed, np.nan), stations]),
        np.concatenate([np.full((fixed, 2), -1), along]),
    )


def part_counts(curves: Curves) -> Indices:
    """Numbers of parts that bring the edges of each curve closest to the wanted length."""
    length = curves.spans[:, 1] - curves.spans[:, 0]
    counts = np.maximum(np.floor(length), 1.0)
    # The ratio of the edge to 1 decides, not the difference: n → n + 1 at length √(n (n + 1)).
    counts += length > np.sqrt(counts * (counts + 1.0))
    counts = np.maximum(counts, np.ceil(np.sqrt(length * curves.turning / (8.0 * SAGITTA))))
    loop = curves.ends[:, 0] == curves.ends[:, 1]
    counts = np.where(loop, np.maximum(counts, 5), counts).astype(np.intp)
    # Two curves between the same nodes must not become the same edge.
    pair = np.sort(curves.ends, axis=1)
    order = np.lexsort((-length, counts, pair[:, 1], pair[:, 0]))
    same = (np.diff(pair[order], axis=0) == 0).all(axis=1)
    both_single = same & (counts[order][1:] == 1)
    counts[order[:-1][both_single]] = 2
    return counts
