"""Writing SVG: one group per ink, in millimetres."""

from __future__ import annotations

import math
from collections.abc import Sequence
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.colours import colour_hex
from sheetmorph.drawing.ink import Ink, check_names
from sheetmorph.drawing.model import Curve
from sheetmorph.drawing.svg_page import ORIGIN

HAIRLINE = 0.01
"""Width of every stroke [mm]."""

MAX_MARGIN = 1.0
_DIGITS = 9


def svg_bytes(inks: Sequence[Ink], *, margin: float = 0.0, title: str = "") -> bytes:
    """A drawing as SVG whose numbers are millimetres of the model, with y negated.

    The page fits the shapes; its lower left corner is the origin of a reader, so that the
    root says in data-sheetmorph-origin where that corner lies in the model [mm], and
    `read_drawing` gives back the coordinates that were written.

    Args:
        inks: what to draw; each becomes a group with the name as its id.
        margin: room around the shapes [m].
        title: what a viewer shows as the name of the drawing.

    Raises:
        InputError: nothing to draw, two inks of one name, or no usable margin.
    """
    check_names(inks)
    if not (math.isfinite(margin) and 0.0 <= margin <= MAX_MARGIN):
        raise InputError("is out of bounds", key="margin", value=margin, allowed="0 to 1 m")
    drawn = [(ink, list(ink.outlines)) for ink in inks]
    points = [curve.points for _, group in drawn for curves in group for curve in curves]
    if not points:
        raise InputError("there is nothing to draw")
    every = 1e3 * np.vstack(points)
    # A page of whole micrometres: its corner is a short number and adds no rounding.
    low = np.floor((every.min(axis=0) - 1e3 * margin) * 1e3) / 1e3
    high = np.ceil((every.max(axis=0) + 1e3 * margin) * 1e3) / 1e3
    width, height = np.maximum(high - low, 1e-3)
    corner = f"{_text(low[0])} {_text(low[1])}"
    box = f"{_text(low[0])} {_text(-low[1] - height)} {_text(width)} {_text(height)}"
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" version="1.1" width="{_text(width)}mm" '
            f'height="{_text(height)}mm" viewBox="{box}" {ORIGIN}="{corner}">'
        ),
    ]
    if title:
        plain = "".join(c for c in title if c >= " ")
        lines.append(f"  <title>{escape(plain)}</title>")
    for ink, group in drawn:
        lines.append(
            f'  <g id={quoteattr(ink.name)} fill="none" stroke="{colour_hex(ink.colour)}"'
            f' stroke-width="{HAIRLINE}" fill-rule="evenodd">'
        )
        lines += [f'    <path d="{" ".join(map(_data, curves))}"/>' for curves in group]
        lines.append("  </g>")
    return ("\n".join([*lines, "</svg>"]) + "\n").encode("utf-8")


def _data(curve: Curve) -> str:
    pairs = [f"{_text(1e3 * x)},{_text(-1e3 * y)}" for x, y in curve.points.tolist()]
    return "M" + " L".join(pairs) + (" Z" if curve.closed else "")


def _text(value: float) -> str:
    """A number in mm, to a millionth of a micrometre."""
    text = f"{value:.{_DIGITS}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text
