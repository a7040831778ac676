"""Derivatives by the fields of the published model, from the adjoint of a state."""

from __future__ import annotations

import numpy as np

from sheetmorph.design.laminate import (
    BENDING,
    LayerStack,
    tapered_slopes,
    tapered_stiffness,
)
from sheetmorph.energy.hinge import CoupledHinge
from sheetmorph.energy.stretch import EdgeStretch
from sheetmorph.geometry import surface
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.study.model import Problem
from sheetmorph.study.parameters import layer_presence
from sheetmorph.study.published_model import SIGNS

STEP = 1e-5


def published_fields(
    problem: Problem, x: Floats, adjoint: Floats, ramp: float
) -> dict[str, Floats]:
    """−λᵀ ∂g/∂p for eigenstrain, stiffness, coupling and rest length of edges and hinges.

    Args:
        problem: the problem.
        x: the state, shape (n,).
        adjoint: λ, shape (n,).
        ramp: actuation of the state.

    Returns:
        "eigenstrain", "stretch_stiffness", "rest_length" (E,), "bending_stiffness" and
        "coupling" (H,); all but the one that is named held fixed.
    """
    stretch, bend, *_ = problem.model.terms
    assert isinstance(stretch, EdgeStretch)  # noqa: S101  the order of published_parts
    assert isinstance(bend, CoupledHinge)  # noqa: S101
    mesh = problem.mesh
    here, along = problem.positions(x), problem.positions(adjoint)
    rest = mesh.edge_lengths
    strain = surface.edge_strain(here, mesh.edges, rest)
    ends, ways = here[mesh.edges], along[mesh.edges]
    sides = ends[:, 1] - ends[:, 0]
    lengths = np.linalg.norm(sides, axis=1)
    turn = ((ways[:, 1] - ways[:, 0]) * sides).sum(axis=1) / (lengths * rest)
    misfit = strain - ramp * stretch.eigenstrain
    around = mesh.hinge_edges[:, 1:]
    difference, moved = misfit[around] @ SIGNS, turn[around] @ SIGNS
    angle = surface.dihedral_angles(here, mesh.hinges) - bend.coupling * difference
    swing = _angle_change(here, along, mesh) - bend.coupling * moved
    by_mismatch = -bend.stiffness * bend.coupling
    eigen = ramp * stretch.stiffness * turn
    np.add.at(eigen, around, (ramp * by_mismatch * swing)[:, None] * SIGNS)
    # A strain e = l/l0 − 1 and its change both fall with l0: by (1 + e)/l0 and by turn/l0.
    by_length = stretch.stiffness * turn * (1.0 + strain + misfit) / rest
    pull = swing[:, None] * (1.0 + strain[around]) + angle[:, None] * turn[around]
    np.add.at(by_length, around, by_mismatch[:, None] * SIGNS * pull / rest[around])
    return {
        "eigenstrain": eigen,
        "stretch_stiffness": -misfit * turn,
        "bending_stiffness": -angle * swing,
        "coupling": bend.stiffness * (difference * swing + angle * moved),
        "rest_length": by_length,
    }


def _angle_change(here: Floats, along: Floats, mesh: SheetMesh) -> Floats:
    """Change of the dihedral angles along a motion, by a central difference, shape (H,)."""
    largest = float(np.abs(along).max())
    if largest == 0.0:
        return np.zeros(len(mesh.hinges))
    h = STEP * float(np.ptp(here)) / largest
    ahead, behind = (surface.dihedral_angles(here + s * along, mesh.hinges) for s in (h, -h))
    return np.asarray((ahead - behind) / (2.0 * h))


def layer_fields(problem: Problem, fields: dict[str, Floats]) -> dict[str, Floats]:
    """By thickness, modulus and Poisson's ratio of the layers at every edge, shape (L, E).

    They act through the stretching stiffness of the edge and the bending stiffness of its
    hinge. A layer that does not lie there has thickness 0 and a derivative all the same: what
    laying it down would do.
    """
    design, mesh = problem.design, problem.mesh
    whole = LayerStack.of(design.layers)
    shares = layer_presence(design, problem.regions, edges=True)
    thickness = shares * whole.thicknesses[:, None]
    young = np.broadcast_to(whole.young_moduli[:, None], shares.shape)
    poisson = np.broadcast_to(whole.poisson_ratios[:, None], shares.shape)
    moduli = young / (1.0 - poisson**2)
    membrane, _ = tapered_stiffness(thickness, moduli)
    by_membrane = fields["stretch_stiffness"] * problem.model.stretch_stiffness / membrane
    by_rigidity = np.zeros(len(mesh.edges))
    by_rigidity[mesh.hinge_edges[:, 0]] = BENDING * fields["bending_stiffness"]
    by_thickness, by_modulus = tapered_slopes(thickness, moduli)
    by_plate = by_membrane * thickness + by_rigidity * by_modulus
    return {
        "thickness": by_membrane * moduli + by_rigidity * by_thickness,
        "young_modulus": by_plate / (1.0 - poisson**2),
        "poisson_ratio": by_plate * 2.0 * poisson * moduli / (1.0 - poisson**2),
    }


def published_rest(problem: Problem, fields: dict[str, Floats]) -> Floats:
    """By the positions of the nodes before actuation, through the lengths of the edges, (V, 3).

    The stiffness of an edge goes with its own length where the design says so, and all of them
    with the square of the mean length unless the design gives that.
    """
    design, mesh = problem.design, problem.mesh
    by_length = fields["rest_length"].copy()
    works = fields["stretch_stiffness"] * problem.model.stretch_stiffness
    if design.published.stretch_stiffness == "scaled_by_edge_length":
        by_length += works / mesh.edge_lengths
    if design.published.mean_edge_length is None:
        by_length += 2.0 * works.sum() / mesh.edge_lengths.sum()
    ends = mesh.nodes[mesh.edges]
    pull = (by_length / mesh.edge_lengths)[:, None] * (ends[:, 1] - ends[:, 0])
    found = np.zeros_like(mesh.nodes)
    np.add.at(found, mesh.edges[:, 1], pull)
    np.add.at(found, mesh.edges[:, 0], -pull)
    return found
