"""A pattern from a graded field: inert material where the film shall shrink little."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats, Ints
from sheetmorph.inverse.families import EPS_PRE, FREE, SIZE, Family, Parameter, Space
from sheetmorph.inverse.graded import GradedSheet, polygon_text
from sheetmorph.inverse.limits import Limits
from sheetmorph.inverse.plans import SPREAD, Plan

SHARE = "inert_share"
_LOW, _HIGH = 0.8, 1.25
"""Bounds of the sheet's size, in sizes of the graded film."""
_PLACES = (
    np.array([[4, 1, 1], [1, 4, 1], [1, 1, 4], [2, 2, 2], [3, 2, 1], [3, 1, 2], [1, 3, 2]]) / 6.0
)
"""Places in a triangle, by the shares of its corners, at which its strain is looked at."""
_FINEST = 2e-5
"""Contours are drawn to this [m]."""


@dataclass(frozen=True, eq=False)
class Threshold:
    """The plans of one field: the share of the sheet that is inert decides on the level.

    Attributes:
        nodes: of the mesh of the film [m], shape (V, 2).
        triangles: shape (T, 3).
        strain: at the nodes, shape (V,).
        outline: of the film [m], shape (n, 2).
        width: of the narrowest rib and gap [m].
    """

    nodes: Floats
    triangles: Ints
    strain: Floats
    outline: Floats
    width: float

    @cached_property
    def size(self) -> float:
        """Longer side of the film [m]."""
        return float(np.ptp(self.outline, axis=0).max())

    def __call__(self, values: Mapping[str, float]) -> Plan:
        """Outline and pattern.

        Raises:
            InputError: nothing of the pattern is as wide as it must be.
        """
        import shapely

        scale = values[SIZE] / self.size
        region = shapely.transform(self.region(values[SHARE]), lambda points: scale * points)
        outline = scale * self.outline
        region = rounded(region, self.width, shapely.Polygon(outline))
        parts = [part for part in shapely.get_parts(region) if part.area > self.width**2]
        if not parts:
            raise InputError("no part of the pattern is as wide as the limits want")
        rings = [
            [np.asarray(ring.coords)[:-1] for ring in (part.exterior, *part.interiors)]
            for part in parts
        ]
        polygons = ", ".join(
            f"[{', '.join(polygon_text(ring) for ring in polygon)}]" for polygon in rings
        )
        return Plan(
            ('kind = "polygon"', 'unit = "mm"', f"points = {polygon_text(outline)}"),
            (('kind = "polygons"', 'unit = "mm"', f"polygons = [{polygons}]", "clip = true"),),
        )

    def region(self, share: float) -> object:
        """Where the sheet shrinks least, a share of its area; before widths are looked at [m]."""
        import shapely

        level = self._level(share)
        corners, values = self.nodes[self.triangles], self.strain[self.triangles]
        polygons = [
            _above(points, strains - level)
            for points, strains in zip(corners, values, strict=True)
            if strains.max() > level
        ]
        return shapely.union_all([shapely.Polygon(ring) for ring in polygons if len(ring) > 2])

    def spread(self, values: Mapping[str, float]) -> Floats:
        """Points spread over the sheet [m], shape (n, 2)."""
        places = self.nodes[self.triangles].mean(axis=1)
        step = max(1, len(places) // SPREAD)
        return np.asarray(values[SIZE] / self.size * places[::step])

    def _level(self, share: float) -> float:
        a, b, c = (self.nodes[self.triangles[:, k]] for k in range(3))
        u, v = b - a, c - a
        areas = 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
        inside = (self.strain[self.triangles] @ _PLACES.T).ravel()
        areas = np.repeat(areas, len(_PLACES))
        order = np.argsort(-inside)
        reached = np.cumsum(areas[order]) / areas.sum()
        return float(np.interp(share, reached, inside[order]))


def _above(points: Floats, heights: Floats) -> list[Floats]:
    """The part of a triangle where a linear function is positive, as a ring."""
    ring = []
    for k in range(3):
        here, there = heights[k], heights[k - 2]
        if here > 0.0:
            ring.append(points[k])
        if (here > 0.0) != (there > 0.0):
            ring.append(points[k] + here / (here - there) * (points[k - 2] - points[k]))
    return ring


def rounded(region: object, width: float, sheet: object) -> object:
    """A region without ribs and gaps narrower than a width [m], and smooth, within the sheet."""
    import shapely

    radius = 0.51 * width
    opened = shapely.buffer(shapely.buffer(region, -radius), radius)
    closed = shapely.buffer(shapely.buffer(opened, radius), -radius)
    inside = shapely.intersection(closed, sheet)
    # What closing joined to the rim, or the rim cut off, may be narrow again.
    again = shapely.buffer(shapely.buffer(inside, -radius), radius)
    return shapely.simplify(shapely.intersection(again, sheet), _FINEST)


def threshold_space(
    sheet: GradedSheet,
    strain: Floats,
    outline: Floats,
    limits: Limits,
    overrides: Mapping[str, object],
) -> Space:
    """The designs whose pattern is a field cut off at some level.

    Args:
        sheet: the film.
        strain: of its faces, shape (T,).
        outline: of the film [m].
        limits: of fabrication.
        overrides: keys of the design that are set.
    """
    mesh = sheet.mesh
    areas = np.repeat(mesh.triangle_areas, 3)
    corners = mesh.triangles.ravel()
    sums = np.bincount(corners, areas * np.repeat(strain, 3), len(mesh.nodes))
    at_nodes = sums / np.bincount(corners, areas, len(mesh.nodes))
    threshold = Threshold(
        mesh.nodes[:, :2], mesh.triangles, at_nodes, outline, limits.minimum_width
    )
    most = min(0.9, limits.most_inert)
    family = Family(
        FREE,
        "the outline of the flattened target, inert where it shall shrink little",
        (Parameter(SHARE, 0.03, most, ""),),
        threshold,
        threshold.spread,
    )
    size = Parameter(SIZE, _LOW * threshold.size, _HIGH * threshold.size, "m")
    return Space(family, (size, *family.parameters, EPS_PRE), {}, limits, dict(overrides))
