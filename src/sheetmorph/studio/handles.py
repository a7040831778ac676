"""Points of the flat pattern that a person drags, and the keys of the design that follow.

A handle moves along a line (`slide`), round a centre (`turn`) or anywhere (`move`). The browser
works out the value while it is dragged; the rule is in the handle, so that it knows no shapes.
Lengths are in mm and angles in degrees, as in the texts that the browser sends back.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design

MAX_CORNERS = 80
"""Polygons with more corners get no handle for each."""
LEAST = 0.05
"""Shortest length to which a handle goes [mm]."""

Handle = dict[str, Any]


def handles(design: Design) -> list[Handle]:
    """The handles of the outline and of every shape of the pattern."""
    found = [*_of_shape("outline", "Sheet", design.outline)]
    many = len(design.pattern) > 1
    for index, shape in enumerate(design.pattern):
        name = shape.kind.replace("_", " ").capitalize()
        title = f"{name} {index + 1}" if many else name
        found += _of_shape(f"pattern.{index}", title, shape)
    return found


def _of_shape(key: str, title: str, shape: Any) -> list[Handle]:
    rules = _RULES.get(shape.kind, ())
    centre = _mm(getattr(shape, "centre", (0.0, 0.0)))
    turn = math.degrees(getattr(shape, "rotation", 0.0))
    made = []
    for rule in rules:
        made += rule(key, title, shape, centre, turn)
    if rules and key != "outline" and hasattr(shape, "centre"):
        made.append(_move(f"{key}.centre", f"{title}: centre", centre))
    return made


def _slide(key: str, label: str, origin: Any, angle: float, value: float, factor: float) -> Handle:
    """A length that is `factor` times the distance from `origin` in the direction `angle`."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    x, y = origin[0] + c * value / factor, origin[1] + s * value / factor
    return {
        "rule": "slide",
        "key": key,
        "label": label,
        "at": [x, y],
        "origin": list(origin),
        "direction": [c, s],
        "factor": factor,
        "value": value,
        "least": LEAST,
        "unit": "mm",
    }


def _move(key: str, label: str, at: Any) -> Handle:
    return {"rule": "move", "key": key, "label": label, "at": list(at), "unit": "mm"}


def _turn(key: str, label: str, centre: Any, radius: float, angle: float, add: float) -> Handle:
    """An angle: that of the handle about `centre` is the value plus `add`."""
    where = math.radians(angle + add)
    at = [centre[0] + radius * math.cos(where), centre[1] + radius * math.sin(where)]
    return {
        "rule": "turn",
        "key": key,
        "label": label,
        "at": at,
        "origin": list(centre),
        "value": angle,
        "add": add,
        "unit": "deg",
    }


Rule = Callable[[str, str, Any, Any, float], list[Handle]]


def _along(name: str, label: str, *, angle: float = 0.0, factor: float = 1.0) -> Rule:
    """A length from the centre, in a direction turned with the shape."""

    def rule(key: str, title: str, shape: Any, centre: Any, turn: float) -> list[Handle]:
        value = getattr(shape, name)
        if not value:
            return []
        where = turn + angle
        return [_slide(f"{key}.{name}", f"{title}: {label}", centre, where, 1e3 * value, factor)]

    return rule


def _across(name: str, label: str, length: Callable[[Any], float]) -> Rule:
    """A half-width, at some distance along the first arm."""

    def rule(key: str, title: str, shape: Any, centre: Any, turn: float) -> list[Handle]:
        value = getattr(shape, name)
        if not value:
            return []
        along = 1e3 * length(shape)
        c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
        foot = (centre[0] + c * along, centre[1] + s * along)
        return [_slide(f"{key}.{name}", f"{title}: {label}", foot, turn + 90.0, 1e3 * value, 1.0)]

    return rule


def _rotation(reach: Callable[[Any], float], add: Callable[[Any], float] = lambda s: 0.0) -> Rule:
    """The direction of the shape, by a handle at `reach` [m]."""

    def rule(key: str, title: str, shape: Any, centre: Any, turn: float) -> list[Handle]:
        radius = 1e3 * reach(shape)
        return [_turn(f"{key}.rotation", f"{title}: rotation", centre, radius, turn, add(shape))]

    return rule


def _corners(key: str, title: str, shape: Any, centre: Any, turn: float) -> list[Handle]:
    if len(shape.points) > MAX_CORNERS:
        return []
    return [
        _move(f"{key}.points.{k}", f"{title}: corner {k + 1}", _mm(point))
        for k, point in enumerate(shape.points)
    ]


def _ends(key: str, title: str, shape: Any, centre: Any, turn: float) -> list[Handle]:
    start, end = _mm(shape.start), _mm(shape.end)
    angle = math.degrees(math.atan2(end[1] - start[1], end[0] - start[0]))
    middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
    return [
        _move(f"{key}.start", f"{title}: start", start),
        _move(f"{key}.end", f"{title}: end", end),
        _slide(
            f"{key}.half_width",
            f"{title}: half width",
            middle,
            angle + 90.0,
            1e3 * shape.half_width,
            1.0,
        ),
    ]


def _mm(point: Any) -> tuple[float, float]:
    return 1e3 * point[0], 1e3 * point[1]


def _next_arm(shape: Any) -> float:
    """Halfway to the second arm, where the handle of the rotation meets no other."""
    return 180.0 / float(max(shape.arms, 2))


_RULES: dict[str, tuple[Rule, ...]] = {
    "disc": (_along("radius", "radius"),),
    "ellipse": (
        _along("half_width", "half width"),
        _along("half_height", "half height", angle=90.0),
    ),
    "rectangle": (
        _along("width", "width", factor=2.0),
        _along("height", "height", angle=90.0, factor=2.0),
    ),
    "regular_polygon": (
        _along("radius", "radius"),
        _rotation(lambda s: 0.7 * s.radius, lambda s: 180.0 / s.sides),
    ),
    "polygon": (_corners,),
    "star": (
        _along("arm_length", "arm length"),
        _across("half_width", "half width", lambda s: 0.55 * s.arm_length),
        _along("hub_radius", "hub radius", angle=200.0),
        _rotation(lambda s: 0.6 * s.arm_length, _next_arm),
    ),
    "cross": (
        _along("arm_length", "arm length"),
        _across("half_width", "half width", lambda s: 0.55 * s.arm_length),
        _rotation(lambda s: 0.6 * s.arm_length, _next_arm),
    ),
    "twin_star": (_along("spacing", "spacing", factor=2.0),),
    "bar": (_ends,),
    "lotus": (
        _along("radius", "radius"),
        _along("disc_radius", "disc radius", angle=200.0),
        _across("petal_half_width", "petal half width", lambda s: 0.6 * s.radius),
    ),
    "ring": (_along("radius", "radius"),),
    "rings": (_along("spacing", "spacing"),),
    "spiral": (_along("pitch", "pitch"),),
}
"""How each kind of shape is dragged; kinds that are not here are edited by their numbers."""
