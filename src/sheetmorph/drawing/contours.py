"""From loose curves to contours: dropping what has no length, keeping copies once, joining ends."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.model import Curve, Floats
from sheetmorph.drawing.notes import Notes, at, mm

SAME = 1e-8
"""Ends that are no farther apart [m] are one point: the rounding of a written number."""

MAX_NEIGHBOURS = 5_000_000
_COPY = 1e-7

End = tuple[int, int]
"""A curve and its end: 0 where it starts, 1 where it ends."""


def cleaned(points: Floats, closed: bool, notes: Notes) -> Curve | None:
    """A curve without segments of length zero, or None when nothing is left; both are noted."""
    keep = np.append(np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-9, True)
    if closed and len(points) > 1 and np.linalg.norm(points[-1] - points[0]) <= 1e-9:
        keep[-1] = False
    # A closed outline that repeats its first point at the end is the custom, no fault.
    dropped = np.flatnonzero(~keep[:-1])
    left = points[keep]
    if len(left) < 2:
        notes.add("zero length", f"a line of length zero at {at(points[0])} was dropped")
        return None
    for index in dropped:
        notes.add(
            "zero-length segment", f"a segment of length zero at {at(points[index])} was dropped"
        )
    if closed and len(left) == 2:
        notes.add("two points", f"a contour of two points at {at(left[0])} was read as a line")
        closed = False
    return Curve(left, closed)


def joined(curves: Sequence[Curve], gap: float, notes: Notes) -> list[Curve]:
    """Join loose curves where their ends meet: first ends at one point, then across gaps.

    Copies of a curve are kept once. Where more than two ends meet, an even number is
    paired by direction so that no pair crosses another; an odd number stays apart.

    Args:
        curves: open and closed curves [m].
        gap: the widest gap to close [m]; both ends move to its middle.
        notes: receives the copies left out and the gaps closed, with coordinates.
    """
    found = _join(_once(curves, notes), min(SAME, gap), notes)
    if gap > SAME:
        short = [
            not c.closed and _length(c) <= gap and np.ptp(c.points, axis=0).max() <= gap
            for c in found
        ]
        for curve, is_short in zip(found, short, strict=True):
            if is_short:
                notes.add(
                    "shorter than the gap",
                    f"a line of {mm(_length(curve))} at {at(curve.points[0])} is shorter than "
                    "the allowed gap and was dropped",
                )
        kept = [curve for curve, is_short in zip(found, short, strict=True) if not is_short]
        found = _join(kept, gap, notes)
    return _once(found, notes)


def open_contour(curves: Iterable[Curve], gap: float, hint: str = "") -> InputError | None:
    """What to say of curves that do not close, with a hint, or None when all are closed."""
    loose = [curve for curve in curves if not curve.closed]
    if not loose:
        return None
    ends = np.array([curve.points[[0, -1]] for curve in loose]).reshape(-1, 2)
    distance, partner = cKDTree(ends).query(ends, k=2)
    # Of two ends in one place the search may name either first.
    own = np.arange(len(ends))
    other = np.where(partner[:, 1] == own, partner[:, 0], partner[:, 1])
    first = int(np.argmin(distance[:, 1]))
    a, b, apart = ends[first], ends[other[first]], float(distance[first, 1])
    more = f" ({len(loose) - 1} more lines do not close)" if len(loose) > 1 else ""
    if apart <= gap:
        count = int((np.linalg.norm(ends - a, axis=1) <= gap).sum())
        return InputError(
            f"{count} ends of lines meet at {at(a)}, but a contour has two there{more}; "
            "remove the lines that do not belong to a contour, or put them on a layer of their own"
        )
    return InputError(
        f"open contour: ends at {at(a)} and {at(b)} are {mm(apart)} apart{more}; "
        f"close it in the drawing{hint}",
        key="gap",
        allowed=f"gap of {mm(gap)}",
    )


def _join(curves: Sequence[Curve], tolerance: float, notes: Notes) -> list[Curve]:
    closed = [curve for curve in curves if curve.closed]
    loose = [curve for curve in curves if not curve.closed]
    if not loose:
        return closed
    ends = np.array([curve.points[[0, -1]] for curve in loose]).reshape(-1, 2)
    place = _places(ends, tolerance)
    count = int(place.max()) + 1
    middle = np.stack(
        [
            np.bincount(place, ends[:, k], count) / np.bincount(place, minlength=count)
            for k in (0, 1)
        ],
        axis=1,
    )
    meeting: list[list[int]] = [[] for _ in range(count)]
    for end, where in enumerate(place.tolist()):
        meeting[where].append(end)
    partner: dict[int, int] = {}
    for where, members in enumerate(meeting):
        if len(members) < 2 or len(members) % 2:
            continue
        ordered = members if len(members) == 2 else _by_direction(members, loose)
        for a, b in zip(ordered[::2], ordered[1::2], strict=True):
            partner[a], partner[b] = b, a
            apart = float(np.linalg.norm(ends[a] - ends[b]))
            if apart > SAME:
                notes.add("gap", f"a gap of {mm(apart)} at {at(middle[where])} was closed")
    return closed + _chains(loose, partner, place, middle)


def _chains(
    loose: Sequence[Curve], partner: dict[int, int], place: NDArray[np.int64], middle: Floats
) -> list[Curve]:
    """Follow partners from every free end, then round what is left. End 2 i + s is side s of i."""
    done = [False] * len(loose)
    free = [end for end in range(2 * len(loose)) if end not in partner]
    chains: list[Curve] = []
    for start in (*free, *range(0, 2 * len(loose), 2)):
        if done[start // 2]:
            continue
        pieces: list[Floats] = []
        end: int | None = start
        closed = False
        while end is not None:
            index, side = divmod(end, 2)
            done[index] = True
            points = loose[index].points[:: -1 if side else 1].copy()
            leave = end ^ 1
            if end in partner:
                points[0] = middle[place[end]]
            if leave in partner:
                points[-1] = middle[place[leave]]
            pieces.append(points[1:] if pieces else points)
            end = partner.get(leave)
            if end == start:
                closed, end = True, None
        chain = np.vstack(pieces)
        if closed:
            chain = chain[:-1]
        chains.append(Curve(chain, closed and len(chain) > 2))
    return chains


def _places(ends: Floats, tolerance: float) -> NDArray[np.int64]:
    """Number the places where ends lie, those within the tolerance as one, shape (E,)."""
    tree = cKDTree(ends)
    if int(tree.count_neighbors(tree, tolerance)) > MAX_NEIGHBOURS:
        raise InputError("too many lines end in one place")
    pairs = tree.query_pairs(tolerance, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(ends),) * 2)
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def _by_direction(members: Sequence[int], loose: Sequence[Curve]) -> list[int]:
    """Ends that meet in a place, sorted by the direction in which their curves leave it."""

    def direction(end: int) -> float:
        index, side = divmod(end, 2)
        a, b = loose[index].points[[-1, -2] if side else [0, 1]]
        return float(np.arctan2(b[1] - a[1], b[0] - a[0]))

    return sorted(members, key=direction)


def _once(curves: Sequence[Curve], notes: Notes) -> list[Curve]:
    """Leave out copies: curves that agree to 0.1 µm in box, length, middle and ends."""
    if len(curves) < 2:
        return list(curves)
    points = np.vstack([curve.points for curve in curves])
    first = np.cumsum([0, *(len(curve.points) for curve in curves[:-1])])
    boxes = [pick.reduceat(points, first, axis=0) for pick in (np.minimum, np.maximum)]
    _, group, count = np.unique(
        _on_grid(np.hstack(boxes)), axis=0, return_inverse=True, return_counts=True
    )
    shared = count[group.ravel()] > 1
    kept: list[Curve] = []
    seen: set[tuple[int, ...]] = set()
    for curve, has_rivals in zip(curves, shared.tolist(), strict=True):
        if not has_rivals:
            kept.append(curve)
            continue
        key = tuple(_on_grid(_features(curve)).tolist())
        if (*key, curve.closed) in seen:
            what = "contour" if curve.closed else "line"
            notes.add(
                "drawn twice",
                f"the {what} at {at(curve.points[0])} is drawn twice and was kept once",
            )
            continue
        seen.add((*key, curve.closed))
        kept.append(curve)
    return kept


def _on_grid(values: Floats) -> NDArray[np.int64]:
    """Cells of a grid; an offset keeps the round numbers of drawings off its limits."""
    return np.floor(values / _COPY + 0.37).astype(np.int64)


def _features(curve: Curve) -> Floats:
    """Numbers that do not depend on the direction of a curve, nor on where a closed one starts."""
    path = curve.path
    chords = np.linalg.norm(np.diff(path, axis=0), axis=1)
    length = chords.sum()
    box = [*path.min(axis=0), *path.max(axis=0)]
    centres = (path[1:] + path[:-1]) / 2.0
    if curve.closed:
        moments = [chords @ centres[:, 0], chords @ centres[:, 1], chords @ (centres[:, 0] ** 2)]
        moments = [moments[0] / length, moments[1] / length, (moments[2] / length) ** 0.5]
        return np.array([*box, length, *moments])
    first, last = path[0], path[-1]
    mean = chords @ centres / length
    return np.array([*box, length, *mean, *(first + last), *np.abs(first - last)])


def _length(curve: Curve) -> float:
    return float(np.linalg.norm(np.diff(curve.path, axis=0), axis=1).sum())
