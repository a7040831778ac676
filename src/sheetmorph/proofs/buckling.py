"""Buckling of heated plates: a clamped disc, and a square that is simply supported."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from sheetmorph.core.errors import ComputationError
from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.geometry.structured import disc, rectangle
from sheetmorph.proofs.proof import Check, Curve, Plot, Proof, convergence_order
from sheetmorph.solve.constraints import HeldDofs
from sheetmorph.solve.critical import Critical, first_critical, stationary
from sheetmorph.solve.linear import make_solver
from sheetmorph.solve.system import System
from sheetmorph.study.model import build_problem

THICKNESS, POISSON = 0.001, 0.3
FULL_STRAIN = 8e-6
"""Free strain at the end of the ramp."""
RAMPS = tuple(np.linspace(0.0, 1.0, 6).tolist())

_SHEET = f"""
model = "laminate"
[[layers]]
name = "plate"
role = "active"
thickness = "{THICKNESS} m"
young_modulus = "1 MPa"
poisson_ratio = {POISSON}
[actuation]
eps_pre = {FULL_STRAIN}
profile = "uniform"
[perturbation]
total_force = "0 N"
[mesh]
size = "0.1 m"
"""

DISC = f"""
name = "clamped disc"
{_SHEET}
[outline]
kind = "disc"
radius = "1 m"
[[supports]]
kind = "nodes"
nodes = [0]
clamp = true
"""

SQUARE = f"""
name = "square plate"
{_SHEET}
[outline]
kind = "rectangle"
width = "1 m"
height = "1 m"
[[supports]] # the sides that press, and may slide along themselves
kind = "box"
x = ["-0.5 m", "-0.5 m"]
y = ["-1 m", "1 m"]
hold = ["x", "z"]
[[supports]]
kind = "box"
x = ["0.5 m", "0.5 m"]
y = ["-1 m", "1 m"]
hold = ["x", "z"]
[[supports]] # the other two, free to move apart
kind = "box"
x = ["-1 m", "1 m"]
y = ["-0.5 m", "-0.5 m"]
hold = ["z"]
[[supports]]
kind = "box"
x = ["-1 m", "1 m"]
y = ["0.5 m", "0.5 m"]
hold = ["z"]
[[supports]] # a corner, against drifting
kind = "nodes"
nodes = [0]
hold = ["y"]
"""

COUNTS = (8, 12, 18)
"""Rings of the discs; half as many cells again along a side of the squares."""
SIZES = (0.12, 0.08, 0.055)
"""Lengths of the edges of the irregular discs [m]; half of that for the squares."""


@dataclass(frozen=True)
class _Plate:
    """One of the two plates and what is known of it."""

    key: str
    name: str
    text: str
    strain: float  # at which it buckles
    coefficient: str
    scale: float  # the coefficient, over the strain
    shape: Callable[[Floats], Floats]  # of the mode, 1 at the middle, by place


def critical_strain(text: str, mesh: SheetMesh | None = None) -> tuple[float, Critical, SheetMesh]:
    """Free strain at which a plate buckles, on a mesh or on that of its design.

    Raises:
        ComputationError: it does not buckle along the ramp.
    """
    design = Design.from_toml(text)
    problem = build_problem(design, mesh)
    pattern = problem.total.pattern
    system = System(
        problem.total, HeldDofs.of(pattern, problem.held_dofs), make_solver(pattern, "auto")
    )
    newton = partial(stationary, tolerance=problem.residual_tolerance)
    found = first_critical(system, problem.start, RAMPS, newton)
    if found is None:
        raise ComputationError(f"{design.name} does not buckle up to a strain of {FULL_STRAIN}")
    return FULL_STRAIN * found.ramp, found, problem.mesh


def prove(reference: Path | None = None) -> Proof:
    """Critical strains and modes of both plates on structured and irregular meshes.

    Raises:
        ComputationError: a plate does not buckle.
    """
    del reference
    checks: list[Check] = []
    curves: list[Curve] = []
    for plate, families in _cases():
        for family, sizes, runs in families:
            strains = []
            for text, mesh in runs:
                strain, found, on = critical_strain(text, mesh)
                strains.append(strain)
            off = np.array(strains) / plate.strain - 1.0
            known = plate.shape(on.nodes)
            deflection = found.mode[: on.nodes.size].reshape(-1, 3)[:, 2]
            deflection = deflection / deflection[known.argmax()]
            key = f"{plate.key}-{family}"
            where = f"{plate.name}, {family}"
            checks += [
                Check(
                    key,
                    f"{plate.coefficient}: {where}, {len(on.nodes)} nodes",
                    plate.scale * plate.strain,
                    plate.scale * strains[-1],
                    0.01,
                ),
                Check(
                    f"{key}-mode",
                    f"largest deviation of the mode from the exact one: {where}",
                    0.02,
                    float(np.abs(deflection - known).max()),
                    kind="at most",
                ),
                Check(
                    f"{key}-order",
                    f"order of convergence: {where}",
                    1.8,
                    convergence_order(sizes, off),
                    kind="at least",
                ),
            ]
            curves.append(Curve(where, np.asarray(sizes), np.abs(off)))
    guide = np.array([min(COUNTS), max(COUNTS)], dtype=np.float64)
    curves.append(Curve("second order", 1.0 / guide, 1.2 / guide**2, "dashes"))
    return Proof(
        name="buckling",
        title="Buckling of heated plates",
        statement=(
            "Plates that are heated and cannot expand: a disc whose rim is clamped buckles at the "
            "free strain ε = 1.2235 h²/[(1 + ν) R²], and a square that is pressed along one "
            "direction and simply supported at all four sides at N = k π² D/b² with k = 4. The "
            "plates stay flat, whether stable or not, while the strain grows; the first negative "
            "pivot of the Hessian brackets the critical strain, and Brent's method finds the zero "
            "of the smallest eigenvalue. Its vector is compared with the exact mode at every "
            f"node. ν = {POISSON}, h = {THICKNESS} of the radius or of the side."
        ),
        source="Timoshenko, Gere, Theory of elastic stability, 2nd edition, 1961, chapter 9",
        checks=tuple(checks),
        plots=(
            Plot(
                "buckling",
                "Error of the critical strain",
                "length of edges over radius or side",
                "relative error",
                tuple(curves),
                log="xy",
            ),
        ),
    )


_Runs = list[tuple[str, SheetMesh | None]]


def _cases() -> list[tuple[_Plate, list[tuple[str, Sequence[float], _Runs]]]]:
    from scipy.special import j0, jn_zeros

    root = float(jn_zeros(1, 1)[0])  # of J1: 3.8317

    def bell(nodes: Floats) -> Floats:
        radius = np.hypot(nodes[:, 0], nodes[:, 1])
        return np.asarray((j0(root * radius) - j0(root)) / (1.0 - j0(root)))

    def wave(nodes: Floats) -> Floats:
        return np.asarray(np.cos(np.pi * nodes[:, 0]) * np.cos(np.pi * nodes[:, 1]))

    clamped = root**2 / 12.0 * THICKNESS**2 / (1.0 + POISSON)
    pressed = 4.0 * np.pi**2 * THICKNESS**2 / (12.0 * (1.0 - POISSON**2))
    round_plate = _Plate(
        *("disc", "clamped disc", DISC, clamped, "ε (1 + ν) R²/h²"),
        *((1.0 + POISSON) / THICKNESS**2, bell),
    )
    square = _Plate(
        *("square", "supported square", SQUARE, pressed, "k"),
        *(4.0 / pressed, wave),
    )
    cells = [3 * n // 2 for n in COUNTS]
    return [
        (
            round_plate,
            [
                ("structured", [1.0 / n for n in COUNTS], [_clamped(disc(1.0, n)) for n in COUNTS]),
                ("irregular", SIZES, [_clamped(_made(DISC, size)) for size in SIZES]),
            ],
        ),
        (
            square,
            [
                (
                    "structured",
                    [1.0 / n for n in cells],
                    [(SQUARE, rectangle(1.0, 1.0, n, n, "alternating")) for n in cells],
                ),
                (
                    "irregular",
                    [0.5 * size for size in SIZES],
                    [(SQUARE, _made(SQUARE, 0.5 * size)) for size in SIZES],
                ),
            ],
        ),
    ]


def _made(text: str, size: float) -> SheetMesh:
    return Design.from_toml(text).with_values({"mesh.size": f"{size} m"}).build_mesh()


def _clamped(mesh: SheetMesh) -> tuple[str, SheetMesh]:
    rim = np.unique(mesh.edges[mesh.rim_edges]).tolist()
    return DISC.replace("nodes = [0]", f"nodes = {rim}"), mesh
