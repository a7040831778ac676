"""Regular meshes: counts, numbering, areas, and arguments out of range."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.structured import disc, rectangle, ring_sector, sphere_sector

EDGE = math.radians(18.0)


@pytest.mark.parametrize("pattern", ["right", "alternating"])
def test_rectangle(pattern):
    mesh = rectangle(0.04, 0.02, 6, 4, pattern, centre=(0.01, 0.0))
    assert mesh.counts == (35, 82, 48)
    assert mesh.flat
    assert mesh.triangle_areas == pytest.approx(np.full(48, 0.04 * 0.02 / 48), rel=1e-12)
    node = mesh.nodes[3 * 7 + 2]  # column 2, row 3
    assert node == pytest.approx([0.01 - 0.02 + 2 * 0.04 / 6, -0.01 + 3 * 0.005, 0.0])


def test_patterns_differ_by_their_diagonals():
    right, turns = (rectangle(1.0, 1.0, 4, 4, pattern) for pattern in ("right", "alternating"))

    def diagonals(mesh):
        d = np.diff(mesh.nodes[mesh.edges, :2], axis=1)[:, 0]
        return np.sign(d[:, 0] * d[:, 1])

    assert np.bincount(diagonals(right).astype(int) + 1).tolist() == [0, 40, 16]
    assert np.bincount(diagonals(turns).astype(int) + 1).tolist() == [8, 40, 8]
    # As in a union jack, the middle node has eight neighbours.
    assert (turns.edges == 12).sum() == 8


def test_irregular_meshes_keep_their_rim():
    plain = rectangle(2.0, 1.0, 10, 8)
    mesh = rectangle(2.0, 1.0, 10, 8, irregular=0.24, seed=3)
    assert mesh.triangle_areas.sum() == pytest.approx(2.0, rel=1e-12)
    assert mesh.triangle_areas.min() > 0
    for axis, extreme in ((0, 1.0), (1, 0.5)):
        rim = np.abs(plain.nodes[:, axis]) == extreme
        assert np.array_equal(mesh.nodes[rim, axis], plain.nodes[rim, axis])
    moved = np.abs(mesh.nodes - plain.nodes)[:, :2] / [0.2, 0.125]
    assert 0.2 < moved.max() <= 0.24
    assert np.array_equal(rectangle(2.0, 1.0, 10, 8, irregular=0.24, seed=3).nodes, mesh.nodes)
    assert (rectangle(2.0, 1.0, 10, 8, irregular=0.24, seed=4).nodes != mesh.nodes).any()


@pytest.mark.parametrize("irregular", [0.0, 0.24])
def test_disc(irregular):
    mesh = disc(2.0, 5, irregular=irregular, seed=1)
    assert mesh.counts == (91, 240, 150)
    assert mesh.triangle_areas.min() > 0
    radii = np.hypot(*mesh.nodes[:, :2].T)
    assert radii[-30:] == pytest.approx(np.full(30, 2.0), rel=1e-12)
    assert len(mesh.rim_edges) == 30
    assert np.array_equal(mesh.nodes[0], [0.0, 0.0, 0.0])


@pytest.mark.parametrize("irregular", [0.0, 0.24])
def test_a_quarter_of_a_disc(irregular):
    mesh = disc(2.0, 5, quarter=True, irregular=irregular, seed=1)
    assert mesh.counts == (36, 85, 50)
    assert mesh.triangle_areas.min() > 0
    assert len(mesh.rim_edges) == 10 + 2 * 5
    x, y, _ = mesh.nodes.T
    assert (np.abs(x) < 1e-12).sum() == (np.abs(y) < 1e-12).sum() == 6
    assert min(x.min(), y.min()) > -1e-12
    assert np.hypot(x, y)[-11:] == pytest.approx(np.full(11, 2.0), rel=1e-12)


def test_a_regular_disc_has_the_symmetry_of_a_hexagon():
    mesh = disc(2.0, 4)
    turn, cos, sin = np.eye(3), 0.5, math.sqrt(0.75)
    turn[:2, :2] = [[cos, -sin], [sin, cos]]
    edges = {tuple(sorted(edge)) for edge in mesh.edges.tolist()}
    for change in (turn, np.diag([1.0, -1.0, 1.0])):
        apart = np.linalg.norm(mesh.nodes[:, None] - mesh.nodes @ change, axis=2)
        image = apart.argmin(axis=1)
        assert apart.min(axis=1).max() < 1e-12
        assert {tuple(sorted(image[list(edge)])) for edge in edges} == edges


def test_a_whole_ring_is_slit():
    mesh = ring_sector(6.0, 10.0, 4, 40)
    assert mesh.counts[0] == 5 * 41
    first, last = mesh.nodes[:5], mesh.nodes[-5:]
    assert first == pytest.approx(last, abs=1e-12)
    assert len(mesh.rim_edges) == 2 * 40 + 2 * 4
    exact = 40 * 0.5 * math.sin(2 * math.pi / 40) * (100 - 36)  # of the inscribed polygons
    assert mesh.triangle_areas.sum() == pytest.approx(exact, rel=1e-12)


def test_a_ring_sector_lies_between_its_angles():
    mesh = ring_sector(1.0, 2.0, 2, 6, "alternating", start=0.5, end=1.5)
    angles = np.arctan2(mesh.nodes[:, 1], mesh.nodes[:, 0])
    assert angles.min() == pytest.approx(0.5)
    assert angles.max() == pytest.approx(1.5)
    angle = 0.5 + 2 / 6  # column 1, row 2
    expected = [1.5 * math.cos(angle), 1.5 * math.sin(angle), 0.0]
    assert mesh.nodes[2 * 3 + 1] == pytest.approx(expected)


@pytest.mark.parametrize("pattern", ["right", "alternating"])
def test_the_hemisphere_with_a_hole(pattern):
    errors = []
    for n in (8, 16):
        mesh = sphere_sector(10.0, (EDGE, math.pi / 2), (0.0, math.pi / 2), n, n, pattern)
        assert not mesh.flat
        assert np.linalg.norm(mesh.nodes, axis=1) == pytest.approx(np.full((n + 1) ** 2, 10.0))
        outward = (mesh.triangle_normals * mesh.nodes[mesh.triangles].mean(axis=1)).sum(axis=1)
        assert (outward > 9.0).all()
        exact = 100.0 * (math.pi / 2) * math.cos(EDGE)
        errors.append(1 - mesh.triangle_areas.sum() / exact)
        assert mesh.node_areas.sum() == pytest.approx(mesh.triangle_areas.sum(), rel=1e-12)
    assert errors[0] < 0.01
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)  # second order


def test_the_rim_and_its_triangles():
    mesh = rectangle(3.0, 2.0, 3, 2)
    ends = mesh.nodes[mesh.edges[mesh.rim_edges], :2]
    on_rim = (np.abs(ends[..., 0]) == 1.5).all(axis=1) | (np.abs(ends[..., 1]) == 1.0).all(axis=1)
    assert len(on_rim) == 10
    assert on_rim.all()
    for edge, triangle in zip(mesh.rim_edges, mesh.rim_triangles, strict=True):
        assert set(mesh.edges[edge]) <= set(mesh.triangles[triangle])


@pytest.mark.parametrize(
    ("make", "fragments"),
    [
        (lambda: rectangle(1.0, 0.0, 2, 2), ["height", "> 0"]),
        (lambda: rectangle(1.0, 1.0, 0, 2), ["(0, 2)", "≥ 1"]),
        (lambda: rectangle(1.0, 1.0, 2, 2, "left"), ["pattern", "right, alternating"]),
        (lambda: rectangle(1.0, 1.0, 2, 2, irregular=0.3), ["irregular", "0 to 0.24"]),
        (lambda: ring_sector(2.0, 1.0, 2, 2), ["outer", "> 0"]),
        (lambda: ring_sector(1.0, 2.0, 2, 9, end=7.0), ["end", "6.28319 rad"]),
        (lambda: sphere_sector(1.0, (0.0, 1.0), (0.0, 1.0), 2, 2), ["polar", "> 0"]),
        (lambda: sphere_sector(1.0, (0.5, 1.6), (0.0, 1.0), 2, 2), ["polar", "rad"]),
        (lambda: sphere_sector(1.0, (0.5, 1.0), (1.0, 1.0), 2, 2), ["azimuth", "above 0"]),
    ],
)
def test_arguments_out_of_range(make, fragments):
    with pytest.raises(InputError) as caught:
        make()
    for fragment in fragments:
        assert fragment in str(caught.value)
