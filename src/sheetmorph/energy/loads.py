"""Dead loads on the nodes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from sheetmorph.core.compiled import kernel
from sheetmorph.energy.term import Kernel
from sheetmorph.geometry.mesh import Floats, Ints, SheetMesh


@dataclass(frozen=True, eq=False)
class NodalLoad:
    """−f·(x − X) for every node: forces that keep their size and direction.

    Attributes:
        stencil: the loaded nodes, shape (n, 1).
        force: f at the full load [N], shape (n, 3).
        rest: reference positions X of these nodes [m], shape (n, 3).
        factor: fraction of the load that acts.
    """

    stencil: Ints
    force: Floats
    rest: Floats
    factor: float = 0.0

    name = "load"
    reference = (
        "Zhang, Alon, Jawed, section Model Parameters: small uniform load that fades to zero"
    )
    linear = True

    def at(self, ramp: float, load: float) -> Self:
        """The same forces at a fraction of the load."""
        return replace(self, factor=load)

    @classmethod
    def specimen(cls, mesh: SheetMesh, rng: np.random.Generator) -> Self:
        """Every node, with a random force."""
        nodes = np.arange(len(mesh.nodes), dtype=np.int32)[:, None]
        return cls(nodes, rng.standard_normal(mesh.nodes.shape), mesh.nodes)

    def local_kernel(self) -> Kernel:
        """Kernel and parameters; the Hessian is zero and is never asked for."""
        return _nodal_load, (self.stencil, self.force, self.rest, self.factor)


@dataclass(frozen=True, eq=False)
class AppliedLoad(NodalLoad):
    """The loads of a design: they grow with the actuation and stay."""

    name = "applied"
    reference = "dead loads, in proportion to the actuation"

    def at(self, ramp: float, load: float) -> Self:
        """The same forces at a fraction of the actuation."""
        return replace(self, factor=ramp)


@dataclass(frozen=True, eq=False)
class Weight(NodalLoad):
    """The weight of the sheet: it comes on before the actuation, and stays.

    Before the actuation it is there in proportion to the load, so that a path which begins
    with nothing lays the sheet down first.
    """

    name = "weight"
    reference = "dead load: density times thickness times area"

    def at(self, ramp: float, load: float) -> Self:
        """The whole weight once the actuation has begun, a fraction of it before."""
        return replace(self, factor=load if ramp == 0.0 else 1.0)


@kernel
def _nodal_load(x, stencil, force, rest, factor, start, stop, order, energy, gradient, hessian):  # type: ignore[no-untyped-def]
    for i in range(start, stop):
        k = i - start
        work = 0.0
        for c in range(3):
            f = factor * force[i, c]
            work += f * (x[stencil[i, 0], c] - rest[i, c])
            if order >= 1:
                gradient[k, 0, c] = -f
        energy[k] = -work
