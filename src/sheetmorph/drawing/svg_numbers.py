"""The small languages inside SVG attributes: lengths, transforms, view boxes."""

from __future__ import annotations

import math
import re
from functools import lru_cache
from typing import Any

import numpy as np

from sheetmorph.core.errors import InputError, shorten
from sheetmorph.drawing.model import Floats

NUMBER = r"[+-]?(?:[0-9]++(?:\.[0-9]*+)?|\.[0-9]++)(?:[eE][+-]?[0-9]++)?"
PIXELS: dict[str, float] = {
    "": 1.0,
    "px": 1.0,
    "mm": 96.0 / 25.4,
    "cm": 960.0 / 25.4,
    "q": 24.0 / 25.4,
    "in": 96.0,
    "pt": 96.0 / 72.0,
    "pc": 16.0,
    "em": 16.0,
    "ex": 8.0,
}
"""Pixels of CSS (1/96 in) in a unit; em and ex at the usual size of text."""
PHYSICAL = ("mm", "cm", "q", "in", "pt", "pc")
IDENTITY: Floats = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])

_LENGTH = re.compile(rf"\s*({NUMBER})\s*([a-zA-Z]*|%)\s*")
_NUMBERS = re.compile(NUMBER)
# CSS wants a digit after the point; programs write "1." all the same.
_BARE_POINT = re.compile(r"(?<=[0-9])\.(?![0-9])")
_COUNTS = {
    "matrix": (6,),
    "translate": (1, 2),
    "scale": (1, 2),
    "rotate": (1, 3),
    "skewx": (1,),
    "skewy": (1,),
}
MAX_NUMBERS = 500_000
MAX_TRANSFORM = 5000


def length(text: str, whole: float, what: str) -> float:
    """A length in user units (pixels); a percentage is of `whole`.

    Raises:
        InputError: the text is no length.
    """
    match = _LENGTH.fullmatch(text[:100])
    unit = match[2].lower() if match else ""
    if match is None or (unit != "%" and unit not in PIXELS):
        raise InputError(f"{what} is no length", value=text, allowed="a number, or with mm, px, …")
    value = float(match[1]) * (whole / 100.0 if unit == "%" else PIXELS[unit])
    if not math.isfinite(value):
        raise InputError(f"{what} is no finite length", value=text)
    return value


def unit_of(text: str) -> str:
    """The unit that a length is written with, in small letters; empty when it has none."""
    match = _LENGTH.fullmatch(text[:100])
    return match[2].lower() if match else ""


def numbers(text: str) -> list[float]:
    """The numbers in a text, such as those of `points`.

    Raises:
        InputError: something else than numbers and commas is there, or one is not finite.
    """
    words = _NUMBERS.findall(text)
    if len(words) > MAX_NUMBERS:
        raise InputError("is too long a list of numbers", allowed=f"≤ {MAX_NUMBERS}")
    if _NUMBERS.sub("", text).replace(",", " ").strip():
        raise InputError("is no list of numbers", value=shorten(text[:100], 60))
    values = [float(word) for word in words]
    if not all(map(math.isfinite, values)):
        raise InputError("has a number that is not finite", value=shorten(text[:100], 60))
    return values


def compose(outer: Floats, inner: Floats) -> Floats:
    """The map that applies `inner` first, shapes (2, 3)."""
    product = np.empty((2, 3))
    product[:, :2] = outer[:, :2] @ inner[:, :2]
    product[:, 2] = outer[:, :2] @ inner[:, 2] + outer[:, 2]
    return product


def applied(matrix: Floats, points: Floats) -> Floats:
    """Points under a map, shape (N, 2)."""
    return np.asarray(points @ matrix[:, :2].T + matrix[:, 2], dtype=np.float64)


def stretch(matrix: Floats) -> float:
    """The largest factor by which a map lengthens anything: its larger singular value."""
    (a, c, _), (b, d, _) = matrix.tolist()
    return (math.hypot(a + d, b - c) + math.hypot(a - d, b + c)) / 2.0


@lru_cache(maxsize=4096)
def transform(text: str) -> Floats:
    """The map of a `transform` attribute, shape (2, 3), not to be written to.

    Raises:
        InputError: a function or its numbers are unknown to SVG.
    """
    from tinycss2 import parse_component_value_list

    if len(text) > MAX_TRANSFORM:
        raise InputError("the transform is too long", allowed=f"≤ {MAX_TRANSFORM} characters")
    result = IDENTITY
    for node in parse_component_value_list(_BARE_POINT.sub(".0", text)):
        if node.type == "whitespace" or node == ",":
            continue
        name = node.lower_name if node.type == "function" else ""
        arguments = [part for part in getattr(node, "arguments", ()) if part.type != "whitespace"]
        values = [part.value for part in arguments if _is_number(part)]
        strange = any(not _is_number(part) and part != "," for part in arguments)
        if strange or len(values) not in _COUNTS.get(name, ()):
            raise InputError("the transform cannot be read", value=text)
        result = compose(result, _function(name, values))
    if not np.isfinite(result).all():
        raise InputError("the transform is not finite", value=text)
    return result


def _is_number(token: Any) -> bool:
    return token.type == "number" or (
        token.type == "dimension" and token.lower_unit in ("deg", "px")
    )


def _function(name: str, values: list[float]) -> Floats:
    if name == "matrix":
        a, b, c, d, e, f = values
        return np.array([[a, c, e], [b, d, f]])
    if name == "translate":
        return np.array([[1.0, 0.0, values[0]], [0.0, 1.0, (*values, 0.0)[1]]])
    if name == "scale":
        return np.array([[values[0], 0.0, 0.0], [0.0, values[-1], 0.0]])
    angle = math.radians(values[0])
    if name == "skewx":
        return np.array([[1.0, math.tan(angle), 0.0], [0.0, 1.0, 0.0]])
    if name == "skewy":
        return np.array([[1.0, 0.0, 0.0], [math.tan(angle), 1.0, 0.0]])
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    centre = np.array(values[1:] or [0.0, 0.0])
    return np.column_stack([turn, centre - turn @ centre])


def viewport(box: list[float], width: float, height: float, fit: str) -> Floats:
    """The map from a view box into a viewport of some size, by `preserveAspectRatio`.

    Raises:
        InputError: the box has no size.
    """
    x, y, w, h = box
    if not (w > 0.0 and h > 0.0):
        raise InputError("the viewBox has no size", value=" ".join(f"{v:g}" for v in box))
    words = [word for word in fit.split() if word != "defer"] or ["xMidYMid"]
    across, down = width / w, height / h
    if words[0] == "none":
        return np.array([[across, 0.0, -x * across], [0.0, down, -y * down]])
    scale = max(across, down) if words[1:2] == ["slice"] else min(across, down)
    share = {"min": 0.0, "mid": 0.5, "max": 1.0}
    match = re.fullmatch(r"x(min|mid|max)y(min|mid|max)", words[0].lower())
    if match is None:
        raise InputError("preserveAspectRatio cannot be read", value=fit)
    dx = share[match[1]] * (width - w * scale) - x * scale
    dy = share[match[2]] * (height - h * scale) - y * scale
    return np.array([[scale, 0.0, dx], [0.0, scale, dy]])
