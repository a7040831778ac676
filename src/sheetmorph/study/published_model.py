"""The energy of the published model for a design on its mesh."""

from __future__ import annotations

import numpy as np

from sheetmorph.design.laminate import force_scale, published_stiffness
from sheetmorph.design.meshing import hinge_coupling
from sheetmorph.design.regions import Regions
from sheetmorph.design.spec import Design
from sheetmorph.energy.fold import FoldGuard
from sheetmorph.energy.guard import TriangleGuard
from sheetmorph.energy.hinge import CoupledHinge
from sheetmorph.energy.stretch import EdgeStretch
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.study.parts import ModelParts

SIGNS = np.array([1.0, -1.0, 1.0, -1.0])
"""Signs of the strains of ac, ad, bc, bd in the mismatch of a hinge."""


def published_parts(
    design: Design, mesh: SheetMesh, region: Regions, eigenstrain: Floats
) -> ModelParts:
    """Edges and hinges of the published model."""
    stiffness = published_stiffness(design, mesh, region)
    coupling = hinge_coupling(design, mesh, region)
    around = mesh.hinge_edges[:, 1:]
    terms = (
        EdgeStretch(mesh.edges, mesh.edge_lengths, stiffness.stretch, eigenstrain),
        CoupledHinge(
            mesh.hinges,
            mesh.edge_lengths[around],
            stiffness.bending,
            coupling,
            eigenstrain[around] @ SIGNS,
        ),
        TriangleGuard.of(mesh, stiffness.stretch[mesh.triangle_edges].mean(axis=1)),
        FoldGuard.of(mesh, stiffness.bending),
    )
    return ModelParts(
        terms=terms,
        held_scalars=np.zeros(0, dtype=np.bool_),
        force_scale=force_scale(design, mesh, region),
        stretch_force=float((stiffness.stretch / mesh.edge_lengths).max()),
        stretch_stiffness=stiffness.stretch,
        bending_stiffness=stiffness.bending,
        coupling=coupling,
    )
