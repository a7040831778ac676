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
GROUP = 16
"""Sides that share a box, by which those far away are passed over."""
NEGLIGIBLE = 20.0
"""Sides farther than the nearest by more than this many ranges do not count: e⁻²⁰ = 2·10⁻⁹."""
LAST = math.exp(-NEGLIGIBLE)
"""Taken off every weight, so that it is nothing where a side ceases to count."""


@dataclass(frozen=True, eq=False)
class Boundary:
    """The rings of a region: M corners, each ring closed by its first corner again.

    Attributes:
        corners: [m], shape (M, 2).
        sides: index of the first corner of each side, the second follows it, shape (S,).
        turns: 1 where the region lies on the left of a side, −1 where on the right, shape (S,).
        boxes: (low x, low y, high x, high y) of every `GROUP` sides in a row [m], shape (B, 4).
    """

    corners: Floats
    sides: NDArray[np.intp]
    turns: Floats
    boxes: Floats

    @classmethod
    def of(cls, region: BaseGeometry) -> Boundary:
        """The boundary of a polygon or of polygons [m]."""
        import shapely

        rings, polygon = shapely.get_rings(shapely.get_parts(region), return_index=True)
        corners, ring = shapely.get_coordinates(rings, return_index=True)
        sides = np.flatnonzero(ring[1:] == ring[:-1])
        outer = np.concatenate([[True], polygon[1:] != polygon[:-1]])
        turns = np.where(shapely.is_ccw(rings) == outer, 1.0, -1.0)
        ends = np.stack([corners[sides], corners[sides + 1]])
        starts = np.arange(0, len(sides), GROUP)
        low = np.minimum.reduceat(ends.min(axis=0), starts, axis=0)
        high = np.maximum.reduceat(ends.max(axis=0), starts, axis=0)
        boxes = np.concatenate([low, high], axis=1)
        return cls(np.ascontiguousarray(corners), sides, turns[ring[sides]], boxes)

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
        _shares(points, self.corners, self.sides, self.turns, self.boxes, 0.5 * width, found)
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
        _blended(points, self.corners, self.sides, self.boxes, BLEND * width, ROUND * width, found)
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
            self.boxes,
            0.5 * width,
            found,
        )
        used = np.flatnonzero(by_away)
        _pull_blended(
            points[used],
            by_away[used],
            self.corners,
            self.sides,
            self.boxes,
            BLEND * width,
            ROUND * width,
            found,
        )
        return found


@kernel
def _shares(points, corners, sides, turns, boxes, radius, found):  # type: ignore[no-untyped-def]
    """1 or 0 by the winding number, less what is missing of the angles of sides close by."""
    for i in range(len(points)):
        # A little beside the place: on a side or a corner the winding number is not defined.
        px, py = points[i, 0] + 7e-11 * radius, points[i, 1] + 3e-11 * radius
        winding, missing, k = 0.0, 0.0, -1
        while k + 1 < len(sides):
            k += 1
            box = k // GROUP
            if k % GROUP == 0 and (
                boxes[box, 3] < py - radius
                or boxes[box, 1] > py + radius
                or boxes[box, 2] < px - radius
            ):
                k += GROUP - 1  # beside the point, or where its ray does not go
                continue
            j = sides[k]
            ay, by = corners[j, 1] - py, corners[j + 1, 1] - py
            ax, bx = corners[j, 0] - px, corners[j + 1, 0] - px
            cross = ax * by - ay * bx
            if ay <= 0.0 < by and cross > 0.0:
                winding += turns[k]
            elif by <= 0.0 < ay and cross < 0.0:
                winding -= turns[k]
            if (ax > radius and bx > radius) or (ax < -radius and bx < -radius):
                continue
            length = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
            if length > 0.0 and abs(cross) < radius * length:
                ux, uy = (bx - ax) / length, (by - ay) / length
                p = cross / length  # positive with the point on the left of the side
                reach = math.sqrt(radius * radius - p * p)
                s, t = max(ax * ux + ay * uy, -reach), min(bx * ux + by * uy, reach)
                if t > s:
                    missing += turns[k] * _missing(p, s, t, radius)
        found[i] = min(max(winding - missing / (2.0 * math.pi), 0.0), 1.0)


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
def _outside(px, py, box):  # type: ignore[no-untyped-def]
    """Distance of a point from a box, 0 in it."""
    x = max(box[0] - px, px - box[2], 0.0)
    y = max(box[1] - py, py - box[3], 0.0)
    return math.sqrt(x * x + y * y)


@kernel
def _pull_shares(points, weights, corners, sides, turns, boxes, radius, found):  # type: ignore[no-untyped-def]
    """A corner's motion v changes χ by ∫ φ v·n along its sides, n the outward normal."""
    scale = 3.0 / (math.pi * radius * radius)
    for i in range(len(points)):
        k = -1
        while k + 1 < len(sides):
            k += 1
            if k % GROUP == 0 and _outside(points[i, 0], points[i, 1], boxes[k // GROUP]) > radius:
                k += GROUP - 1
                continue
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
def _lines(corners, sides):  # type: ignore[no-untyped-def]
    """Start, way to the end, length, and its square's inverse (0 without a length) of sides."""
    found = np.empty((len(sides), 6))
    for k in range(len(sides)):
        j = sides[k]
        x, y = corners[j, 0], corners[j, 1]
        ex, ey = corners[j + 1, 0] - x, corners[j + 1, 1] - y
        square = ex * ex + ey * ey
        found[k] = x, y, ex, ey, math.sqrt(square), 1.0 / square if square > 0.0 else 0.0
    return found


@kernel
def _distances(px, py, lines, box, squares):  # type: ignore[no-untyped-def]
    """Squared distance from every side of a box; return the least, of sides with a length."""
    least = math.inf
    for k in range(box * GROUP, min((box + 1) * GROUP, len(lines))):
        ax, ay, ex, ey = px - lines[k, 0], py - lines[k, 1], lines[k, 2], lines[k, 3]
        t = min(max((ax * ex + ay * ey) * lines[k, 5], 0.0), 1.0)
        x, y = ax - t * ex, ay - t * ey
        squares[k] = x * x + y * y if lines[k, 5] > 0.0 else math.inf
        least = min(least, squares[k])
    return least


@kernel
def _nearby(px, py, lines, boxes, rounding, blend, bounds, squares):  # type: ignore[no-untyped-def]
    """Squared distances from the sides of all boxes that are within the limit.

    Returns:
        Distance from the nearest side, and that beyond which a side does not count.
    """
    first = 0
    for box in range(len(boxes)):
        bounds[box] = _outside(px, py, boxes[box])
        if bounds[box] < bounds[first]:
            first = box
    nearest = math.sqrt(_distances(px, py, lines, first, squares))
    limit = max(nearest, rounding) + NEGLIGIBLE * blend
    for box in range(len(boxes)):
        if box != first and bounds[box] < limit:
            square = _distances(px, py, lines, box, squares)
            if square < nearest * nearest:
                nearest = math.sqrt(square)
                limit = max(nearest, rounding) + NEGLIGIBLE * blend
    return nearest, limit


@kernel
def _blend(px, py, lines, boxes, rounding, blend, bounds, squares, near, over):  # type: ignore[no-untyped-def]
    """Weighted mean of u, and the sum of the weights; `near` lists the sides that count.

    `squares` has u of these sides, `over` has exp((least − u)/k).

    Returns:
        The mean, the sum, and how many sides count.
    """
    nearest, limit = _nearby(px, py, lines, boxes, rounding, blend, bounds, squares)
    least, narrow = _rounded(nearest, rounding), 1.0 / blend
    whole, mean, count = 0.0, 0.0, 0
    for box in range(len(boxes)):
        if bounds[box] >= limit:
            continue
        for k in range(box * GROUP, min((box + 1) * GROUP, len(lines))):
            if squares[k] < limit * limit:
                value = _rounded(math.sqrt(squares[k]), rounding)
                factor = math.exp((least - value) * narrow)
                if factor <= LAST:
                    continue
                weight = lines[k, 4] / (lines[k, 4] + blend) * (factor - LAST)
                whole += weight
                mean += weight * value
                squares[k], over[k], near[count] = value, factor, k
                count += 1
    return mean / whole, whole, count


@kernel
def _blended(points, corners, sides, boxes, blend, rounding, found):  # type: ignore[no-untyped-def]
    bounds, squares = np.empty(len(boxes)), np.empty(len(sides))
    near, over, lines = np.empty(len(sides), np.int64), np.empty(len(sides)), _lines(corners, sides)
    for i in range(len(points)):
        px, py = points[i, 0], points[i, 1]
        found[i], _, _ = _blend(px, py, lines, boxes, rounding, blend, bounds, squares, near, over)


@kernel
def _pull_blended(points, weights, corners, sides, boxes, blend, rounding, found):  # type: ignore[no-untyped-def]
    bounds, squares = np.empty(len(boxes)), np.empty(len(sides))
    near, over, lines = np.empty(len(sides), np.int64), np.empty(len(sides)), _lines(corners, sides)
    narrow, flat = 1.0 / blend, 1.0 / (rounding * rounding)
    for i in range(len(points)):
        px, py = points[i, 0], points[i, 1]
        mean, whole, count = _blend(
            px, py, lines, boxes, rounding, blend, bounds, squares, near, over
        )
        part = weights[i] / whole
        nearest, spread = near[0], 0.0
        for n in range(count):
            k = near[n]
            spread += lines[k, 4] / (lines[k, 4] + blend) * (squares[k] - mean)
            if squares[k] < squares[nearest]:
                nearest = k
        for n in range(count):
            k = near[n]
            length, value = lines[k, 4], squares[k]
            ax, ay, ex, ey = px - lines[k, 0], py - lines[k, 1], lines[k, 2], lines[k, 3]
            t = min(max((ax * ex + ay * ey) * lines[k, 5], 0.0), 1.0)
            x, y = ax - t * ex, ay - t * ey
            if value >= rounding:  # u is the distance itself
                slope = 1.0 / value
            else:
                slope = (3.0 - (x * x + y * y) * flat) * 0.5 / rounding
            share, beyond = 1.0 / (length + blend), over[k] - LAST
            turn = (beyond - over[k] * (value - mean) * narrow) * length * share
            if k == nearest:  # which sets from where on sides do not count
                turn += LAST * spread * narrow
            pull = -part * turn * slope
            longer = part * beyond * (value - mean) * blend * share * share / length
            j = sides[k]
            found[j, 0] += (1.0 - t) * pull * x - longer * ex
            found[j, 1] += (1.0 - t) * pull * y - longer * ey
            found[j + 1, 0] += t * pull * x + longer * ex
            found[j + 1, 1] += t * pull * y + longer * ey
