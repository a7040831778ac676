"""The boundary of a flat region as corners and sides: a smeared indicator and a blended distance.

Both are smooth functions of the corners. A signed distance is not: it has creases where two pieces
of the boundary are equally near, between arms of a pattern and inwards from every corner.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.compiled import kernel
from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

BLEND = 0.125
"""Range over which distances from several sides are blended, in widths."""
ROUND = 0.5
"""Below this distance, in widths, the crease at the boundary itself is rounded."""
NEGLIGIBLE = 40.0
"""Sides farther than the nearest by more than this many ranges do not count: e⁻⁴⁰."""


@dataclass(frozen=True, eq=False)
class Boundary:
    """The rings of a region: M corners, each ring closed by its first corner again.

    Attributes:
        corners: [m], shape (M, 2).
        sides: index of the first corner of each side, the second follows it, shape (S,).
        turns: 1 where the region lies on the left of a side, −1 where on the right, shape (S,).
    """

    corners: Floats
    sides: NDArray[np.intp]
    turns: Floats

    @classmethod
    def of(cls, region: BaseGeometry) -> Boundary:
        """The boundary of a polygon or of polygons [m]."""
        import shapely

        rings, polygon = shapely.get_rings(shapely.get_parts(region), return_index=True)
        corners, ring = shapely.get_coordinates(rings, return_index=True)
        sides = np.flatnonzero(ring[1:] == ring[:-1])
        outer = np.concatenate([[True], polygon[1:] != polygon[:-1]])
        turns = np.where(shapely.is_ccw(rings) == outer, 1.0, -1.0)
        return cls(np.ascontiguousarray(corners), sides, turns[ring[sides]])

    def share(self, points: Floats, width: float) -> Floats:
        """χ: how much of the neighbourhood of each point lies in the region, shape (N,).

        χ(x) = ∫ φ(|y − x|) dy over the region with φ = 3/(π R²) (1 − r²/R²)² within R = w/2. So
        it goes from 0 to 1 over the width w across a straight side. By Gauss' theorem it is
        1/(2π) ∮ (1 − (1 − r²/R²)³) dθ along the boundary, in closed form for a straight side.

        Args:
            points: [m], shape (N, 2).
            width: w [m].
        """
        found = np.empty(len(points))
        _shares(points, self.corners, self.sides, self.turns, 0.5 * width, found)
        return found

    def away(self, points: Floats, width: float) -> Floats:
        """Blended distance from the boundary, on both sides of it [m], shape (N,).

        Σ c u exp(−u/k) / Σ c exp(−u/k) over the sides with k = w/8 and u the distance d from a
        side; below ρ = w/2 it is rounded to u = ρ (3 + 6 (d/ρ)² − (d/ρ)⁴)/8, so that it has no
        crease on the boundary. c = L/(L + k) of sides of the length L, so that nothing jumps
        where a side comes or goes. At a distance from corners and creases it is d itself.

        Args:
            points: [m], shape (N, 2).
            width: w [m].
        """
        found = np.empty(len(points))
        _blended(points, self.corners, self.sides, BLEND * width, ROUND * width, found)
        return found

    def onto_corners(
        self, points: Floats, by_share: Floats, by_away: Floats, width: float
    ) -> Floats:
        """Derivative of Σ a χ + b u by the corners, shape (M, 2).

        Args:
            points: [m], shape (N, 2).
            by_share: a, shape (N,).
            by_away: b [1/m], shape (N,).
            width: w [m].
        """
        found = np.zeros_like(self.corners)
        used = np.flatnonzero(by_share)
        _pull_shares(
            points[used],
            by_share[used],
            self.corners,
            self.sides,
            self.turns,
            0.5 * width,
            found,
        )
        used = np.flatnonzero(by_away)
        _pull_blended(
            points[used],
            by_away[used],
            self.corners,
            self.sides,
            BLEND * width,
            ROUND * width,
            found,
        )
        return found


@kernel
def _shares(points, corners, sides, turns, radius, found):  # type: ignore[no-untyped-def]
    for i in range(len(points)):
        total = 0.0
        for k in range(len(sides)):
            j = sides[k]
            ax, ay = corners[j, 0] - points[i, 0], corners[j, 1] - points[i, 1]
            bx, by = corners[j + 1, 0] - points[i, 0], corners[j + 1, 1] - points[i, 1]
            angle = math.atan2(ax * by - ay * bx, ax * bx + ay * by)
            length = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
            if length > 0.0:
                # p: signed distance of the side's line, positive with the point on its left.
                ux, uy = (bx - ax) / length, (by - ay) / length
                p = ax * uy - ay * ux
                if abs(p) < radius:
                    reach = math.sqrt(radius * radius - p * p)
                    start, end = ax * ux + ay * uy, bx * ux + by * uy
                    s, t = max(start, -reach), min(end, reach)
                    if t > s:
                        angle -= _missing(p, s, t, radius)
            total += turns[k] * angle
        found[i] = min(max(total / (2.0 * math.pi), 0.0), 1.0)


@kernel
def _missing(p, s, t, radius):  # type: ignore[no-untyped-def]
    """∫ (1 − r²/R²)³ dθ from s to t along a line at the distance p; r² = p² + s²."""
    angle = math.atan2(p * (t - s), p * p + s * t)
    p, s, t = p / radius, s / radius, t / radius
    d1, d3, d5 = t - s, t**3 - s**3, t**5 - s**5
    p2 = p * p
    rest = 3.0 * d1 - 3.0 * (p2 * d1 + d3 / 3.0) + p2 * p2 * d1 + 2.0 * p2 * d3 / 3.0 + d5 / 5.0
    return angle - p * rest


@kernel
def _pull_shares(points, weights, corners, sides, turns, radius, found):  # type: ignore[no-untyped-def]
    """A corner's motion v changes χ by ∫ φ v·n along its sides, n the outward normal."""
    scale = 3.0 / (math.pi * radius * radius)
    for i in range(len(points)):
        for k in range(len(sides)):
            j = sides[k]
            ax, ay = corners[j, 0] - points[i, 0], corners[j, 1] - points[i, 1]
            bx, by = corners[j + 1, 0] - points[i, 0], corners[j + 1, 1] - points[i, 1]
            length = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
            if length == 0.0:
                continue
            ux, uy = (bx - ax) / length, (by - ay) / length
            p = ax * uy - ay * ux
            if abs(p) >= radius:
                continue
            reach = math.sqrt(radius * radius - p * p)
            start, end = ax * ux + ay * uy, bx * ux + by * uy
            s, t = max(start, -reach) / radius, min(end, reach) / radius
            if t <= s:
                continue
            q = 1.0 - (p / radius) ** 2
            whole = q * q * (t - s) - 2.0 * q * (t**3 - s**3) / 3.0 + (t**5 - s**5) / 5.0
            first = q * q * (t**2 - s**2) / 2.0 - q * (t**4 - s**4) / 2.0 + (t**6 - s**6) / 6.0
            factor = weights[i] * turns[k] * scale * radius
            far = factor * (first * radius - start * whole) / length
            near = factor * whole - far
            found[j, 0] += near * uy
            found[j, 1] -= near * ux
            found[j + 1, 0] += far * uy
            found[j + 1, 1] -= far * ux


@kernel
def _rounded(d, rounding):  # type: ignore[no-untyped-def]
    if d >= rounding:
        return d
    q2 = (d / rounding) ** 2
    return rounding * (3.0 + q2 * (6.0 - q2)) / 8.0


@kernel
def _nearest(px, py, corners, j):  # type: ignore[no-untyped-def]
    """Vector from a side to the point, its foot as a fraction of the side, and its length."""
    ax, ay = corners[j, 0], corners[j, 1]
    ex, ey = corners[j + 1, 0] - ax, corners[j + 1, 1] - ay
    squared = ex * ex + ey * ey
    t = ((px - ax) * ex + (py - ay) * ey) / squared if squared > 0.0 else 0.0
    t = min(max(t, 0.0), 1.0)
    return px - ax - t * ex, py - ay - t * ey, t, math.sqrt(squared)


@kernel
def _blend(point, corners, sides, rounding, blend, values, counts):  # type: ignore[no-untyped-def]
    """Fill in u and c of every side; return the weighted mean, Σ c exp(…) and the least u."""
    least = math.inf
    for k in range(len(sides)):
        x, y, _, length = _nearest(point[0], point[1], corners, sides[k])
        values[k] = _rounded(math.sqrt(x * x + y * y), rounding)
        counts[k] = length / (length + blend)
        if length > 0.0:
            least = min(least, values[k])
    whole, mean = 0.0, 0.0
    for k in range(len(sides)):
        over = (values[k] - least) / blend
        if over < NEGLIGIBLE:
            weight = counts[k] * math.exp(-over)
            whole += weight
            mean += weight * values[k]
    return mean / whole, whole, least


@kernel
def _blended(points, corners, sides, blend, rounding, found):  # type: ignore[no-untyped-def]
    values, counts = np.empty(len(sides)), np.empty(len(sides))
    for i in range(len(points)):
        found[i], _, _ = _blend(points[i], corners, sides, rounding, blend, values, counts)


@kernel
def _pull_blended(points, weights, corners, sides, blend, rounding, found):  # type: ignore[no-untyped-def]
    values, counts = np.empty(len(sides)), np.empty(len(sides))
    for i in range(len(points)):
        mean, whole, least = _blend(points[i], corners, sides, rounding, blend, values, counts)
        for k in range(len(sides)):
            over = (values[k] - least) / blend
            if over >= NEGLIGIBLE:
                continue
            j = sides[k]
            x, y, t, length = _nearest(points[i, 0], points[i, 1], corners, j)
            if length == 0.0:
                continue
            d = math.sqrt(x * x + y * y)
            slope = 1.0 / max(d, 1e-300)
            if d < rounding:
                slope = (3.0 - (d / rounding) ** 2) / (2.0 * rounding)
            part = weights[i] * math.exp(-over) / whole
            pull = -part * counts[k] * (1.0 - (values[k] - mean) / blend) * slope
            longer = part * (values[k] - mean) * blend / (length + blend) ** 2 / length
            ex, ey = corners[j + 1, 0] - corners[j, 0], corners[j + 1, 1] - corners[j, 1]
            found[j, 0] += (1.0 - t) * pull * x - longer * ex
            found[j, 1] += (1.0 - t) * pull * y - longer * ey
            found[j + 1, 0] += t * pull * x + longer * ex
            found[j + 1, 1] += t * pull * y + longer * ey
