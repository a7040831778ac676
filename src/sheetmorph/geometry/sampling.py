"""Nodes on boundary curves: equal parts, as long as the wanted edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sheetmorph.geometry.boundary import SAGITTA, Curves
from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.triangulate import Indices

REFINEMENTS = 4  # how often parts may be halved
RATIO = 2.0  # parts that meet differ by less than this
SHORTEST = 0.15  # no part is made shorter than this, in shortest wanted edge lengths
NEAR = 0.5  # a node closer to a part than this share of its length is too close
SHARP = np.radians(30.0)
FAN = 1.1  # parts beside a sharp corner are longer than the gap between its sides by this
LONGEST_FAN = 40  # most parts beside a sharp corner


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


def even_stations(curves: Curves, counts: Indices) -> Floats:
    """Arc lengths that divide each curve into parts of equal measure, increasing.

    Args:
        counts: parts of each curve, shape (C,), each at least 1.
    """
    inner = counts - 1
    total = int(inner.sum())
    owner = np.repeat(np.arange(len(counts)), inner)
    place = np.arange(total) - np.repeat(np.cumsum(inner) - inner, inner) + 1
    low, high = curves.measured(curves.spans)[owner].T
    return curves.stations(low + (high - low) * place / counts[owner])


def refined_stations(curves: Curves, stations: Floats) -> Floats:
    """Arc lengths with more of them in sharp corners and where parts are long beside others.

    A part is halved when a node off its ends is closer to it than `NEAR` of its length, so
    that the triangle between them would be flat, or when it is much longer than a part that
    it meets. The two parts that make a sharp corner stay: halving them would only make the
    narrow triangle there smaller.
    """
    fixed = len(curves.nodes)
    stations = _fanned(curves, stations)
    for _ in range(REFINEMENTS):
        chain = np.sort(np.concatenate([curves.spans.ravel(), stations]))
        owner = np.searchsorted(curves.spans[:, 0], chain, side="right") - 1
        node = fixed + np.arange(len(chain))
        at_start, at_end = chain == curves.spans[owner, 0], chain == curves.spans[owner, 1]
        node[at_start] = curves.ends[owner[at_start], 0]
        node[at_end] = curves.ends[owner[at_end], 1]
        first = np.flatnonzero(~at_end)
        long = chain[first + 1] - chain[first]
        place = curves.at(chain)
        ends = np.stack([place[first], place[first + 1]], axis=1)
        sides = np.stack([node[first], node[first + 1]], axis=1)
        shortest = np.full(fixed + len(chain), np.inf)
        np.minimum.at(shortest, sides.ravel(), np.repeat(long, 2))
        halve = long > RATIO * shortest[sides].min(axis=1)
        halve |= _beside(ends, sides, place, node) < NEAR * long
        halve &= (long > 2.0 * SHORTEST) & ~curves.locked[owner[first]]
        halve &= ~_make_sharp_corner(ends, sides)[0]
        if not halve.any():
            break
        new = 0.5 * (chain[first] + chain[first + 1])[halve]
        stations = np.sort(np.concatenate([stations, new]))
    return stations


def _fanned(curves: Curves, stations: Floats) -> Floats:
    """Arc lengths whose distances grow away from sharp corners as the gap between the curves."""
    corners = _sharp_ends(curves, stations)
    owner = np.searchsorted(curves.spans[:, 0], stations, side="right") - 1
    kept = [stations[~np.isin(owner, [curve for curve, _ in corners])]]
    for curve in sorted({curve for curve, _ in corners}):
        low, high = curves.spans[curve].tolist()
        part = (high - low) / (1 + np.count_nonzero(owner == curve))
        both = (curve, 0) in corners and (curve, 1) in corners
        room = (high - low) * (0.5 if both else 1.0) - 0.7 * part
        fans = [
            _fan(corners[curve, end], part, room) if (curve, end) in corners else np.empty(0)
            for end in (0, 1)
        ]
        first, last = low + fans[0], high - fans[1][::-1]
        start = first[-1] if len(first) else low
        stop = last[0] if len(last) else high
        count = max(round((stop - start) / part), 1)
        kept += [first, np.linspace(start, stop, count + 1)[1:-1], last]
    return np.sort(np.concatenate(kept))


def _fan(angle: float, part: float, room: float) -> Floats:
    """Distances from a sharp corner: one part, then as wide apart as the sides are there."""
    places: list[float] = []
    place = part
    while place < room and len(places) < LONGEST_FAN:
        places.append(place)
        step = FAN * angle * place
        if step > 0.8 * part:
            break
        place += step
    return np.array(places)


def _sharp_ends(curves: Curves, stations: Floats) -> dict[tuple[int, int], float]:
    """Curves and their ends (0 or 1) that make a corner below `SHARP`, and its angle [rad]."""
    inner = np.bincount(
        np.searchsorted(curves.spans[:, 0], stations, side="right") - 1, minlength=len(curves.ends)
    )
    low, high = curves.spans.T
    part = (high - low) / (inner + 1)
    place = np.concatenate([curves.at(low + part), curves.at(high - part)])
    node = curves.ends.T.ravel()
    step = place - curves.nodes[node]
    heading = np.arctan2(step[:, 1], step[:, 0])
    order = np.lexsort((heading, node))
    one, other = order, np.roll(order, -1)
    # The last one at a node is beside the first one.
    last = np.flatnonzero(np.diff(node[order], append=-1))
    other[last] = order[np.concatenate([[0], last[:-1] + 1])]
    between = (heading[other] - heading[one]) % (2.0 * np.pi)
    found: dict[tuple[int, int], float] = {}
    for k in np.flatnonzero((between < SHARP) & (one != other)).tolist():
        for end in (one[k], other[k]):
            curve, side = int(end % len(part)), int(end // len(part))
            if inner[curve] and not curves.locked[curve]:
                found[curve, side] = min(found.get((curve, side), np.inf), float(between[k]))
    return found


def _beside(ends: Floats, sides: Indices, place: Floats, node: Indices) -> Floats:
    """Distance of the nearest node that is no end of a segment, shape (M,)."""
    _, near = cKDTree(place).query(ends.mean(axis=1), k=min(10, len(place)))
    a, along = ends[:, :1], ends[:, 1:] - ends[:, :1]
    off = place[near] - a
    share = (off * along).sum(axis=2) / (along * along).sum(axis=2)
    off -= np.clip(share, 0.0, 1.0)[:, :, None] * along
    distance = np.linalg.norm(off, axis=2)
    distance[(node[near] == sides[:, :1]) | (node[near] == sides[:, 1:])] = np.inf
    return np.asarray(distance.min(axis=1))


def _make_sharp_corner(ends: Floats, sides: Indices) -> tuple[NDArray[np.bool_], Indices]:
    """Which segments make a corner below `SHARP` with another one, shape (M,), and where."""
    step = ends[:, 1] - ends[:, 0]
    heading = np.concatenate(
        [np.arctan2(step[:, 1], step[:, 0]), np.arctan2(-step[:, 1], -step[:, 0])]
    )
    node = np.concatenate([sides[:, 0], sides[:, 1]])
    order = np.lexsort((heading, node))
    first = np.flatnonzero(np.diff(node[order], prepend=-1))
    following = np.arange(1, len(order) + 1)
    following[np.append(first[1:], len(order)) - 1] = first
    between = (heading[order][following] - heading[order]) % (2.0 * np.pi)
    sharp = (between < SHARP) & (following != np.arange(len(order)))
    found = np.zeros(len(sides), dtype=bool)
    found[order[sharp] % len(sides)] = True
    found[order[following[sharp]] % len(sides)] = True
    return found, np.unique(node[order[sharp]])


def sharp_corners(sampling: Sampling) -> Indices:
    """Nodes where two segments make a corner below `SHARP`, which no mesh can improve."""
    return _make_sharp_corner(sampling.points[sampling.segments], sampling.segments)[1]


def sample(curves: Curves, stations: Floats) -> Sampling:
    """Nodes at the ends of the curves and at increasing arc lengths between them."""
    fixed, total = len(curves.nodes), len(stations)
    owner = np.searchsorted(curves.spans[:, 0], stations, side="right") - 1
    index = fixed + np.arange(total)
    along = np.stack([index - 1, index + 1], axis=1)
    at_start = np.diff(owner, prepend=-1) != 0
    at_end = np.diff(owner, append=-1) != 0
    along[at_start, 0] = curves.ends[owner[at_start], 0]
    along[at_end, 1] = curves.ends[owner[at_end], 1]
    single = np.bincount(owner, minlength=len(curves.ends)) == 0
    segments = np.concatenate(
        [
            curves.ends[single],
            np.stack([along[:, 0], index], axis=1),
            np.stack([index, along[:, 1]], axis=1)[at_end],
        ]
    )
    slides = np.where(curves.locked[owner], np.nan, stations)
    return Sampling(
        np.concatenate([curves.nodes, curves.at(stations)]),
        segments,
        np.concatenate([np.full(fixed, np.nan), slides]),
        np.concatenate([np.full((fixed, 2), -1), along]),
    )


def part_counts(curves: Curves) -> Indices:
    """Numbers of parts that bring the edges of each curve closest to the wanted length."""
    low, high = curves.measured(curves.spans).T
    length = high - low
    counts = np.maximum(np.floor(length), 1.0)
    # The ratio of the edge to 1 decides, not the difference: n → n + 1 at length √(n (n + 1)).
    counts += length > np.sqrt(counts * (counts + 1.0))
    turning = np.where(curves.locked, 0.0, curves.turning)
    counts = np.maximum(counts, np.ceil(np.sqrt(length * turning / (8.0 * SAGITTA))))
    loop = curves.ends[:, 0] == curves.ends[:, 1]
    counts = np.where(loop, np.maximum(counts, 5), counts).astype(np.intp)
    # A slit between two tips opens at the nodes between them.
    slit_ends = np.bincount(curves.ends[curves.cut].ravel(), minlength=len(curves.nodes))
    lone = curves.cut & (slit_ends[curves.ends] == 1).all(axis=1)
    counts = np.where(lone, np.maximum(counts, 2), counts)
    # Two curves between the same nodes must not become the same edge.
    pair = np.sort(curves.ends, axis=1)
    order = np.lexsort((-length, curves.locked, counts, pair[:, 1], pair[:, 0]))
    same = (np.diff(pair[order], axis=0) == 0).all(axis=1)
    both_single = same & (counts[order][1:] == 1)
    counts[order[:-1][both_single]] = 2
    return np.asarray(counts)
