"""Stretching and bending of layered triangles: constant strain and a mid-edge second form."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sheetmorph.energy.laminate_kernel import laminate_local
from sheetmorph.energy.laminate_patch import Patch
from sheetmorph.energy.lamination import Lamination, Rest
from sheetmorph.energy.term import Kernel
from sheetmorph.geometry.mesh import Ints, SheetMesh


@dataclass(frozen=True, eq=False)
class LaminateShell:
    """The energy of a stack of layers, integrated through the thickness, for every triangle.

    W = ½ (p − p̄)ᵀ M (p − p̄) + w of the six shape measures p of a triangle: the squared
    lengths l_i² of its sides, which are its first fundamental form a, and β_i = 2 h_i α_i,
    which are its second, b = −Σ β_i ∇λ_i ⊗ ∇λ_i. h_i is the altitude upon side i, and α_i the
    angle by which the surface normal at the middle of the side leans out of the triangle. This
    director is an unknown of its own, common to both triangles of an edge; it makes b converge on
    any mesh, as Morley's triangle does for plates.

    Attributes:
        patch: nodes, unknowns and sides of the triangles.
        lamination: the layers; gives M, p̄ and w at any actuation.
        rest: M, p̄ and w at the current actuation.
    """

    patch: Patch
    lamination: Lamination
    rest: Rest

    name = "laminate"
    reference = (
        "classical lamination theory with eigenstrains; Chen, Sastry, van Rees, Vouga, Physical "
        "simulation of environmentally induced thin shell deformation, 2018; mid-edge directors: "
        "Grinspun, Gingold, Reisman, Zorin, Computing discrete shape operators on general meshes, "
        "2006; Morley, The constant-moment plate-bending element, 1971"
    )
    linear = False
    linear_in_ramp = False

    @classmethod
    def of(cls, patch: Patch, lamination: Lamination) -> LaminateShell:
        """The shell at zero actuation."""
        return cls(patch, lamination, lamination.rest_at(0.0))

    @property
    def stencil(self) -> Ints:
        """Corners of each triangle and the nodes opposite its sides, shape (T, 6)."""
        return self.patch.stencil

    @property
    def scalars(self) -> Ints:
        """Degrees of freedom of the directors of the three sides, shape (T, 3)."""
        return self.patch.directors

    def at(self, ramp: float, load: float) -> LaminateShell:
        """The same triangles at a fraction of the actuation."""
        if ramp == self.rest.ramp:
            return self
        return replace(self, rest=self.lamination.rest_at(ramp))

    @classmethod
    def specimen(cls, mesh: SheetMesh, rng: np.random.Generator) -> LaminateShell:
        """Every triangle, with two random layers, random eigenstrains and bent at rest."""
        patch = Patch.of(mesh, director_length=mesh.mean_edge_length)
        return cls.of(patch, Lamination.specimen(mesh, patch, rng))

    def local_kernel(self) -> Kernel:
        """Kernel and parameters; see `sheetmorph.energy.term.Term.local_kernel`."""
        patch, rest = self.patch, self.rest
        sides = (patch.directors, patch.share, patch.turn, patch.lean, patch.flap)
        return laminate_local, (patch.stencil, *sides, rest.stiffness, rest.natural, rest.floor)
