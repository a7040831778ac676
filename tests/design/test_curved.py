"""Designs on curved meshes: fit to the plan, supports, loads, strain in the triangles' frames."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from sheetmorph.core.errors import InputError
from sheetmorph.design.actuation import edge_eigenstrain, triangle_eigenstrain
from sheetmorph.design.check import describe
from sheetmorph.design.loads import load_forces
from sheetmorph.design.regions import regions
from sheetmorph.design.spec import Design
from sheetmorph.design.supports import directed_edges, held_components
from sheetmorph.geometry.files import write_mesh
from sheetmorph.geometry.structured import sphere_sector

HOLE = math.radians(18.0)
ARC = np.linspace(0.0, math.pi / 2, 41)


def quarter() -> str:
    rim = [[math.cos(a), math.sin(a)] for a in ARC]
    hole = [[math.sin(HOLE) * math.cos(a), math.sin(HOLE) * math.sin(a)] for a in ARC[::-1]]
    points = (10.0 * np.round([*rim, *hole], 12)).tolist()
    return f"""
name = "hemisphere"
model = "laminate"

[outline]
kind = "polygon"
unit = "m"
points = {points}

[[layers]]
name = "shell"
role = "inert"
thickness = "4 cm"
young_modulus = "68.25 MPa"
poisson_ratio = 0.3

[[supports]]
kind = "symmetry"
plane = "x"

[[supports]]
kind = "symmetry"
plane = "y"

[[supports]]
kind = "nodes"
nodes = [8]
hold = ["z"]

[[loads]]
kind = "point"
at = ["10 m", "0 m", "0 m"]
force = ["-200 N", "0 N", "0 N"]

[[loads]]
kind = "point"
at = ["0 m", "10 m"]
force = ["0 N", "200 N", "0 N"]

[mesh]
file = "dome.txt"
unit = "m"
curved = true
"""


@pytest.fixture
def folder(tmp_path):
    mesh = sphere_sector(10.0, (HOLE, math.pi / 2), (0.0, math.pi / 2), 8, 8)
    write_mesh(tmp_path / "dome.txt", mesh)
    return tmp_path


@pytest.fixture
def dome(folder):
    design = Design.from_toml(quarter(), folder)
    return design, design.build_mesh()


def test_the_quarter_hemisphere(dome):
    design, mesh = dome
    region = regions(design, mesh)
    assert mesh.counts[0] == 81
    held = held_components(design, mesh, region)
    assert np.array_equal(held[:, 0], np.abs(mesh.nodes[:, 0]) < 1e-9)
    assert np.array_equal(held[:, 1], np.abs(mesh.nodes[:, 1]) < 1e-9)
    assert np.flatnonzero(held[:, 2]).tolist() == [8]
    edges, conormal = directed_edges(design, mesh, region)
    assert len(edges) == 16
    on_x = np.abs(mesh.edge_midpoints[edges, 0]) < 1e-9
    assert np.array_equal(conormal, np.where(on_x[:, None], [-1.0, 0, 0], [0, -1.0, 0]))
    forces = load_forces(design, mesh, region)
    assert forces[8].tolist() == [-200.0, 0.0, 0.0]
    assert forces[80].tolist() == [0.0, 200.0, 0.0]
    assert np.count_nonzero(forces) == 2


def test_check_describes_it(dome):
    design, mesh = dome
    report = describe(design, mesh)
    assert report["directed_edges"] == 16
    directors = len(mesh.edges) - 16
    assert report["supports"]["free_dofs"] == 3 * 81 - 9 - 9 - 1 + directors
    assert report["mass"] == pytest.approx(1000 * 0.04 * mesh.triangle_areas.sum(), rel=1e-12)
    assert report["warnings"] == []


def test_a_clamped_edge_leaves_in_its_triangle(folder):
    text = quarter()
    start, end = text.index("[[supports]]"), text.index("[[loads]]")
    clamp = (
        '[[supports]]\nkind = "box"\nx = ["0 m", "10 m"]\ny = ["0 m", "10 m"]\n'
        'z = ["0 m", "0.1 m"]\nclamp = true\n'
    )
    design = Design.from_toml(text[:start] + clamp + text[end:], folder)
    mesh = design.build_mesh()
    held = held_components(design, mesh, regions(design, mesh))
    equator = mesh.nodes[:, 2] < 1e-9
    assert np.array_equal(held, np.tile(equator[:, None], 3))
    edges, conormal = directed_edges(design, mesh, regions(design, mesh))
    assert len(edges) == 8
    # Meridians end at the equator straight down; triangles lean by half their angle.
    lean = math.sin(0.5 * (math.pi / 2 - HOLE) / 8)
    assert conormal[:, 2] == pytest.approx(np.full(8, -math.sqrt(1 - lean**2)), abs=2e-3)
    along = np.diff(mesh.nodes[mesh.edges[edges]], axis=1)[:, 0]
    assert (along * conormal).sum(axis=1) == pytest.approx(np.zeros(8), abs=1e-12)


def test_weight_and_area_are_those_of_the_surface(folder):
    text = quarter().split("[[loads]]")[0] + '[[loads]]\nkind = "weight"\n'
    design = Design.from_toml(text + quarter()[quarter().index("[mesh]") :], folder)
    mesh = design.build_mesh()
    forces = load_forces(design, mesh, regions(design, mesh))
    assert forces.sum(axis=0) == pytest.approx(
        [0.0, 0.0, -9.80665 * 1000 * 0.04 * mesh.triangle_areas.sum()], rel=1e-12
    )


def test_main_directions_are_lifted_onto_the_surface(folder):
    text = quarter().replace('"inert"', '"active"').replace(
        "[mesh]",
        '[actuation]\neps_pre = -0.1\nprofile = "uniform"\ntransverse = 0.0\n'
        'direction = "radial"\n[mesh]',
    )  # fmt: skip
    design = Design.from_toml(text, folder)
    mesh = design.build_mesh()
    strain = triangle_eigenstrain(design, mesh, regions(design, mesh))
    assert strain[:, 0] + strain[:, 1] == pytest.approx(np.full(128, -0.1), rel=1e-12)
    # Meridians shrink, circles of latitude do not.
    along = edge_eigenstrain(mesh, strain)
    i = mesh.edges % 9
    hoop = i[:, 0] == i[:, 1]
    meridian = (mesh.edges // 9)[:, 0] == (mesh.edges // 9)[:, 1]
    assert np.abs(along[hoop]).max() < 5e-3
    assert np.abs(along[meridian] + 0.1).max() < 5e-3


@pytest.mark.parametrize(
    ("old", "new", "fragments"),
    [
        ("curved = true", "curved = false", ["not flat"]),
        ("curved = true", 'curved = "yes"', ["mesh.curved", "true or false"]),
        ('file = "dome.txt"\nunit = "m"', 'size = "1 m"', ["mesh.curved", "made is flat"]),
        ('unit = "m"\ncurved', 'unit = "mm"\ncurved', ["does not fit the outline"]),
        (
            'model = "laminate"',
            'model = "published"\n[actuation]\neps_pre = 0.1',
            ["belongs to the laminate model"],
        ),
    ],
)
def test_broken_curved_designs(folder, old, new, fragments):
    assert old in quarter()
    with pytest.raises(InputError) as caught:
        Design.from_toml(quarter().replace(old, new), folder).build_mesh()
    for fragment in fragments:
        assert fragment in str(caught.value)
    assert "\n" not in str(caught.value)


def test_curved_alone_is_refused_by_the_published_model(base):
    text = base.replace('size = "2 mm"', 'file = "a.txt"\ncurved = true')
    with pytest.raises(InputError, match=r"mesh\.curved: belongs to the laminate model"):
        Design.from_toml(text)


def test_the_pattern_lies_in_the_plan(folder):
    text = quarter().replace(
        "[[supports]]",
        '[[layers]]\nname = "patch"\nrole = "inert"\nthickness = "1 cm"\nyoung_modulus = "1 MPa"\n'
        'where = "pattern"\n[[pattern]]\nkind = "disc"\nradius = "4 m"\ncentre = ["4 m", "5 m"]\n'
        "clip = true\n[[supports]]",
        1,
    )  # fmt: skip
    design = Design.from_toml(text, folder)
    mesh = design.build_mesh()
    inside = regions(design, mesh).triangle_in_pattern
    disc = shapely.Point(4, 5).buffer(4)
    expected = shapely.contains_xy(disc, *mesh.triangle_centroids.T)
    assert np.array_equal(inside, expected)
    assert inside.any()
