"""From a design to the problem that the solver works on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sheetmorph.design.actuation import thermal_strain
from sheetmorph.design.laminate import PublishedStiffness, published_stiffness
from sheetmorph.design.meshing import hinge_coupling
from sheetmorph.design.regions import Regions, regions
from sheetmorph.design.spec import Design
from sheetmorph.design.supports import held_nodes, perturbation_forces
from sheetmorph.energy.hinge import CoupledHinge
from sheetmorph.energy.loads import NodalLoad
from sheetmorph.energy.stretch import EdgeStretch
from sheetmorph.energy.total import Total
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.solve.constraints import rigid_motion_pins

SIGNS = np.array([1.0, -1.0, 1.0, -1.0])
"""Signs of the strains of ac, ad, bc, bd in the mismatch of a hinge."""

RESIDUAL_FLOOR = 1e-13
"""Rounding of the residual, as a fraction of the largest force a stretched edge can exert."""


@dataclass(frozen=True, eq=False)
class Problem:
    """A design made ready to solve.

    Attributes:
        design: the design.
        mesh: its reference mesh, hinges oriented.
        regions: what lies in the pattern.
        stiffness: of edges and hinges.
        thermal_strain: eigenstrain of the edges at full actuation, shape (E,).
        coupling: natural dihedral angle per strain mismatch of the hinges, shape (H,).
        held_nodes: nodes that the supports hold, shape (N,); empty for a free sheet.
        held_dofs: True at the degrees of freedom that keep their value, shape (3 V,).
        total: the energy.
        force_scale: a moment of one stiffest hinge bent by 1 rad, over a mean edge length
            [N]: the measure of what residual force is small.
    """

    design: Design
    mesh: SheetMesh
    regions: Regions
    stiffness: PublishedStiffness
    thermal_strain: Floats
    coupling: Floats
    held_nodes: NDArray[np.intp]
    held_dofs: NDArray[np.bool_]
    total: Total
    force_scale: float

    @property
    def residual_tolerance(self) -> float:
        """Largest residual force that counts as equilibrium [N]."""
        stretch = float((self.stiffness.stretch / self.mesh.edge_lengths).max())
        asked = self.design.solver.tolerance * self.force_scale
        return max(asked, RESIDUAL_FLOOR * stretch)


def build_problem(design: Design) -> Problem:
    """Mesh the design and set up its energy.

    Raises:
        InputError: the mesh, the supports or the actuation do not fit together.
    """
    mesh = design.build_mesh()
    region = regions(design, mesh)
    stiffness = published_stiffness(design, mesh, region)
    eigenstrain = thermal_strain(design, mesh, region)
    coupling = hinge_coupling(design, mesh, region)
    held = held_nodes(design, mesh, region)
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
        NodalLoad(
            np.arange(len(mesh.nodes), dtype=np.int32)[:, None],
            perturbation_forces(design, mesh),
            mesh.nodes,
        ),
    )
    return Problem(
        design=design,
        mesh=mesh,
        regions=region,
        stiffness=stiffness,
        thermal_strain=eigenstrain,
        coupling=coupling,
        held_nodes=held,
        held_dofs=_held_dofs(mesh, held),
        total=Total.of(terms, len(mesh.nodes)),
        force_scale=float(stiffness.bending.max(initial=0.0)) / mesh.mean_edge_length,
    )


def _held_dofs(mesh: SheetMesh, nodes: NDArray[np.intp]) -> NDArray[np.bool_]:
    if not len(nodes):
        return rigid_motion_pins(mesh.nodes)
    held = np.zeros((len(mesh.nodes), 3), dtype=bool)
    held[nodes] = True
    return held.ravel()
