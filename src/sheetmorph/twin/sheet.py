"""What a finite-element program must be told of a design: layers in space, strains, loads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.design.actuation import triangle_eigenstrain
from sheetmorph.design.loads import load_forces
from sheetmorph.design.regions import Regions, regions
from sheetmorph.design.sections import EVERYWHERE, Layer
from sheetmorph.design.spec import Design
from sheetmorph.design.supports import directed_edges, held_components, perturbation_forces
from sheetmorph.geometry.mesh import Floats, Ints, SheetMesh
from sheetmorph.solve.constraints import rigid_motion_pins

SAME = 1e-9
"""Heights that differ by less than this share of the size are one."""


@dataclass(frozen=True)
class Slab:
    """One layer where it lies.

    Attributes:
        layer: index in the layers of the design.
        bottom: height of its lower face above the reference plane [m].
        top: height of its upper face [m].
    """

    layer: int
    bottom: float
    top: float

    @property
    def middle(self) -> float:
        """Height of its middle [m]."""
        return 0.5 * (self.bottom + self.top)


@dataclass(frozen=True, eq=False)
class Sheet:
    """A design made ready for a finite-element program.

    The reference plane z = 0 is the middle of the layers that lie everywhere.

    Attributes:
        name: of the design.
        mesh: the plan.
        layers: of the design, from the bottom up.
        slabs: of each cell of the plan, from the bottom up.
        triangle_cell: cell of each triangle, shape (T,).
        eigenstrain: e11, e22, e12 of an active layer of factor 1 at full actuation, shape (T, 3).
        thickening: layers that shrink keep their volume.
        held: degrees of freedom of the reference plane that keep their value, shape (V, 3).
        free: nothing is held but the six rigid motions.
        clamped: edges of the rim whose surface normal keeps its direction, shape (K,).
        clamped_axis: axis along which nothing above or below them moves, shape (K,).
        forces: the perturbation on the nodes of the reference plane [N], shape (V, 3).
        applied: the loads that grow with the actuation [N], shape (V, 3).
        fading_steps: number of equal steps in which it is removed.
    """

    name: str
    mesh: SheetMesh
    layers: tuple[Layer, ...]
    slabs: tuple[tuple[Slab, ...], ...]
    triangle_cell: NDArray[np.intp]
    eigenstrain: Floats
    thickening: bool
    held: NDArray[np.bool_]
    free: bool
    clamped: Ints
    clamped_axis: NDArray[np.intp]
    forces: Floats
    applied: Floats
    fading_steps: int

    @classmethod
    def of(cls, design: Design) -> Sheet:
        """Mesh a design and lay its layers out in space.

        Raises:
            InputError: the design and its mesh do not fit together, its pattern is smeared, or a
                layer of the pattern lies between two that lie everywhere, which no flat body
                shows.
        """
        if design.spec.mesh.pattern_smoothing is not None:
            raise InputError(
                "the finite-element twin has no layers that taper off; leave it out for the twin",
                key="mesh.pattern_smoothing",
            )
        mesh = design.build_mesh()
        if np.abs(mesh.nodes[:, 2]).max() > SAME * mesh.size:
            raise InputError("the sheet is not flat; its finite-element twin must be", key="mesh")
        region = regions(design, mesh)
        held = held_components(design, mesh, region)
        free = not held.any()
        return cls(
            design.name,
            mesh,
            design.layers,
            slabs_of(design, region),
            region.triangle_cell,
            triangle_eigenstrain(design, mesh, region),
            design.spec.laminate.thickening == "volume_conserved",
            rigid_motion_pins(mesh.nodes).reshape(-1, 3) if free else held,
            free,
            *_clamped(design, mesh, region, held),
            perturbation_forces(design, mesh),
            load_forces(design, mesh, region),
            design.perturbation.ramp_down_steps,
        )

    @property
    def factors(self) -> Floats:
        """Factor on the eigenstrain of each layer, 0 for inert ones, shape (n,)."""
        return np.array(
            [layer.eigenstrain_factor * (layer.role == "active") for layer in self.layers]
        )


def _clamped(
    design: Design, mesh: SheetMesh, region: Regions, held: NDArray[np.bool_]
) -> tuple[Ints, NDArray[np.intp]]:
    """Edges that keep the direction of their normal, and the axis across each.

    Raises:
        InputError: one that does not run along x or y, or whose nodes move across it.
    """
    edges, conormals = directed_edges(design, mesh, region)
    axes = np.abs(conormals).argmax(axis=1)
    across = np.abs(conormals).max(axis=1, initial=0.0) > 1.0 - SAME
    if not (across & held[mesh.edges[edges], axes[:, None]].all(axis=1)).all():
        raise InputError(
            "the finite-element twin clamps edges that run along x or y alone, and whose nodes "
            "are held across them",
            key="supports",
        )
    return edges, axes


def slabs_of(design: Design, region: Regions) -> tuple[tuple[Slab, ...], ...]:
    """The layers of each cell of a plan, in space.

    Raises:
        InputError: a layer of the pattern lies between two that lie everywhere.
    """
    whole = [index for index, layer in enumerate(design.layers) if layer.where == EVERYWHERE]
    for index in range(whole[0], whole[-1]):
        if design.layers[index].where != EVERYWHERE:
            raise InputError(
                "a layer of the pattern between two that lie everywhere lifts the upper one off "
                "its place; the finite-element twin cannot lay them out",
                key=f"layers[{index}]",
                value=design.layers[index].name,
            )
    lowest = -0.5 * sum(design.layers[index].thickness for index in whole)
    found = []
    for cell in region.cells:
        here = [
            index
            for index, layer in enumerate(design.layers)
            if layer.where == EVERYWHERE or layer.where in cell.parts
        ]
        below = sum(design.layers[index].thickness for index in here if index < whole[0])
        heights = np.cumsum([lowest - below, *(design.layers[index].thickness for index in here)])
        found.append(
            tuple(
                Slab(index, float(low), float(high))
                for index, low, high in zip(here, heights, heights[1:], strict=False)
            )
        )
    return tuple(found)
