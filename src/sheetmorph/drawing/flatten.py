"""Curves as chains of chords that stay within a distance of the true curve."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from sheetmorph.drawing.model import Floats
from sheetmorph.drawing.notes import Budget

_LEAST_PER_TURN = 12


def arc(
    centre: Floats,
    u: Floats,
    v: Floats,
    start: float,
    sweep: float,
    tolerance: float,
    budget: Budget,
) -> Floats:
    """Points centre + u cos φ + v sin φ with φ from `start` over `sweep` [rad], shape (N, D).

    A circle's sagitta r (1 − cos Δφ/2) bounds the chord error, with the larger half-axis
    as radius. A full turn does not repeat its first point.
    """
    size = max(math.hypot(*u), math.hypot(*v))
    ratio = min(tolerance / size, 1.0) if size > 0.0 else 1.0
    step = min(2.0 * math.acos(1.0 - ratio), 2.0 * math.pi / _LEAST_PER_TURN)
    # Below a ratio of 1e-16 the cosine is one: the budget refuses the infinite number.
    count = budget.vertices(math.ceil(abs(sweep) / step) if step > 0.0 else math.inf)
    full = abs(abs(sweep) - 2.0 * math.pi) < 1e-12
    angle = start + sweep * np.linspace(0.0, 1.0, max(count, 1) + 1)
    if full:
        angle = angle[:-1]
    return np.asarray(
        centre + np.cos(angle)[:, None] * u + np.sin(angle)[:, None] * v, dtype=np.float64
    )


def bezier(controls: Floats, tolerance: float, budget: Budget) -> Floats:
    """Points on a Bézier curve of degree 2 or 3, its ends included, shape (N, D).

    With n equal parts of the parameter the chord error is below
    d (d − 1) / 8 · max |second difference of the controls| / n².
    """
    degree = len(controls) - 1
    bend = float(np.linalg.norm(np.diff(controls, n=2, axis=0), axis=1).max())
    wanted = math.sqrt(degree * (degree - 1) / 8.0 * bend / tolerance)
    count = budget.vertices(max(math.ceil(wanted), 1) if math.isfinite(wanted) else math.inf)
    t = np.linspace(0.0, 1.0, count + 1)[:, None]
    rows = list(controls)
    for _ in range(degree):
        rows = [(1.0 - t) * a + t * b for a, b in pairwise(rows)]
    points = np.asarray(rows[0], dtype=np.float64)
    points[0], points[-1] = controls[0], controls[-1]
    return points


def bulge(a: Floats, b: Floats, value: float, tolerance: float, budget: Budget) -> Floats:
    """The arc from a to b, shape (2,), whose quarter angle has the tangent `value`; ends included.

    A positive bulge lies to the right of a→b, so that the arc runs counter-clockwise.
    """
    chord = b - a
    if value == 0.0 or not chord.any():
        budget.vertices(1)
        return np.array([a, b])
    sweep = 4.0 * math.atan(value)
    normal = np.array([-chord[1], chord[0]])
    centre = (a + b) / 2.0 + normal * (1.0 - value * value) / (4.0 * value)
    u = a - centre
    points = arc(centre, u, np.array([-u[1], u[0]]), 0.0, sweep, tolerance, budget)
    points[0], points[-1] = a, b
    return points
