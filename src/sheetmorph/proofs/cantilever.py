"""Sze's cantilever: a flat strip, clamped at one end, with a shear force at the other."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sheetmorph.design.spec import Design
from sheetmorph.proofs.load_steps import SOURCE
from sheetmorph.proofs.proof import Check, Curve, Plot, Proof, convergence_order
from sheetmorph.proofs.sheets import benchmark_table, nearest_node, solved, states_at

DESIGN = """
name = "cantilever"
model = "laminate"
[outline]
kind = "rectangle"
width = "10 m"
height = "1 m"
centre = ["5 m", "0.5 m"]
[[layers]]
name = "strip"
role = "inert"
thickness = "10 cm"
young_modulus = "1.2 MPa"
poisson_ratio = 0
[perturbation]
total_force = "0 N"
[[supports]]
kind = "box"
x = ["0 m", "0 m"]
y = ["0 m", "1 m"]
clamp = true
[[loads]]
kind = "line"
x = ["10 m", "10 m"]
y = ["0 m", "1 m"]
force_per_length = ["0 N/m", "0 N/m", "4 N/m"]
[mesh]
size = "0.5 m"
[solver]
initial_step = 0.02
max_step = 0.05
"""

SIZES = (0.5, 0.25, 0.125)
"""Lengths of the edges of the three meshes [m]."""


def prove(reference: Path | None = None) -> Proof:
    """Deflection of the tip at every load step, on irregular meshes of three sizes.

    Raises:
        InputError: the published table is not there.
    """
    table = benchmark_table("sze_cantilever_endshear", reference)
    loads, w, u = (np.array(table[key]) for key in ("P", "W", "minusU"))
    finest, tips = (np.zeros(0), np.zeros(0)), []
    for size in SIZES:
        design = Design.from_toml(DESIGN).with_values({"mesh.size": f"{size} m"})
        result = solved(design, stops=loads.tolist())
        tip = nearest_node(result.mesh, (10.0, 0.5, 0.0))
        moved = result.positions[states_at(result, loads.tolist()), tip] - result.mesh.nodes[tip]
        finest = moved[:, 2], -moved[:, 0]
        tips.append(float(moved[-1, 2]))
    checks = [
        Check(
            f"{key}-{load:.2f}", f"{text} at P = {load:.2f} Pmax", float(known), float(ours), 0.02
        )
        for key, text, values, found in (
            ("w", "deflection W", w, finest[0]),
            ("u", "shortening −U", u, finest[1]),
        )
        for load, known, ours in zip(loads, values, found, strict=True)
    ]
    steps = np.abs(np.diff(tips))
    order = convergence_order(SIZES[:2], steps)
    checks.append(
        Check("order", "order of convergence of the tip's deflection", 1.5, order, kind="at least")
    )
    return Proof(
        name="cantilever",
        title="Cantilever with an end shear force",
        statement=(
            "A strip of 10 × 1 m, 0.1 m thick, E = 1.2 MPa, ν = 0, is clamped at one end and "
            "loaded by a shear force up to 4 N at the other. Tip deflection W and shortening −U "
            f"are compared at each of {len(loads)} load steps, on an irregular mesh with edges of "
            f"{SIZES[-1]} m. The order is that of the differences between three meshes."
        ),
        source=f"{SOURCE}, table 1",
        checks=tuple(checks),
        plots=(
            Plot(
                "cantilever",
                "Tip of the cantilever",
                "displacement [m]",
                "P / Pmax",
                (
                    Curve("W, Sze et al.", w, loads, "line"),
                    Curve("−U, Sze et al.", u, loads, "line"),
                    Curve("W, laminate model", finest[0], loads),
                    Curve("−U, laminate model", finest[1], loads),
                ),
            ),
        ),
    )
