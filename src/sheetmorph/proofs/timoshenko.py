"""A strip of two layers: Timoshenko's curvature, and exact circles at large mismatch."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.structured import rectangle
from sheetmorph.proofs.bilayer import (
    Bilayer,
    circle_of_exact_fibres,
    circle_of_the_law,
    timoshenko_curvature,
)
from sheetmorph.proofs.proof import Check, Curve, Plot, Proof, convergence_order
from sheetmorph.proofs.sheets import circle_curvature, solved

DESIGN = """
name = "bilayer strip"
model = "laminate"
[outline]
kind = "rectangle"
width = "20 mm"
height = "2 mm"
[[layers]]
name = "lower"
role = "active"
thickness = "0.05 mm"
young_modulus = "1 MPa"
poisson_ratio = 0
[[layers]]
name = "upper"
role = "inert"
thickness = "0.05 mm"
young_modulus = "1 MPa"
poisson_ratio = 0
[actuation]
eps_pre = -0.001
profile = "uniform"
transverse = 0
[perturbation]
total_force = "0 N"
[laminate]
thickening = "none"
[mesh]
size = "0.5 mm"
[solver]
initial_step = 1.0
max_step = 1.0
"""

THICKNESS = 0.1e-3
RATIOS = (0.1, 10**-0.5, 1.0, 10**0.5, 10.0)
"""Of thicknesses m and of moduli n, lower layer over upper."""
SMALL = -1e-3
MISMATCHES = (-0.02, -0.05, -0.1, -0.15, -0.2, -0.25, -0.3)
MESHES = {"structured": 0.0, "irregular": 0.2}
"""By what part of a cell the nodes are moved at random."""
CELLS = (10, 20, 40)
"""Cells along the strip for the order of convergence; the last one for large mismatch."""


def prove(reference: Path | None = None) -> Proof:
    """Curvatures of strips, all fitted to their nodes."""
    grid, checks = {}, []
    for mesh, irregular in MESHES.items():
        for m in RATIOS:
            for n in RATIOS:
                layers = _layers(m, n, SMALL)
                known = timoshenko_curvature(layers)
                found = _curvature(layers, (20e-3, 2e-3), 40, irregular)
                grid[mesh, m, n] = found
                what = f"curvature at m = {m:.3g}, n = {n:.3g}, {mesh} mesh"
                name = f"small-{mesh}-m{m:.2g}-n{n:.2g}"
                checks.append(Check(name, what, known, found, 0.01, unit="1/m"))
    large: dict[bool, list[float]] = {}
    for thickening in (False, True):
        large[thickening] = []
        for e in MISMATCHES:
            layers = _layers(1.0, 1.0, e, thickening)
            found = _curvature(layers, _SHORT, CELLS[-1], MESHES["irregular"])
            large[thickening].append(found * THICKNESS)
            what = f"κ h at a mismatch of {e:g}{', thickening' if thickening else ''}"
            name = f"large{'-thickening' if thickening else ''}-{-e:g}"
            known = circle_of_the_law(layers) * THICKNESS
            checks.append(Check(name, what, known, found * THICKNESS, 0.01))
    errors = {mesh: _errors(irregular) for mesh, irregular in MESHES.items()}
    checks += [
        Check(
            f"order-{mesh}",
            f"order of convergence of the curvature, {mesh} meshes",
            1.9,
            convergence_order(_EDGES, errors[mesh]),
            kind="at least",
        )
        for mesh in MESHES
    ]
    return Proof(
        name="timoshenko",
        title="Bilayer strip",
        statement=(
            "A strip of two layers, of which the lower one shrinks lengthwise by e; no Poisson's "
            "effect. Small mismatch: e = −0.001, m = h1/h2 and n = E1/E2 (lower over upper) each "
            "from 0.1 to 10, on meshes of 40 × 4 cells, against Timoshenko's formula. Large "
            "mismatch: equal layers, e down to −0.3, an irregular mesh of 40 × 8 cells, with "
            "layers that keep their thickness and with a lower layer that keeps its volume, "
            "against the circle for which the energy of the two layers is least, a problem of "
            "two unknowns. Curvatures are those of the circle through the nodes, of the middle "
            "surface, negative where the lower face is the concave one: the shrinking layer lies "
            "inside."
        ),
        source="Timoshenko, Analysis of bi-metal thermostats, Journal of the Optical Society of "
        "America 11, 1925",
        checks=tuple(checks),
        plots=(_small_plot(grid), _large_plot(large), _order_plot(errors)),
        notes=(_fibre_note(),),
    )


_SHORT = (10 * THICKNESS, 2 * THICKNESS)
_EDGES = [_SHORT[0] / cells for cells in CELLS]


def _layers(m: float, n: float, mismatch: float, thickening: bool = False) -> Bilayer:
    upper = THICKNESS / (1.0 + m)
    return Bilayer((m * upper, upper), (n * 1e6, 1e6), mismatch, thickening)


def _curvature(layers: Bilayer, size: tuple[float, float], cells: int, irregular: float) -> float:
    """Curvature of the strip's circle [1/m], negative where its ends sink."""
    lower, upper = layers.thicknesses
    small = abs(layers.mismatch) <= abs(SMALL)
    design = Design.from_toml(DESIGN).with_values(
        {
            "outline.width": f"{size[0]} m",
            "outline.height": f"{size[1]} m",
            "layers.0.thickness": f"{lower} m",
            "layers.1.thickness": f"{upper} m",
            "layers.0.young_modulus": f"{layers.moduli[0]} Pa",
            "actuation.eps_pre": layers.mismatch,
            "laminate.thickening": "volume_conserved" if layers.thickening else "none",
            "mesh.size": f"{size[1] / 2} m",
            "solver.initial_step": 1.0 if small else 0.1,
            "solver.max_step": 1.0 if small else 0.2,
        }
    )
    across = round(cells * size[1] / size[0])
    mesh = rectangle(*size, cells, across, "alternating", irregular=irregular)
    x = solved(design, mesh=mesh).positions[-1]
    middle = np.abs(mesh.nodes[:, 0]) < 0.25 * size[0]
    bend = np.polyfit(mesh.nodes[middle, 0], x[middle, 2], 2)[0]
    return float(np.sign(bend)) * circle_curvature(x[:, [0, 2]])


def _errors(irregular: float) -> Floats:
    """Relative errors of the curvature at a mismatch of −0.2 on finer and finer meshes."""
    layers = _layers(1.0, 1.0, -0.2)
    known = circle_of_the_law(layers)
    return np.array([abs(_curvature(layers, _SHORT, n, irregular) / known - 1) for n in CELLS])


def _small_plot(grid: dict[tuple[str, float, float], float]) -> Plot:
    fine = np.geomspace(RATIOS[0], RATIOS[-1], 60)
    scale, shown = THICKNESS / SMALL, RATIOS[::2]
    curves = []
    for n in shown:
        known = [scale * timoshenko_curvature(_layers(float(m), n, SMALL)) for m in fine]
        curves.append(Curve(f"n = {n:g}, Timoshenko", fine, np.array(known), "line"))
    for mesh in MESHES:
        found = np.array([scale * grid[mesh, m, n] for n in shown for m in RATIOS])
        curves.append(Curve(f"{mesh} mesh", np.tile(RATIOS, len(shown)), found))
    return Plot("timoshenko", "Small mismatch", "m = h1/h2", "κ h / e", tuple(curves), "x")


def _large_plot(large: dict[bool, list[float]]) -> Plot:
    fine = np.linspace(0.0, MISMATCHES[-1], 31)[1:]
    curves = []
    for thickening, found in large.items():
        text = "thickening" if thickening else "no thickening"
        strips = [_layers(1.0, 1.0, float(e), thickening) for e in fine]
        law = np.array([-circle_of_the_law(strip) * THICKNESS for strip in strips])
        fibres = np.array([-circle_of_exact_fibres(strip) * THICKNESS for strip in strips])
        curves += [
            Curve(f"{text}, exact", -fine, law, "line"),
            Curve(f"{text}, model", -np.array(MISMATCHES), -np.array(found)),
            Curve(f"{text}, exact fibres", -fine, fibres, "dashes"),
        ]
    linear = np.array([-timoshenko_curvature(_layers(1.0, 1.0, float(e))) for e in fine])
    curves.append(Curve("Timoshenko", -fine, linear * THICKNESS, "line"))
    return Plot(
        "large_mismatch", "Large mismatch, equal layers", "shrinkage −e", "−κ h", tuple(curves)
    )


def _order_plot(errors: dict[str, Floats]) -> Plot:
    sizes = np.array(_EDGES) / THICKNESS
    curves = [Curve(f"{mesh} meshes", sizes, found) for mesh, found in errors.items()]
    slope = errors["irregular"][-1] * (sizes / sizes[-1]) ** 2
    curves.append(Curve("order 2", sizes, slope, "dashes"))
    return Plot(
        "timoshenko_order",
        "Curvature at a mismatch of −0.2",
        "length of a cell / h",
        "relative error",
        tuple(curves),
        "xy",
    )


def _fibre_note() -> str:
    parts = []
    for thickening in (False, True):
        strips = [_layers(1.0, 1.0, e, thickening) for e in (-0.1, -0.3)]
        ratios = [circle_of_exact_fibres(s) / circle_of_the_law(s) - 1 for s in strips]
        text = "with a thickening film" if thickening else "without thickening"
        parts.append(f"{100 * ratios[0]:.2g} % and {100 * ratios[1]:.2g} % {text}")
    return (
        "The laminate model's strain is linear in the height z, ½ (a − ḡ) − z b; a fibre has "
        "exactly ½ λ² (1 − z κ)² in the place of ½ a − z b, which differs by ½ λ² z² κ². A strip "
        "of the same elastic law with exact fibres would curl more at mismatches of −0.1 and "
        "−0.3: by "
        f"{' and '.join(parts)}. The difference grows with the square of the mismatch."
    )
