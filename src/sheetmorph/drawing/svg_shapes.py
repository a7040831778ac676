"""The outlines of SVG elements, flattened in the coordinates of the element."""

from __future__ import annotations

import math
import re
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from sheetmorph.core.errors import InputError, shorten
from sheetmorph.drawing.flatten import arc, bezier
from sheetmorph.drawing.markup import local
from sheetmorph.drawing.model import Curve, Floats
from sheetmorph.drawing.notes import Budget
from sheetmorph.drawing.svg_numbers import NUMBER, length, numbers

SHAPES = ("path", "rect", "circle", "ellipse", "line", "polyline", "polygon")
MAX_SEGMENTS = 200_000

# The grammar of path data: the library that reads it takes much else for a comment.
_GAP = r"[ \t\r\n]*+(?:,[ \t\r\n]*+)?"
_N, _FLAG = rf"(?:{_GAP}{NUMBER})", rf"{_GAP}[01]"
_RUN = re.compile(
    rf"[ \t\r\n]*+(?:[MmLlTt](?:{_N}{_N})++|[Zz]|[HhVv]{_N}++|[SsQq](?:{_N}{{4}})++"
    rf"|[Cc](?:{_N}{{6}})++|[Aa](?:{_N}{{3}}{_FLAG}{_FLAG}{_N}{_N})++)"
)
_SIZES = {"m": 2, "l": 2, "t": 2, "z": 1, "h": 1, "v": 1, "s": 4, "q": 4, "c": 6, "a": 5}
_NUMBERS = re.compile(NUMBER)


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

    def value(name: str, whole: float) -> float:
        return length(element.get(name, "0"), whole, name)

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
    """A rectangle, with round corners as path data says them."""

    def value(name: str, text: str) -> float:
        return length(text, view[name in ("y", "height", "ry")], name)

    x, y, w, h = (value(name, element.get(name, "0")) for name in ("x", "y", "width", "height"))
    if w <= 0.0 or h <= 0.0:
        return []
    given = [element.get(name, "auto") for name in ("rx", "ry")]
    radii = [given[k] if given[k] != "auto" else given[1 - k] for k in (0, 1)]
    a, b = (
        0.0 if text == "auto" else min(max(value(name, text), 0.0), side / 2.0)
        for name, text, side in zip(("rx", "ry"), radii, (w, h), strict=True)
    )
    if a == 0.0 or b == 0.0:
        budget.vertices(4)
        return [Curve(np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h]]), True)]
    # Arcs meet without a straight piece where the radius is half a side.
    right, left = (f"H{x + w - a}", f"H{x + a}") if 2.0 * a < w else ("", "")
    down, up = (f"V{y + h - b}", f"V{y + b}") if 2.0 * b < h else ("", "")
    turn = f"A{a} {b} 0 0 1"
    text = (
        f"M{x + a} {y}{right}{turn} {x + w} {y + b}{down}{turn} {x + w - a} {y + h}"
        f"{left}{turn} {x} {y + h - b}{up}{turn} {x + a} {y}z"
    )
    return _path(text, tolerance, budget)


def _path(text: str, tolerance: float, budget: Budget) -> list[Curve]:
    """The curves of path data; a closed one does not repeat its first point."""
    from svg.path import Close, Move

    curves: list[Curve] = []
    points: list[Any] = []

    def finish(closed: bool) -> None:
        if points:
            chain = np.array(points, dtype=np.complex128).view(np.float64).reshape(-1, 2)
            if closed and len(chain) > 1 and np.array_equal(chain[0], chain[-1]):
                chain = chain[:-1]
            if len(chain) > 1 or closed:
                curves.append(Curve(chain, closed and len(chain) > 1))
        points.clear()

    for segment in _segments(text):
        if isinstance(segment, Move):
            finish(False)
            continue
        if not points:
            points.append(segment.start)
        if isinstance(segment, Close):
            finish(True)
        else:
            points += _flattened(segment, tolerance, budget)
    finish(False)
    return curves


def _segments(text: str) -> Any:
    """The segments of path data as svg.path has them, after a check of grammar and size.

    Raises:
        InputError: not of the grammar, too long, or with a number that is not finite.
    """
    from svg.path import parse_path

    text = text.strip(" \t\r\n")
    position = 0
    count = 0.0
    while position < len(text):
        match = _RUN.match(text, position)
        if match is None:
            raise InputError(
                "the path cannot be read, or ends within a segment",
                value=shorten(text[position : position + 100], 40),
            )
        run = match[0].lstrip(" \t\r\n")
        if position == 0 and run[0] not in "Mm":
            raise InputError("the path does not start with M", value=shorten(text[:100], 40))
        # The flags of an arc may stand together with what follows: three numbers look like one.
        count += max(len(_NUMBERS.findall(run)) / _SIZES[run[0].lower()], 1.0)
        if count > MAX_SEGMENTS:
            raise InputError("a path has too many segments", allowed=f"≤ {MAX_SEGMENTS}")
        position = match.end()
    try:
        segments = parse_path(text)
    except (ValueError, ArithmeticError) as error:
        raise InputError(
            "the path has an arc that cannot be drawn", value=shorten(text[:100], 40)
        ) from error
    if not all(math.isfinite(abs(s.end)) for s in segments):
        raise InputError("the path has a number that is not finite", value=shorten(text[:100], 40))
    return segments


def _flattened(segment: Any, tolerance: float, budget: Budget) -> list[complex]:
    """The points of a segment after its start, as complex numbers."""
    from svg.path import Arc, CubicBezier, QuadraticBezier

    if isinstance(segment, QuadraticBezier):
        controls = [segment.start, segment.control, segment.end]
    elif isinstance(segment, CubicBezier):
        controls = [segment.start, segment.control1, segment.control2, segment.end]
    elif isinstance(segment, Arc) and hasattr(segment, "center"):
        return _round(segment, tolerance, budget)
    else:
        # A line, or an arc without a radius or a chord, which stands for one.
        budget.vertices(1)
        return [segment.end]
    points = bezier(_plane(controls), tolerance, budget)
    return list(points[1:] @ [1.0, 1.0j])


def _round(segment: Any, tolerance: float, budget: Budget) -> list[complex]:
    rotation = np.exp(1j * math.radians(segment.rotation))
    radius = segment.radius * segment.radius_scale
    centre, u, v = _plane([segment.center, rotation * radius.real, rotation * 1j * radius.imag])
    start, sweep = math.radians(segment.theta), math.radians(segment.delta)
    points = arc(centre, u, v, start, sweep, tolerance, budget)
    return [*(points[1:-1] @ [1.0, 1.0j]), segment.end]


def _plane(values: list[complex]) -> Floats:
    return np.array(values, dtype=np.complex128).view(np.float64).reshape(-1, 2)
