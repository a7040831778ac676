"""The designs of the paper on the released meshes: regions, stiffness, supports."""

from __future__ import annotations

import numpy as np
import pytest

from sheetmorph.design.actuation import edge_distance, thermal_strain
from sheetmorph.design.laminate import published_stiffness
from sheetmorph.design.regions import regions
from sheetmorph.design.spec import Design
from sheetmorph.design.supports import held_nodes, perturbation_forces
from sheetmorph.geometry.topology import build_mesh

SECTIONS = ("*shellNodes", "*FaceNodes", "*Edges")
NAMES = ("bowl", "canoe", "petals")


@pytest.fixture(scope="session")
def released(reference, examples):
    """Design and mesh by name, read without the loader of the program."""

    def read(name):
        rows: dict[str, list[list[float]]] = {}
        for line in (reference / f"{name}_mesh.txt").read_text("utf-8").splitlines():
            if line.startswith("*"):
                current = rows.setdefault(line.strip(), [])
            elif line.strip():
                current.append([float(cell) for cell in line.split(",")[1:]])
        nodes, faces, edges = (np.array(rows[section]) for section in SECTIONS)
        return (
            Design.load(examples / f"{name}.toml"),
            build_mesh(nodes, faces.astype(int), edges.astype(int)),
        )

    return {name: read(name) for name in NAMES}


def arms(points, centre, count, length, half_width, first=0.0):
    """Rays of the released pattern, in mm, by projection onto each arm."""
    q = points - centre
    inside = np.zeros(len(q), dtype=bool)
    for k in range(count):
        angle = first + 2 * np.pi * k / count
        along = q @ [np.cos(angle), np.sin(angle)]
        across = np.abs(q @ [-np.sin(angle), np.cos(angle)])
        inside |= (along >= 0) & (along <= length) & (across <= half_width)
    return inside


def in_pattern(name, points, centre):
    if name == "bowl":
        hub = np.linalg.norm(points - centre, axis=1) <= 2.9
        return arms(points, centre, 6, 44.1, 5.9) | hub
    if name == "petals":
        return arms(points, centre, 4, 70.7, 5.9, np.pi / 4)
    offset = np.array([27.87, 0])
    stars = [arms(points, centre + sign * offset, 6, 44.595, 2.787) for sign in (-1, 1)]
    q = np.abs(points - centre)
    return stars[0] | stars[1] | ((q[:, 0] <= 27.87) & (q[:, 1] <= 2.787))


@pytest.mark.parametrize(("name", "edges"), [("bowl", 999), ("canoe", 643), ("petals", 319)])
def test_regions_are_the_released_ones(released, name, edges):
    design, mesh = released[name]
    centre = 0.5e3 * (mesh.nodes[:, :2].min(axis=0) + mesh.nodes[:, :2].max(axis=0))
    region = regions(design, mesh)
    for points, got in (
        (mesh.edge_midpoints, region.edge_in_pattern),
        (mesh.triangle_centroids, region.triangle_in_pattern),
        (mesh.nodes[:, :2], region.node_in_pattern),
    ):
        assert np.array_equal(got, in_pattern(name, 1e3 * points, centre))
    assert region.edge_in_pattern.sum() == edges


@pytest.mark.parametrize(("name", "count"), [("bowl", 48), ("canoe", 21), ("petals", 8)])
def test_held_nodes_are_the_released_ones(released, name, count):
    design, mesh = released[name]
    plane = 1e3 * mesh.nodes[:, :2]
    centre = 0.5 * (plane.min(axis=0) + plane.max(axis=0))
    if name == "canoe":
        box = (plane >= [57.7, 45.8]).all(axis=1) & (plane <= [98.7, 53.8]).all(axis=1)
    else:
        box = (np.abs(plane - centre) <= 10).all(axis=1)
    if name != "bowl":
        box &= in_pattern(name, plane, centre)
    nodes = held_nodes(design, mesh, regions(design, mesh))
    assert np.array_equal(nodes, np.flatnonzero(box))
    assert len(nodes) == count


def test_petals_against_the_released_numbers(released, reference):
    design, mesh = released["petals"]
    region = regions(design, mesh)
    stiffness = published_stiffness(design, mesh, region)
    with np.load(reference / "petals_eps-0.30.npz") as data:
        assert np.array_equal(mesh.hinges, data["hinges"])
        assert stiffness.stretch_plain == pytest.approx(data["stretch_stiffness"], rel=1e-12)
        assert stiffness.bending == pytest.approx(data["bending_stiffness"], rel=1e-12)
        assert np.array_equal(held_nodes(design, mesh, region), data["held_nodes"])
    assert np.array_equal(stiffness.stretch, stiffness.stretch_plain * mesh.edge_lengths)


@pytest.mark.parametrize("name", NAMES)
def test_strain_and_load(released, name):
    design, mesh = released[name]
    region = regions(design, mesh)
    strain = thermal_strain(design, mesh, region)
    mid = mesh.edge_midpoints
    inside = region.edge_in_pattern
    gaps = np.linalg.norm(mid[~inside, None] - mid[None, inside], axis=2).min(axis=1)
    assert strain[~inside] == pytest.approx(design.eps_pre * gaps / gaps.max(), rel=1e-12)
    assert not strain[inside].any()
    assert edge_distance(design, mesh, region)[1] == pytest.approx(gaps.max(), rel=1e-12)
    assert (perturbation_forces(design, mesh) == [0, 0, 9.81e-7]).all()


@pytest.mark.parametrize(
    ("name", "counts"),
    [("bowl", (970, 2800, 1831)), ("canoe", (1215, 3505, 2291)), ("petals", (388, 1087, 700))],
)
def test_the_program_reads_these_meshes_in_their_order(released, name, counts):
    files = pytest.importorskip("sheetmorph.geometry.files", reason="the mesh reader is not here")
    assert files
    design, expected = released[name]
    mesh = design.build_mesh()
    assert mesh.counts == counts
    assert np.array_equal(mesh.nodes, expected.nodes)
    assert np.array_equal(mesh.edges, expected.edges)
    assert np.array_equal(mesh.hinges, expected.hinges)
    design.hash.encode("ascii")
