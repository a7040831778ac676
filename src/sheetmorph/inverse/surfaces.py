"""Surfaces by name, in closed form: one unit wide, z up."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from sheetmorph.compare.surface import Surface
from sheetmorph.geometry import structured
from sheetmorph.geometry.mesh import Floats, SheetMesh

RINGS, CELLS = 24, 40


def bowl(depth: float) -> Surface:
    """Part of a sphere, open upward; deeper than a hemisphere, half an ellipsoid.

    With a rim of diameter 1 a cap of height h spans the angle 2 atan 2h on either side of its
    axis.

    Args:
        depth: height over the diameter of the rim.
    """
    angle = 2.0 * math.atan(2.0 * min(depth, 0.5))
    radius = 0.5 / math.sin(angle)
    stretch = max(depth / 0.5, 1.0)

    def place(r: Floats, t: Floats) -> tuple[Floats, Floats, Floats]:
        across = radius * np.sin(angle * r)
        return (
            across * np.cos(t),
            across * np.sin(t),
            stretch * radius * (1.0 - np.cos(angle * r)),
        )

    return _round(place)


def dome(depth: float) -> Surface:
    """A paraboloid of revolution, open downward; `depth` is its height over its width."""
    return _round(lambda r, t: (0.5 * r * np.cos(t), 0.5 * r * np.sin(t), -depth * r**2))


def cone(depth: float) -> Surface:
    """A circular cone, its tip up; `depth` is its height over its width."""
    return _round(lambda r, t: (0.5 * r * np.cos(t), 0.5 * r * np.sin(t), -depth * r))


def saddle(depth: float) -> Surface:
    """z = depth/2 (x² − y²)/R² above a disc of radius R = 1/2; `depth` is height over width."""
    return _round(
        lambda r, t: (
            0.5 * r * np.cos(t),
            0.5 * r * np.sin(t),
            0.5 * depth * r**2 * np.cos(2.0 * t),
        )
    )


def cylinder(depth: float) -> Surface:
    """Part of a circular cylinder as long as it is wide; `depth` is the rise of its arch, ≤ ½."""
    angle = 2.0 * math.atan(2.0 * depth)
    radius = 0.5 / math.sin(angle)
    sheet = structured.rectangle(1.0, 1.0, CELLS, CELLS)
    x, y = sheet.nodes[:, 0], sheet.nodes[:, 1]
    x = 2.0 * (x - x.min()) / np.ptp(x) - 1.0
    y = (y - y.min()) / np.ptp(y) - 0.5
    points = np.column_stack(
        [radius * np.sin(angle * x), y, radius * (np.cos(angle * x) - np.cos(angle))]
    )
    return _surface(points, sheet)


def canoe(slenderness: float, depth: float) -> Surface:
    """An elliptic paraboloid with a level rim, `slenderness` times as long as it is wide.

    Args:
        slenderness: length over width of the rim; the length is 1.
        depth: height over the width of the rim.
    """
    across = 0.5 / slenderness

    def place(r: Floats, t: Floats) -> tuple[Floats, Floats, Floats]:
        return 0.5 * r * np.cos(t), across * r * np.sin(t), depth / slenderness * r**2

    return _round(place)


def _round(place: Callable[[Floats, Floats], tuple[Floats, Floats, Floats]]) -> Surface:
    sheet = structured.disc(1.0, RINGS)
    x, y = sheet.nodes[:, 0], sheet.nodes[:, 1]
    return _surface(np.column_stack(place(np.hypot(x, y), np.arctan2(y, x))), sheet)


def _surface(points: Floats, sheet: SheetMesh) -> Surface:
    return Surface(points, sheet.triangles.astype(np.int64))
