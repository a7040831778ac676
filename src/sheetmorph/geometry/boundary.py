"""Boundary curves of an outline and a pattern: noded, split at corners, resampled."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.geometry.joints import (
    CORNER,
    GRID,
    MERGE,
    arc_lengths,
    closed_slivers,
    lies_on,
    merged_places,
    turns,
)
from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.plan import Plan
from sheetmorph.geometry.sizing import SizeField, UniformSize
from sheetmorph.geometry.triangulate import Indices

if TYPE_CHECKING:
    from shapely import Geometry

# All lengths here are in units of the wanted edge length.
CHORD = 0.1  # corners that stand out less than this are noise of the polyline
SAGITTA = 0.05  # chords leave a curve by no more than this


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
        measure: ∫ ds/h along the axis at the vertices, shape (N,).
        locked: curves whose points never slide, shape (C,).
        cut: curves along slits, shape (C,).
    """

    nodes: Floats
    ends: Indices
    spans: Floats
    knots: Floats
    vertices: Floats
    turning: Floats
    measure: Floats
    locked: NDArray[np.bool_]
    cut: NDArray[np.bool_]

    def at(self, stations: Floats) -> Floats:
        """Positions at arc lengths, shape (..., 2)."""
        return np.stack([np.interp(stations, self.knots, self.vertices[:, k]) for k in (0, 1)], -1)

    def measured(self, stations: Floats) -> Floats:
        """How many wanted edges fit on the axis before each arc length."""
        if self.measure is self.knots:
            return stations
        return np.interp(stations, self.knots, self.measure)

    def stations(self, measure: Floats) -> Floats:
        """Arc length at each measure."""
        if self.measure is self.knots:
            return measure
        return np.interp(measure, self.measure, self.knots)


def trace(plan: Plan, size: SizeField) -> Curves:
    """Curves that the lines of a plan make together.

    All lines are noded together first, so that curves meet only at their ends; then they
    are split at corners, and corners and junctions closer than `MERGE` become one. Slits
    and straight locked lines keep their ends and their course.
    """
    import shapely

    rings = [plan.outline.boundary]
    rings += [region.boundary for region in plan.regions if not region.is_empty]
    rings += [] if plan.slits.is_empty else [plan.slits]
    noded = shapely.unary_union([ring.simplify(1e-9) for ring in rings], grid_size=GRID)
    lines = [shapely.get_coordinates(line) for line in shapely.get_parts(shapely.line_merge(noded))]
    tips = np.array([end for line in lines if not _closed(line) for end in (line[0], line[-1])])
    kept = shapely.union(plan.locked.boundary, plan.slits.boundary)
    pieces = [piece for line in lines for piece in _split(_rotated(line, tips), kept, size)]
    return _joined(pieces, plan, size)


def _closed(line: Floats) -> bool:
    return bool((line[0] == line[-1]).all())


def _rotated(line: Floats, junctions: Floats) -> Floats:
    """A ring starts at its junction, else at its sharpest corner, else at its right-most point."""
    if not _closed(line) or (len(junctions) and (junctions == line[0]).all(axis=1).any()):
        return line
    ring = line[:-1]
    turning = turns(np.vstack([ring[-1:], ring, ring[:1]]))
    if turning.max() > CORNER:
        start = int(np.argmax(turning))
    else:
        start = int(np.lexsort((np.abs(ring[:, 1]), -np.round(ring[:, 0], 6)))[0])
    ring = np.roll(ring, -start, axis=0)
    return np.vstack([ring, ring[:1]])


def _total_turning(line: Floats, unit: float) -> float:
    """Angle by which a curve turns in all, without the noise of its polyline."""
    import shapely

    noise = 0.5 * SAGITTA * unit
    course = shapely.simplify(shapely.LineString(line), noise, preserve_topology=False)
    return float(turns(shapely.get_coordinates(course)).sum())


def _split(line: Floats, places: Geometry, size: SizeField) -> list[Floats]:
    """Cut a polyline at the corners that stand out, and at its vertices on given places."""
    import shapely

    unit = float(size.at(line).min())
    corner = np.zeros(len(line), dtype=bool)
    corner[1:-1] = (turns(line) > CORNER) | _rounded_corner(line / unit)
    if corner.any():
        outstanding = shapely.get_coordinates(
            shapely.simplify(shapely.LineString(line), CHORD * unit, preserve_topology=False)
        )
        keep = {tuple(point) for point in outstanding}
        corner &= np.fromiter((tuple(point) in keep for point in line), bool, len(line))
    corner[1:-1] |= lies_on(places, line[1:-1])
    cuts = [0, *np.flatnonzero(corner).tolist(), len(line) - 1]
    return [line[a : b + 1] for a, b in pairwise(cuts)]


def _rounded_corner(line: Floats) -> NDArray[np.bool_]:
    """Middle of each fillet that is much smaller than an edge: chords would cut it off."""
    window = 0.4
    s = arc_lengths(line)
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
    sharp = turns(line) > CORNER
    for k in np.flatnonzero(found):
        found[k] = not sharp[np.abs(inner - inner[k]) < 2 * window].any()
    return found


def _with_feet(pieces: list[Floats], plan: Plan, size: SizeField) -> list[Floats]:
    """Pieces divided where the end of another one comes closer to them than `MERGE`."""
    import shapely

    places = np.unique([end for piece in pieces for end in (piece[0], piece[-1])], axis=0)
    lines = np.array([shapely.LineString(piece) for piece in pieces])
    reach = MERGE * size.at(places)
    tree = shapely.STRtree(lines)
    ends = np.array([[piece[0], piece[-1]] for piece in pieces])
    cuts: dict[int, list[float]] = {}
    points = shapely.points(places)
    place, piece = tree.query(points, predicate="dwithin", distance=reach)
    away = np.linalg.norm(ends[piece] - places[place][:, None], axis=2).min(axis=1)
    along = shapely.line_locate_point(lines[piece], points[place])
    inside = np.minimum(along, shapely.length(lines[piece]) - along)
    free = (away > reach[place]) & (inside > reach[place])
    free &= ~np.array([lies_on(plan.locked, pieces[k]).all() for k in piece], dtype=bool)
    for k, s in zip(piece[free].tolist(), along[free].tolist(), strict=True):
        cuts.setdefault(k, []).append(s)
    divided: list[Floats] = []
    for k, line in enumerate(pieces):
        knots, start = arc_lengths(line), 0.0
        for s in [*sorted(cuts.get(k, [])), float(knots[-1])]:
            if s - start < 1e-3:
                continue
            tips = [[np.interp(t, knots, line[:, axis]) for axis in (0, 1)] for t in (start, s)]
            within = line[(knots > start + 1e-9) & (knots < s - 1e-9)]
            divided.append(line if k not in cuts else np.vstack([tips[:1], within, tips[1:]]))
            start = s
    return divided


def _joined(pieces: list[Floats], plan: Plan, size: SizeField) -> Curves:
    """Number the ends of the pieces, merge those that are too close, and chain the curves."""
    import shapely

    pieces = _with_feet(pieces, plan, size)
    tips = np.array([end for piece in pieces for end in (piece[0], piece[-1])])
    places, ends = np.unique(tips, axis=0, return_inverse=True)
    ends = ends.reshape(-1, 2)
    unit = size.at(places)
    lengths = np.array([arc_lengths(piece)[-1] for piece in pieces])
    label, nodes = merged_places(places, ends, lengths / unit[ends].min(axis=1), unit, plan)
    lines: list[Floats] = []
    kept: list[tuple[int, int]] = []
    for piece, (a, b), length in zip(pieces, ends, lengths, strict=True):
        first, last = int(label[a]), int(label[b])
        if first == last and length < 2 * MERGE * unit[a]:
            continue
        line = _reattached(piece, nodes[first], unit[a])
        lines.append(_reattached(line[::-1], nodes[last], unit[b])[::-1])
        kept.append((first, last))
    twins = closed_slivers(lines, kept, plan, size)
    lines = [line for k, line in enumerate(lines) if k not in twins]
    kept = [pair for k, pair in enumerate(kept) if k not in twins]
    # Vertices of what lies beside a locked line must not change how it is divided.
    locked = np.array([lies_on(plan.locked, line).all() for line in lines])
    lines = [line[[0, -1]] if one else line for line, one in zip(lines, locked, strict=True)]
    if not isinstance(size, UniformSize):
        # No round number: lines of equal length must get equally many vertices.
        step = 0.4963 * size.finest
        lines = [
            shapely.get_coordinates(shapely.segmentize(shapely.LineString(line), step))
            for line in lines
        ]
    units = [float(size.at(line).min()) for line in lines]
    arcs = [arc_lengths(line) for line in lines]
    lengths = np.array([arc[-1] for arc in arcs])
    starts = np.concatenate([[0.0], np.cumsum(lengths[:-1] + 1.0)])
    used, ends = np.unique(np.array(kept), return_inverse=True)
    knots = np.concatenate([start + arc for start, arc in zip(starts, arcs, strict=True)])
    vertices = np.concatenate(lines)
    return Curves(
        nodes[used],
        ends.reshape(-1, 2),
        np.stack([starts, starts + lengths], axis=1),
        knots,
        vertices,
        np.array([_total_turning(line, one) for line, one in zip(lines, units, strict=True)]),
        _measure(knots, vertices, plan, size),
        locked,
        np.array([lies_on(plan.slits, line).all() for line in lines]),
    )


def _measure(knots: Floats, vertices: Floats, plan: Plan, size: SizeField) -> Floats:
    if isinstance(size, UniformSize):
        return knots
    pace = 1.0 / size.at(vertices)
    locked = lies_on(plan.locked, vertices)
    pace[locked] = 1.0 / size.exactly_at(vertices[locked])
    steps = np.diff(knots) * 0.5 * (pace[1:] + pace[:-1])
    return np.concatenate([[0.0], np.cumsum(steps)])


def _reattached(line: Floats, node: Floats, unit: float) -> Floats:
    """A polyline that starts at a node near its first vertex and joins its course one edge on."""
    if np.abs(line[0] - node).max() <= 10 * GRID:
        return np.vstack([node, line[1:]])
    s = arc_lengths(line)
    ahead = min(unit, 0.5 * s[-1])
    joint = [np.interp(ahead, s, line[:, k]) for k in (0, 1)]
    return np.vstack([node, joint, line[s > ahead + 1e-9]])
