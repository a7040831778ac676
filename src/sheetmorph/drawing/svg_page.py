"""The page of an SVG: how large it is and where its corner lies."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.model import Floats
from sheetmorph.drawing.request import UNITS, Request
from sheetmorph.drawing.svg_numbers import (
    IDENTITY,
    PHYSICAL,
    compose,
    length,
    numbers,
    unit_of,
    viewport,
)

ORIGIN = "data-sheetmorph-origin"
MAX_ORIGIN = 1e5


@dataclass(frozen=True)
class Page:
    """The map from user units to metres, shape (2, 3); the size of the page in user units.

    `unit` is the length of one user unit, `pixel` that of a pixel of the screen [m].
    """

    matrix: Floats
    view: tuple[float, float]
    unit: float
    pixel: float


def page_of(root: Element, request: Request) -> Page:
    """The page of the outermost <svg>; its lower left corner is the origin of the model.

    Raises:
        InputError: the size, the view box or the origin cannot be read.
    """
    box = _box(root)
    width, height = (_side(root, name) for name in ("width", "height"))
    if box is not None:
        if not (box[2] > 0.0 and box[3] > 0.0):
            raise InputError("the viewBox has no size", key="<svg>", value=root.get("viewBox"))
        if width is None:
            width = box[2] if height is None else box[2] * height / box[3]
        if height is None:
            height = box[3] * width / box[2]
        inner = viewport(box, width, height, root.get("preserveAspectRatio", ""))
        view = (box[2], box[3])
    else:
        if height is None:
            request.notes.add("page", "the page has no height: y is counted from its upper edge")
        inner, view = IDENTITY, (width or 0.0, height or 0.0)
    pixel = UNITS["px"]
    physical = any(unit_of(root.get(name, "")) in PHYSICAL for name in ("width", "height"))
    if request.scale is not None:
        scale = request.scale / float(inner[0, 0])
        if physical and not np.isclose(scale, pixel, rtol=1e-6):
            request.notes.add(
                "unit",
                f"the size of the page is {scale / pixel:.6g} times what the file says, because "
                f"a unit of {request.unit} was asked for",
            )
        pixel = scale
    elif not physical:
        request.notes.add(
            "unit", "the page has no physical size: 1 px is read as 1/96 in = 0.264583 mm"
        )
    x, y = _origin(root)
    page = np.array([[pixel, 0.0, x], [0.0, -pixel, y + pixel * (height or 0.0)]])
    matrix = compose(page, inner)
    if not np.isfinite(matrix).all() or matrix[0, 0] <= 0.0:
        raise InputError("the size of the page is not usable", key="<svg>")
    return Page(matrix, view, float(matrix[0, 0]), pixel)


def _box(root: Element) -> list[float] | None:
    text = root.get("viewBox")
    if text is None:
        return None
    values = numbers(text)
    if len(values) != 4:
        raise InputError("the viewBox needs four numbers", key="<svg>", value=text)
    return values


def _side(root: Element, name: str) -> float | None:
    """Width or height of the page in pixels; None when it is left to the viewer."""
    text = root.get(name, "").strip()
    if not text or text == "auto" or text.endswith("%"):
        return None
    value = length(text, 0.0, name)
    if value <= 0.0:
        raise InputError(f"the {name} of the page must be positive", key="<svg>", value=text)
    return value


def _origin(root: Element) -> tuple[float, float]:
    text = root.get(ORIGIN)
    if text is None:
        return 0.0, 0.0
    values = numbers(text)
    if len(values) != 2 or max(map(abs, values)) > MAX_ORIGIN:
        raise InputError(
            f"{ORIGIN} cannot be read", key="<svg>", value=text, allowed="x y in mm, below 1e5"
        )
    return 1e-3 * values[0], 1e-3 * values[1]
