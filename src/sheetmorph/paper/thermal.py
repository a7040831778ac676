"""Fig. 4E–G: profiles of the thermal strain, and what they do to the bowl."""

from __future__ import annotations

import numpy as np

from sheetmorph.design.actuation import edge_distance, profile
from sheetmorph.geometry.mesh import Floats
from sheetmorph.paper.rows import Curve, CurveFigure, Findings, ShapeFigure, claims, judged
from sheetmorph.paper.runs import Outcomes, Run, Setting
from sheetmorph.paper.sections import (
    WITHOUT_MESHES,
    Section,
    failures,
    listed,
    result_of,
    rising,
)
from sheetmorph.study.result import Result

GAMMAS = (0.1, 1.0, 5.0)
EPS_PRE = -0.7


def _run(gamma: float) -> Run:
    values = {
        "actuation.eps_pre": EPS_PRE,
        "actuation.profile": "exponential",
        "actuation.gamma": gamma,
    }
    return Run.of("bowl", values)


def _runs(setting: Setting) -> tuple[Run, ...]:
    del setting
    return tuple(_run(gamma) for gamma in GAMMAS)


def concentration(result: Result) -> float:
    """Share of all folding, Σ|θ| times edge length, in the tenth of the hinges folded most."""
    lengths = result.mesh.edge_lengths[result.mesh.hinge_edges[:, 0]]
    folded = np.abs(result.dihedral[-1]) * lengths
    most = np.sort(folded)[-max(1, len(folded) // 10) :]
    return float(most.sum() / max(folded.sum(), 1e-300))


def _evaluate(setting: Setting, outcomes: Outcomes) -> Findings:
    runs = _runs(setting)
    s = np.linspace(0.0, 1.0, 2001)
    by_gamma = [profile(s, "exponential", gamma) for gamma in GAMMAS]
    tiny = profile(s, "exponential", 1e-9)
    steep = profile(s, "exponential", 1e4)
    ends = all(abs(y[0]) < 1e-15 and abs(y[-1] - 1) < 1e-15 for y in by_gamma)
    off_linear = float(np.abs(by_gamma[0] - s).max())
    where = "Fig. 4E, Eq. thermal strain profile, Appendix A"
    rows = [
        judged(
            "profile-conditions",
            "Profile: zero at the pattern, ε_pre at d_max, monotone",
            where,
            "conditions (i) to (iii)",
            "0 and 1 at the ends" if ends else "other values at the ends",
            claims(
                ("0 at d = 0 and 1 at d_max", ends),
                ("rises everywhere between", all(rising(y) for y in by_gamma)),
            ),
        ),
        judged(
            "profile-limits",
            "Profile: its limits for γ → 0 and γ → ∞",
            where,
            "linear; a step",
            f"{np.abs(tiny - s).max():.1e} from linear at γ = 1e−9",
            claims(
                ("linear to 1e−9 at γ = 1e−9", float(np.abs(tiny - s).max()) < 1e-9),
                ("1 to 1e−9 beyond s = 0.01 at γ = 1e4", float(1 - steep[s > 0.01].min()) < 1e-9),
            ),
        ),
        judged(
            "profile-0.1",
            "Profile at γ = 0.1 is nearly linear",
            where,
            "approaches a linear profile",
            off_linear,
            claims(
                (f"at most {off_linear:.4f} from linear, less than 0.02", off_linear < 0.02),
            ),
        ),
    ]
    lack = failures(outcomes, *runs)
    ready = [outcomes[run] for run in runs] if not lack else []
    fifth = len(s) // 5
    sharpest = [float(np.abs(result_of(outcome).dihedral[-1]).max()) for outcome in ready]
    shares = [concentration(result_of(outcome)) for outcome in ready]
    least = [_nearest_edge(result_of(outcome)) for outcome in ready]
    rows += [
        judged(
            "profile-no-zero",
            "No edge of the film lies at d = 0",
            "Fig. 4E",
            "no markers at d/d_max = 0",
            f"the nearest at d/d_max = {min(least):.3f}" if least else None,
            claims(("every distance of an edge in the film is above 0", min(least, default=0) > 0)),
            lack=lack,
        ),
        judged(
            "gamma-local",
            "A at −0.7: larger γ, more localised deformation",
            "Fig. 4F, G",
            "more localised from γ = 0.1 to 5",
            f"largest |θ| {listed(sharpest)} rad; share of folding in the tenth of the hinges "
            f"folded most {listed([100 * share for share in shares], 0)} %"
            if shares
            else None,
            claims(
                (
                    "the strain reached within a fifth of d_max of the pattern rises ("
                    + listed([100 * float(y[fifth]) for y in by_gamma], 0)
                    + " %)",
                    rising(np.array([y[fifth] for y in by_gamma])),
                ),
                ("the sharpest fold grows", bool(shares) and rising(np.array(sharpest))),
                (
                    "the share of all folding in the tenth of the hinges folded most rises",
                    bool(shares) and rising(np.array(shares)),
                ),
            ),
            lack=lack,
        ),
    ]
    curves = [Curve(f"γ = {gamma:g}", s, y) for gamma, y in zip(GAMMAS, by_gamma, strict=True)]
    curves.append(Curve("linear", s, s, "dashed"))
    for gamma, outcome in zip(GAMMAS, ready, strict=False):
        x, y = _edges(result_of(outcome))
        curves.append(Curve(f"edges, γ = {gamma:g}", x, y, "dots"))
    figures: list[CurveFigure | ShapeFigure] = [
        CurveFigure(
            "profiles",
            "Thermal strain over the free strain against the distance from the pattern "
            "(Fig. 4E): formula, and the edges of the bowl's mesh.",
            "d/dₘₐₓ  [–]",
            "εᵗʰ / εₚᵣₑ",
            tuple(curves),
        )
    ]
    columns = tuple(
        (f"γ = {gamma:g}", run)
        for gamma, run in zip(GAMMAS, runs, strict=True)
        if outcomes[run].result is not None
    )
    if columns:
        caption = "The bowl at −0.7 for three γ, in perspective and from above (Fig. 4F, G)."
        figures.append(ShapeFigure("gammas", caption, columns, ("shape", "top")))
    notes = [
        (
            "The caption of Fig. 4 gives ε_pre as +0.7; it is taken as a shrinkage, −0.7, which is "
            "the sign that the text gives to all shrinkage."
        )
    ]
    if not setting.reference:
        notes.append(WITHOUT_MESHES)
    return Findings(rows, figures, (), notes)


def _distances(result: Result) -> Floats:
    """d/d_max of the edges in the film, shape (n,)."""
    distances, farthest = edge_distance(result.design, result.mesh, result.regions)
    return np.asarray(distances[~result.edge_in_pattern] / farthest)


def _nearest_edge(result: Result) -> float:
    return float(_distances(result).min())


def _edges(result: Result) -> tuple[Floats, Floats]:
    """Every twentieth edge by distance: d/d_max and its share of the strain."""
    s = _distances(result)
    order = np.argsort(s)[::20]
    share = result.thermal_strain_full[~result.edge_in_pattern] / result.summary["eps_pre"]
    return s[order], np.asarray(share[order])


THERMAL = Section(
    "thermal", "Profiles of the thermal strain", "Fig. 4E–G, Appendix A", _runs, _evaluate
)
