"""Stiffness and mass of a stack of layers, and of the edges and hinges of a mesh.

Formulas: `docs/model.md` and Zhang, Alon, Jawed, *Emergent morphogenesis via planar fabrication
enabled by a reduced model of composites*, Eqs. for k_s, k_b and D_eff.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.design.sections import EVERYWHERE
from sheetmorph.geometry.mesh import Floats, SheetMesh

if TYPE_CHECKING:
    from sheetmorph.design.regions import Regions
    from sheetmorph.design.sections import Layer
    from sheetmorph.design.spec import Design


STRETCHING = np.sqrt(3.0) / 2.0
"""k_s over Σ Y h l0²."""
BENDING = 2.0 / np.sqrt(3.0)
"""k_b over D."""


@dataclass(frozen=True, eq=False)
class LayerStack:
    """Layers bonded face to face, from the bottom up; n layers.

    Attributes:
        thicknesses: [m], shape (n,).
        young_moduli: [Pa], shape (n,).
        poisson_ratios: shape (n,).
        densities: [kg/m³], shape (n,).
        active: layers that shrink or swell, shape (n,).
        eigenstrain_factors: of the free strain of each layer, 0 for inert ones, shape (n,).
    """

    thicknesses: Floats
    young_moduli: Floats
    poisson_ratios: Floats
    densities: Floats
    active: NDArray[np.bool_]
    eigenstrain_factors: Floats

    @classmethod
    def of(cls, layers: Sequence[Layer]) -> LayerStack:
        """The stack of these layers, in their order."""
        return cls(
            np.array([layer.thickness for layer in layers]),
            np.array([layer.young_modulus for layer in layers]),
            np.array([layer.poisson_ratio for layer in layers]),
            np.array([layer.density for layer in layers]),
            np.array([layer.role == "active" for layer in layers], dtype=np.bool_),
            np.array([layer.eigenstrain_factor * (layer.role == "active") for layer in layers]),
        )

    @property
    def thickness(self) -> float:
        """Thickness of the stack [m]."""
        return float(self.thicknesses.sum())

    @property
    def plate_moduli(self) -> Floats:
        """Y = Y0/(1 − ν²) of each layer [Pa], shape (n,)."""
        return np.asarray(self.young_moduli / (1.0 - self.poisson_ratios**2))

    @property
    def mid_heights(self) -> Floats:
        """Height of the middle of each layer above the bottom [m], shape (n,)."""
        return np.asarray(np.cumsum(self.thicknesses) - 0.5 * self.thicknesses)

    @property
    def neutral_height(self) -> float:
        """Height of the neutral plane of bending above the bottom, Σ Y h y / Σ Y h [m]."""
        weights = self.plate_moduli * self.thicknesses
        return float(weights @ self.mid_heights / weights.sum())

    @property
    def membrane_stiffness(self) -> float:
        """Σ Y h [N/m]."""
        return float(self.plate_moduli @ self.thicknesses)

    @property
    def flexural_rigidity(self) -> float:
        """D = Σ Y [h³/12 + h (y − ȳ)²] per unit width [N·m]."""
        offsets = self.mid_heights - self.neutral_height
        inertia = self.thicknesses**3 / 12.0 + self.thicknesses * offsets**2
        return float(self.plate_moduli @ inertia)

    @property
    def face(self) -> int:
        """Where the inert layers lie: 1 above the active ones, −1 below, 0 when they balance.

        Above is where the neutral height of the inert layers is above that of the active
        ones by more than a millionth of the thickness.
        """
        weights = self.plate_moduli * self.thicknesses
        inert, active = weights * ~self.active, weights * self.active
        if not (inert.any() and active.any()):
            return 0
        rise = inert @ self.mid_heights / inert.sum() - active @ self.mid_heights / active.sum()
        return 0 if abs(rise) <= 1e-6 * self.thickness else int(np.sign(rise))

    @property
    def areal_mass(self) -> float:
        """Mass per area [kg/m²]."""
        return float(self.densities @ self.thicknesses)

    def stretching_stiffness(self, mean_edge_length: float) -> float:
        """k_s = (√3/2) Σ Y h l0² [J] of an edge in a mesh of mean edge length l0 [m]."""
        return float(STRETCHING * self.membrane_stiffness * mean_edge_length**2)

    @property
    def bending_stiffness(self) -> float:
        """k_b = (2/√3) D of a hinge [J]."""
        return float(BENDING * self.flexural_rigidity)


def tapered_stiffness(thicknesses: Floats, plate_moduli: Floats) -> tuple[Floats, Floats]:
    """Σ Y h [N/m] and D [N·m] at N places where layers differ in thickness, shape (N,) each.

    Args:
        thicknesses: [m], shape (layers, N); zero where there is no such layer.
        plate_moduli: Y [Pa], shape (layers, N) or (layers, 1).
    """
    middles = np.cumsum(thicknesses, axis=0) - 0.5 * thicknesses
    weights = plate_moduli * thicknesses
    membrane = weights.sum(axis=0)
    offsets = middles - (weights * middles).sum(axis=0) / membrane
    return membrane, (weights * (thicknesses**2 / 12.0 + offsets**2)).sum(axis=0)


def tapered_slopes(thicknesses: Floats, plate_moduli: Floats) -> tuple[Floats, Floats]:
    """Derivatives of the D of `tapered_stiffness` by thicknesses [N] and by Y [m³].

    D = Σ Y h (h²/12 + (y − ȳ)²), in which ȳ makes it least. A thicker layer lifts those above it.

    Args:
        thicknesses: [m], shape (layers, N).
        plate_moduli: Y [Pa], shape (layers, N).

    Returns:
        Shape (layers, N) each.
    """
    middles = np.cumsum(thicknesses, axis=0) - 0.5 * thicknesses
    weights = plate_moduli * thicknesses
    offsets = middles - (weights * middles).sum(axis=0) / weights.sum(axis=0)
    inertia = thicknesses**2 / 12.0 + offsets**2
    moments = weights * offsets
    above = moments.sum(axis=0) - np.cumsum(moments, axis=0)
    lifted = moments + 2.0 * above
    return plate_moduli * (inertia + thicknesses**2 / 6.0) + lifted, thicknesses * inertia


@dataclass(frozen=True, eq=False)
class PublishedStiffness:
    """Stiffness of the published model on a mesh.

    Attributes:
        stretch_plain: factor·k_s of the region of each edge [J], shape (E,).
        stretch: K of each edge as the energy uses it [J], shape (E,): `stretch_plain`,
            times the edge's own length in metres when the design says
            "scaled_by_edge_length".
        bending: k_b of each hinge [J], shape (H,).
    """

    stretch_plain: Floats
    stretch: Floats
    bending: Floats


def film_stack(design: Design) -> LayerStack:
    """The layers outside the pattern: those everywhere."""
    return stack_of(design, ())


def stack_of(design: Design, parts: Collection[str]) -> LayerStack:
    """The layers where these parts of the pattern lie: theirs and those everywhere."""
    return LayerStack.of(
        [layer for layer in design.layers if layer.where == EVERYWHERE or layer.where in parts]
    )


def mean_edge_length(design: Design, mesh: SheetMesh) -> float:
    """l0 of the stiffness formulas [m]: as the design says, or else that of the mesh."""
    given = design.published.mean_edge_length
    return mesh.mean_edge_length if given is None else given


def force_scale(design: Design, mesh: SheetMesh, regions: Regions) -> float:
    """A moment that bends the stiffest part of the sheet by 1 rad, over an edge length [N].

    It is made of the largest flexural rigidity; in the published model, of the largest k_b.
    """
    if design.laminate:
        largest = max(cell.stack.flexural_rigidity for cell in regions.cells)
    else:
        stiffness = published_stiffness(design, mesh, regions)
        largest = float(stiffness.bending.max(initial=0.0))
    return largest / mesh.mean_edge_length


def published_stiffness(design: Design, mesh: SheetMesh, regions: Regions) -> PublishedStiffness:
    """Stiffness of edges and hinges by region; a hinge takes the region of its edge."""
    l0, options = mean_edge_length(design, mesh), design.published
    scaled = options.stretch_stiffness == "scaled_by_edge_length"
    if regions.smooth is None:
        stacks = [cell.stack for cell in regions.cells]
        stretching = np.array([stack.stretching_stiffness(l0) for stack in stacks])
        plain = options.stretch_factor * stretching[regions.edge_cell]
        bending = np.array([stack.bending_stiffness for stack in stacks])[regions.hinge_cell]
    else:
        whole = LayerStack.of(design.layers)
        shares = regions.smooth.layer_shares(design, regions.smooth.edges)
        thicknesses = shares * whole.thicknesses[:, None]
        membrane, rigidity = tapered_stiffness(thicknesses, whole.plate_moduli[:, None])
        plain = options.stretch_factor * STRETCHING * l0**2 * membrane
        bending = BENDING * rigidity[mesh.hinge_edges[:, 0]]
    return PublishedStiffness(plain, plain * mesh.edge_lengths if scaled else plain, bending)


def triangle_masses(mesh: SheetMesh, regions: Regions) -> Floats:
    """Masses of the triangles before actuation [kg], shape (T,)."""
    if regions.smooth is not None:
        return np.asarray(mesh.triangle_areas * regions.smooth.areal_masses)
    areal = np.array([cell.stack.areal_mass for cell in regions.cells])
    return np.asarray(mesh.triangle_areas * areal[regions.triangle_cell])


def total_mass(mesh: SheetMesh, regions: Regions) -> float:
    """Mass of the sheet [kg]."""
    return float(triangle_masses(mesh, regions).sum())
