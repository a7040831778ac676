"""A guard that keeps triangles from collapsing into slivers and turning inside out."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np

from sheetmorph.core.compiled import kernel
from sheetmorph.energy.term import Kernel
from sheetmorph.energy.vectors import dot, normal
from sheetmorph.geometry.mesh import Floats, Ints, SheetMesh

WORST = 0.3
"""Part of the quality of its natural shape below which a triangle is held open.

A triangle with equal sides is there squeezed to angles of 15°, 15° and 150°. The published
designs stay above 0.68.
"""

LEAST_AREA = 0.1
"""Least part of its area that a triangle keeps in one step."""

HALVINGS = 12


@dataclass(frozen=True, eq=False)
class TriangleGuard:
    """φ = −κ (1 − u)² ln u for every triangle with u < 1, where u = q/q_min is its quality.

    q = 4 √3 area / (sum of the squared sides) is 1 with equal sides and 0 where a triangle has
    collapsed, whatever its size. Neither springs along edges nor the law of Saint Venant and
    Kirchhoff resist that, and beyond it the normal of the triangle and with it all bending
    turns over. φ and its first two derivatives are zero for u ≥ 1: shapes without such
    triangles do not feel it.

    Attributes:
        stencil: corners, shape (T, 3).
        limit: q_min, shape (T,).
        stiffness: κ [J], shape (T,).
    """

    stencil: Ints
    limit: Floats
    stiffness: Floats

    name = "guard"
    keeps = "triangles from collapsing"
    reference = (
        "Li, Ferguson, Schneider, Langlois, Zorin, Panozzo, Jiang, Kaufman, Incremental "
        "potential contact, ACM Transactions on Graphics 39, 2020: the clamped log barrier"
    )
    linear = False

    @classmethod
    def of(cls, mesh: SheetMesh, stiffness: Floats, natural: Floats | None = None) -> TriangleGuard:
        """The guard of a mesh.

        Args:
            mesh: the reference mesh.
            stiffness: κ of its triangles [J], shape (T,).
            natural: squared sides of the triangles at full actuation, left alone [m²], shape
                (T, 3); those of the mesh by default.
        """
        limit = WORST * qualities(mesh.nodes, mesh.triangles)
        if natural is not None:
            limit = np.minimum(limit, WORST * qualities_by_sides(natural))
        return cls(np.ascontiguousarray(mesh.triangles, dtype=np.int32), limit, stiffness)

    @classmethod
    def specimen(cls, mesh: SheetMesh, rng: np.random.Generator) -> Self:
        """A guard that half of the triangles feel, for tests."""
        count = len(mesh.triangles)
        limit = qualities(mesh.nodes, mesh.triangles) * rng.uniform(0.5, 1.5, count)
        triangles = np.ascontiguousarray(mesh.triangles, dtype=np.int32)
        return cls(triangles, limit, rng.uniform(1.0, 2.0, count))

    def at(self, ramp: float, load: float) -> Self:
        """The same guard."""
        return self

    def held_open(self, x: Floats) -> Ints:
        """The triangles that it holds at positions x, rows of three."""
        squeezed = qualities(x, self.stencil) < self.limit
        return np.flatnonzero(squeezed).astype(np.int32)

    def idle(self, x: Floats) -> bool:
        """True where no triangle feels it; see `sheetmorph.energy.term.Term`."""
        return not _any_squeezed(x, self.stencil, self.limit)

    def reach(self, x: Floats, step: Floats) -> float:
        """The part of a step in which no triangle turns by 90° or all but loses its area.

        Farther than that derivatives at x tell nothing, and a triangle that turns over on the
        way leaves the sheet in a knot.
        """
        return part_of_step(lambda part: not _turns_over(x, step, part, self.stencil), HALVINGS)

    def local_kernel(self) -> Kernel:
        """Kernel and parameters; see `sheetmorph.energy.term.Term.local_kernel`."""
        return _guard_local, (self.stencil, self.limit, self.stiffness)


def qualities(x: Floats, triangles: Ints) -> Floats:
    """Quality of triangles, 4 √3 area over the sum of the squared sides, shape (T,)."""
    a, b, c = (x[triangles[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    squares = sum(np.einsum("ij,ij->i", d, d) for d in (b - a, c - b, a - c))
    return np.asarray(4.0 * math.sqrt(3.0) * area / squares)


def qualities_by_sides(squares: Floats) -> Floats:
    """Quality of triangles by their squared sides, shape (T, 3); 0 where there is no triangle."""
    total = squares.sum(axis=1)
    areas = np.maximum(total**2 - 2.0 * (squares**2).sum(axis=1), 0.0)  # 16 area², by Heron
    return np.asarray(math.sqrt(3.0) * np.sqrt(areas) / total)


def part_of_step(allowed: Callable[[float], bool], halvings: int) -> float:
    """1, or the first of its halves that is allowed, or the last that is tried."""
    part = 1.0
    for _ in range(halvings):
        if allowed(part):
            break
        part *= 0.5
    return part


@kernel
def _any_squeezed(x, stencil, limit):  # type: ignore[no-untyped-def]
    """Is the quality of a triangle below its limit?"""
    n = np.empty(3)
    for i in range(len(stencil)):
        a, b, c = stencil[i, 0], stencil[i, 1], stencil[i, 2]
        square, squares = normal(x, a, b, c, n), 0.0
        for p in range(3):
            ahead, past = stencil[i, (p + 1) % 3], stencil[i, (p + 2) % 3]
            for r in range(3):
                squares += (x[past, r] - x[ahead, r]) ** 2
        if not 12.0 * square >= (limit[i] * squares) ** 2:
            return True
    return False


@kernel
def _turns_over(x, step, part, stencil):  # type: ignore[no-untyped-def]
    """Does a triangle turn by 90° or lose its area in a part of a step?"""
    before, after = np.empty(3), np.empty(3)
    y = x + part * step
    for i in range(len(stencil)):
        a, b, c = stencil[i, 0], stencil[i, 1], stencil[i, 2]
        size, left = normal(x, a, b, c, before), normal(y, a, b, c, after)
        if not (dot(before, after) > 0.0 and left >= LEAST_AREA**2 * size):
            return True
    return False


@kernel
def _guard_local(  # type: ignore[no-untyped-def]
    x, stencil, limit, stiffness, start, stop, order, energy, grad, hess
):
    """Write the local quantities of triangles start … stop − 1.

    With y = ln u = ln A − ln S + const, A the area and S the sum of the squared sides, all
    derivatives of φ(y) follow from those of A and S. Corner i lies opposite d_i, and c_i = d_i × n.
    """
    d = np.empty((3, 3))
    c = np.empty((3, 3))
    by_area = np.empty((3, 3))
    by_sides = np.empty((3, 3))
    n = np.empty(3)
    for i in range(start, stop):
        k = i - start
        for p in range(3):
            ahead, past = stencil[i, (p + 1) % 3], stencil[i, (p + 2) % 3]
            for r in range(3):
                d[p, r] = x[ahead, r] - x[past, r]
        for r in range(3):
            # the cross product of the sides from corner 0
            n[r] = d[1, (r + 1) % 3] * d[2, (r + 2) % 3] - d[1, (r + 2) % 3] * d[2, (r + 1) % 3]
        double = math.sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2)
        squares = 0.0
        for p in range(3):
            squares += d[p, 0] ** 2 + d[p, 1] ** 2 + d[p, 2] ** 2
        u = 2.0 * math.sqrt(3.0) * double / (squares * limit[i])
        energy[k] = 0.0
        if order >= 1:
            grad[k] = 0.0
        if order >= 2:
            hess[k] = 0.0
        if u >= 1.0:
            continue
        if u <= 0.0:
            energy[k] = math.inf
            continue
        y, rest = math.log(u), 1.0 - u
        energy[k] = -stiffness[i] * rest * rest * y
        if order < 1:
            continue
        first = stiffness[i] * (2.0 * u * rest * y - rest * rest)
        for r in range(3):
            n[r] /= double
        for p in range(3):
            q, s = (p + 1) % 3, (p + 2) % 3
            for r in range(3):
                c[p, r] = d[p, (r + 1) % 3] * n[(r + 2) % 3] - d[p, (r + 2) % 3] * n[(r + 1) % 3]
                by_area[p, r] = c[p, r] / double
                by_sides[p, r] = 2.0 * (d[s, r] - d[q, r]) / squares
                grad[k, p, r] = first * (by_area[p, r] - by_sides[p, r])
        if order < 2:
            continue
        second = stiffness[i] * u * (2.0 * (1.0 - 2.0 * u) * y + 4.0 * rest)
        block = 0
        for p in range(3):
            for q in range(p, 3):
                along = d[p, 0] * d[q, 0] + d[p, 1] * d[q, 1] + d[p, 2] * d[q, 2]
                for r in range(3):
                    for s in range(3):
                        slope = (by_area[p, r] - by_sides[p, r]) * (by_area[q, s] - by_sides[q, s])
                        value = -first * by_area[p, r] * by_area[q, s]
                        if r == s:
                            value -= first * (4.0 if p == q else -2.0) / squares
                        if order == 3:
                            hess[k, block, r, s] = value + max(second, 0.0) * slope
                            continue
                        bent = -d[q, r] * d[p, s] - c[p, r] * c[q, s]
                        if r == s:
                            bent += along
                        elif p != q:
                            # minus the matrix of n ×, for corners that follow each other
                            sign = 1.0 if (r - s) % 3 == 1 else -1.0
                            bent -= (1.0 if q == p + 1 else -1.0) * sign * n[3 - r - s] * double
                        value += first * (bent / double**2 + by_sides[p, r] * by_sides[q, s])
                        hess[k, block, r, s] = value + second * slope
                block += 1
