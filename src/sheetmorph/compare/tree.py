"""The nearest point of a triangle surface: a tree of boxes, asked by compiled threads.

libigl's tree finds the same points; it takes two to three times as long, and other threads
have to wait for it.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numba import config
from numpy.typing import NDArray

from sheetmorph.core.compiled import kernel
from sheetmorph.geometry.mesh import Floats

Indices = NDArray[np.int64]

LEAF = 2  # triangles in a box that is not divided further, at most
CHUNK = 2048  # points that one thread takes at a time
DEPTH = 64  # boxes that wait at any time: one for each level, and no tree is that deep


@dataclass(frozen=True, eq=False)
class Tree:
    """Boxes around halves of halves of the triangles of a surface.

    The 2^levels boxes of the last level hold the triangles in equal parts; box k has the
    halves 2k + 1 and 2k + 2.

    Attributes:
        order: the triangle of the surface at each row of `rows`, shape (T,).
        rows: every triangle in its plane, shape (T, 15): the corner where its longest edge
            begins; unit vectors along that edge, across it towards the third corner, and
            square to both; length of the edge; where the third corner lies along and across.
        boxes: lowest and highest corner of each box, shape (2^(levels + 1) − 1, 6).
        levels: how often the triangles were halved.
    """

    order: Indices
    rows: Floats
    boxes: Floats
    levels: int

    @classmethod
    def over(cls, points: Floats, triangles: Indices) -> Tree:
        """A tree over triangles, each with an area; at least one.

        Args:
            points: shape (V, 3).
            triangles: shape (T, 3).
        """
        count = len(triangles)
        levels = max(0, int(np.ceil(np.log2(count / LEAF))))
        corners = points[triangles]
        low, high = corners.min(axis=1), corners.max(axis=1)
        order = _halved(low + high, levels)
        starts = _starts(count, levels)
        boxes = np.empty((2 ** (levels + 1) - 1, 6))
        level = np.hstack(
            [np.minimum.reduceat(low[order], starts), np.maximum.reduceat(high[order], starts)]
        )
        boxes[2**levels - 1 :] = level
        for depth in range(levels - 1, -1, -1):
            first, second = level[::2], level[1::2]
            level = np.hstack(
                [np.minimum(first[:, :3], second[:, :3]), np.maximum(first[:, 3:], second[:, 3:])]
            )
            boxes[2**depth - 1 : 2 ** (depth + 1) - 1] = level
        return cls(order, _in_their_planes(corners[order]), boxes, levels)

    def nearest(self, points: Floats) -> tuple[Floats, Indices, Floats]:
        """Squared distance, triangle and nearest point of each of n points.

        Args:
            points: shape (n, 3).

        Returns:
            Shapes (n,), (n,) and (n, 3). Where several triangles are equally near, as at
            their common edge, it is one of them; which one does not depend on the number
            of threads, which NUMBA_NUM_THREADS sets.
        """
        points = np.ascontiguousarray(points, dtype=np.float64)
        square, place = np.empty(len(points)), np.empty(len(points), dtype=np.int64)
        found = np.empty((len(points), 3))

        def ask(start: int) -> None:
            part = slice(start, start + CHUNK)
            _nearest(
                points[part], self.rows, self.boxes, self.levels,
                square[part], place[part], found[part],
            )  # fmt: skip

        chunks = range(0, len(points), CHUNK)
        if len(chunks) > 1 and config.NUMBA_NUM_THREADS > 1:
            list(_threads().map(ask, chunks))
        else:
            for start in chunks:
                ask(start)
        return square, self.order[place], found


@cache
def _threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(config.NUMBA_NUM_THREADS)


def _starts(count: int, levels: int) -> Indices:
    return (np.arange(2**levels, dtype=np.int64) * count) >> levels


def _halved(centres: Floats, levels: int) -> Indices:
    """An order of the triangles in which every part is halved across its widest side."""
    count = len(centres)
    order = np.arange(count, dtype=np.int64)
    for level in range(levels):
        starts = _starts(count, level)
        part = np.repeat(np.arange(len(starts)), np.diff(starts, append=count))
        there = centres[order]
        low = np.minimum.reduceat(there, starts)
        width = np.maximum.reduceat(there, starts) - low
        axis = width.argmax(axis=1)
        span = np.maximum(np.take_along_axis(width, axis[:, None], 1)[:, 0], 1e-300)
        along = np.take_along_axis(there - low[part], axis[part][:, None], 1)[:, 0] / span[part]
        order = order[np.argsort(part + 0.5 * along, kind="stable")]
    return order


def _in_their_planes(corners: Floats) -> Floats:
    """`Tree.rows` of triangles, shape (T, 3, 3).

    With the longest edge as the axis, the foot of the height lies on that edge, and the
    directions are as exact as the triangle has them, even where it is nearly a line.
    """
    edges = corners[:, [1, 2, 0]] - corners
    first = (edges**2).sum(axis=2).argmax(axis=1)
    row = np.arange(len(corners))
    start, third = corners[row, first], corners[row, (first + 2) % 3]
    edge = edges[row, first]
    length = np.linalg.norm(edge, axis=1)
    along = edge / length[:, None]
    side = third - start
    foot = (side * along).sum(axis=1)
    rise = side - foot[:, None] * along
    rise -= (rise * along).sum(axis=1)[:, None] * along  # once more, for the digits lost
    height = np.linalg.norm(rise, axis=1)
    # Where rounding leaves no height, any direction across will do.
    least = np.eye(3)[np.abs(along).argmin(axis=1)]
    rise = np.where(height[:, None] > 0.0, rise, np.cross(along, least))
    across = rise / np.linalg.norm(rise, axis=1)[:, None]
    numbers = np.stack([length, foot, height], axis=1)
    return np.hstack([start, along, across, np.cross(along, across), numbers])


def _box_python(boxes: Floats, k: int, x: float, y: float, z: float) -> Any:
    """Squared distance to a box."""
    dx = max(max(boxes[k, 0] - x, x - boxes[k, 3]), 0.0)
    dy = max(max(boxes[k, 1] - y, y - boxes[k, 4]), 0.0)
    dz = max(max(boxes[k, 2] - z, z - boxes[k, 5]), 0.0)
    return dx * dx + dy * dy + dz * dz


def _triangle_python(
    rows: Floats, t: int, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """Squared distance to a triangle, and its nearest point along and across its edge."""
    x, y, z = x - rows[t, 0], y - rows[t, 1], z - rows[t, 2]
    s = x * rows[t, 3] + y * rows[t, 4] + z * rows[t, 5]
    r = x * rows[t, 6] + y * rows[t, 7] + z * rows[t, 8]
    off = x * rows[t, 9] + y * rows[t, 10] + z * rows[t, 11]
    length, foot, height = rows[t, 12], rows[t, 13], rows[t, 14]
    if r <= 0.0:
        near_s, near_r = min(max(s, 0.0), length), 0.0
    else:
        near_s, near_r = s, r
        gap = np.inf
        # Both other edges, where the point is beyond them; behind the corner it is both.
        if s * height < r * foot:
            share = min(max((s * foot + r * height) / (foot**2 + height**2), 0.0), 1.0)
            near_s, near_r = share * foot, share * height
            gap = (s - near_s) ** 2 + (r - near_r) ** 2
        rest = length - foot
        if (length - s) * height < r * rest:
            share = ((length - s) * rest + r * height) / (rest**2 + height**2)
            share = min(max(share, 0.0), 1.0)
            other_s, other_r = length - share * rest, share * height
            if (s - other_s) ** 2 + (r - other_r) ** 2 < gap:
                near_s, near_r = other_s, other_r
    return off * off + (s - near_s) ** 2 + (r - near_r) ** 2, near_s, near_r


_box: Any = kernel(_box_python)
_triangle: Any = kernel(_triangle_python)


def _nearest_python(
    points: Floats,
    rows: Floats,
    boxes: Floats,
    levels: int,
    square: Floats,
    place: Indices,
    found: Floats,
) -> None:
    """Depth first, the nearer half first; what is farther than the best so far is left out."""
    waiting, away = np.empty(DEPTH, dtype=np.int64), np.empty(DEPTH)
    leaves, count = 2**levels - 1, len(rows)
    best = 0
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        # Neighbours in the list are mostly neighbours in space: the last answer is a bound.
        least, along, across = _triangle(rows, best, x, y, z)
        waiting[0], away[0], top = 0, 0.0, 1
        while top > 0:
            top -= 1
            if away[top] >= least:
                continue
            k = waiting[top]
            while k < leaves:
                near, far = 2 * k + 1, 2 * k + 2
                low, high = _box(boxes, near, x, y, z), _box(boxes, far, x, y, z)
                if high < low:
                    near, far, low, high = far, near, high, low
                if high < least:
                    waiting[top], away[top] = far, high
                    top += 1
                if low >= least:
                    break
                k = near
            else:
                leaf = k - leaves
                for t in range((leaf * count) >> levels, ((leaf + 1) * count) >> levels):
                    other, new_along, new_across = _triangle(rows, t, x, y, z)
                    if other < least:
                        least, along, across, best = other, new_along, new_across, t
        square[i], place[i] = least, best
        for d in range(3):
            found[i, d] = rows[best, d] + along * rows[best, 3 + d] + across * rows[best, 6 + d]


_nearest: Any = kernel(_nearest_python)
