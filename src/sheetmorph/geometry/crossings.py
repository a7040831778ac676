"""Where a surface passes through itself: pairs of triangles that cross."""

from __future__ import annotations

import numpy as np

from sheetmorph.core.compiled import kernel
from sheetmorph.geometry.mesh import Floats, Ints


def crossing_pairs(positions: Floats, triangles: Ints) -> Ints:
    """Pairs of triangles of which a side of one passes through the inside of the other.

    Triangles that share an edge do not count, and of two that share a corner only the sides
    opposite to it. Touching is not crossing: a side must reach both faces of a triangle, and
    signs of volumes decide, without tolerance (Guigue and Devillers, Fast and robust
    triangle-triangle overlap test using orientation predicates, J. Graphics Tools 8, 2003).
    Triangles that overlap in one plane do not cross.

    Args:
        positions: of the nodes [m], shape (V, 3).
        triangles: their nodes, shape (T, 3).

    Returns:
        Indices of the triangles, the smaller first, in increasing order, shape (P, 2).
    """
    corners = positions[triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    widest = int(np.ptp(positions, axis=0).argmax())
    order = np.argsort(low[:, widest], kind="stable").astype(np.int32)
    capacity = len(triangles) + 16
    while True:
        found = np.empty((capacity, 2), dtype=np.int32)
        count = _sweep(positions, triangles, low, high, order, widest, found)
        if count <= capacity:
            break
        capacity = count
    pairs = np.sort(found[:count], axis=1)
    return np.asarray(pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))])


@kernel
def _sweep(x, triangles, low, high, order, axis, found):  # type: ignore[no-untyped-def]
    """Test all pairs whose boxes overlap; writes as many as there is room for, counts all."""
    count = 0
    for i in range(len(order)):
        a = order[i]
        for j in range(i + 1, len(order)):
            b = order[j]
            if low[b, axis] > high[a, axis]:
                break
            apart = False
            for c in range(3):
                apart = apart or low[a, c] > high[b, c] or low[b, c] > high[a, c]
            if not apart and _cross(x, triangles[a], triangles[b]):
                if count < len(found):
                    found[count, 0], found[count, 1] = a, b
                count += 1
    return count


@kernel
def _cross(x, a, b):  # type: ignore[no-untyped-def]
    shared = 0
    for p in range(3):
        for q in range(3):
            if a[p] == b[q]:
                shared += 1
    if shared > 1:
        return False
    for p in range(3):
        first, second = a[p], a[(p + 1) % 3]
        if first not in b and second not in b and _pierces(x, first, second, b):
            return True
        first, second = b[p], b[(p + 1) % 3]
        if first not in a and second not in a and _pierces(x, first, second, a):
            return True
    return False


@kernel
def _pierces(x, first, second, triangle):  # type: ignore[no-untyped-def]
    """Whether the segment between two nodes passes through the inside of a triangle."""
    above = _volume(x, triangle[0], triangle[1], triangle[2], first)
    below = _volume(x, triangle[0], triangle[1], triangle[2], second)
    if not above * below < 0.0:
        return False
    positive = negative = True
    for p in range(3):
        side = _volume(x, first, second, triangle[p], triangle[(p + 1) % 3])
        positive = positive and side > 0.0
        negative = negative and side < 0.0
    return positive or negative


@kernel
def _volume(x, a, b, c, d):  # type: ignore[no-untyped-def]
    """Six times the signed volume of a tetrahedron."""
    ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    vx, vy, vz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
    wx, wy, wz = x[d, 0] - x[a, 0], x[d, 1] - x[a, 1], x[d, 2] - x[a, 2]
    return (uy * vz - uz * vy) * wx + (uz * vx - ux * vz) * wy + (ux * vy - uy * vx) * wz
