"""A guard that keeps neighbouring triangles from folding through each other."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from sheetmorph.core.compiled import kernel
from sheetmorph.energy.guard import part_of_step
from sheetmorph.energy.hinge import add_angle_hessian, outer_products
from sheetmorph.energy.term import Kernel
from sheetmorph.energy.vectors import cross, dot, normal
from sheetmorph.geometry.mesh import Floats, Ints, SheetMesh
from sheetmorph.geometry.surface import dihedral_angles

FOLDED = math.radians(155.0)
"""Dihedral angle [rad] beyond which a fold is held open; 180° is folded flat."""

STIFFER = 10.0
"""κ over the stiffness against bending of the sheet at the hinge."""

HALVINGS = 30


@dataclass(frozen=True, eq=False)
class FoldGuard:
    """φ = −κ (1 − u)² ln u for every hinge with u < 1, u = (π − |θ|)/(π − θ_max).

    θ is the dihedral angle. At ±π one triangle lies on the other, and a sheet goes no farther;
    the angle jumps there by a whole turn and every energy of it with it. φ and its first two
    derivatives are zero for u ≥ 1: shapes without such folds do not feel it.

    Attributes:
        stencil: nodes (a, b, c, d) of the hinges, shape (H, 4).
        stiffness: κ [J], shape (H,).
        limit: θ_max [rad].
    """

    stencil: Ints
    stiffness: Floats
    limit: float = FOLDED

    name = "fold"
    keeps = "triangles from folding through each other"
    reference = (
        "Li, Ferguson, Schneider, Langlois, Zorin, Panozzo, Jiang, Kaufman, Incremental "
        "potential contact, ACM Transactions on Graphics 39, 2020: the clamped log barrier"
    )
    linear = False

    @classmethod
    def of(cls, mesh: SheetMesh, bending: Floats) -> FoldGuard:
        """The guard of a mesh.

        Args:
            mesh: the reference mesh.
            bending: energy per squared angle with which the sheet resists bending at its hinges,
                twice [J], shape (H,).
        """
        return cls(mesh.hinges, STIFFER * bending)

    @classmethod
    def specimen(cls, mesh: SheetMesh, rng: np.random.Generator) -> Self:
        """A guard that all but flat hinges feel, for tests."""
        return cls(mesh.hinges, rng.uniform(1.0, 2.0, len(mesh.hinges)), 1e-3)

    def at(self, ramp: float, load: float) -> Self:
        """The same guard."""
        return self

    def held_open(self, x: Floats) -> Ints:
        """The hinges that it holds at positions x."""
        folded = np.abs(dihedral_angles(x, self.stencil)) > self.limit
        return np.flatnonzero(folded).astype(np.int32)

    def idle(self, x: Floats) -> bool:
        """True where no hinge feels it; see `sheetmorph.energy.term.Term`."""
        return not _any_folded(x, self.stencil, math.cos(self.limit))

    def reach(self, x: Floats, step: Floats) -> float:
        """The part of a step in which no hinge folds past 180°.

        Steps are taken to turn hinges by less than 180°: `TriangleGuard.reach` sees to it.
        """
        return part_of_step(lambda part: not _passes_flat(x, step, part, self.stencil), HALVINGS)

    def local_kernel(self) -> Kernel:
        """Kernel and parameters; see `sheetmorph.energy.term.Term.local_kernel`."""
        return _fold_local, (self.stencil, self.stiffness, self.limit)


@kernel
def _normals(x, nodes, n):  # type: ignore[no-untyped-def]
    """Write a → b and the normals of abc and adb, twice their areas long; their product."""
    a, b, c, d = nodes[0], nodes[1], nodes[2], nodes[3]
    for r in range(3):
        n[0, r] = x[b, r] - x[a, r]
    normal(x, a, b, c, n[1])
    normal(x, a, d, b, n[2])
    return dot(n[1], n[2])


@kernel
def _angle(n, product):  # type: ignore[no-untyped-def]
    """The dihedral angle by what `_normals` gives."""
    return math.atan2(dot(n[0], cross(n[1], n[2])) / math.sqrt(dot(n[0], n[0])), product)


@kernel
def _any_folded(x, stencil, cosine):  # type: ignore[no-untyped-def]
    """Is the cosine of an angle below a limit?"""
    n = np.empty((3, 3))
    for i in range(len(stencil)):
        product = _normals(x, stencil[i], n)
        if product >= 0.0 and cosine <= 0.0:
            continue
        if product < cosine * math.sqrt(dot(n[1], n[1]) * dot(n[2], n[2])):
            return True
    return False


@kernel
def _passes_flat(x, step, part, stencil):  # type: ignore[no-untyped-def]
    """Does a hinge turn through ±π in a part of a step?"""
    before, after = np.empty((3, 3)), np.empty((3, 3))
    y = x + part * step
    for i in range(len(stencil)):
        first, second = _normals(x, stencil[i], before), _normals(y, stencil[i], after)
        if first >= 0.0 and second >= 0.0:
            continue
        if abs(_angle(after, second) - _angle(before, first)) > math.pi:
            return True
    return False


@kernel
def _fold_local(  # type: ignore[no-untyped-def]
    x, stencil, stiffness, limit, start, stop, order, energy, grad, hess
):
    """Write the local quantities of hinges start … stop − 1; ∇θ and ∇²θ as in the hinge."""
    n, g = np.empty((3, 3)), np.empty((4, 3))
    width = math.pi - limit
    for i in range(start, stop):
        k = i - start
        energy[k] = 0.0
        if order >= 1:
            grad[k] = 0.0
        if order >= 2:
            hess[k] = 0.0
        theta = _angle(n, _normals(x, stencil[i], n))
        u = (math.pi - abs(theta)) / width
        if u >= 1.0:
            continue
        if u <= 0.0:
            energy[k] = math.inf
            continue
        y, rest = math.log(u), 1.0 - u
        energy[k] = -stiffness[i] * rest * rest * y
        if order < 1:
            continue
        moment = stiffness[i] * (rest * rest / u - 2.0 * rest * y) / math.copysign(width, theta)
        a, c, d = stencil[i, 0], stencil[i, 2], stencil[i, 3]
        length = math.sqrt(dot(n[0], n[0]))
        double1, double2 = math.sqrt(dot(n[1], n[1])), math.sqrt(dot(n[2], n[2]))
        foot1 = foot2 = 0.0
        for r in range(3):
            n[0, r] /= length
            n[1, r] /= double1
            n[2, r] /= double2
            foot1 += (x[c, r] - x[a, r]) * n[0, r] / length
            foot2 += (x[d, r] - x[a, r]) * n[0, r] / length
        for r in range(3):
            g[2, r] = -n[1, r] * length / double1
            g[3, r] = -n[2, r] * length / double2
            g[0, r] = -(1.0 - foot1) * g[2, r] - (1.0 - foot2) * g[3, r]
            g[1, r] = -foot1 * g[2, r] - foot2 * g[3, r]
        for p in range(4):
            for r in range(3):
                grad[k, p, r] = moment * g[p, r]
        if order < 2:
            continue
        second = stiffness[i] * (rest * (4.0 + rest / u) / u - 2.0 * y) / (width * width)
        outer_products(hess, k, second, g)
        if order == 3:
            continue
        along, n1, n2 = n[0], n[1], n[2]
        inward1, inward2 = cross(n1, along), cross(along, n2)
        add_angle_hessian(
            hess, k, -moment, 1.0 / length, length / double1, foot1, along, n1, inward1, 2
        )
        add_angle_hessian(
            hess, k, -moment, 1.0 / length, length / double2, foot2, along, n2, inward2, 3
        )
