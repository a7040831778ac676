"""Strokes as ribs: the area that a pen of some width leaves behind."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.drawing.model import Curve, Floats, Pen

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

_CAPS = {"butt": "flat", "round": "round", "square": "square"}
# A chord of a curve turns by less: such corners are kept sharp even where joins are cut.
_SMOOTH_TURN = 0.2


def rib(pen: Pen, flatness: float) -> BaseGeometry:
    """The area of a stroke [m] with its caps and joins, as SVG paints it.

    A mitre longer than its limit falls back to a bevel, as SVG wants; shapely would cut
    it at the limit, so that mitres are put onto a bevelled stroke here.
    """
    import shapely
    from shapely.affinity import affine_transform

    half = pen.width / 2.0
    scale = math.sqrt(abs(float(np.linalg.det(pen.matrix[:, :2])))) or 1.0
    ratio = min(flatness / max(half * scale, 1e-12), 0.25)
    quarter = max(math.ceil(math.pi / 4.0 / math.acos(1.0 - ratio)), 4)
    style = "round" if pen.join == "round" else "bevel"
    parts: list[BaseGeometry] = []
    for curve in pen.curves:
        line = _line(curve)
        if line is None:
            continue
        parts.append(
            shapely.buffer(
                line,
                half,
                quad_segs=min(quarter, 500),
                cap_style=_CAPS[pen.cap],
                join_style=style,
            )
        )
        if pen.join != "round":
            limit = pen.miter_limit if pen.join == "miter" else 0.0
            parts.append(_mitres(curve, half, limit))
    a, b, c, d, e, f = pen.matrix.T.ravel()
    return affine_transform(shapely.union_all(parts), [a, c, b, d, e, f])


def _line(curve: Curve) -> BaseGeometry | None:
    import shapely

    if len(curve.points) < 2:
        return shapely.Point(curve.points[0]) if len(curve.points) else None
    if curve.closed and len(curve.points) > 2:
        return shapely.LinearRing(curve.points)
    return shapely.LineString(curve.path)


def _mitres(curve: Curve, half: float, limit: float) -> BaseGeometry:
    """The tips that mitres add to bevels, for corners within the limit."""
    import shapely

    path = curve.path
    if curve.closed:
        path = np.vstack([path, path[1:2]])
    step = np.diff(path, axis=0)
    length = np.linalg.norm(step, axis=1)
    keep = length > 0.0
    step, corner = step[keep] / length[keep, None], path[1:][keep]
    if len(step) < 2:
        return shapely.Polygon()
    before, after, tip = step[:-1], step[1:], corner[:-1]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turn = np.arctan2(cross, (before * after).sum(axis=1))
    sharp = 1.0 / np.maximum(np.cos(turn / 2.0), 1e-9)
    chosen = (np.abs(turn) > 1e-9) & ((sharp <= limit) | (np.abs(turn) < _SMOOTH_TURN))
    if not chosen.any():
        return shapely.Polygon()
    before, after, tip, turn = before[chosen], after[chosen], tip[chosen], turn[chosen]
    outward = -np.sign(turn)[:, None] * half
    a, b = tip + outward * _left(before), tip + outward * _left(after)
    middle = _left(before) + _left(after)
    middle /= np.linalg.norm(middle, axis=1)[:, None]
    peak = tip + outward * middle * sharp[chosen][:, None]
    return shapely.union_all(shapely.polygons(np.stack([tip, a, peak, b], axis=1)))


def _left(direction: Floats) -> Floats:
    return np.stack([-direction[:, 1], direction[:, 0]], axis=1)
