"""From a design to the problem that the solver works on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sheetmorph.design.actuation import thermal_strain
from sheetmorph.design.loads import load_forces
from sheetmorph.design.regions import Regions, regions
from sheetmorph.design.spec import Design
from sheetmorph.design.supports import held_components, perturbation_forces
from sheetmorph.energy.fold import FoldGuard
from sheetmorph.energy.guard import TriangleGuard
from sheetmorph.energy.loads import AppliedLoad, NodalLoad
from sheetmorph.energy.total import Total
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.solve.constraints import level_motion_pins, rigid_motion_pins
from sheetmorph.study.laminate_model import laminate_parts
from sheetmorph.study.parts import ModelParts
from sheetmorph.study.published_model import published_parts
from sheetmorph.study.surroundings import Surroundings, surroundings_of

RESIDUAL_FLOOR = 1e-13
"""Rounding of the residual, as a fraction of the largest force a stretched edge can exert."""


@dataclass(frozen=True, eq=False)
class Problem:
    """A design made ready to solve.

    Attributes:
        design: the design.
        mesh: its reference mesh, hinges oriented.
        regions: what lies in the pattern.
        model: the internal energy of the design's model.
        thermal_strain: eigenstrain of the edges at full actuation, shape (E,).
        held_nodes: nodes of which the supports hold a coordinate, shape (N,); empty for a free
            sheet.
        surroundings: weight and contact.
        held_dofs: True at the degrees of freedom that keep their value, shape (n,).
        total: the energy, of the n degrees of freedom: coordinates, then scalar unknowns.
    """

    design: Design
    mesh: SheetMesh
    regions: Regions
    model: ModelParts
    thermal_strain: Floats
    held_nodes: NDArray[np.intp]
    surroundings: Surroundings
    held_dofs: NDArray[np.bool_]
    total: Total

    @property
    def start(self) -> Floats:
        """The degrees of freedom of the sheet before actuation, shape (n,)."""
        return np.concatenate([self.mesh.nodes.ravel(), np.zeros(len(self.model.held_scalars))])

    @property
    def floats(self) -> bool:
        """True where nothing hinders the six rigid motions of the sheet: no support, no table."""
        return not len(self.held_nodes) and self.surroundings.table is None

    @property
    def residual_tolerance(self) -> float:
        """Largest residual force that counts as equilibrium [N]."""
        asked = self.design.solver.tolerance * self.model.force_scale
        return max(asked, RESIDUAL_FLOOR * self.model.stretch_force)

    def held_open(self, positions: Floats) -> dict[str, int]:
        """What guards keep from happening in a shape, and in how many places; none is empty."""
        guards = [one for one in self.model.terms if isinstance(one, TriangleGuard | FoldGuard)]
        places = {guard.keeps: len(guard.held_open(positions)) for guard in guards}
        return {what: count for what, count in places.items() if count}

    def positions(self, x: Floats) -> Floats:
        """Node positions among the degrees of freedom [m], shape (V, 3)."""
        return x[: self.mesh.nodes.size].reshape(-1, 3)


def build_problem(
    design: Design, mesh: SheetMesh | None = None, region: Regions | None = None
) -> Problem:
    """Mesh the design and set up its energy.

    Args:
        design: the design.
        mesh: reference mesh to take in the place of the design's own.
        region: what lies where on this mesh, if it is known.

    Raises:
        InputError: the mesh, the supports or the actuation do not fit together.
    """
    mesh = design.build_mesh() if mesh is None else mesh
    region = regions(design, mesh) if region is None else region
    eigenstrain = thermal_strain(design, mesh, region)
    model = (
        laminate_parts(design, mesh, region)
        if design.laminate
        else published_parts(design, mesh, region, eigenstrain)
    )
    held = held_components(design, mesh, region)
    nodes = np.arange(len(mesh.nodes), dtype=np.int32)[:, None]
    terms = [*model.terms, NodalLoad(nodes, perturbation_forces(design, mesh), mesh.nodes)]
    if design.loads:
        terms.append(AppliedLoad(nodes, load_forces(design, mesh, region), mesh.nodes))
    around = surroundings_of(design, mesh, region, eigenstrain, model.force_scale)
    terms += around.terms
    pins = rigid_motion_pins if around.table is None else level_motion_pins
    dofs = held.ravel() if held.any() else pins(mesh.nodes)
    return Problem(
        design=design,
        mesh=mesh,
        regions=region,
        model=model,
        thermal_strain=eigenstrain,
        held_nodes=np.flatnonzero(held.any(axis=1)),
        surroundings=around,
        held_dofs=np.concatenate([dofs, model.held_scalars]),
        total=Total.of(terms, len(mesh.nodes), len(model.held_scalars), around.contact),
    )
