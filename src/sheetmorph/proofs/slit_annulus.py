"""Sze's slit annular plate: one lip of the slit is clamped, the other lifted."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.geometry.structured import ring_sector
from sheetmorph.proofs.load_steps import SOURCE, Displacements, load_step_checks, load_step_plot
from sheetmorph.proofs.proof import Check, Proof, convergence_order
from sheetmorph.proofs.sheets import STEPS, benchmark_table, solved, states_at

INNER, OUTER = 6.0, 10.0
INNER_END, OUTER_END = "inner end", "outer end"

DESIGN = f"""
name = "slit annulus"
model = "laminate"
[outline]
kind = "disc"
radius = "{OUTER} m"
slits = [[["{INNER} m", "0 m"], ["{OUTER} m", "0 m"]]]
[[outline.cutouts]]
kind = "disc"
radius = "{INNER} m"
[[layers]]
name = "plate"
role = "inert"
thickness = "3 cm"
young_modulus = "21 MPa"
poisson_ratio = 0
[perturbation]
total_force = "0 N"
[[supports]]
kind = "nodes"
nodes = [0]
clamp = true
[[loads]]
kind = "line"
nodes = [0, 1]
force_per_length = ["0 N/m", "0 N/m", "0.8 N/m"]
[mesh]
size = "0.5 m"
{STEPS}"""

CELLS = (7, 10, 14)
"""Cells along the slit of the structured meshes; eight times as many go around."""


def prove(reference: Path | None = None) -> Proof:
    """Lift of both ends of the free lip at every load step.

    Raises:
        InputError: the published table is not there.
        ComputationError: a run did not reach its end.
    """
    table = benchmark_table("sze_slit_annular", reference)
    loads = np.array(table["P"])
    known = {INNER_END: np.array(table["W_13891"]), OUTER_END: np.array(table["W_17528"])}
    meshes = [ring_sector(INNER, OUTER, n, 8 * n, "alternating") for n in CELLS]
    structured = [_lift(mesh, loads) for mesh in meshes]
    irregular = Design.from_toml(DESIGN).build_mesh()
    found = {"structured": structured[-1], "irregular": _lift(irregular, loads)}
    checks = load_step_checks(loads, known, found, "lift of the")
    for end in known:
        steps = np.diff([lift[end][-1] for lift in structured])
        order = convergence_order([1.0 / n for n in CELLS[:2]], steps)
        what = f"order of convergence of the lift of the {end}, structured"
        checks.append(Check(f"order-{end.split()[0]}", what, 1.4, order, kind="at least"))
    return Proof(
        name="slit_annulus",
        title="Slit annular plate",
        statement=(
            f"A flat ring with radii of {INNER:g} and {OUTER:g} m, 3 cm thick, E = 21 MPa, ν = 0, "
            "is slit along a radius. One lip is clamped, the other lifted by 0.8 N/m. The lift of "
            f"the inner and of the outer end of the free lip is compared at {len(loads)} load "
            f"steps, on a structured mesh of {CELLS[-1]} × {8 * CELLS[-1]} cells with alternating "
            f"diagonals ({len(meshes[-1].nodes)} nodes) and on an irregular one with edges of "
            f"half a metre ({len(irregular.nodes)} nodes). The model is too stiff by one or "
            "two percent there, as flat triangles are when a surface bends that can hardly "
            "stretch; the order is that of the differences between three structured meshes, and "
            "still below two."
        ),
        source=SOURCE,
        checks=tuple(checks),
        plots=(
            load_step_plot(
                "slit-annulus",
                "Free lip of the slit annular plate",
                "lift [m]",
                loads,
                known,
                found,
            ),
        ),
    )


def _lift(mesh: SheetMesh, loads: Floats) -> Displacements:
    """How far the ends of the free lip are lifted."""
    held, free = _lips(mesh)
    design = Design.from_toml(
        DESIGN.replace("nodes = [0]", f"nodes = {held}").replace(
            "nodes = [0, 1]", f"nodes = {free}"
        )
    )
    stops = loads.tolist()
    result = solved(design, mesh, stops)
    height = result.positions[states_at(result, stops), :, 2]
    reach = mesh.nodes[free, 0]
    ends = {OUTER_END: free[int(reach.argmax())], INNER_END: free[int(reach.argmin())]}
    return {end: height[:, node] for end, node in ends.items()}


def _lips(mesh: SheetMesh) -> tuple[list[int], list[int]]:
    """Nodes on the lips of the slit along the x axis: where y > 0 is next to it, and y < 0."""
    x, y = mesh.nodes[:, 0], mesh.nodes[:, 1]
    on = np.flatnonzero((np.abs(y) < 1e-6 * OUTER) & (x > 0.0))
    above = np.unique(mesh.triangles[mesh.triangle_centroids[:, 1] > 0.0])
    return on[np.isin(on, above)].tolist(), on[~np.isin(on, above)].tolist()
