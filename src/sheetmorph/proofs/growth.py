"""Growth that varies over a sheet: caps, saddles and cones of known curvature."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from sheetmorph.core.files import write_text
from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.structured import disc
from sheetmorph.proofs.excess_cone import steepest_ray
from sheetmorph.proofs.proof import Check, Curve, Plot, Proof, convergence_order
from sheetmorph.proofs.sheets import QUARTER, solved
from sheetmorph.study.laminate_model import laminate_shell
from sheetmorph.study.model import build_problem
from sheetmorph.study.result import Result

RADIUS, THICKNESS = 20e-3, 0.1e-3
TABLE = "growth.csv"
DESIGN = f"""
name = "growth"
model = "laminate"
[outline]
kind = "disc"
radius = "{RADIUS} m"
[[layers]]
name = "sheet"
role = "active"
thickness = "{THICKNESS} m"
young_modulus = "1 MPa"
[actuation]
profile = "radial"
radial_profile = "{TABLE}"
[laminate]
thickening = "none"
[perturbation]
total_force = "1e-6 N"
{QUARTER}[mesh]
size = "2 mm"
[solver]
initial_step = 0.01
"""

MESHES = {"structured": 0.0, "irregular": 0.2}
RINGS, COARSER = 32, (16, 24)
"""Rings of triangles over the radius; coarser ones for the order."""
_SIZES = [1.0 / rings for rings in (*COARSER, RINGS)]
INNER = 0.7
"""Part of the radius that is measured; beyond, the bending of the rim is felt."""
BINS = np.linspace(0.0, INNER, 8)
CONES, EXCESS_CONES = (0.9, 0.7), (1.2,)
"""Growth around over growth along."""

Profile = Callable[[Floats], Floats]
"""Of the distance from the middle over the radius."""


@dataclass(frozen=True)
class Growth:
    """A metric λr² dr² + λθ² r² dθ² on a disc of radius 1.

    Attributes:
        title: for people.
        along, around: λr and λθ.
        curvature: Gaussian curvature, times R².
    """

    title: str
    along: Profile
    around: Profile
    curvature: Profile


def _conformal(sign: float) -> Growth:
    """λ = 1/(1 ± r²/4): the curvature ±1 everywhere."""

    def stretch(r: Floats) -> Floats:
        return 1.0 / (1.0 + 0.25 * sign * r * r)

    title = "cap, λ = 1/(1 + r²/4)" if sign > 0 else "saddle, λ = 1/(1 − r²/4)"
    return Growth(title, stretch, stretch, lambda r: np.full_like(r, sign))


def _rim(growth: float) -> Growth:
    """λr = 1, λθ = 1 + g r⁴: the curvature −(r λθ)″/(r λθ)."""
    return Growth(
        "rim growth, λθ = 1 + 0.15 r⁴",
        np.ones_like,
        lambda r: 1.0 + growth * r**4,
        lambda r: -20.0 * growth * r * r / (1.0 + growth * r**4),
    )


SHAPES = {"cap": _conformal(1.0), "saddle": _conformal(-1.0), "rim": _rim(0.15)}


def prove(reference: Path | None = None) -> Proof:
    """Gaussian curvatures, the radius of the cap, the angles of cones."""
    checks: list[Check] = []
    order, scatter = float("nan"), {}
    fine = np.linspace(0.0, INNER, 50)
    curves = [
        Curve(growth.title, fine, growth.curvature(fine), "line") for growth in SHAPES.values()
    ]
    middles = 0.5 * (BINS[1:] + BINS[:-1])
    for mesh, irregular in MESHES.items():
        points = []
        for name, growth in SHAPES.items():
            grown = _grown(growth, RINGS, irregular)
            known, found = _curvatures(grown, growth, BINS)
            points += list(zip(middles, found, strict=True))
            known, found = _curvatures(grown, growth, np.array([0.0, INNER]))
            what = f"K R² of the {name}, r < {INNER:g} R, {mesh} mesh"
            checks.append(Check(f"{name}-{mesh}", what, known[0], found[0], 0.02))
            if name == "cap":
                what = f"radius of the cap over R, {mesh} mesh"
                radius = _sphere_radius(grown) / RADIUS
                checks.append(Check(f"radius-{mesh}", what, 1.0, radius, 0.02))
                rough = [_scatter(_grown(growth, n, irregular)) for n in COARSER]
                scatter[mesh] = _scatter(grown)
                order = convergence_order(_SIZES, [*rough, scatter[mesh]])
        curves.append(Curve(f"{mesh} meshes", *np.array(points).T))
        for ratio in CONES:
            what = f"half the angle of the cone with λθ/λr = {ratio:g}, {mesh} mesh"
            half, angle = float(np.rad2deg(np.arcsin(ratio))), _cone_angle(ratio, irregular)
            checks.append(Check(f"cone-{mesh}-{ratio:g}", what, half, angle, 0.02, unit="°"))
        for ratio in EXCESS_CONES:
            what = f"height of the ridges over their length, λθ/λr = {ratio:g}, {mesh} mesh"
            known_height, height = steepest_ray(ratio), _ridge(ratio, irregular)
            checks.append(Check(f"cone-{mesh}-{ratio:g}", what, known_height, height, 0.02))
        what = f"order of convergence of the scatter of K, cap, {mesh} meshes"
        checks.append(Check(f"order-{mesh}", what, 1.0, order, kind="at least"))
    return Proof(
        name="growth",
        title="Growth metrics",
        statement=(
            "Discs of one layer, R/h = 200, that grow by tables over the distance r from their "
            "middle (in units of R here). A conformal factor λ = 1/(1 ± r²/4) gives the Gaussian "
            "curvature ±1/R² everywhere: a cap of a sphere of radius R, and a saddle. Growth of "
            "the rim, λθ = 1 + 0.15 r⁴, gives a saddle whose curvature is that of this metric. "
            "λθ < λr gives a cone of half the angle arcsin(λθ/λr); λθ > λr one with more than a "
            "turn around its tip, a saddle of straight rays whose directions run along a closed "
            "curve of least bending on the unit sphere. K is det b/det a of the triangles, "
            f"averaged by area; within {INNER:g} R, for a free rim bends away from its metric over "
            "a length of √(h R). The scatter is the standard deviation of K within half "
            f"the radius. Quarters of discs, {RINGS} rings of triangles."
        ),
        source="Gauss, Disquisitiones generales circa superficies curvas, 1827; Klein, Efrati, "
        "Sharon, Shaping of elastic sheets by prescription of non-Euclidean metrics, Science 315, "
        "2007; Müller, Ben Amar, Guven, Conical defects in growing sheets, Physical Review "
        "Letters 101, 2008",
        checks=tuple(checks),
        plots=(
            Plot("growth", "Gaussian curvature of grown discs", "r / R", "K R²", tuple(curves)),
        ),
        notes=(_note(scatter),),
    )


def _note(scatter: dict[str, float]) -> str:
    sag = RADIUS / (RINGS**2 * THICKNESS)
    parts = [f"{100 * value:.1f} % on the {mesh} mesh" for mesh, value in scatter.items()]
    return (
        f"In the cap K scatters from triangle to triangle by {' and '.join(parts)}. Sides of "
        "triangles are chords; where their sag, s² κ/8 for edges of the length s, is no longer "
        "small against the thickness, stretching moves the nodes off the smooth surface to suit "
        f"them. Here s² κ/h is {sag:.2g}; meshes for strongly curved thin sheets should keep it "
        "below 1."
    )


@dataclass(frozen=True, eq=False)
class _Grown:
    """A grown sheet, with the fundamental forms of its triangles."""

    result: Result
    first: Floats
    second: Floats

    @property
    def gaussian(self) -> Floats:
        """K R² of the triangles, shape (T,)."""
        return _determinant(self.second) / _determinant(self.first) * RADIUS**2

    @property
    def areas(self) -> Floats:
        """Of the grown triangles [m²], shape (T,)."""
        return self.result.mesh.triangle_areas * np.sqrt(_determinant(self.first))

    @property
    def places(self) -> Floats:
        """Distance of the triangles from the middle over R before they grew, shape (T,)."""
        return _distances(self.result.mesh.triangle_centroids)


def _grown(growth: Growth, rings: int, irregular: float) -> _Grown:
    r = np.linspace(0.0, 1.0, 201)
    rows = np.column_stack([r * RADIUS, growth.along(r) - 1.0, growth.around(r) - 1.0])
    lines = [", ".join(f"{value:.12g}" for value in row) for row in rows]
    mesh = disc(RADIUS, rings, quarter=True, irregular=irregular)
    with TemporaryDirectory() as folder:
        write_text(Path(folder) / TABLE, "\n".join(["r [m], e_radial, e_hoop", *lines, ""]))
        design = Design.from_toml(DESIGN, folder)
        result = solved(design, mesh=mesh)
        shell = laminate_shell(design, mesh, build_problem(design, mesh).regions)
    state = np.concatenate([result.positions[-1].ravel(), result.scalars[-1]])
    return _Grown(result, *shell.lamination.measures.forms(state, shell.patch))


def _curvatures(grown: _Grown, growth: Growth, bounds: Floats) -> tuple[Floats, Floats]:
    """Known and found K R² between these distances over R, averaged by area."""
    bins = np.digitize(grown.places, bounds) - 1
    inside = (bins >= 0) & (bins < len(bounds) - 1)

    def averaged(values: Floats) -> Floats:
        sums = np.bincount(bins[inside], (grown.areas * values)[inside])
        return np.asarray(sums / np.bincount(bins[inside], grown.areas[inside]))

    return averaged(growth.curvature(grown.places)), averaged(grown.gaussian)


def _scatter(grown: _Grown) -> float:
    """Standard deviation of K R² within half the radius."""
    inside = grown.places < 0.5
    weights, values = grown.areas[inside], grown.gaussian[inside]
    mean = np.average(values, weights=weights)
    return float(np.sqrt(np.average((values - mean) ** 2, weights=weights)))


def _sphere_radius(grown: _Grown) -> float:
    """Radius of the sphere that fits the inner nodes best [m]."""
    x = grown.result.positions[-1][_distances(grown.result.mesh.nodes) < INNER] / RADIUS
    system = np.column_stack([2.0 * x, np.ones(len(x))])
    *centre, rest = np.linalg.lstsq(system, (x**2).sum(axis=1), rcond=None)[0]
    return float(np.sqrt(rest + np.square(centre).sum())) * RADIUS


def _cone(ratio: float, irregular: float) -> Floats:
    """Distances over R of the nodes from 0.3 R to 0.7 R, and where they are, shape (n, 4)."""

    def around(r: Floats) -> Floats:
        return np.full_like(r, ratio)

    grown = _grown(Growth("cone", np.ones_like, around, np.zeros_like), COARSER[1], irregular)
    distance = _distances(grown.result.mesh.nodes)
    inside = (distance > 0.3) & (distance < INNER)
    return np.column_stack([distance, grown.result.positions[-1]])[inside]


def _cone_angle(ratio: float, irregular: float) -> float:
    """Angle between axis and surface [°]."""
    _, x, y, z = _cone(ratio, irregular).T
    slope = np.polyfit(np.hypot(x, y), z, 1)[0]
    return 90.0 - float(np.rad2deg(np.arctan(abs(slope))))


def _ridge(ratio: float, irregular: float) -> float:
    """Height of the highest ray, or depth of the lowest, over its length: their mean."""
    distance, _, _, z = _cone(ratio, irregular).T
    steepness = z / (RADIUS * distance)
    return 0.5 * float(np.ptp(steepness))


def _determinant(form: Floats) -> Floats:
    return np.asarray(form[:, 0] * form[:, 1] - form[:, 2] ** 2)


def _distances(points: Floats) -> Floats:
    return np.asarray(np.hypot(points[:, 0], points[:, 1]) / RADIUS)
