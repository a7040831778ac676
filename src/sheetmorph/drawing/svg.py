"""Reading SVG: the tree of elements with its transforms, styles and copies."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from xml.etree.ElementTree import Element

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.markup import local, parsed
from sheetmorph.drawing.model import Curve, DrawnItem, FillRule, Floats, Pen
from sheetmorph.drawing.notes import MAX_ENTITIES, at
from sheetmorph.drawing.request import Contents, Request
from sheetmorph.drawing.svg_numbers import (
    IDENTITY,
    applied,
    compose,
    length,
    numbers,
    stretch,
    transform,
    viewport,
)
from sheetmorph.drawing.svg_page import Page, page_of
from sheetmorph.drawing.svg_shapes import SHAPES, outline
from sheetmorph.drawing.svg_style import INITIAL, StyleSheet, inherited, is_clear, paint

MAX_DEPTH = 64
MAX_COPIES = 10_000
_LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
_LINK = ("href", "{http://www.w3.org/1999/xlink}href")
_GROUPS = ("g", "a", "switch", "svg", "symbol")
_UNREAD = ("text", "image", "foreignObject")


@dataclass(frozen=True)
class _Place:
    """Where the walk stands: what an element inherits from those around it."""

    matrix: Floats
    style: Mapping[str, str]
    names: tuple[tuple[str, str], ...]
    view: tuple[float, float]
    depth: int = 0
    copied: bool = False


def read_svg(data: bytes, request: Request) -> tuple[Contents, float]:
    """Read an SVG file.

    The origin is the lower left corner of the page, x to the right and y upward, so that
    the model looks like the screen: y = page height − (user y), in mm. With
    viewBox="x0 y0 w h" the corner is the user point (x0, y0 + h). A root attribute
    data-sheetmorph-origin="x y" gives that corner other coordinates [mm]; `svg_bytes`
    writes it. Without any size of a page, y = −(user y).

    Returns:
        The items by id, label, class and colour, their own and those of the groups around
        them, and the length of a user unit [m].

    Raises:
        InputError: not an SVG, damaged, or beyond the bounds.
    """
    root = parsed(data, "the file", MAX_ENTITIES, forbid_dtd=False)
    if local(root) != "svg":
        raise InputError("is no SVG file: the outermost element is no <svg>", value=root.tag[:60])
    page = page_of(root, request)
    walk = _Walk(root, page, request)
    place = _Place(page.matrix, INITIAL, (), page.view)
    walk.visit(root, place)
    return walk.contents, page.unit


class _Walk:
    """Goes through the tree once and unfolds <use>."""

    def __init__(self, root: Element, page: Page, request: Request) -> None:
        self.contents = Contents()
        self._root = root
        self._page = page
        self._request = request
        self._sheet = StyleSheet(root, request.notes)
        self._copies = 0
        self._by_id: dict[str, Element] = {}
        for element in root.iter():
            self._by_id.setdefault(element.get("id", ""), element)

    def visit(self, element: Element, place: _Place, size: tuple[str, str] | None = None) -> None:
        """Read an element and all below; `size` is what a <use> says of its symbol."""
        self._request.budget.entity()
        self._copies += place.copied
        if self._copies > MAX_COPIES:
            raise InputError(
                "the drawing has too many elements when every <use> is unfolded",
                allowed=f"≤ {MAX_COPIES} copies",
            )
        if place.depth > MAX_DEPTH:
            raise InputError(
                "elements are nested too deeply, or a <use> contains itself",
                key=_called(element),
                allowed=f"≤ {MAX_DEPTH} levels",
            )
        try:
            self._read(element, place, size)
        except InputError as error:
            raise InputError(
                error.message,
                key=error.key or _called(element),
                value=error.value,
                allowed=error.allowed,
            ) from error.__cause__

    def _read(self, element: Element, place: _Place, size: tuple[str, str] | None) -> None:
        tag = local(element)
        if tag not in (*_GROUPS, *SHAPES, *_UNREAD, "use"):
            return
        if tag == "symbol" and size is None:
            return
        declared = self._sheet.declared(element)
        if declared.get("display") == "none":
            return
        notes = self._request.notes
        if is_clear(declared.get("opacity", "1")):
            notes.add("invisible", f"{_called(element)} is fully transparent and was ignored")
            return
        for name in ("clip-path", "mask"):
            if declared.get(name, "none") != "none":
                notes.add(name, f"the {name} of {_called(element)} was ignored")
        matrix = place.matrix
        if element is not self._root or "transform" in element.attrib:
            matrix = compose(matrix, transform(element.get("transform", "")))
        inner = replace(
            place,
            matrix=matrix,
            style=inherited(place.style, declared),
            names=place.names + _names(element),
            depth=place.depth + 1,
        )
        if tag in SHAPES:
            self._shape(element, inner, declared)
        elif tag == "use":
            self._use(element, inner)
        elif tag in _UNREAD:
            corner = [length((element.get(k, "").split() or ["0"])[0], 0.0, k) for k in "xy"]
            where = at(applied(matrix, np.array([corner]))[0])
            hint = "; turn it into paths to have it read" if tag == "text" else ""
            notes.add(tag, f"{_called(element)} at {where} was ignored{hint}")
        else:
            if tag in ("svg", "symbol") and element is not self._root:
                inner = self._viewport(element, inner, size)
            for child in element:
                self.visit(child, inner)

    def _viewport(self, element: Element, place: _Place, size: tuple[str, str] | None) -> _Place:
        given = size or ("", "")
        across, down = place.view
        width = length(given[0] or element.get("width", "100%"), across, "width")
        height = length(given[1] or element.get("height", "100%"), down, "height")
        corner = [
            length(element.get(name, "0"), whole, name)
            for name, whole in (("x", across), ("y", down))
        ]
        move = np.column_stack([IDENTITY[:, :2], corner])
        box = element.get("viewBox")
        if box is None:
            return replace(place, matrix=compose(place.matrix, move), view=(width, height))
        values = numbers(box)
        if len(values) != 4:
            raise InputError("the viewBox needs four numbers", value=box)
        fit = viewport(values, width, height, element.get("preserveAspectRatio", ""))
        matrix = compose(place.matrix, compose(move, fit))
        return replace(place, matrix=matrix, view=(values[2], values[3]))

    def _use(self, element: Element, place: _Place) -> None:
        link = next((element.attrib[name] for name in _LINK if name in element.attrib), "")
        target = self._by_id.get(link[1:]) if link.startswith("#") and len(link) > 1 else None
        if target is None:
            what = "leads out of the file" if link and link[0] != "#" else "leads nowhere"
            self._request.notes.add(
                "use", f"{_called(element)} with the link {link[:60]!r} {what} and was ignored"
            )
            return
        corner = [
            length(element.get(name, "0"), whole, name)
            for name, whole in zip("xy", place.view, strict=True)
        ]
        move = np.column_stack([IDENTITY[:, :2], corner])
        size = (element.get("width", ""), element.get("height", ""))
        self.visit(
            target,
            replace(place, matrix=compose(place.matrix, move), copied=True),
            size if local(target) in ("svg", "symbol") else None,
        )

    def _shape(self, element: Element, place: _Place, declared: Mapping[str, str]) -> None:
        style, notes = place.style, self._request.notes
        if style["visibility"] != "visible":
            return
        # A singular map flattens its shapes to a line; the smallest of tolerances serves it.
        factor = stretch(place.matrix)
        tolerance = self._request.flatness / factor if factor > 0.0 else math.inf
        fill, stroke = (paint(style, what) for what in ("fill", "stroke"))
        if local(element) == "line":
            fill = None
        if fill is None and stroke is None:
            notes.add("unpainted", f"{_called(element)} is not painted and was ignored")
            return
        for what, colour in (("fill", fill), ("stroke", stroke)):
            if colour == "":
                notes.add(
                    "paint",
                    f"the {what} {style[what][:40]!r} of {_called(element)} is read as paint",
                )
        budget = self._request.budget
        drawn = outline(element, place.view, tolerance, budget)
        if not all(np.isfinite(curve.points).all() for curve in drawn):
            raise InputError("has a coordinate that is not finite")
        made = [
            self._request.curve(applied(place.matrix, curve.points), curve.closed)
            for curve in drawn
        ]
        curves = tuple(curve for curve in made if curve is not None)
        rule: FillRule | None = None
        if fill is not None and any(len(curve.points) > 2 for curve in curves):
            rule = "evenodd" if style["fill-rule"] == "evenodd" else "nonzero"
        pen = None if stroke is None else self._pen(drawn, place, declared)
        if pen is not None and style["stroke-dasharray"] not in ("none", ""):
            notes.add("dashes", f"the dashes of {_called(element)} were read as a full line")
        if not curves and pen is None:
            return
        colours = [("colour", colour) for colour in (fill, stroke) if colour]
        self.contents.add(DrawnItem(curves, rule, pen), (*place.names, *colours))

    def _pen(self, drawn: list[Curve], place: _Place, declared: Mapping[str, str]) -> Pen | None:
        style, matrix = place.style, place.matrix
        whole = math.hypot(*place.view) / math.sqrt(2.0)
        width = length(style["stroke-width"], whole, "the width of the stroke")
        if width <= 0.0:
            return None
        cap, join = style["stroke-linecap"], style["stroke-linejoin"]
        curves = tuple(drawn)
        if declared.get("vector-effect") == "non-scaling-stroke":
            curves = tuple(
                Curve(applied(matrix, curve.points) / self._page.pixel, curve.closed)
                for curve in drawn
            )
            matrix = self._page.pixel * IDENTITY
        limit = numbers(style["stroke-miterlimit"]) or [4.0]
        return Pen(
            curves,
            matrix,
            width,
            cap if cap in ("round", "square") else "butt",  # type: ignore[arg-type]
            join if join in ("round", "bevel") else "miter",  # type: ignore[arg-type]
            max(limit[0], 1.0),
        )


def _names(element: Element) -> tuple[tuple[str, str], ...]:
    names = [("class", name) for name in element.get("class", "").split()]
    names += [("label", element.get(_LABEL, "")), ("id", element.get("id", ""))]
    return tuple(names)


def _called(element: Element) -> str:
    name = element.get("id") or element.get(_LABEL) or ""
    return f"<{local(element)[:30]}> {name[:60]!r}" if name else f"<{local(element)[:30]}>"
