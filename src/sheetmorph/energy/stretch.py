"""Stretching of the edges against their eigenstrain."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from sheetmorph.core.compiled import kernel
from sheetmorph.energy.term import Kernel
from sheetmorph.geometry.mesh import Floats, Ints, SheetMesh


@dataclass(frozen=True, eq=False)
class EdgeStretch:
    """½ K (e − t·eth)² for every edge, with the strain e = l/l0 − 1.

    Attributes:
        stencil: the two nodes of each edge, shape (n, 2).
        rest_length: l0 [m], shape (n,).
        stiffness: K [J], shape (n,).
        eigenstrain: eth at full actuation, shape (n,).
        ramp: fraction t of the actuation.
    """

    stencil: Ints
    rest_length: Floats
    stiffness: Floats
    eigenstrain: Floats
    ramp: float = 0.0

    name = "stretch"
    reference = (
        "Zhang, Alon, Jawed, Emergent morphogenesis via planar fabrication, eq. (bilayer_energy), "
        "first sum"
    )
    linear = False

    def at(self, ramp: float, load: float) -> EdgeStretch:
        """The same edges at a fraction of the actuation."""
        return replace(self, ramp=ramp)

    @classmethod
    def specimen(cls, mesh: SheetMesh, rng: np.random.Generator) -> EdgeStretch:
        """Every edge, with random stiffness and eigenstrain."""
        count = len(mesh.edges)
        return cls(
            mesh.edges,
            mesh.edge_lengths,
            rng.uniform(0.1, 1.0, count),
            rng.uniform(-0.7, 0.2, count),
        )

    def local_kernel(self) -> Kernel:
        """Kernel and parameters; see `sheetmorph.energy.term.Term.local_kernel`."""
        parameters = (self.rest_length, self.stiffness, self.eigenstrain, self.ramp)
        return _edge_stretch, (self.stencil, *parameters)


@kernel
def _edge_stretch(  # type: ignore[no-untyped-def]
    x, stencil, rest_length, stiffness, eigenstrain, ramp, start, stop, order, energy, grad, hess
):
    """K/2 (e − t eth)²; ∇e = ±u/l0; ∇²e = (I − uuᵀ)/(l0 l), which is not zero at e = 0."""
    u = np.empty(3)
    for i in range(start, stop):
        k = i - start
        a, b = stencil[i, 0], stencil[i, 1]
        for c in range(3):
            u[c] = x[b, c] - x[a, c]
        length = math.sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2])
        l0 = rest_length[i]
        mismatch = (length - l0) / l0 - ramp * eigenstrain[i]
        energy[k] = 0.5 * stiffness[i] * mismatch * mismatch
        if order < 1:
            continue
        force = stiffness[i] * mismatch / l0
        inverse = 1.0 / length
        for c in range(3):
            u[c] *= inverse
            grad[k, 0, c] = -force * u[c]
            grad[k, 1, c] = force * u[c]
        if order < 2:
            continue
        across = force * inverse
        if order == 3 and across < 0.0:
            across = 0.0  # an edge in compression; without it the block is K uuᵀ/l0²
        along = stiffness[i] / (l0 * l0) - across
        for r in range(3):
            for c in range(3):
                value = along * u[r] * u[c]
                if r == c:
                    value += across
                hess[k, 0, r, c] = value
                hess[k, 1, r, c] = -value
                hess[k, 2, r, c] = value
