"""The outlines of SVG elements, flattened in the coordinates of the element."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from xml.etree.ElementTree import Element

import numpy as np

from sheetmorph.core.errors import InputError, shorten
from sheetmorph.drawing.flatten import arc, bezier
from sheetmorph.drawing.model import Curve, Floats
from sheetmorph.drawing.notes import Budget
from sheetmorph.drawing.svg_numbers import NUMBER, length, numbers
from sheetmorph.drawing.svg_style import local

SHAPES = ("path", "rect", "circle", "ellipse", "line", "polyline", "polygon")

_TOKEN = re.compile(rf"\s*,?\s*(?:([a-zA-Z])|({NUMBER}))")
_FLAG = re.compile(r"\s*,?\s*([01])")
_COUNTS = {"m": 2, "l": 2, "h": 1, "v": 1, "c": 6, "s": 4, "q": 4, "t": 2, "a": 7, "z": 0}


def outline(
    element: Element, view: tuple[float, float], tolerance: float, budget: Budget
) -> list[Curve]:
    """The curves of a basic shape or path, in its own coordinates.

    Args:
        element: one of `SHAPES`.
        view: width and height of the viewport, for percentages.
        tolerance: largest chord error, in the element's units.
        budget: pays for the vertices.

    Raises:
        InputError: an attribute cannot be read.
    """
    kind = local(element)
    if kind == "path":
        return _path(element.get("d", ""), tolerance, budget)
    if kind in ("polyline", "polygon"):
        values = numbers(element.get("points", ""))
        budget.vertices(len(values) // 2)
        points = np.array(values[: len(values) // 2 * 2]).reshape(-1, 2)
        return [Curve(points, kind == "polygon")] if len(points) > 1 else []
    across, down = view
    size = math.hypot(across, down) / math.sqrt(2.0)

    def value(name: str, whole: float, default: str = "0") -> float:
        return length(element.get(name, default), whole, name)

    if kind == "line":
        ends = [[value("x1", across), value("y1", down)], [value("x2", across), value("y2", down)]]
        budget.vertices(2)
        return [Curve(np.array(ends), False)]
    if kind == "rect":
        return _rectangle(element, view, tolerance, budget)
    centre = np.array([value("cx", across), value("cy", down)])
    if kind == "circle":
        a = b = value("r", size)
    else:
        a, b = value("rx", across), value("ry", down)
    if a <= 0.0 or b <= 0.0:
        return []
    u, v = np.array([a, 0.0]), np.array([0.0, b])
    return [Curve(arc(centre, u, v, 0.0, 2.0 * math.pi, tolerance, budget), True)]


def _rectangle(
    element: Element, view: tuple[float, float], tolerance: float, budget: Budget
) -> list[Curve]:
    def value(name: str, whole: float) -> float:
        return length(element.get(name, "0"), whole, name)

    x, y = value("x", view[0]), value("y", view[1])
    w, h = value("width", view[0]), value("height", view[1])
    if w <= 0.0 or h <= 0.0:
        return []
    given = [element.get(name, "auto") for name in ("rx", "ry")]
    radii = [given[k] if given[k] != "auto" else given[1 - k] for k in (0, 1)]
    a = 0.0 if radii[0] == "auto" else min(max(length(radii[0], view[0], "rx"), 0.0), w / 2.0)
    b = 0.0 if radii[1] == "auto" else min(max(length(radii[1], view[1], "ry"), 0.0), h / 2.0)
    if a == 0.0 or b == 0.0:
        budget.vertices(4)
        return [Curve(np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h]]), True)]
    corners = [(x + w - a, y + b), (x + w - a, y + h - b), (x + a, y + h - b), (x + a, y + b)]
    u, v = np.array([a, 0.0]), np.array([0.0, b])
    quarter = math.pi / 2.0
    parts = [
        arc(np.array(corner), u, v, (k - 1) * quarter, quarter, tolerance, budget)
        for k, corner in enumerate(corners)
    ]
    points = np.vstack(parts)
    # Arcs meet without a straight piece where the radius is half a side.
    apart = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1) > 1e-9 * (w + h)
    return [Curve(points[apart], True)]


def _path(text: str, tolerance: float, budget: Budget) -> list[Curve]:
    curves: list[Curve] = []
    pieces: list[Floats] = []
    here = start = np.zeros(2)
    control: Floats | None = None
    before = ""

    def finish(closed: bool) -> None:
        if pieces:
            points = np.vstack(pieces)
            if closed and len(points) > 1 and np.array_equal(points[0], points[-1]):
                points = points[:-1]
            if len(points) > 1 or closed:
                curves.append(Curve(points, closed and len(points) > 1))
        pieces.clear()

    for command, values in _commands(text):
        kind = command.lower()
        if not before and kind != "m":
            raise InputError("the path does not start with M", value=shorten(text, 40))
        if kind == "m":
            finish(False)
            here = start = np.array(values) + (here if command == "m" else 0.0)
            before = kind
            continue
        if kind == "z":
            if not pieces:
                pieces.append(start[None])
            finish(True)
            here, before = start, kind
            continue
        if not pieces:
            pieces.append(here[None])
        base = here if command.islower() else np.zeros(2)
        if kind in ("h", "v"):
            end = here.copy()
            axis = "hv".index(kind)
            end[axis] = values[0] + base[axis]
            new = end[None]
            budget.vertices(1)
        elif kind == "l":
            end = np.array(values) + base
            new = end[None]
            budget.vertices(1)
        elif kind == "a":
            end = np.array(values[5:]) + base
            new = _elliptic(here, end, values, tolerance, budget)
        else:
            points = np.array(values).reshape(-1, 2) + base
            if kind in ("s", "t"):
                same = before in ({"s": "cs", "t": "qt"}[kind])
                mirrored = 2.0 * here - control if same and control is not None else here
                points = np.vstack([mirrored, points])
            new = bezier(np.vstack([here, points]), tolerance, budget)[1:]
            control, end = points[-2], points[-1]
        if not np.isfinite(end).all():
            raise InputError("the path has a number that is not finite", value=shorten(text, 40))
        pieces.append(new)
        here, before = end, kind
    finish(False)
    return curves


def _commands(text: str) -> Iterator[tuple[str, list[float]]]:
    """The commands of path data, each with the numbers of one segment."""
    position, command, count = 0, "", 0
    text = text.strip()
    values: list[float] = []
    while position < len(text):
        arc_flag = command in ("a", "A") and len(values) in (3, 4)
        match = (_FLAG if arc_flag else _TOKEN).match(text, position)
        if match is None:
            raise InputError("the path cannot be read", value=shorten(text[position:], 40))
        position = match.end()
        if not arc_flag and match[1]:
            command = match[1]
            if values or command.lower() not in _COUNTS:
                raise InputError("the path cannot be read", value=shorten(match[0], 40))
            count = _COUNTS[command.lower()]
            if count == 0:
                yield command, []
            continue
        if count == 0:
            raise InputError("the path cannot be read", value=shorten(match[0], 40))
        values.append(float(match[1] if arc_flag else match[2]))
        if len(values) == count:
            yield command, values
            values = []
            # Further pairs after a move are lines.
            command = {"m": "l", "M": "L"}.get(command, command)
    if values or (count and not text[-1].isdigit() and text[-1] != "."):
        raise InputError("the path ends within a segment", value=shorten(text[-40:], 44))


def _elliptic(
    a: Floats, b: Floats, values: list[float], tolerance: float, budget: Budget
) -> Floats:
    """The arc of the A command without its first point: the conversion of SVG, appendix B.2.4."""
    rx, ry = abs(values[0]), abs(values[1])
    if rx == 0.0 or ry == 0.0 or not (b - a).any():
        budget.vertices(1)
        return b[None]
    angle = math.radians(values[2])
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    # In the frame of the ellipse, scaled to a unit circle, the chord has this half.
    half = (turn.T @ (a - b)) / 2.0 / [rx, ry]
    size = float(half @ half)
    if size > 1.0:
        rx, ry, half = rx * math.sqrt(size), ry * math.sqrt(size), half / math.sqrt(size)
        size = 1.0
    away = math.sqrt(max(1.0 / size - 1.0, 0.0)) * (1.0 if values[3] != values[4] else -1.0)
    centre = away * np.array([half[1], -half[0]])
    first = math.atan2(*(half - centre)[::-1])
    last = math.atan2(*(-half - centre)[::-1])
    sweep = last - first
    if values[4] and sweep <= 0.0:
        sweep += 2.0 * math.pi
    if not values[4] and sweep >= 0.0:
        sweep -= 2.0 * math.pi
    middle = turn @ (centre * [rx, ry]) + (a + b) / 2.0
    points = arc(middle, turn[:, 0] * rx, turn[:, 1] * ry, first, sweep, tolerance, budget)
    points[-1] = b
    return points[1:]
