"""The heavy elastica: a strip, clamped level at one end, bends by its own weight."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.geometry.structured import rectangle
from sheetmorph.measure.elastica import LARGEST, load_number
from sheetmorph.proofs.proof import Check, Curve, Plot, Proof, convergence_order
from sheetmorph.proofs.sheets import benchmark_table, solved, states_at

WIDTH = 0.05  # over the length of 1 m
THICKNESS = 0.002
MODULUS, GRAVITY = 1e6, 10.0

DESIGN = f"""
name = "heavy elastica"
model = "laminate"
[outline]
kind = "rectangle"
width = "1 m"
height = "{WIDTH} m"
centre = ["0.5 m", "0 m"]
[[layers]]
name = "strip"
role = "inert"
thickness = "{THICKNESS} m"
young_modulus = "{MODULUS} Pa"
poisson_ratio = 0
[perturbation]
total_force = "0 N"
[[supports]]
kind = "box"
x = ["0 m", "0 m"]
y = ["-{WIDTH} m", "{WIDTH} m"]
clamp = true
[[loads]]
kind = "weight"
gravity = "{GRAVITY} m/s^2"
[mesh]
size = "0.02 m"
[solver]
initial_step = 1e-4
min_step = 1e-5
tolerance = 1e-9
"""

CELLS = (40, 80, 120)
"""Cells along the structured meshes of the strip."""
SIZES = (0.025, 0.015, 0.009)
"""Lengths of the edges of the irregular meshes [m]."""
ORDER_AT = 10.0
"""Γ at which the order of convergence is taken: the strip is bent all along there."""


@dataclass(frozen=True, eq=False)
class Shapes:
    """Droop H and reach W of the tip over the length, shape (rows,) each."""

    droop: Floats
    reach: Floats


def prove(reference: Path | None = None) -> Proof:
    """Droop and reach of the tip for every row, on structured and irregular meshes.

    Raises:
        InputError: the published table is not there.
        ComputationError: a run did not reach its end.
    """
    number, droop, reach = np.array(benchmark_table("heavy_elastica", reference)["rows"]).T
    rigidity = MODULUS * THICKNESS**3 / 12.0
    density = number[-1] * rigidity / (GRAVITY * THICKNESS)
    design = Design.from_toml(DESIGN).with_values(
        {"layers.0.density": f"{density} kg/m^3"},
    )
    families = {
        "structured": [
            _shapes(
                design, number, rectangle(1.0, WIDTH, n, n // 20, "alternating", centre=(0.5, 0.0))
            )
            for n in CELLS
        ],
        "irregular": [
            _shapes(design.with_values({"mesh.size": f"{size} m"}), number) for size in SIZES
        ],
    }
    at = int(np.flatnonzero(number == ORDER_AT)[0])
    checks = []
    for family, shapes in families.items():
        finest = shapes[-1]
        for key, text, known, found in (
            ("h", "droop H/L", droop, finest.droop),
            ("w", "reach W/L", reach, finest.reach),
        ):
            checks += [
                Check(f"{family}-{key}-{g:g}", f"{text} at Γ = {g:g}, {family}", a, b, 0.01)
                for g, a, b in zip(number.tolist(), known.tolist(), found.tolist(), strict=True)
            ]
        sizes = SIZES if family == "irregular" else [1.0 / n for n in CELLS]
        order = convergence_order(sizes, [float(s.droop[at]) - droop[at] for s in shapes])
        what = f"order of convergence of the droop at Γ = {ORDER_AT:g}, {family}"
        checks.append(Check(f"{family}-order", what, 1.7, order, kind="at least"))
    known = droop < LARGEST
    own = load_number(droop[known], "self_weight")
    checks += [
        Check(f"table-{g:g}", f"Γ of the elastica with the row's H/L, Γ = {g:g}", g, found, 1e-3)
        for g, found in zip(number[known].tolist(), own.tolist(), strict=True)
    ]
    return Proof(
        name="heavy_elastica",
        title="Heavy elastica",
        statement=(
            f"A strip of 1 × {WIDTH} m, {1e3 * THICKNESS:g} mm thick, ν = 0, is clamped level at "
            "one end and bends by its own weight, up to Γ = ρ g h L³/D = "
            f"{number[-1]:g}. How far the tip droops (H) and how far it reaches (W) is compared "
            f"with the heavy elastica for {len(number)} values of Γ, on a structured mesh of "
            f"{CELLS[-1]} cells along the strip and on an irregular one with edges of "
            f"{1e3 * SIZES[-1]:g} mm. At large Γ all bending sits in a length of L/√Γ at the "
            "clamp, which the mesh must resolve: this is what the errors of W grow with. The "
            "table itself is held against the equation of the elastica, integrated from the tip."
        ),
        source="the equation of the heavy elastica, θ″ = −Γ u cos θ, solved as a boundary value "
        "problem",
        checks=tuple(checks),
        plots=(
            Plot(
                "heavy-elastica",
                "Tip of a strip under its own weight",
                "Γ = ρ g h L³ / D",
                "over the length",
                (
                    Curve("droop H, elastica", number, droop, "line"),
                    Curve("reach W, elastica", number, reach, "line"),
                    *(
                        Curve(f"{name}, {family}", number, getattr(shapes[-1], name))
                        for family, shapes in families.items()
                        for name in ("droop", "reach")
                    ),
                ),
                log="x",
            ),
        ),
    )


def _shapes(design: Design, number: Floats, mesh: SheetMesh | None = None) -> Shapes:
    stops = (number / number[-1]).tolist()
    result = solved(design, mesh, stops)
    end = np.isclose(result.mesh.nodes[:, 0], 1.0)
    tip = result.positions[states_at(result, stops)][:, end].mean(axis=1)
    return Shapes(-tip[:, 2], tip[:, 0])
