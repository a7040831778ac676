"""The laminate model on whole designs: what must not matter, and what must."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import sheetmorph as sm
from sheetmorph.geometry.topology import build_mesh
from sheetmorph.study.simulate import simulate

SHEET = """
name = "cross"
model = "laminate"
[outline]
kind = "rectangle"
width = "60 mm"
height = "60 mm"
[[pattern]]
kind = "star"
arms = 4
arm_length = "42 mm"
half_width = "4 mm"
rotation = "45 deg"
clip = true
[[layers]]
name = "film"
role = "active"
thickness = "0.3 mm"
young_modulus = "0.9 MPa"
poisson_ratio = 0.33
[[layers]]
name = "ribs"
role = "inert"
thickness = "0.8 mm"
young_modulus = "2.7 MPa"
poisson_ratio = 0.33
where = "pattern"
[actuation]
eps_pre = -0.3
under_pattern = 0.1
[mesh]
size = "5 mm"
"""


@pytest.fixture(scope="module")
def cross() -> sm.Result:
    return sm.simulate(sm.Design.from_toml(SHEET))


def distances(points: np.ndarray) -> np.ndarray:
    """Distances between all pairs: the shape, without its place."""
    return np.linalg.norm(points[:, None] - points[None], axis=2)


def test_it_completes_and_is_stable(cross: sm.Result) -> None:
    assert cross.status == "completed"
    assert cross.summary["stable"]
    assert cross.summary["aspect_ratio"] > 0.2


def test_numbering_does_not_matter(cross: sm.Result) -> None:
    """Other numbers of nodes, other first corners, other directions of edges: the same shape."""
    rng = np.random.default_rng(1)
    order = rng.permutation(len(cross.mesh.nodes)).astype(np.int32)
    nodes = np.empty_like(cross.mesh.nodes)
    nodes[order] = cross.mesh.nodes
    edges = order[cross.mesh.edges]
    turned = rng.random(len(edges)) < 0.5
    edges[turned] = edges[turned][:, ::-1]
    corners = order[cross.mesh.triangles]
    rolled = np.array([np.roll(t, rng.integers(3)) for t in corners])
    mesh = build_mesh(nodes, rolled, edges=edges)
    again = simulate(cross.design, mesh=mesh)
    assert again.status == "completed"
    ours, theirs = cross.positions[-1], again.positions[-1][order]
    assert np.abs(distances(ours) - distances(theirs)).max() < 1e-9


def test_the_shrinking_face_is_the_concave_one(cross: sm.Result) -> None:
    """Film below the ribs: the middle is up. Ribs below the film: the mirror image."""

    def rise(result: sm.Result) -> float:
        shape, plan = result.positions[-1], result.mesh.nodes
        middle = np.argmin((plan**2).sum(axis=1))
        return float(shape[middle, 2] - shape[np.argmax((plan**2).sum(axis=1)), 2])

    text = SHEET.replace('role = "active"', 'role = "x"')
    film, ribs = text.index("[[layers]]"), text.rindex("[[layers]]")
    end = text.index("[actuation]")
    swapped = text[:film] + text[ribs:end] + text[film:ribs] + text[end:]
    other = sm.simulate(sm.Design.from_toml(swapped.replace('role = "x"', 'role = "active"')))
    assert rise(cross) > 5e-3
    assert rise(other) == pytest.approx(-rise(cross), rel=1e-6)


def test_equal_layers_are_one_thick_layer() -> None:
    """Two layers of 0.15 mm, glued, are one of 0.3 mm."""
    one = sm.Design.from_toml(SHEET)
    half = SHEET.replace('thickness = "0.3 mm"', 'thickness = "0.15 mm"')
    start = half.index("[[layers]]")
    end = half.index("[[layers]]", start + 1)
    film = half[start:end]
    two = sm.Design.from_toml(half[:end] + film.replace('"film"', '"film 2"') + half[end:])
    assert len(two.layers) == 3
    shapes = [sm.simulate(design).positions[-1] for design in (one, two)]
    assert np.abs(shapes[0] - shapes[1]).max() < 1e-10


def test_a_bare_film_only_shrinks() -> None:
    """Free, uniform shrinkage costs nothing, and thickens what keeps its volume."""
    text = SHEET[: SHEET.index("[[pattern]]")] + SHEET[SHEET.index("[[layers]]") :]
    start = text.rindex("[[layers]]")
    text = text[:start] + text[text.index("[actuation]") :]
    text = text.replace("under_pattern = 0.1", 'profile = "uniform"')
    result = sm.simulate(sm.Design.from_toml(text))
    plan, shape = result.mesh.nodes[:, :2], result.positions[-1]
    np.testing.assert_allclose(distances(shape), 0.7 * distances(plan), atol=1e-9)
    assert abs(result.summary["energy_J"]["laminate"]) < 1e-12


def test_energy_densities_add_up(cross: sm.Result) -> None:
    """Stretching and bending, with what misfitting layers hold at rest, are the energy."""
    from sheetmorph.study.laminate_model import laminate_shell

    areas = cross.mesh.triangle_areas
    parts = (cross.stretch_energy_density[-1] + cross.bend_energy_density[-1]) @ areas
    floor = laminate_shell(cross.design, cross.mesh, cross.regions).at(1.0, 0.0).rest.floor.sum()
    assert (cross.bend_energy_density[-1] > -1e-9).all()
    assert floor > 0
    assert parts + floor == pytest.approx(cross.summary["energy_J"]["laminate"], rel=1e-9)


def test_a_result_is_kept_whole(cross: sm.Result, tmp_path: Path) -> None:
    cross.save(tmp_path)
    again = sm.Result.load(tmp_path)
    np.testing.assert_array_equal(again.scalars, cross.scalars)
    np.testing.assert_array_equal(again.bend_energy_density, cross.bend_energy_density)
    assert again.design.model == "laminate"


def test_refinement_converges() -> None:
    """Height over width on three meshes: the differences fall."""
    ratios = []
    for size in ("6 mm", "4 mm", "2.5 mm"):
        design = sm.Design.from_toml(SHEET).with_values({"mesh.size": size})
        ratios.append(sm.simulate(design).summary["aspect_ratio"])
    assert abs(ratios[2] - ratios[1]) < 0.5 * abs(ratios[1] - ratios[0])


def test_the_path_does_not_matter(cross: sm.Result) -> None:
    """The final state does not depend on the steps that led to it."""
    design = cross.design.with_values({"solver.max_step": 0.05, "solver.initial_step": 0.03})
    again = sm.simulate(design)
    assert again.summary["states"] > cross.summary["states"]
    np.testing.assert_allclose(again.positions[-1], cross.positions[-1], atol=1e-9)


def test_stops_are_states(cross: sm.Result) -> None:
    stops = (0.123, 0.5, 0.77)
    result = simulate(cross.design, stops=stops)
    for stop in stops:
        assert np.isclose(result.ramp, stop, atol=1e-12).any()
    np.testing.assert_allclose(result.positions[-1], cross.positions[-1], atol=1e-9)


def test_running_a_design_again_gives_the_same_bits(cross: sm.Result) -> None:
    again = simulate(cross.design)
    np.testing.assert_array_equal(again.positions, cross.positions)
