"""A result that needs no solver: a disc with a three-armed pattern that becomes a dome."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from types import SimpleNamespace

import numpy as np
import pytest
import shapely

from sheetmorph.geometry.topology import build_mesh

SOURCE = """\
name = "dome"  # the <b>name</b> & more
model = "published"

[actuation]
eps_pre = -0.3
"""


@dataclass
class StandInDesign:
    """The attributes of a design that pictures and reports use."""

    name: str = "dome"
    model: str = "published"
    source: str = SOURCE
    eps_pre: float = -0.3
    outline: object = None
    pattern: object = None
    layers: tuple = field(
        default_factory=lambda: (
            SimpleNamespace(
                name="polystyrene",
                role="active",
                thickness=0.3e-3,
                young_modulus=1e6,
                poisson_ratio=0.33,
                where="everywhere",
            ),
            SimpleNamespace(
                name="PLA",
                role="inert",
                thickness=0.7e-3,
                young_modulus=3e6,
                poisson_ratio=0.33,
                where="pattern",
            ),
        )
    )

    def outline_polygon(self):
        return self.outline

    @property
    def layout(self):
        return SimpleNamespace(parts={"pattern": self.pattern})


@dataclass
class StandInResult:
    """The attributes of a result that pictures and reports use, computed here."""

    design: StandInDesign
    mesh: object
    positions: np.ndarray
    ramp: np.ndarray
    load_fraction: np.ndarray
    thermal_strain_full: np.ndarray
    edge_in_pattern: np.ndarray
    triangle_in_pattern: np.ndarray
    held_nodes: np.ndarray
    summary: dict
    motion: None = None

    @property
    def regions(self):
        film = SimpleNamespace(parts=(), area=shapely.Polygon(), stack=SimpleNamespace(face=0))
        pattern = SimpleNamespace(
            parts=("pattern",), area=self.design.pattern, stack=SimpleNamespace(face=1)
        )
        cell = self.triangle_in_pattern.astype(int)
        return SimpleNamespace(cells=(film, pattern), triangle_cell=cell)

    @property
    def status(self):
        return self.summary["status"]

    @property
    def actuation(self):
        return self.ramp * self.summary["eps_pre"]

    @cached_property
    def strain(self):
        ends = self.positions[:, self.mesh.edges]
        return np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2) / self.mesh.edge_lengths - 1

    @cached_property
    def dihedral(self):
        a, b, c, d = (self.positions[:, self.mesh.hinges[:, k]] for k in range(4))
        left, right = np.cross(b - a, c - a), np.cross(d - a, b - a)
        edge = (b - a) / np.linalg.norm(b - a, axis=2, keepdims=True)
        sine = (np.cross(left, right) * edge).sum(axis=2)
        return np.arctan2(sine, (left * right).sum(axis=2))

    @cached_property
    def aspect_ratio(self):
        span = np.ptp(self.positions, axis=1)
        return span[:, 2] / span[:, :2].max(axis=1)


def summary_of(positions, mesh, eps_pre, **changes):
    nodes, edges, triangles = mesh.counts
    span = np.ptp(positions[-1], axis=0)
    return {
        "status": "completed",
        "status_message": "The full actuation was reached.",
        "remedy": "",
        "stable": True,
        "negative_pivots": 0,
        "residual_max_N": 3.2e-12,
        "newton_iterations": 61,
        "factorisations": 70,
        "seconds": {
            "assembly": 0.41,
            "factorise": 0.62,
            "solve": 0.11,
            "total": 1.21,
            "wall": 1.34,
        },
        "solver": "mkl",
        "model": "published",
        "nodes": nodes,
        "edges": edges,
        "triangles": triangles,
        "height_m": float(span[2]),
        "bbox_m": span.tolist(),
        "aspect_ratio": float(span[2] / span[:2].max()),
        "energy_J": {"stretch": 1.2e-4, "bend": 3.4e-5, "load": 0.0, "total": 1.54e-4},
        "version": "0.1.0",
        "design_hash": "5f2c" * 16,
        "eps_pre": eps_pre,
    } | changes


def make_result(mesh, positions, ramp, load, pattern, design=None, eps_pre=-0.3, **summary):
    inside = shapely.contains_xy(pattern, mesh.edge_midpoints[:, 0], mesh.edge_midpoints[:, 1])
    centroids = mesh.triangle_centroids
    distance = shapely.distance(pattern, shapely.points(mesh.edge_midpoints))
    design = design or StandInDesign(eps_pre=eps_pre)
    design.pattern = pattern
    design.outline = shapely.convex_hull(shapely.multipoints(mesh.nodes[:, :2]))
    held = np.flatnonzero(np.linalg.norm(mesh.nodes[:, :2] - centroids.mean(0), axis=1) < 8e-3)
    return StandInResult(
        design=design,
        mesh=mesh,
        positions=positions,
        ramp=ramp,
        load_fraction=load,
        thermal_strain_full=eps_pre * np.where(inside, 0.0, distance / distance.max()),
        edge_in_pattern=inside,
        triangle_in_pattern=shapely.contains_xy(pattern, centroids[:, 0], centroids[:, 1]),
        held_nodes=held,
        summary=summary_of(positions, mesh, eps_pre, **summary),
    )


def disc_mesh(rings=7, radius=0.05):
    points, triangles = [(0.0, 0.0)], []
    first = [0]
    for ring in range(1, rings + 1):
        first.append(len(points))
        angles = 2 * np.pi * np.arange(6 * ring) / (6 * ring)
        points += [
            (radius * ring / rings * np.cos(a), radius * ring / rings * np.sin(a)) for a in angles
        ]
    for ring in range(1, rings + 1):
        for sector in range(6):
            for k in range(ring):
                outer = [first[ring] + (sector * ring + k + j) % (6 * ring) for j in (0, 1)]
                inside = max(6 * (ring - 1), 1)
                inner = [first[ring - 1] + (sector * (ring - 1) + k + j) % inside for j in (0, 1)]
                triangles.append((outer[0], outer[1], inner[0]))
                if k < ring - 1:
                    triangles.append((inner[0], outer[1], inner[1]))
    return build_mesh(np.array(points), np.array(triangles))


def three_arms(length=0.044, half_width=0.005):
    arm = shapely.box(-half_width, -half_width, length, half_width)
    turned = [shapely.affinity.rotate(arm, 120 * k + 90, origin=(0, 0)) for k in range(3)]
    return shapely.unary_union(turned)


def dome(mesh, states=6, height=0.03):
    ramp = np.linspace(0.0, 1.0, states)
    x, y = mesh.nodes[:, 0], mesh.nodes[:, 1]
    r2 = (x**2 + y**2) / (x**2 + y**2).max()
    wave = 1 + 0.35 * np.cos(3 * np.arctan2(y, x) + np.pi / 2)
    positions = np.array(
        [
            np.column_stack(
                [x * (1 - 0.25 * t * r2), y * (1 - 0.25 * t * r2), height * t**0.7 * r2 * wave]
            )
            for t in ramp
        ]
    )
    return positions, ramp


@pytest.fixture(scope="session")
def dome_result():
    mesh = disc_mesh()
    positions, ramp = dome(mesh)
    load = np.where(ramp < 1, 1.0, 0.0)
    return make_result(mesh, positions, ramp, load, three_arms())


@pytest.fixture
def build():
    """`make_result`, for tests that want a result of their own."""
    return make_result


@pytest.fixture
def small():
    """Mesh, positions, ramp and pattern of a small dome."""
    mesh = disc_mesh(3)
    return mesh, *dome(mesh), three_arms()
