"""The arrays through which a design enters its energy, and how they move with a key."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sheetmorph.design.actuation import thermal_strain, triangle_eigenstrain
from sheetmorph.design.laminate import published_stiffness
from sheetmorph.design.loads import gravity_forces, load_forces
from sheetmorph.design.meshing import hinge_coupling
from sheetmorph.design.regions import Regions
from sheetmorph.design.sections import EVERYWHERE
from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats, SheetMesh

_MOVED_BY: dict[str, tuple[str, ...]] = {
    "actuation": ("eigenstrain",),
    "published": ("stretch_stiffness", "bending_stiffness", "coupling"),
    "loads": ("applied",),
    "gravity": ("weight",),
}
"""Which arrays a key can move, by its table; layers and pattern have chains of their own."""


def model_arrays(
    design: Design, mesh: SheetMesh, region: Regions, table: str
) -> Mapping[str, Floats]:
    """The arrays of a design that a key of the given table can move.

    Published model: "eigenstrain" (E,), "stretch_stiffness" (E,), "bending_stiffness" (H,),
    "coupling" (H,). Laminate model: "eigenstrain" (T, 3). Both: "applied" and "weight", forces of
    loads and gravity on the nodes (V, 3).

    Args:
        design: the design.
        mesh: its mesh.
        region: what lies where, which is not looked up anew.
        table: name of the key's table.
    """
    wanted = _MOVED_BY.get(table, ())
    found: dict[str, Floats] = {}
    if "eigenstrain" in wanted:
        strains = triangle_eigenstrain if design.laminate else thermal_strain
        found["eigenstrain"] = strains(design, mesh, region)
    if "coupling" in wanted and not design.laminate:
        stiffness = published_stiffness(design, mesh, region)
        found["stretch_stiffness"] = stiffness.stretch
        found["bending_stiffness"] = stiffness.bending
        found["coupling"] = hinge_coupling(design, mesh, region)
    if "applied" in wanted and design.loads:
        found["applied"] = load_forces(design, mesh, region)
    if "weight" in wanted and design.gravity is not None:
        found["weight"] = gravity_forces(design, mesh, region)
    return found


def layer_presence(design: Design, region: Regions, *, edges: bool = False) -> Floats:
    """By which each layer's thickness is multiplied on every triangle, 0 to 1, shape (L, T).

    Args:
        design: the design.
        region: what lies where.
        edges: at every edge instead, shape (L, E).
    """
    if region.smooth is not None:
        cover = region.smooth.edges if edges else region.smooth.triangles
        return region.smooth.layer_shares(design, cover)
    rows = [
        [layer.where == EVERYWHERE or layer.where in cell.parts for cell in region.cells]
        for layer in design.layers
    ]
    places = region.edge_cell if edges else region.triangle_cell
    return np.array(rows, dtype=np.float64)[:, places]
