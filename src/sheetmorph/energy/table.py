"""A table below the sheet that no node passes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from sheetmorph.core.compiled import kernel
from sheetmorph.energy.term import Kernel, evaluate_elements
from sheetmorph.geometry.mesh import Floats, Ints, SheetMesh

HALFWAY = 0.5 + math.log(2.0)
"""Force of the barrier halfway through its range, over κ times the range."""

KEPT = 0.9
"""Part of its distance from the table by which a node may come down in one step."""


@dataclass(frozen=True, eq=False)
class TableContact:
    """b(s) = −κ (s − r)² ln(s/r) for every node closer than r, and infinite at s = 0.

    s is the height of a node above the plane `up`·x = `offset`. The barrier and its first two
    derivatives begin at zero at s = r, and it is convex, so that it cannot destabilise.

    Attributes:
        stencil: the nodes, shape (n, 1).
        up: unit normal of the table, towards the sheet, shape (3,).
        offset: of the plane along it that no node reaches [m].
        range: r [m].
        stiffness: κ [N/m].
    """

    stencil: Ints
    up: Floats
    offset: float
    range: float
    stiffness: float

    name = "table"
    reference = (
        "Li, Ferguson, Schneider, Langlois, Zorin, Panozzo, Jiang, Kaufman, Incremental "
        "potential contact, ACM Transactions on Graphics 39, 2020: the clamped log barrier"
    )
    linear = False

    def at(self, ramp: float, load: float) -> Self:
        """The same table."""
        return self

    @classmethod
    def specimen(cls, mesh: SheetMesh, rng: np.random.Generator) -> Self:
        """A tilted table below every node of the mesh, within reach of many."""
        up = np.array([0.1, -0.2, 1.0])
        up /= np.linalg.norm(up)
        nodes = np.arange(len(mesh.nodes), dtype=np.int32)[:, None]
        heights = mesh.nodes @ up
        reach = max(float(np.ptp(heights)), 0.1 * mesh.size)
        return cls(nodes, up, float(heights.min()) - 0.5 * reach, reach, rng.uniform(1.0, 2.0))

    @classmethod
    def of(cls, count: int, up: Floats, offset: float, reach: float, force: float) -> TableContact:
        """A table below the first `count` nodes that bears a force at half its range.

        Args:
            count: number of nodes.
            up: unit normal, shape (3,).
            offset: of the plane that no node reaches [m].
            reach: range of the barrier [m].
            force: on a node halfway through the range [N].
        """
        nodes = np.arange(count, dtype=np.int32)[:, None]
        return cls(nodes, up, offset, reach, force / (HALFWAY * reach))

    def heights(self, x: Floats) -> Floats:
        """s of the nodes [m], shape (n,); x has rows of three."""
        return np.asarray(x[self.stencil[:, 0]] @ self.up - self.offset)

    def forces(self, x: Floats) -> Floats:
        """Forces of the table on the nodes, along `up` [N], shape (n,)."""
        count = len(self.stencil)
        energy, gradient = np.zeros(count), np.zeros((count, 1, 3))
        hessian = np.zeros((0, 1, 3, 3))
        evaluate_elements(self.local_kernel(), x, (0, count), 1, energy, gradient, hessian)
        return np.asarray(-gradient[:, 0] @ self.up)

    def reach(self, x: Floats, step: Floats) -> float:
        """The part of a step, at most 1, that keeps every node above the table.

        Args:
            x: positions in rows of three, shape (≥ V, 3).
            step: their change, same shape.
        """
        fall = -(step[self.stencil[:, 0]] @ self.up)
        falling = fall > 0.0
        part = (KEPT * self.heights(x)[falling] / fall[falling]).min(initial=1.0)
        return float(max(part, 0.0))

    def local_kernel(self) -> Kernel:
        """Kernel and parameters; it is convex, so that its order 3 is its order 2."""
        return _table, (self.stencil, self.up, self.offset, self.range, self.stiffness)


@kernel
def _table(x, stencil, up, offset, r, k, start, stop, order, energy, gradient, hessian):  # type: ignore[no-untyped-def]
    for i in range(start, stop):
        e = i - start
        node = stencil[i, 0]
        s = up[0] * x[node, 0] + up[1] * x[node, 1] + up[2] * x[node, 2] - offset
        value = slope = curvature = 0.0
        if s <= 0.0:
            value = np.inf
        elif s < r:
            away, log = s - r, math.log(s / r)
            value = -k * away * away * log
            slope = -k * (2.0 * away * log + away * away / s)
            curvature = -k * (2.0 * log + 4.0 * away / s - away * away / (s * s))
        energy[e] = value
        if order < 1:
            continue
        for c in range(3):
            gradient[e, 0, c] = slope * up[c]
        if order < 2:
            continue
        for a in range(3):
            for c in range(3):
                hessian[e, 0, a, c] = curvature * up[a] * up[c]
