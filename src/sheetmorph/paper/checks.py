"""The checks that the paper names: derivatives, tension and compression, a cantilever."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import ComputationError
from sheetmorph.energy.hinge import CoupledHinge
from sheetmorph.energy.loads import NodalLoad
from sheetmorph.energy.stretch import EdgeStretch
from sheetmorph.energy.taylor import taylor_slopes
from sheetmorph.energy.total import Total
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.geometry.topology import build_mesh
from sheetmorph.paper.rows import Curve, CurveFigure, Findings, Row, judged, reaching, within
from sheetmorph.paper.runs import LETTERS, Outcomes, Run, Setting
from sheetmorph.paper.sections import Section, result_of
from sheetmorph.paper.shapes import final
from sheetmorph.solve.constraints import HeldDofs
from sheetmorph.solve.linear import make_solver
from sheetmorph.solve.minimise import Minimum, NewtonOptions, minimise
from sheetmorph.solve.system import System
from sheetmorph.study.model import build_problem

MODULUS, THICKNESS = 1e6, 0.3e-3
"""Y [Pa] and h [m] of the strips."""

ELASTICA_2 = 0.49346
"""Deflection over length of the elastica at P L²/EI = 2 (Mattiasson, IJNME 17, 145, 1981)."""

WHERE = "Model Parameters (verification)"


def _runs(setting: Setting) -> tuple[Run, ...]:
    del setting
    return tuple(final(design) for design in LETTERS)


def _evaluate(setting: Setting, outcomes: Outcomes) -> Findings:
    del setting
    rows: list[Row] = []
    for design, letter in LETTERS.items():
        outcome = outcomes[final(design)]
        slopes = [] if outcome.failure else derivative_orders(final(design), outcomes)
        for k, (name, order) in enumerate((("gradient", 2.0), ("Hessian", 3.0))):
            worst = min((found[k] for found in slopes), default=None)
            rows.append(
                judged(
                    f"taylor-{name.lower()}-{design}",
                    f"{letter}: order of the Taylor remainder with the {name}",
                    WHERE,
                    "verified by finite differences",
                    None if worst is None else min(worst, order),
                    reaching(order - 0.05, order - 0.2),
                    lack=outcome.failure,
                    note=f"{order:g} is right; the least of three states: flat, flat and "
                    "actuated, final.",
                )
            )
    rows += _strip_rows()
    loads = np.array([0.02, 0.5, 1.0, 2.0, 3.5, 5.0])
    tips = np.array([cantilever(8, float(load), 10 * THICKNESS) for load in loads])
    lengths = np.linspace(0.0, 5.0, 60)
    curves = (
        Curve("PL³/(3EI)", lengths[:30], lengths[:30] / 3, "dashed"),
        Curve("elastica", *elastica(), "line"),
        Curve("strip of triangles", loads, tips, "dots"),
    )
    figure = CurveFigure(
        "cantilever",
        "Tip deflection of a cantilever under a load at its end, with L its length.",
        "P L² / (E I)",
        "deflection / L",
        curves,
    )
    notes = (
        (
            "An equilateral lattice of edges with K = (√3/2) Y h l₀² has membrane "
            "stiffness Y h and Poisson's ratio 1/3 in the limit of fine meshes; its hinges bend a "
            "narrow strip with E I = (8/9) D w. The strips have no coupling and no thermal strain."
        ),
    )
    return Findings(rows, [figure], (), notes)


def derivative_orders(run: Run, outcomes: Outcomes) -> list[tuple[float, float]]:
    """Orders of the Taylor remainders at the flat, the flat actuated, and the final state."""
    result = result_of(outcomes[run])
    problem = build_problem(result.design)
    rng = np.random.default_rng(0)
    direction = rng.standard_normal(3 * len(problem.mesh.nodes))
    # A step as long as the finest edges bend by little.
    scale = 0.02 * float(problem.mesh.edge_lengths.min())
    sizes = np.asarray(scale * 0.5 ** np.arange(7), dtype=np.float64)
    flat = problem.mesh.nodes.ravel().copy()
    states = ((flat, 0.0), (flat, 1.0), (np.ascontiguousarray(outcomes[run].shape).ravel(), 1.0))
    orders = []
    for x, ramp in states:
        slopes = taylor_slopes(problem.total.at(ramp, 0.0), x, direction, sizes)
        orders.append((slopes.gradient, slopes.hessian))
    return orders


def _strip_rows() -> list[Row]:
    rows = []
    for name, strain in (("tension", 1e-4), ("compression", -1e-4)):
        coarse, fine = (pulled(rows_across, strain)[0] for rows_across in (12, 24))
        limit = (2 * fine - coarse) / (MODULUS * THICKNESS)
        rows.append(
            judged(
                name,
                f"Uniaxial {name}: error of the membrane stiffness Y h",
                WHERE,
                "verified by the closed form",
                abs(limit - 1),
                within(0.01, 0.05),
                note="Extrapolated from 12 and 24 rows of triangles; at 24 rows "
                f"{abs(fine / (MODULUS * THICKNESS) - 1):.3f}, for the spare edges of the rim.",
            )
        )
    small, large = 1e-2, 2.0
    cases = (
        ("", "small end load: error of the deflection", small, small / 3, 12, THICKNESS),
        ("-large", "P L²/EI = 2: error of the deflection", large, ELASTICA_2, 8, 10 * THICKNESS),
    )
    for suffix, what, load, exact, rows_across, thickness in cases:
        found = cantilever(rows_across, load, thickness) / exact
        rows.append(
            judged(
                f"cantilever{suffix}",
                f"Cantilever, {what}",
                WHERE,
                "verified by the closed form",
                abs(found - 1),
                within(0.01, 0.05),
                note="Against P L³/(3 E I)."
                if not suffix
                else "Against the elastica, 0.49346 L "
                "(Mattiasson 1981); the paper names the small load alone.",
            )
        )
    return rows


def strip(columns: int, rows: int, l0: float) -> SheetMesh:
    """Rows of equilateral triangles of side l0 along x, centred on y = 0."""
    starts = np.cumsum([0] + [columns + 1 - j % 2 for j in range(rows + 1)])
    points, triangles = [], []
    for j in range(rows + 1):
        odd = j % 2
        x = (np.arange(columns + 1 - odd) + 0.5 * odd) * l0
        points.append(np.column_stack([x, np.full(len(x), (j - rows / 2) * l0 * np.sqrt(0.75))]))
    for j in range(rows):
        long, short = (j, j + 1) if j % 2 == 0 else (j + 1, j)
        a = starts[long] + np.arange(columns)
        b = starts[short] + np.arange(columns)
        pointing = np.column_stack([a, a + 1, b])
        between = np.column_stack([a[1:], b[1:], b[:-1]])
        both = np.concatenate([pointing, between])
        triangles.append(both if j % 2 == 0 else both[:, [0, 2, 1]])
    return build_mesh(np.concatenate(points), np.concatenate(triangles))


def pulled(rows: int, strain: float) -> tuple[float, float]:
    """Membrane stiffness [N/m] and Poisson's ratio of a strip pulled along x by a strain."""
    l0 = 0.02 / rows
    mesh = strip(2 * rows, rows, l0)
    x = mesh.nodes[:, 0]
    length = float(np.ptp(x))
    held = np.zeros((len(x), 3), dtype=bool)
    held[(x < 0.6 * l0) | (x > length - 0.6 * l0), 0] = True
    held[:, 2] = True
    held[np.argmin(np.abs(mesh.nodes - [length / 2, 0, 0]).sum(axis=1)), 1] = True
    stretch = np.sqrt(3) / 2 * MODULUS * THICKNESS * l0**2
    found = _solve(mesh, held, stretch, 0.0, None, mesh.nodes * [1 + strain, 1, 1], 1e-12)
    moved = found.x.reshape(-1, 3)
    middle = np.abs(x - length / 2) < length / 4
    across = np.polyfit(mesh.nodes[middle, 1], moved[middle, 1], 1)[0] - 1
    area = float(mesh.triangle_areas.sum())
    return 2 * found.energy / (strain**2 * area), float(-across / strain)


def cantilever(rows: int, load: float, thickness: float) -> float:
    """Tip deflection over length of a cantilever under an end load.

    It is half of a strip held in its middle and loaded at both ends.

    Args:
        rows: rows of triangles across.
        load: P L²/(E I).
        thickness: [m].
    """
    width = 0.01
    l0 = width / rows / np.sqrt(0.75)
    columns = 2 * round(8 * width / l0)
    mesh = strip(columns, rows, l0)
    x, y = mesh.nodes[:, 0], mesh.nodes[:, 1]
    length = columns * l0 / 2
    rigidity = MODULUS * thickness**3 / 12
    unit = load * (8 / 9) * rigidity * width / length**2
    tips = (x < 0.1 * l0) | (x > 2 * length - 0.1 * l0)
    force = np.zeros_like(mesh.nodes)
    force[tips, 2] = 2 * unit / tips.sum()
    held = np.zeros((len(x), 3), dtype=bool)
    middle = int(np.argmin(np.abs(mesh.nodes - [length, 0, 0]).sum(axis=1)))
    held[middle] = True
    held[np.argmin(np.abs(mesh.nodes - [length - l0, 0, 0]).sum(axis=1)), 2] = True
    held[np.abs(y) < 0.1 * l0, 1] = True
    stretch = np.sqrt(3) / 2 * MODULUS * thickness * l0**2
    bend = 2 / np.sqrt(3) * rigidity
    found = _solve(mesh, held, stretch, bend, force, mesh.nodes, 1e-5 * unit)
    moved = found.x.reshape(-1, 3)
    return float((moved[tips, 2].mean() - moved[middle, 2]) / length)


def _solve(
    mesh: SheetMesh,
    held: NDArray[np.bool_],
    stretch: float,
    bend: float,
    force: Floats | None,
    start: Floats,
    tolerance: float,
) -> Minimum:
    """The equilibrium of uniform edges and hinges without coupling.

    Raises:
        ComputationError: there is none near the start.
    """
    edges, hinges = len(mesh.edges), len(mesh.hinges)
    total = Total.of(
        [
            EdgeStretch(mesh.edges, mesh.edge_lengths, np.full(edges, stretch), np.zeros(edges)),
            CoupledHinge(
                mesh.hinges,
                mesh.edge_lengths[mesh.hinge_edges[:, 1:]],
                np.full(hinges, bend),
                np.zeros(hinges),
                np.zeros(hinges),
            ),
            NodalLoad(
                np.arange(len(mesh.nodes), dtype=np.int32)[:, None],
                np.zeros_like(mesh.nodes) if force is None else force,
                mesh.nodes,
            ),
        ],
        len(mesh.nodes),
    ).at(1.0, 1.0)
    system = System(total, HeldDofs.of(total.pattern, held.ravel()), make_solver(total.pattern))
    found = minimise(system, start.ravel().copy(), NewtonOptions(tolerance, max_iterations=200))
    if found.outcome != "converged":
        raise ComputationError(f"the strip found no equilibrium ({found.outcome})")
    return found


def elastica() -> tuple[Floats, Floats]:
    """P L²/EI and tip deflection over L of the inextensible elastica, by elliptic integrals.

    With the tip angle φ, m = (1 + sin φ)/2 and sin ψ = 1/√(2m), √(P L²/EI) = K(m) − F(ψ, m)
    and deflection/L = 1 − 2 (E(m) − E(ψ, m))/√(P L²/EI).
    """
    from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

    m = (1 + np.sin(np.linspace(1e-3, 1.29, 80))) / 2
    psi = np.arcsin(1 / np.sqrt(2 * m))
    root = ellipk(m) - ellipkinc(psi, m)
    return root**2, 1 - 2 * (ellipe(m) - ellipeinc(psi, m)) / root


CHECKS = Section("checks", "Derivatives, tension, cantilever", "Model Parameters", _runs, _evaluate)
