"""What a simulation returns: every state, its fields, and how it was computed."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sheetmorph.geometry.mesh import Floats, SheetMesh

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design

Bools = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Result:
    """States of a sheet from flat to actuated, with S states, V nodes, E edges, H hinges.

    Attributes:
        design: the design that was simulated.
        mesh: its reference mesh.
        positions: node positions of every state [m], shape (S, V, 3); state 0 is flat.
        ramp: fraction of the actuation at every state, shape (S,), 0 to 1.
        load: fraction of the perturbation load at every state, shape (S,).
        thermal_strain_full: eigenstrain of the edges at full actuation, shape (E,).
        edge_in_pattern: edges whose midpoint lies in the pattern, shape (E,).
        triangle_in_pattern: triangles whose centroid lies in the pattern, shape (T,).
        stretch_stiffness: K of every edge [J], shape (E,).
        bending_stiffness: k_b of every hinge [J], shape (H,).
        held_nodes: indices of the nodes that supports hold, shape (N,).
        summary: the numbers of `summary.json`.
    """

    design: Design
    mesh: SheetMesh
    positions: Floats
    ramp: Floats
    load: Floats
    thermal_strain_full: Floats
    edge_in_pattern: Bools
    triangle_in_pattern: Bools
    stretch_stiffness: Floats
    bending_stiffness: Floats
    held_nodes: NDArray[np.intp]
    summary: dict[str, Any] = field(default_factory=dict)

    @property
    def status(self) -> str:
        """How the run ended, such as "completed"; see `sheetmorph.solve.path.Status`."""
        return str(self.summary["status"])

    @cached_property
    def actuation(self) -> Floats:
        """Free shrinkage eps_pre reached at every state, shape (S,)."""
        return np.asarray(self.ramp * self.summary["eps_pre"])

    @cached_property
    def strain(self) -> Floats:
        """Edge strain l/l0 − 1, shape (S, E)."""
        raise NotImplementedError

    @cached_property
    def dihedral(self) -> Floats:
        """Signed dihedral angle of the hinges [rad], shape (S, H)."""
        raise NotImplementedError

    @cached_property
    def thermal_strain(self) -> Floats:
        """Eigenstrain of the edges, shape (S, E)."""
        return np.asarray(self.ramp[:, None] * self.thermal_strain_full)

    @cached_property
    def height(self) -> Floats:
        """Height z of the nodes above the reference plane [m], shape (S, V)."""
        return np.asarray(self.positions[:, :, 2])

    @cached_property
    def stretch_energy_density(self) -> Floats:
        """Stretching energy of the edges per area of the sheet [J/m²], shape (S, E)."""
        raise NotImplementedError

    @cached_property
    def bend_energy_density(self) -> Floats:
        """Bending energy of the hinges per area of the sheet [J/m²], shape (S, H)."""
        raise NotImplementedError

    @cached_property
    def mean_curvature(self) -> Floats:
        """Mean curvature at the nodes [1/m], shape (S, V)."""
        raise NotImplementedError

    @cached_property
    def gaussian_curvature(self) -> Floats:
        """Gaussian curvature at the nodes [1/m²], shape (S, V); zero on the rim."""
        raise NotImplementedError

    @cached_property
    def aspect_ratio(self) -> Floats:
        """h/d of every state, shape (S,): height over in-plane width."""
        raise NotImplementedError
