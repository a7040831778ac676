"""The curves of single DXF entities, flattened in the coordinates of their layout."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.flatten import arc, bulge
from sheetmorph.drawing.model import Floats
from sheetmorph.drawing.notes import Budget

Pieces = list[tuple[Floats, bool]]
"""Curves as points, shape (N, 3), and whether they are closed."""

MAX_CONTROLS = 20_000
_FULL = 2.0 * math.pi


def curves_of(entity: Any, tolerance: float, budget: Budget) -> Pieces:
    """The curves of an entity whose kind is in `SHAPES`.

    Args:
        entity: an entity of ezdxf.
        tolerance: largest chord error in the entity's units.
        budget: pays for the vertices.
    """
    return SHAPES[entity.dxftype()](entity, tolerance, budget)


def is_mesh(entity: Any) -> bool:
    """Whether a POLYLINE is one of those that hold faces in space."""
    return entity.dxftype() == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline)


def _line(entity: Any, _tolerance: float, budget: Budget) -> Pieces:
    budget.vertices(2)
    return [(np.array([_point(entity.dxf.start), _point(entity.dxf.end)]), False)]


def _arc(entity: Any, tolerance: float, budget: Budget) -> Pieces:
    start, end = (math.radians(entity.dxf.get(k, 0.0)) for k in ("start_angle", "end_angle"))
    sweep = (end - start) % _FULL or _FULL
    points = _round(entity.dxf, start, sweep, tolerance, budget)
    return [(points @ _axes(entity), sweep == _FULL)]


def _circle(entity: Any, tolerance: float, budget: Budget) -> Pieces:
    return [(_round(entity.dxf, 0.0, _FULL, tolerance, budget) @ _axes(entity), True)]


def _round(dxf: Any, start: float, sweep: float, tolerance: float, budget: Budget) -> Floats:
    radius = abs(float(dxf.radius))
    u, v = np.array([radius, 0.0, 0.0]), np.array([0.0, radius, 0.0])
    return arc(_point(dxf.center), u, v, start, sweep, tolerance, budget)


def _ellipse(entity: Any, tolerance: float, budget: Budget) -> Pieces:
    u = _point(entity.dxf.major_axis)
    normal = _point(entity.dxf.get("extrusion", (0.0, 0.0, 1.0)))
    length = float(np.linalg.norm(normal))
    v = np.cross(normal / (length or 1.0), u) * float(entity.dxf.get("ratio", 1.0))
    start = float(entity.dxf.get("start_param", 0.0))
    sweep = (float(entity.dxf.get("end_param", _FULL)) - start) % _FULL
    # A parameter written with few digits misses the full turn by its rounding.
    full = sweep < 1e-9 or _FULL - sweep < 1e-9
    centre = _point(entity.dxf.center)
    return [(arc(centre, u, v, start, _FULL if full else sweep, tolerance, budget), full)]


def _lwpolyline(entity: Any, tolerance: float, budget: Budget) -> Pieces:
    table = np.array(entity.get_points("xyb"), dtype=np.float64).reshape(-1, 3)
    closed = bool(entity.closed)
    height = float(entity.dxf.get("elevation", 0.0))
    return [
        (points @ _axes(entity), closed)
        for points in _bulged(table, closed, height, tolerance, budget)
    ]


def _polyline(entity: Any, tolerance: float, budget: Budget) -> Pieces:
    # A frame of control points (flag 16) goes with a fitted curve and is not drawn.
    vertices = [v for v in entity.vertices if not int(v.dxf.get("flags", 0)) & 16]
    if not vertices:
        return []
    places = np.array([_point(v.dxf.location) for v in vertices])
    closed = bool(entity.is_closed)
    if entity.is_3d_polyline:
        budget.vertices(len(places))
        return [(places, closed)]
    bulges = [float(v.dxf.get("bulge", 0.0)) for v in vertices]
    table = np.column_stack([places[:, :2], bulges])
    height = float(_point(entity.dxf.get("elevation", (0.0, 0.0, 0.0)))[2])
    return [
        (points @ _axes(entity), closed)
        for points in _bulged(table, closed, height, tolerance, budget)
    ]


def _bulged(
    table: Floats, closed: bool, height: float, tolerance: float, budget: Budget
) -> list[Floats]:
    """A polyline with arcs from rows x, y, bulge; one chain of points, shape (N, 3), or none."""
    if len(table) < 2:
        return [np.array([[*table[0, :2], height]])] if len(table) else []
    if not np.isfinite(table).all():
        raise InputError("a polyline has a number that is not finite")
    ends = np.vstack([table[1:], table[:1]]) if closed else table[1:]
    parts = [
        bulge(a[:2], b[:2], float(a[2]), tolerance, budget)[:-1]
        for a, b in zip(table, ends, strict=False)
    ]
    flat = np.vstack(parts if closed else [*parts, table[-1:, :2]])
    return [np.column_stack([flat, np.full(len(flat), height)])]


def _spline(entity: Any, tolerance: float, budget: Budget) -> Pieces:
    if max(len(entity.control_points), len(entity.fit_points), len(entity.knots)) > MAX_CONTROLS:
        raise InputError("a spline has too many points", allowed=f"≤ {MAX_CONTROLS}")
    points = _flattened(entity.construction_tool(), tolerance, budget)
    near = np.linalg.norm(points[-1] - points[0]) <= 1e-9 * (1.0 + np.abs(points).max())
    closed = len(points) > 3 and bool(near)
    return [(points[:-1] if closed else points, closed)]


def _flattened(curve: Any, tolerance: float, budget: Budget) -> Floats:
    """Points on a B-spline, weighted or not, shape (N, 3), by halving what is not yet straight."""
    from scipy.interpolate import BSpline

    degree = int(curve.degree)
    controls = np.array([_point(point) for point in curve.control_points]).reshape(-1, 3)
    weights = np.array([float(w) for w in curve.weights()] or np.ones(len(controls)))
    knots = np.array([float(knot) for knot in curve.knots()])
    domain = np.unique(knots[degree : len(controls) + 1])
    table = np.column_stack([controls * weights[:, None], weights])
    if not (np.isfinite(table).all() and np.isfinite(knots).all()) or (weights <= 0.0).any():
        raise InputError(
            "a spline has a number that is not finite or a weight that is not positive"
        )
    if len(domain) < 2 or len(knots) != len(controls) + degree + 1 or (np.diff(knots) < 0.0).any():
        raise InputError("a spline has knots that do not fit its control points")
    spline = BSpline(knots, table, degree)

    def at(parameters: Floats) -> Floats:
        values = spline(np.minimum(parameters, domain[-1]))
        return np.asarray(values[:, :3] / values[:, 3:], dtype=np.float64)

    # Four parts a span and a quarter of the tolerance: the middle of a chord may lie on the
    # curve by luck, at a point of inflection.
    t = np.interp(np.arange(4 * len(domain) - 3) / 4.0, np.arange(len(domain)), domain)
    budget.vertices(len(t))
    points = at(t)
    while True:
        middle = (t[1:] + t[:-1]) / 2.0
        halves = at(middle)
        rough = np.flatnonzero(_off_chord(points, halves) > tolerance / 4.0)
        if not len(rough):
            return points
        budget.vertices(len(rough))
        t = np.insert(t, rough + 1, middle[rough])
        points = np.insert(points, rough + 1, halves[rough], axis=0)


def _off_chord(points: Floats, halves: Floats) -> Floats:
    """Distances of points, shape (N − 1, 3), from the chords between neighbours, shape (N, 3)."""
    chord, reach = np.diff(points, axis=0), halves - points[:-1]
    square = (chord * chord).sum(axis=1)
    share = (reach * chord).sum(axis=1) / np.where(square > 0.0, square, 1.0)
    away = reach - np.clip(share, 0.0, 1.0)[:, None] * chord
    return np.asarray(np.linalg.norm(away, axis=1), dtype=np.float64)


def _solid(entity: Any, _tolerance: float, budget: Budget) -> Pieces:
    budget.vertices(4)
    corners = [
        _point(entity.dxf.get(f"vtx{k}")) for k in (0, 1, 3, 2) if entity.dxf.hasattr(f"vtx{k}")
    ]
    points = np.array(corners).reshape(-1, 3)
    keep = np.append((np.diff(points, axis=0) != 0.0).any(axis=1), True)
    return [(points[keep] @ _axes(entity), True)] if len(points) else []


def _hatch(entity: Any, tolerance: float, budget: Budget) -> Pieces:
    height = float(_point(entity.dxf.get("elevation", (0.0, 0.0, 0.0)))[2])
    pieces: Pieces = []
    for path in entity.paths:
        if hasattr(path, "vertices"):
            table = np.array(path.vertices, dtype=np.float64).reshape(-1, 3)
            flat = _bulged(table, True, height, tolerance, budget)
            pieces += [(points, True) for points in flat]
            continue
        for edge in path.edges:
            budget.entity()
            points, closed = _edge(edge, tolerance, budget)
            pieces.append((np.column_stack([points, np.full(len(points), height)]), closed))
    return [(points @ _axes(entity), closed) for points, closed in pieces]


def _edge(edge: Any, tolerance: float, budget: Budget) -> tuple[Floats, bool]:
    """One edge of the border of a hatch, shape (N, 2); its direction does not matter."""
    kind = edge.EDGE_TYPE
    if kind == "LineEdge":
        return np.array([_point(edge.start)[:2], _point(edge.end)[:2]]), False
    if kind == "SplineEdge":
        if (
            max(len(edge.control_points), len(edge.fit_points), len(edge.knot_values))
            > MAX_CONTROLS
        ):
            raise InputError("a spline has too many points", allowed=f"≤ {MAX_CONTROLS}")
        return _flattened(edge.construction_tool(), tolerance, budget)[:, :2], False
    if kind == "ArcEdge":
        u, v = np.array([edge.radius, 0.0]), np.array([0.0, edge.radius])
        start, end = math.radians(edge.start_angle), math.radians(edge.end_angle)
    else:
        u = _point(edge.major_axis)[:2]
        v = np.array([-u[1], u[0]]) * float(edge.ratio)
        start, end = float(edge.start_param), float(edge.end_param)
    sweep = (end - start) % _FULL
    full = sweep < 1e-9 or _FULL - sweep < 1e-9
    centre = _point(edge.center)[:2]
    return arc(centre, u, v, start, _FULL if full else sweep, tolerance, budget), full


def _point(values: Sequence[float]) -> Floats:
    point = np.zeros(3)
    given = [float(value) for value in values][:3]
    point[: len(given)] = given
    return point


def _axes(entity: Any) -> Floats:
    """The axes of the entity's own coordinate system as rows: its extrusion direction."""
    ocs = entity.ocs()
    return np.array([_point(axis) for axis in (ocs.ux, ocs.uy, ocs.uz)])


SHAPES: dict[str, Callable[[Any, float, Budget], Pieces]] = {
    "LINE": _line,
    "ARC": _arc,
    "CIRCLE": _circle,
    "ELLIPSE": _ellipse,
    "LWPOLYLINE": _lwpolyline,
    "POLYLINE": _polyline,
    "SPLINE": _spline,
    "SOLID": _solid,
    "TRACE": _solid,
    "HATCH": _hatch,
}
FILLED = ("SOLID", "TRACE", "HATCH")
