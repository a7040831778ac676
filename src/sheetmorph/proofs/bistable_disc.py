"""A bilayer disc becomes a dish, then either of two half-pipes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sheetmorph.geometry.mesh import Floats
from sheetmorph.proofs.bilayer_disc import POISSON, DiscSheet
from sheetmorph.proofs.karman_disc import bifurcation, dish
from sheetmorph.proofs.karman_pipe import half_pipe
from sheetmorph.proofs.proof import Check, Curve, Plot, Proof, convergence_order

DISHES = (0.25, 0.5, 0.75, 1.0, 1.25)
PIPES = (1.5, 2.0, 3.0, 4.0)
THIN = 16.0
"""S = κ0 R²/(4 h) of the states: before the bifurcation, after it, and of the thin limit."""
MESHES = {"structured": 0.0, "irregular": 0.2}
LENS_RINGS, DISC_RINGS = 40, 24
WHOLE_RINGS = (8, 12, 16)
"""Of whole discs, and of the meshes that give the order."""
CRITICAL_S, CRITICAL_K = 2.0 / (1.0 + POISSON) ** 1.5, (1.0 + POISSON) ** -0.5
PRODUCT = 1.0 / (1.0 + POISSON)

_WAVES_OF_THE_LENS = (
    "A lens has all its waves at once: a harmonic deflection rⁿ cos nθ does not stretch the dish, "
    "and its bending, D0 (1 − ν) ∫ (1 − r²/R²)³ |∇∇w|², and the work of the forces, whose stress "
    "function is A (1 − r²/R²)³, A ∫ (1 − r²/R²)³ |∇∇w|², cancel at A = −D0 (1 − ν) for every n. "
    "On a mesh the short waves at the thin rim, which it resolves least, come first; so the "
    "bifurcation of the lens is read from its half-pipes."
)


def prove(reference: Path | None = None) -> Proof:
    """Curvatures of lenses and discs, of quarters of them; the bifurcation of whole discs."""
    checks: list[Check] = []
    lenses, discs = {}, {}
    pipes = {s: half_pipe(s, POISSON, pipe_curvatures(s)) for s in PIPES}
    for mesh, irregular in MESHES.items():
        lenses[mesh] = _branch(LENS_RINGS, True, irregular, (*DISHES, *PIPES, THIN))
        discs[mesh] = _branch(DISC_RINGS, False, irregular, (*DISHES, *PIPES))
        checks += _lens_checks(mesh, lenses[mesh])
        checks += _disc_checks(mesh, discs[mesh], pipes)
    exact_s, exact_k = bifurcation(POISSON)
    found = [_bifurcation(rings) for rings in WHOLE_RINGS]
    errors = [abs(s / exact_s - 1.0) for s, _ in found]
    sizes = [1.0 / rings for rings in WHOLE_RINGS]
    order = convergence_order(sizes, errors)
    known = dish(1.0, POISSON).curvature
    rough = [_branch(n, False, MESHES["irregular"], (1.0,))[1.0].mean() for n in WHOLE_RINGS]
    rough_errors = [abs(float(k) / known - 1.0) for k in rough]
    checks += [
        Check("disc-S", "whole disc, S at the bifurcation", exact_s, found[-1][0], 0.01),
        Check("disc-K", "whole disc, K at the bifurcation", exact_k, found[-1][1], 0.01),
        Check("disc-order", "whole disc, order of convergence of S", 1.8, order, kind="at least"),
        Check(
            "disc-order-irregular",
            "disc, order of convergence of K at S = 1, irregular meshes",
            1.8,
            convergence_order(sizes, rough_errors),
            kind="at least",
        ),
    ]
    return Proof(
        name="bistable_disc",
        title="Bistable disc",
        statement=(
            "A free disc of two layers, one swelling and one shrinking alike in all directions, "
            "with the natural curvature κ0. With K = κ R²/(4 h), S = κ0 R²/(4 h) and ν = 0.33 it "
            "is a dish with S = K [1 + (1 − ν) K²] up to K = 1/√(1 + ν), S = 2/(1 + ν)^1.5. Beyond "
            "it rolls up about either of two axes with Kx Ky = 1/(1 + ν), Kx + Ky = (1 + ν) S, and "
            "κ = (1 + ν) κ0 in the thin limit. These formulas take the curvature as uniform. That "
            "is exact for a disc whose thickness falls to its rim like a lens, h (1 − r²/R²), if "
            "√(2 (7 + ν)) takes the place of 4 (Mansfield); for constant thickness it is "
            "Ritz's method with one term (Freund). So the formulas are checked on a lens, and the "
            "disc of constant thickness by plate theory for moderate slopes with many terms, in r "
            "for the dish and in r and θ for the half-pipe. Quarters of discs, R/h = 400, "
            f"{LENS_RINGS} rings of triangles for the lens and {DISC_RINGS} for the disc; whole "
            f"discs with {WHOLE_RINGS[-1]}; curvatures are those of the "
            "quadratic surface that fits the nodes best. Bifurcations of the quarters are where "
            "(Kx − Ky)², which is linear in S², comes out as zero; that of whole discs is where "
            "the smallest eigenvalue of the Hessian is zero."
        ),
        source="Freund, Substrate curvature due to thin film mismatch strain in the nonlinear "
        "deformation range, Journal of the Mechanics and Physics of Solids 48, 2000; Mansfield, "
        "Bending, buckling and curling of a heated thin plate, Proceedings of the Royal Society A "
        "268, 1962; Seffen and McMahon, Heating of a uniform wafer disk, International Journal of "
        "Mechanical Sciences 49, 2007",
        checks=tuple(checks),
        plots=(_plot(lenses, discs, pipes),),
        notes=(_note(exact_s, exact_k, pipes), _WAVES_OF_THE_LENS),
    )


def dish_curvature(natural: float) -> float:
    """K with K [1 + (1 − ν) K²] = S."""
    roots = np.roots([1.0 - POISSON, 0.0, 1.0, -natural])
    return float(roots[np.abs(roots.imag).argmin()].real)


def pipe_curvatures(natural: float) -> tuple[float, float]:
    """Kx ≥ Ky with Kx + Ky = (1 + ν) S and Kx Ky = 1/(1 + ν); beyond the bifurcation."""
    half = 0.5 * (1.0 + POISSON) * natural
    part = float(np.sqrt(half * half - PRODUCT))
    return half + part, half - part


def _lens_checks(mesh: str, found: dict[float, Floats]) -> list[Check]:
    def check(name: str, what: str, known: float, value: float, limit: float) -> Check:
        return Check(f"lens-{mesh}-{name}", f"lens, {what}, {mesh} mesh", known, value, limit)

    s, k = _extrapolated(found)
    checks = [
        check(f"{n:g}", f"K at S = {n:g}", dish_curvature(n), float(found[n].mean()), 0.01)
        for n in DISHES
    ]
    checks += [
        check("S", "S at the bifurcation", CRITICAL_S, s, 0.01),
        check("K", "K at the bifurcation", CRITICAL_K, k, 0.01),
    ]
    for n in PIPES:
        checks += [
            check(f"product-{n:g}", f"Kx Ky at S = {n:g}", PRODUCT, float(found[n].prod()), 0.02),
            check(f"roll-{n:g}", f"Kx at S = {n:g}", pipe_curvatures(n)[0], found[n][0], 0.01),
        ]
    limit = float(found[THIN][0]) / THIN
    return [*checks, check("thin", f"Kx/S at S = {THIN:g}", 1.0 + POISSON, limit, 0.01)]


def _disc_checks(mesh: str, found: dict[float, Floats], pipes: dict[float, Floats]) -> list[Check]:
    checks = []
    for n in (*DISHES, *PIPES):
        known = pipes[n] if n in pipes else [dish(n, POISSON).curvature]
        for name, k, ours in zip(("Kx", "Ky"), known, found[n], strict=False):
            text = name if n in pipes else "K"
            value = float(ours if n in pipes else found[n].mean())
            what = f"disc, {text} at S = {n:g}, {mesh} mesh"
            checks.append(Check(f"disc-{mesh}-{text}-{n:g}", what, float(k), value, 0.01))
    return checks


def _branch(
    rings: int, lens: bool, irregular: float, naturals: tuple[float, ...]
) -> dict[float, Floats]:
    """(Kx, Ky) at these S, on a quarter: a dish as long as that is stable, then a half-pipe."""
    sheet = DiscSheet.of(rings, naturals[-1], lens=lens, quarter=True, irregular=irregular)
    x, found = sheet.problem.start, {}
    for s in naturals:
        x = sheet.settled(s, sheet.saddled(x) if s == PIPES[0] else x)
        found[s] = sheet.curvatures(x)
    return found


def _extrapolated(found: dict[float, Floats]) -> tuple[float, float]:
    """S and K where (Kx − Ky)² of the first two half-pipes, as a line over S², is zero."""
    (s1, s2), (d1, d2) = PIPES[:2], (np.ptp(found[s]) ** 2 for s in PIPES[:2])
    square = s1 * s1 - d1 * (s2 * s2 - s1 * s1) / (d2 - d1)
    mean = [0.5 * found[s].sum() / s for s in PIPES[:2]]
    critical = float(np.sqrt(square))
    return critical, float(mean[0] + (mean[0] - mean[1]) * (s1 - critical) / (s2 - s1)) * critical


def _bifurcation(rings: int) -> tuple[float, float]:
    """S and K at the bifurcation of a whole disc of constant thickness."""
    sheet = DiscSheet.of(rings, 2.0, lens=False, quarter=False)
    found = sheet.first_bifurcation([0.1 * step for step in range(1, 17)])
    return found.ramp * sheet.most, float(sheet.curvatures(found.x).mean())


def _plot(
    lenses: dict[str, dict[float, Floats]],
    discs: dict[str, dict[float, Floats]],
    rolled: dict[float, Floats],
) -> Plot:
    before = np.linspace(0.0, PIPES[-1], 60)
    after = CRITICAL_S + (PIPES[-1] - CRITICAL_S) * np.linspace(0.0, 1.0, 80) ** 2
    pipes = np.array([pipe_curvatures(s * (1.0 + 1e-12)) for s in after])
    dishes = np.array([dish(s, POISSON).curvature for s in before])
    curves = [
        Curve("dish", before, np.array([dish_curvature(s) for s in before]), "line"),
        Curve("half-pipe, along", after, pipes[:, 0], "line"),
        Curve("half-pipe, across", after, pipes[:, 1], "line"),
        Curve("constant thickness: dish", before, dishes, "dashes"),
    ]
    for k, text in enumerate(("along", "across")):
        found = np.array([rolled[s][k] for s in PIPES])
        curves.append(Curve(f"constant thickness: {text}", np.array(PIPES), found, "dashes"))
    for text, kinds in (("lens", lenses), ("disc", discs)):
        for mesh, states in kinds.items():
            shown = [s for s in states if s <= PIPES[-1]]
            points = np.array([[s, k] for s in shown for k in states[s]])
            curves.append(Curve(f"{text}, {mesh}", points[:, 0], points[:, 1]))
    return Plot("bistable_disc", "Bistable disc", "S = κ0 R²/4h", "K = κ R²/4h", tuple(curves))


def _note(exact_s: float, exact_k: float, rolled: dict[float, Floats]) -> str:
    off = [100.0 * (rolled[s].prod() / PRODUCT - 1.0) for s in PIPES]
    sums = [100.0 * (rolled[s].sum() / ((1.0 + POISSON) * s) - 1.0) for s in PIPES]
    return (
        "A disc of constant thickness has a layer at its rim in which its curvature falls off. "
        f"Plate theory puts its bifurcation at S = {exact_s:.4f} and K = {exact_k:.4f}, where "
        f"the formulas say {CRITICAL_S:.4f} and {CRITICAL_K:.4f}: "
        f"{100 * (exact_s / CRITICAL_S - 1):+.1f} % and "
        f"{100 * (exact_k / CRITICAL_K - 1):+.1f} %. Beyond, at S = "
        f"{', '.join(f'{s:g}' for s in PIPES)}, it differs from them by "
        f"{', '.join(f'{x:+.1f}' for x in off)} % in Kx Ky and "
        f"{', '.join(f'{x:+.1f}' for x in sums)} % in Kx + Ky. So far the formulas are off for "
        "constant thickness; the model's disc follows plate theory."
    )
