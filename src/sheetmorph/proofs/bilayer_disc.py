"""Discs of two layers that shrink and swell alike, of constant thickness or shaped like a lens."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sheetmorph.core.errors import ComputationError
from sheetmorph.design.spec import Design
from sheetmorph.energy.lamination import Lamination
from sheetmorph.energy.total import Total
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.geometry.structured import disc
from sheetmorph.proofs.sheets import QUARTER
from sheetmorph.solve.constraints import HeldDofs
from sheetmorph.solve.critical import Critical, first_critical, stationary
from sheetmorph.solve.linear import make_solver
from sheetmorph.solve.minimise import NewtonOptions, Outcome, minimise
from sheetmorph.solve.system import System
from sheetmorph.study.laminate_model import laminate_shell
from sheetmorph.study.model import Problem, build_problem

RADIUS, THICKNESS, POISSON = 50e-3, 0.125e-3, 0.33
LENS_UNIT = math.sqrt(2.0 * (7.0 + POISSON))
"""Takes the place of 4 in K = κ R²/(4 h) for a lens of the thickness h in its middle."""
LEVELS = 60
"""Thicknesses that triangles of a lens may have."""

DESIGN = f"""
name = "bilayer disc"
model = "laminate"
[outline]
kind = "disc"
radius = "{RADIUS} m"
[[layers]]
name = "lower"
role = "active"
thickness = "{THICKNESS / 2} m"
young_modulus = "1 MPa"
poisson_ratio = {POISSON}
[[layers]]
name = "upper"
role = "active"
thickness = "{THICKNESS / 2} m"
young_modulus = "1 MPa"
poisson_ratio = {POISSON}
eigenstrain_factor = -1
[actuation]
eps_pre = 0.001
profile = "uniform"
[perturbation]
total_force = "0 N"
[laminate]
thickening = "none"
[mesh]
size = "5 mm"
"""


@dataclass(frozen=True, eq=False)
class DiscSheet:
    """A disc, or a quarter of it, whose actuation goes up to S = κ0 R²/(4 h) = `most`.

    Attributes:
        problem: what is solved.
        system: the same with its solver.
        most: S at full actuation.
        unit: 4, or `LENS_UNIT`.
    """

    problem: Problem
    system: System
    most: float
    unit: float

    @classmethod
    def of(
        cls, rings: int, most: float, *, lens: bool, quarter: bool, irregular: float = 0.0
    ) -> DiscSheet:
        """A disc with so many rings of triangles, see `sheetmorph.geometry.structured.disc`."""
        unit = LENS_UNIT if lens else 4.0
        strain = unit * (THICKNESS / RADIUS) ** 2 * most / 3.0
        design = Design.from_toml(DESIGN + QUARTER * quarter)
        mesh = disc(RADIUS, rings, quarter=quarter, irregular=irregular)
        problem = build_problem(design.with_values({"actuation.eps_pre": strain}), mesh)
        if lens:
            problem = _as_lens(problem)
        pattern = problem.total.pattern
        held = HeldDofs.of(pattern, problem.held_dofs)
        solver = make_solver(pattern, design.solver.linear_solver, 1)
        return cls(problem, System(problem.total, held, solver), most, unit)

    def settled(self, natural: float, start: Floats) -> Floats:
        """The minimum at S = `natural` that lies downhill from a start, shape (n,).

        Raises:
            ComputationError: the search for it failed.
        """
        options = NewtonOptions(self.problem.residual_tolerance, max_iterations=300)
        found = minimise(self.system.at(natural / self.most, 0.0), start, options)
        if found.outcome is not Outcome.CONVERGED:
            raise ComputationError(f"bilayer disc at S = {natural:g}: {found.outcome}")
        return found.x

    def first_bifurcation(self, naturals: Sequence[float]) -> Critical:
        """Where the axisymmetric shape loses its stability, passing these values of S.

        Raises:
            ComputationError: it does not, or the path cannot be followed.
        """
        tolerance = self.problem.residual_tolerance
        found = first_critical(
            self.system,
            self.problem.start,
            [s / self.most for s in naturals],
            lambda system, guess: stationary(system, guess, tolerance),
            accuracy=1e-5,
        )
        if found is None:
            raise ComputationError("the bilayer disc stays stable")
        return found

    def saddled(self, x: Floats) -> Floats:
        """A state pushed by a fifth of the thickness towards a saddle."""
        nodes = self.problem.mesh.nodes / RADIUS
        pushed = x.copy()
        height = 0.2 * THICKNESS * (nodes[:, 0] ** 2 - nodes[:, 1] ** 2)
        pushed[2 : nodes.size : 3] += height
        return pushed

    def curvatures(self, x: Floats) -> Floats:
        """Kx ≥ Ky of the quadratic surface that fits a state best, in units of `unit` h/R².

        A fit of least squares to the nodes, each weighted by its share of the area.
        """
        mesh = self.problem.mesh
        places = self.problem.positions(x)
        share = np.zeros(len(places))
        np.add.at(share, mesh.triangles.ravel(), np.repeat(mesh.triangle_areas / 3.0, 3))
        along, across, height = places.T
        terms = [np.ones_like(along), 0.5 * along**2, 0.5 * across**2]
        if not len(self.problem.held_nodes):  # no quarter: it may lie askew
            terms += [along * across, along, across]
        weight = np.sqrt(share)
        fit = np.linalg.lstsq(np.column_stack(terms) * weight[:, None], height * weight, rcond=None)
        xx, yy, xy = (*fit[0], 0.0)[1:4]
        found = np.linalg.eigvalsh([[xx, xy], [xy, yy]])[::-1]
        return np.asarray(found * RADIUS**2 / (self.unit * THICKNESS))


def _as_lens(problem: Problem) -> Problem:
    """The same disc with a thickness of h (1 − r²/R²), and free strains in proportion.

    So its natural curvature is uniform. Thicknesses are those of the triangles' centroids.
    """
    mesh = problem.mesh
    shell = laminate_shell(problem.design, mesh, problem.regions)
    part = _thickness_shares(mesh)
    levels, cells = np.unique(np.round(LEVELS * part), return_inverse=True)
    plain: Lamination = shell.lamination
    layups = tuple(
        replace(plain.layups[0], thicknesses=plain.layups[0].thicknesses * part[cells == i].mean())
        for i in range(len(levels))
    )
    lamination = replace(
        plain, cells=cells, layups=layups, eigenstrains=plain.eigenstrains * part[:, None]
    )
    lens = type(shell).of(shell.patch, lamination)
    total = Total.of([lens], len(mesh.nodes), len(problem.model.held_scalars))
    return replace(problem, total=total)


def _thickness_shares(mesh: SheetMesh) -> Floats:
    radii = np.linalg.norm(mesh.triangle_centroids[:, :2], axis=1)
    return np.asarray(1.0 - (radii / RADIUS) ** 2)
