"""The arrays through which a design enters its energy, and how they move with a key."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sheetmorph.design.actuation import thermal_strain, triangle_eigenstrain
from sheetmorph.design.laminate import LayerStack, published_stiffness
from sheetmorph.design.loads import gravity_forces, load_forces
from sheetmorph.design.meshing import hinge_coupling
from sheetmorph.design.regions import Regions
from sheetmorph.design.sections import EVERYWHERE
from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats, SheetMesh

STIFFNESS = ("stretch_stiffness", "bending_stiffness")
LAYERS = ("thickness", "young_modulus", "poisson_ratio", "eigenstrain_factor")
FORCES = ("applied", "weight")

_MOVED_BY: dict[str, tuple[str, ...]] = {
    "actuation": ("eigenstrain",),
    "layers": (*STIFFNESS, *LAYERS, *FORCES),
    "published": (*STIFFNESS, "coupling"),
    "pattern": ("eigenstrain", *STIFFNESS, "coupling", "thickness", *FORCES),
    "loads": ("applied",),
    "gravity": ("weight",),
}
"""Which arrays a key can move, by the table in which it stands."""


def model_arrays(
    design: Design, mesh: SheetMesh, region: Regions, table: str
) -> Mapping[str, Floats]:
    """The arrays of a design that a key of the given table can move.

    Published model: "eigenstrain" (E,), "stretch_stiffness" (E,), "bending_stiffness" (H,),
    "coupling" (H,). Laminate model: "eigenstrain" (T, 3), and by layer and triangle
    "thickness", "young_modulus", "poisson_ratio", "eigenstrain_factor" (L, T). Both: "applied"
    and "weight", forces of loads and gravity on the nodes (V, 3).

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
    if design.laminate:
        if "thickness" in wanted:
            found |= layer_arrays(design, region)
    else:
        if "stretch_stiffness" in wanted:
            stiffness = published_stiffness(design, mesh, region)
            found["stretch_stiffness"] = stiffness.stretch
            found["bending_stiffness"] = stiffness.bending
        if "coupling" in wanted:
            found["coupling"] = hinge_coupling(design, mesh, region)
    if "applied" in wanted and design.loads:
        found["applied"] = load_forces(design, mesh, region)
    if "weight" in wanted and design.gravity is not None:
        found["weight"] = gravity_forces(design, mesh, region)
    return found


def layer_arrays(design: Design, region: Regions) -> dict[str, Floats]:
    """What the layers are on every triangle, shape (L, T) each; thickness 0 where one is not."""
    whole = LayerStack.of(design.layers)
    shares = layer_presence(design, region)
    ones = np.ones_like(shares)
    return {
        "thickness": shares * whole.thicknesses[:, None],
        "young_modulus": ones * whole.young_moduli[:, None],
        "poisson_ratio": ones * whole.poisson_ratios[:, None],
        "eigenstrain_factor": ones * whole.eigenstrain_factors[:, None],
    }


def layer_presence(design: Design, region: Regions) -> Floats:
    """By which each layer's thickness is multiplied on every triangle, 0 to 1, shape (L, T)."""
    if region.smooth is not None:
        return region.smooth.layer_shares(design, region.smooth.triangles)
    rows = [
        [layer.where == EVERYWHERE or layer.where in cell.parts for cell in region.cells]
        for layer in design.layers
    ]
    return np.array(rows, dtype=np.float64)[:, region.triangle_cell]
