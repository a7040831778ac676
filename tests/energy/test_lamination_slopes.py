"""Derivatives of the work of layered triangles, against differences of that work."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from sheetmorph.energy.laminate import LaminateShell
from sheetmorph.energy.laminate_patch import Patch
from sheetmorph.energy.laminate_rest_slopes import Motion, rest_slopes
from sheetmorph.energy.lamination import Lamination, Layup
from sheetmorph.energy.lamination_slopes import Layers, LayerSlopes, layer_slopes
from sheetmorph.energy.shape_measures import ShapeMeasures
from sheetmorph.geometry.mesh import SheetMesh
from sheetmorph.geometry.structured import rectangle


@dataclass(frozen=True, eq=False)
class Case:
    """A bent sheet of three layers, one of them here and there, in some state."""

    mesh: SheetMesh
    layers: Layers
    eigenstrains: np.ndarray
    x: np.ndarray
    motion: np.ndarray

    def patch(self) -> Patch:
        return Patch.of(self.mesh, director_length=0.3)

    def measures(self) -> ShapeMeasures:
        return ShapeMeasures.of(self.mesh.nodes, self.patch(), self.mesh.triangle_frames)

    def work(self) -> np.ndarray:
        """Work of every triangle along the motion, by the energy itself."""
        patch, layers = self.patch(), self.layers
        layup = Layup(
            layers.thicknesses,
            layers.young_moduli,
            layers.poisson_ratios,
            layers.factors,
            layers.anchors,
        )
        cells = np.zeros(len(self.mesh.triangles), dtype=np.intp)
        lamination = Lamination(
            self.measures(), cells, (layup,), self.eigenstrains, layers.thickening
        )
        shell = LaminateShell.of(patch, lamination).at(1.0, 0.0)
        moved = Motion.of(patch, self.x, self.motion)
        strain = moved.measures - shell.rest.natural
        return np.einsum("ti,tij,tj->t", moved.change, shell.rest.stiffness, strain)

    def slopes(self) -> tuple[Motion, LayerSlopes]:
        measures, moved = self.measures(), Motion.of(self.patch(), self.x, self.motion)
        strain, change = (
            np.einsum("tij,tj->ti", measures.strain_maps, p) for p in (moved.measures, moved.change)
        )
        curvatures = measures.reference_curvatures
        return moved, layer_slopes(self.layers, self.eigenstrains, curvatures, strain, change)


@pytest.fixture(scope="module", params=[True, False], ids=["thickening", "thickness kept"])
def case(request: pytest.FixtureRequest) -> Case:
    rng = np.random.default_rng(7)
    flat = rectangle(1.0, 0.8, 4, 3)
    bent = flat.nodes.copy()
    bent[:, 2] = 0.2 * bent[:, 0] ** 2 + 0.1 * bent[:, 0] * bent[:, 1]
    mesh = replace(flat, nodes=bent)
    count = len(mesh.triangles)
    thicknesses = np.array([[0.03], [0.05], [0.04]]) * np.ones((3, count))
    thicknesses[2, ::2] = 0.0
    thicknesses[1] *= rng.uniform(0.5, 1.0, count)
    layers = Layers(
        thicknesses,
        np.array([1.0, 2.0, 3.0]),
        np.array([0.3, 0.2, 0.4]),
        np.array([1.0, 0.4, 0.0]),
        np.array([True, True, False]),
        np.array([True, True, False]),
        request.param,
    )
    rows = -(-len(mesh.edges) // 3)
    x = np.concatenate([mesh.nodes, np.zeros((rows, 3))]) + rng.normal(
        0.0, 0.01, (len(mesh.nodes) + rows, 3)
    )
    eigenstrains = rng.uniform(-0.3, 0.1, (count, 3)) * [1.0, 1.0, 0.4]
    return Case(mesh, layers, eigenstrains, x, rng.normal(0.0, 1.0, x.shape))


def difference(ahead: Case, behind: Case, step: float) -> np.ndarray:
    return (ahead.work() - behind.work()) / (2.0 * step)


@pytest.mark.parametrize("name", ["thickness", "young_modulus", "poisson_ratio"])
def test_by_what_the_layers_are(case: Case, name: str) -> None:
    """Triangle by triangle, where a layer is and where there is none yet."""
    _, slopes = case.slopes()
    areas = case.measures().areas
    plural = {"thickness": "thicknesses", "young_modulus": "young_moduli"}
    field = plural.get(name, "poisson_ratios")
    for layer in range(3):
        h = 1e-6
        ends = []
        for step in (h, -h):
            moved = getattr(case.layers, field).copy()
            moved[layer] += step
            ends.append(replace(case, layers=replace(case.layers, **{field: moved})))
        expected = difference(*ends, h)
        assert areas * getattr(slopes, name)[layer] == pytest.approx(
            expected, rel=1e-5, abs=1e-7 * np.abs(expected).max()
        )


def test_by_the_free_strains_and_their_factors(case: Case) -> None:
    _, slopes = case.slopes()
    areas, h = case.measures().areas, 1e-6
    for component in range(3):
        moved = np.zeros(3)
        moved[component] = h
        ends = [replace(case, eigenstrains=case.eigenstrains + s) for s in (moved, -moved)]
        expected = difference(*ends, h)
        assert areas * slopes.eigenstrain[:, component] == pytest.approx(expected, rel=1e-4)
    for layer in (0, 1):
        moved = np.zeros(3)
        moved[layer] = h
        ends = [
            replace(case, layers=replace(case.layers, factors=case.layers.factors + s))
            for s in (moved, -moved)
        ]
        expected = difference(*ends, h)
        assert areas * slopes.eigenstrain_factor[layer] == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("curved", [True, False])
def test_by_the_positions_at_rest(case: Case, curved: bool) -> None:
    """Lengths, areas, natural curvature and the middle normals of the sides all follow."""
    nodes = case.mesh.nodes * [1.0, 1.0, 1.0 if curved else 0.0]
    case = replace(case, mesh=replace(case.mesh, nodes=nodes))
    found = rest_slopes(case.mesh, case.patch(), *case.slopes())
    rng, h = np.random.default_rng(8), 1e-6
    for axes in ([1.0, 1.0, 0.0], [0.0, 0.0, 1.0]):
        motion = rng.normal(0.0, 1.0, nodes.shape) * axes
        ends = [replace(case, mesh=replace(case.mesh, nodes=nodes + s * motion)) for s in (h, -h)]
        expected = difference(*ends, h).sum()
        assert float((found * motion).sum()) == pytest.approx(expected, rel=1e-5)
