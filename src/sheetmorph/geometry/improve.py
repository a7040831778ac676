"""Raising the smallest angles of a triangulation, one independent set of points at a time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sheetmorph.core.compiled import kernel
from sheetmorph.geometry.boundary import Curves
from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.sampling import Sampling
from sheetmorph.geometry.smooth import corner_angles
from sheetmorph.geometry.triangulate import Indices

STEPS = (0.24, 0.12, 0.04, 0.012)  # lengths of the trial moves, in edge lengths
DIRECTIONS = 12


@dataclass(frozen=True, eq=False)
class Stars:
    """The triangles (point, left, right) around each point, point after point.

    Attributes:
        start: first row of each point, shape (N + 1,).
        others: the two other corners, counter-clockwise, shape (3 T, 2).
    """

    start: Indices
    others: Indices

    @classmethod
    def of(cls, triangles: Indices, count: int) -> Stars:
        """Stars of `count` points."""
        order = np.argsort(triangles.ravel(), kind="stable")
        others = np.stack([np.roll(triangles, -1, 1).ravel(), np.roll(triangles, -2, 1).ravel()])
        start = np.zeros(count + 1, dtype=np.intp)
        np.cumsum(np.bincount(triangles.ravel(), minlength=count), out=start[1:])
        return cls(start, others.T[order])

    def degree(self, chosen: Indices) -> int:
        """Most triangles around one of these points."""
        return int((self.start[chosen + 1] - self.start[chosen]).max())


def sharpen(
    points: Floats,
    stations: Floats,
    triangles: Indices,
    curves: Curves,
    sampling: Sampling,
    target: float,
    rounds: int,
) -> tuple[Floats, Floats]:
    """Move points around triangles whose smallest angle is below a target.

    Every round takes a set of such points of which no two are neighbours, tries moves in
    all directions (along the curve for points on a boundary) and keeps the one that makes
    the smallest angle around the point largest: local max-min-angle optimisation after
    Freitag & Ollivier-Gooch (1997), by pattern search.

    Args:
        points: positions, shape (N, 2); the first B are those of `sampling`.
        stations: present arc length of the B boundary points, shape (B,).
        triangles: corner indices, shape (T, 3).
        target: angle [rad] above which triangles are left alone.
        rounds: number of sets.

    Returns:
        New positions and stations.
    """
    points, stations = points.copy(), stations.copy()
    stars = Stars.of(triangles, len(points))
    movable = np.ones(len(points), dtype=bool)
    movable[: len(stations)] = np.isfinite(stations)
    bad = corner_angles(points, triangles).min(axis=1) < target
    near = np.unique(triangles[bad])
    near = near[movable[near]]
    worst = np.full(len(points), np.pi)
    for turn in range(rounds):
        if len(near):
            worst[near] = _smallest_angle(points, near, points[near][:, None], stars)[:, 0]
        active = near[worst[near] < target]
        chosen = _independent(active, stars, len(points), turn)
        if not len(chosen):
            break
        on_curve = chosen < len(stations)
        for group, sliding in ((chosen[~on_curve], False), (chosen[on_curve], True)):
            if not len(group):
                continue
            spokes = np.empty((len(group), stars.degree(group)))
            _write_spokes(points, group, stars.start, stars.others, spokes)
            scale = spokes.mean(axis=1)
            if sliding:
                trial_at = _slides(group, stations, scale, curves, sampling)
                trial = curves.at(trial_at)
            else:
                trial = points[group][:, None] + scale[:, None, None] * _moves(turn)
            quality = _smallest_angle(points, group, trial, stars)
            best = quality.argmax(axis=1)
            better = quality.max(axis=1) > worst[group] + 1e-9
            rows = np.flatnonzero(better)
            points[group[rows]] = trial[rows, best[rows]]
            if sliding:
                stations[group[rows]] = trial_at[rows, best[rows]]
    return points, stations


def _independent(active: Indices, stars: Stars, count: int, turn: int) -> Indices:
    """Those active points whose pseudo-random rank is above that of all active neighbours."""
    if not len(active):
        return active
    rank = np.zeros(count, dtype=np.uint64)
    mixed = (active.astype(np.uint64) + np.uint64(1 + 7919 * turn)) * np.uint64(2654435761)
    rank[active] = (mixed % np.uint64(2**32)) * np.uint64(count) + active.astype(np.uint64) + 1
    first = np.empty(len(active), dtype=np.bool_)
    _write_unrivalled(active, rank, stars.start, stars.others, first)
    return np.asarray(active[first])


def _moves(turn: int) -> Floats:
    """Trial moves, turned a little every round, shape (n, 2)."""
    angle = 2 * np.pi * (np.arange(DIRECTIONS) + 0.382 * turn) / DIRECTIONS
    unit = np.stack([np.cos(angle), np.sin(angle)], -1)
    return np.concatenate([step * unit for step in STEPS])


def _slides(
    group: Indices, stations: Floats, scale: Floats, curves: Curves, sampling: Sampling
) -> Floats:
    """Trial arc lengths of points on curves; a point stays clear of the ones beside it."""
    here = stations[group]
    curve = np.searchsorted(curves.spans[:, 0], here, side="right") - 1
    limits = []
    for side in (0, 1):
        beside = sampling.along[group, side]
        at = stations[beside]
        limits.append(np.where(np.isnan(at), curves.spans[curve, side], at))
    low, high = limits
    margin = 0.2 * (high - low)
    steps = np.concatenate([np.array(STEPS), -np.array(STEPS)])
    trial = here[:, None] + scale[:, None] * steps
    low, high = np.minimum(low + margin, here), np.maximum(high - margin, here)
    return np.asarray(np.clip(trial, low[:, None], high[:, None]))


def _smallest_angle(points: Floats, chosen: Indices, trial: Floats, stars: Stars) -> Floats:
    """Smallest angle of the star if its centre were at each trial, shape (n, trials).

    The smallest angle has the largest cotangent: one arc tangent per star is enough.
    Triangles turned over count as angles of zero.
    """
    cotangents = np.empty(trial.shape[:2])
    _write_cotangents(points, chosen, trial, stars.start, stars.others, cotangents)
    return np.asarray(np.arctan2(1.0, cotangents))


@kernel
def _write_cotangents(points, chosen, trial, start, others, found):  # type: ignore[no-untyped-def]
    """The largest cotangent, scalar product over cross product, of each star at each trial."""
    for i in range(len(chosen)):
        for j in range(trial.shape[1]):
            x, y = trial[i, j, 0], trial[i, j, 1]
            worst = -np.inf
            for row in range(start[chosen[i]], start[chosen[i] + 1]):
                p, q = others[row, 0], others[row, 1]
                ux, uy = points[p, 0] - x, points[p, 1] - y
                vx, vy = points[q, 0] - x, points[q, 1] - y
                wx, wy = points[q, 0] - points[p, 0], points[q, 1] - points[p, 1]
                cross = ux * vy - uy * vx
                largest = max(ux * vx + uy * vy, -(ux * wx + uy * wy), vx * wx + vy * wy)
                worst = max(worst, largest / cross if cross > 0.0 else np.inf)
            found[i, j] = worst


@kernel
def _write_spokes(points, chosen, start, others, found):  # type: ignore[no-untyped-def]
    """Lengths from points to their neighbours, a row each, the last repeated to fill the row.

    Their mean is the scale of trial moves; that the last counts more there does not matter.
    """
    for i in range(len(chosen)):
        first, last = start[chosen[i]], start[chosen[i] + 1] - 1
        for k in range(found.shape[1]):
            near = others[min(first + k, last), 0]
            x = points[near, 0] - points[chosen[i], 0]
            y = points[near, 1] - points[chosen[i], 1]
            found[i, k] = math.sqrt(x * x + y * y)


@kernel
def _write_unrivalled(active, rank, start, others, found):  # type: ignore[no-untyped-def]
    """Which points have a higher rank than all their neighbours."""
    for i in range(len(active)):
        found[i] = True
        for row in range(start[active[i]], start[active[i] + 1]):
            for end in range(2):
                if rank[others[row, end]] >= rank[active[i]]:
                    found[i] = False
