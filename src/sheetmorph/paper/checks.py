"""The checks that the paper names: derivatives, tension and compression, a cantilever."""

from __future__ import annotations

import numpy as np

from sheetmorph.energy.taylor import taylor_slopes
from sheetmorph.geometry.mesh import Floats
from sheetmorph.paper.rows import Curve, CurveFigure, Findings, Row, judged, reaching, within
from sheetmorph.paper.runs import LETTERS, Outcomes, Run, Setting
from sheetmorph.paper.sections import Section, result_of
from sheetmorph.paper.shapes import final
from sheetmorph.paper.strips import MODULUS, THICKNESS, cantilever, pulled
from sheetmorph.study.model import build_problem

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
        found = cantilever(rows_across, load, thickness)[0] / exact
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
