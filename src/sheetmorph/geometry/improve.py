"""Raising the smallest angles of a triangulation, one independent set of points at a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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

    def around(self, chosen: Indices) -> Indices:
        """Other corners around chosen points, shape (n, degree, 2), the last repeated."""
        degree = self.start[chosen + 1] - self.start[chosen]
        slot = np.minimum(np.arange(degree.max())[None, :], degree[:, None] - 1)
        return np.asarray(self.others[self.start[chosen][:, None] + slot])


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
            worst[near] = _smallest_angle(points[near][:, None], points[stars.around(near)])[:, 0]
        active = near[worst[near] < target]
        chosen = _independent(active, stars, len(points), turn)
        if not len(chosen):
            break
        on_curve = chosen < len(stations)
        for group, sliding in ((chosen[~on_curve], False), (chosen[on_curve], True)):
            if not len(group):
                continue
            around = stars.around(group)
            scale = np.linalg.norm(points[around[:, :, 0]] - points[group][:, None], axis=2)
            scale = scale.mean(axis=1)
            if sliding:
                trial_at = _slides(group, stations, scale, curves, sampling)
                trial = curves.at(trial_at)
            else:
                trial = points[group][:, None] + scale[:, None, None] * _moves(turn)
            quality = _smallest_angle(trial, points[around])
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
    around = stars.around(active)
    rivals = np.maximum(rank[around[:, :, 0]].max(axis=1), rank[around[:, :, 1]].max(axis=1))
    return np.asarray(active[rank[active] > rivals])


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


def _smallest_angle(trial: Floats, around: Floats) -> Floats:
    """Smallest angle of the star if its centre were at each trial, shape (n, trials).

    The smallest angle has the largest cotangent, scalar product over cross product: one arc
    tangent per star is enough. Triangles turned over count as angles of zero.
    """
    corners = around[:, None]
    px, py, qx, qy = (corners[..., end, axis] for end in (0, 1) for axis in (0, 1))
    x, y = trial[:, :, None, 0], trial[:, :, None, 1]
    ux, uy, vx, vy = px - x, py - y, qx - x, qy - y
    wx, wy = qx - px, qy - py
    cross = ux * vy - uy * vx
    at_trial = ux * vx + uy * vy
    at_p, at_q = -(ux * wx + uy * wy), vx * wx + vy * wy
    largest = np.maximum(np.maximum(at_trial, at_p), at_q)
    cotangent = np.divide(largest, cross, out=np.full_like(cross, np.inf), where=cross > 0.0)
    return np.asarray(np.arctan2(1.0, cotangent.max(axis=2)))
