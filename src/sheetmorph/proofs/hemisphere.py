"""Sze's hemisphere with a hole of 18°, pulled and pressed at four points of its rim."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from sheetmorph.design.spec import Design
from sheetmorph.geometry.generate import generate_mesh
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.geometry.structured import sphere_sector
from sheetmorph.geometry.topology import build_mesh
from sheetmorph.proofs.load_steps import SOURCE, Displacements, load_step_checks, load_step_plot
from sheetmorph.proofs.proof import Check, Proof, convergence_order
from sheetmorph.proofs.sheets import PLANES, STEPS, benchmark_table, nearest_node, solved, states_at

RADIUS = 10.0
HOLE, EQUATOR = math.radians(18.0), 0.5 * math.pi
PULLED, PRESSED = "pulled point", "pressed point"
FORCE = 200.0  # on a quarter of the shell: half of the forces, which act in its planes

DESIGN = f"""
name = "hemisphere"
model = "laminate"
[outline] # seen from above
kind = "disc"
radius = "{RADIUS} m"
[[layers]]
name = "shell"
role = "inert"
thickness = "4 cm"
young_modulus = "68.25 MPa"
poisson_ratio = 0.3
[perturbation]
total_force = "0 N"
{PLANES}[[supports]]
kind = "box"
x = ["9.999 m", "10.001 m"]
y = ["-1 mm", "1 mm"]
hold = ["z"]
[[loads]]
kind = "point"
at = ["0 m", "10 m", "0 m"]
force = ["0 N", "{FORCE} N", "0 N"]
[[loads]]
kind = "point"
at = ["10 m", "0 m", "0 m"]
force = ["-{FORCE} N", "0 N", "0 N"]
[mesh]
size = "1 m"
{STEPS}"""

CELLS = (28, 40, 56)
"""Cells along each side of the structured meshes."""
COMPARED = 40
"""Those of the mesh that is compared at every load step."""
HALF = 0.5
"""Load at which the order of convergence is taken, over the full load."""
SPACING = 0.06
"""Length of the edges of the irregular mesh in the plane of polar angle and azimuth [rad]."""


def prove(reference: Path | None = None) -> Proof:
    """Displacements of the loaded points at every load step.

    Raises:
        InputError: the published table is not there.
        ComputationError: a run did not reach its end.
    """
    table = benchmark_table("sze_hemisphere_18deg_hole", reference)
    loads = np.array(table["P"])
    known = {PULLED: np.array(table["VA"]), PRESSED: np.array(table["minusUB"])}
    meshes = {"structured": _structured(COMPARED), "irregular": _irregular()}
    found = {family: _moves(mesh, loads) for family, mesh in meshes.items()}
    checks = load_step_checks(loads, known, found, "displacement of the", ".2f")
    at = int(np.flatnonzero(np.isclose(loads, HALF))[0])
    halves = [
        found["structured"][PRESSED][at]
        if cells == COMPARED
        else _moves(_structured(cells), np.ones(1), HALF)[PRESSED][0]
        for cells in CELLS
    ]
    order = convergence_order([1.0 / n for n in CELLS[:2]], np.diff(halves))
    what = f"order of convergence of the pressed point at P = {HALF} Pmax, structured"
    checks.append(Check("order", what, 1.5, order, kind="at least"))
    return Proof(
        name="hemisphere",
        title="Hemisphere with a hole",
        statement=(
            f"A hemisphere of {RADIUS:g} m radius with a hole of 18° at its pole, 4 cm thick, "
            "E = 68.25 MPa, ν = 0.3, is pulled outward at two opposite points of its equator and "
            "pressed inward at the two between them, with up to 400 N each. A quarter with two "
            "planes of symmetry is computed; its curvature at rest is taken from the mesh. The "
            f"displacement of both points is compared at {len(loads)} load steps, on a structured "
            f"mesh of {COMPARED} × {COMPARED} cells with alternating diagonals "
            f"({len(meshes['structured'].nodes)} nodes) and on an irregular one "
            f"({len(meshes['irregular'].nodes)} nodes). The shell hardly stretches, and coarse "
            "flat triangles err both ways: softer by their facets, stiffer as they cannot bend "
            "without stretching. The order is that of the differences between meshes of "
            f"{', '.join(map(str, CELLS))} cells a side; on coarser ones the two errors cancel in "
            "part."
        ),
        source=SOURCE,
        checks=tuple(checks),
        plots=(
            load_step_plot(
                "hemisphere",
                "Loaded points of the hemisphere",
                "displacement [m]",
                loads,
                known,
                found,
            ),
        ),
    )


def _moves(mesh: SheetMesh, loads: Floats, share: float = 1.0) -> Displacements:
    """Outward and inward displacement of the loaded points at fractions of a share of the load."""
    text = DESIGN.replace(f"{FORCE} N", f"{share * FORCE} N")
    stops = loads.tolist()
    result = solved(Design.from_toml(text), mesh, stops)
    moved = result.positions[states_at(result, stops)] - mesh.nodes
    pulled, pressed = (nearest_node(mesh, place) for place in ((0, RADIUS, 0), (RADIUS, 0, 0)))
    return {PULLED: moved[:, pulled, 1], PRESSED: -moved[:, pressed, 0]}


def _structured(cells: int) -> SheetMesh:
    return sphere_sector(RADIUS, (HOLE, EQUATOR), (0.0, EQUATOR), cells, cells, "alternating")


def _irregular() -> SheetMesh:
    """An irregular mesh of the rectangle of polar angle and azimuth, laid upon the sphere."""
    import shapely

    flat = generate_mesh(shapely.box(HOLE, 0.0, EQUATOR, EQUATOR), [], SPACING)
    polar, azimuth = flat.nodes[:, 0], flat.nodes[:, 1]
    nodes = np.column_stack(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)]
    )
    return build_mesh(RADIUS * nodes, flat.triangles, curved=True)
