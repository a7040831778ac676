"""A plain film whose shrinkage varies from place to place: the strain of every face is free."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from time import perf_counter

import numpy as np

from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.design.spec import Design
from sheetmorph.design.strain_field import field_text
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.geometry.surface import aspect_ratio
from sheetmorph.inverse.evaluations import Evaluations
from sheetmorph.inverse.families import FINE, FREE
from sheetmorph.inverse.flatten import Flattened
from sheetmorph.inverse.misfit import FAILED, Evaluation, Job, pose_numbers, pose_of
from sheetmorph.inverse.objective import apart
from sheetmorph.inverse.plans import mm
from sheetmorph.study.result import Result
from sheetmorph.study.sensitivity import sensitivities
from sheetmorph.study.simulate import simulate

FIELD = "field.csv"
LEAST = -0.80
"""Strongest shrinkage that is asked of the film."""
SMOOTH = 1e-5
"""Weight of the roughness of the field beside the squared distance, both without unit."""
ENOUGH = 1e-3
"""Distance, as a share of the size, at which the field is good enough."""
RIM_POINTS = 160


@dataclass(frozen=True, eq=False)
class GradedSheet:
    """A film with the outline of a flattened target; its designs differ in the strain of the faces.

    Attributes:
        target: the wanted surface [m].
        text: of the design, which names the file of the field.
        mesh: of all designs.
        first: strain of every face to begin with, that of the conformal map, shape (T,).
        run: simulates.
    """

    target: Surface
    text: str
    mesh: SheetMesh
    first: Floats
    run: Callable[..., Result] = field(default=simulate)

    def file(self, strain: Floats) -> bytes:
        """The file of a field: the strain of every face at its centroid."""
        places = self.mesh.triangle_centroids[:, :2]
        return field_text(places, strain, "free strain at the centroids of the mesh").encode()

    @contextmanager
    def design(self, strain: Floats) -> Iterator[Design]:
        """The design with a strain of every face, and its file for as long as the block lasts."""
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / FIELD).write_bytes(self.file(strain))
            yield Design.from_toml(self.text, folder)

    def evaluate(self, job: Job) -> Evaluation:
        """Simulate a field; its misfit is the objective, its residuals are the derivative of it.

        Raises:
            KeyboardInterrupt: the simulation was interrupted.
        """
        began = perf_counter()
        strain = np.array(job.point)
        rough, slope = self._roughness(strain)
        with self.design(strain) as design:
            try:
                result = self.run(design, mesh=self.mesh)
            except InputError:
                return Evaluation(FREE, job.point, 2.0 * FAILED, status="not_allowed")
            if result.status == "interrupted":
                raise KeyboardInterrupt
            try:
                value, by_face, pose = self._distance(result, job.near)
            except ComputationError:
                status = result.status if result.status != "completed" else "unstable"
                return Evaluation(FREE, job.point, FAILED, status=status)
        return Evaluation(
            FREE,
            job.point,
            value + rough,
            float(np.sqrt(value)),
            float(aspect_ratio(result.positions[-1])),
            pose_numbers(pose),
            seconds=perf_counter() - began,
            residuals=tuple((by_face + slope).tolist()),
        )

    def _distance(
        self, result: Result, near: tuple[float, ...]
    ) -> tuple[float, Floats, Similarity]:
        """Squared distance, its derivative by the strain of every face, and the pose."""
        poses: list[Similarity] = []

        def objective(positions: Floats) -> tuple[float, Floats]:
            found = apart(
                self.target, positions, self.mesh.triangles, pose_of(near) if near else None
            )
            poses.append(found.pose)
            return found.square, found.slope

        found = sensitivities(result, objective, fields={"eigenstrain"})
        by_strain = found.fields["eigenstrain"]
        if result.design.laminate:
            return found.value, by_strain[:, 0] + by_strain[:, 1], poses[0]
        # An edge has the mean of the triangles beside it.
        places = self.mesh.triangle_edges
        count = np.bincount(places.ravel(), minlength=len(self.mesh.edges))
        return found.value, (by_strain / count)[places].sum(axis=1), poses[0]

    def _roughness(self, strain: Floats) -> tuple[float, Floats]:
        """Mean squared difference of neighbouring faces, weighted, and its derivative."""
        pairs = self._neighbours
        step = strain[pairs[:, 0]] - strain[pairs[:, 1]]
        weight = SMOOTH * len(strain) / len(pairs)
        slope = np.zeros_like(strain)
        np.add.at(slope, pairs[:, 0], 2.0 * weight * step)
        np.add.at(slope, pairs[:, 1], -2.0 * weight * step)
        return float(weight * step @ step), slope

    @cached_property
    def _neighbours(self) -> np.ndarray:
        """Triangles that share an edge, shape (H, 2)."""
        places = self.mesh.triangle_edges
        order = np.argsort(places.ravel(), kind="stable")
        edges, faces = places.ravel()[order], np.repeat(np.arange(len(places)), 3)[order]
        same = np.flatnonzero(edges[1:] == edges[:-1])
        return np.column_stack([faces[same], faces[same + 1]])


def graded_sheet(
    target: Surface, flat: Flattened, name: str, overrides: Mapping[str, object]
) -> GradedSheet:
    """The film from which a target is made by shrinkage that is graded in space.

    Args:
        target: the wanted surface [m].
        flat: the same, laid flat.
        name: of the design.
        overrides: keys that are set, as for `Design.with_values`.
    """
    from scipy.interpolate import LinearNDInterpolator
    from scipy.spatial import cKDTree

    size = float(np.ptp(flat.plan, axis=0).max())
    text = _TEXT.format(name=name, points=polygon_text(outline_of(flat)), mesh=mm(size / FINE))
    plain = text.replace(_GRADED, "eps_pre = 0.0")
    mesh = Design.from_toml(plain).with_values(dict(overrides)).build_mesh()
    places = mesh.triangle_centroids[:, :2]
    strain = np.asarray(LinearNDInterpolator(flat.plan, flat.strain)(places))
    beyond = ~np.isfinite(strain)
    strain[beyond] = flat.strain[cKDTree(flat.plan).query(places[beyond])[1]]
    return GradedSheet(target, _set(text, overrides), mesh, np.clip(strain, LEAST, 0.0))


def outline_of(flat: Flattened) -> Floats:
    """The rim of a flattened surface, evenly divided [m], shape (n, 2)."""
    loop = flat.plan[flat.rim]
    closed = np.concatenate([loop, loop[:1]])
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1)))
    at = np.linspace(0.0, along[-1], RIM_POINTS, endpoint=False)
    return np.column_stack([np.interp(at, along, closed[:, k]) for k in range(2)])


def polygon_text(points: Floats) -> str:
    """Corners in millimetres, to a micrometre, as a list of a design file."""
    return "[" + ", ".join(f"[{1e3 * x:.3f}, {1e3 * y:.3f}]" for x, y in points.tolist()) + "]"


def optimise(
    evaluations: Evaluations, sheet: GradedSheet, steps: int, least: float = LEAST
) -> Evaluation:
    """Change the strain of every face until the film comes as close to the target as it can.

    L-BFGS-B (Byrd, Lu, Nocedal and Zhu 1995) on the squared distance and a little roughness; the
    derivatives are exact, by the adjoint method, and cost a fraction of a run.

    Args:
        evaluations: measure designs.
        sheet: the film.
        steps: iterations at most.
        least: strongest shrinkage allowed.

    Returns:
        The best of all.

    Raises:
        ComputationError: not even the first field could be computed.
    """
    from scipy.optimize import minimize

    begin = np.clip(sheet.first, least, 0.0)
    first = evaluations(Job(FREE, tuple(begin.tolist())))
    if not first.completed:
        raise ComputationError(
            f"the film did not reach its end ({first.status}); try a smaller target, or another "
            "family"
        )
    seen = [first]

    def objective(strain: Floats) -> tuple[float, Floats]:
        found = evaluations(Job(FREE, tuple(strain.tolist()), near=first.pose))
        seen.append(found)
        if not found.completed:
            return FAILED / first.misfit, np.zeros_like(strain)
        return found.misfit / first.misfit, np.array(found.residuals) / first.misfit

    def enough(_strain: Floats) -> None:
        if min(one.distance for one in seen if one.completed) < ENOUGH:
            raise StopIteration

    minimize(
        objective,
        begin,
        jac=True,
        method="L-BFGS-B",
        bounds=[(least, 0.0)] * len(begin),
        callback=enough,
        options={"maxiter": steps, "maxfun": 2 * steps, "ftol": 1e-3, "gtol": 1e-6},
    )
    return min((one for one in seen if one.completed), key=lambda one: one.misfit)


def _set(text: str, overrides: Mapping[str, object]) -> str:
    from sheetmorph.design.files import edit_design_text

    return edit_design_text(text, dict(overrides)) if overrides else text


_GRADED = f'profile = "field"\nfield = "{FIELD}"'
_TEXT = f"""name = "{{name}}"
model = "published"

[outline]
kind = "polygon"
unit = "mm"
points = {{points}}

[[layers]]
name = "polystyrene"
role = "active"
thickness = "0.3 mm"
young_modulus = "0.8911 MPa"
poisson_ratio = 0.33
density = "1050 kg/m^3"
where = "everywhere"

[actuation] # graded in space: heat, or ink that takes it up, where the table says
{_GRADED}

[published]
coupling = 0.0 # a film without ribs has no side to which it would bend

[perturbation] # a small load that makes the sheet leave its plane, gone at the end
shape = "bowl"
total_force = "0.95 mN"

[mesh]
size = {{mesh}}
"""
