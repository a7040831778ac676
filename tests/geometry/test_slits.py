"""Slits: the mesh follows them exactly and opens along them."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import affinity

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.generate import generate_mesh
from sheetmorph.geometry.slits import open_slits
from sheetmorph.geometry.topology import build_mesh

SHEET = shapely.box(-0.05, -0.05, 0.05, 0.05)
HOLED = SHEET - shapely.Point(0, 0).buffer(0.012, 32)
NOTHING = shapely.Polygon()
SIZE = 3e-3


def lines(*courses):
    return affinity.scale(shapely.MultiLineString(courses), 1e-3, 1e-3, origin=(0, 0))


def opened_grid(slits, cells=6):
    """Nodes and triangles of a grid of unit squares, opened."""
    x, y = np.meshgrid(np.arange(cells + 1.0), np.arange(cells + 1.0))
    nodes = np.column_stack([x.ravel(), y.ravel()])
    row = cells + 1
    low = (np.arange(cells)[:, None] * row + np.arange(cells)).ravel()
    a, b, c, d = low, low + 1, low + row + 1, low + row
    triangles = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return len(nodes), *open_slits(nodes, triangles, shapely.MultiLineString(slits))


# slits on the grid, how often their nodes are repeated
OPENED = {
    "inside": ([[(1, 2), (5, 2)]], {(2, 2): 2, (3, 2): 2, (4, 2): 2}),
    "from the rim": ([[(0, 2), (3, 2)]], {(0, 2): 2, (1, 2): 2, (2, 2): 2}),
    "cross": ([[(2, 3), (4, 3)], [(3, 2), (3, 4)]], {(3, 3): 4}),
    "tee": ([[(2, 3), (4, 3)], [(3, 3), (3, 5)]], {(3, 3): 3, (3, 4): 2}),
    "corner": ([[(2, 4), (2, 2), (4, 2)]], {(2, 3): 2, (2, 2): 2, (3, 2): 2}),
    "diagonal": ([[(1, 1), (3, 3)]], {(2, 2): 2}),
    "one edge": ([[(1, 1), (2, 1)]], {}),
    "across no edge": ([[(1.5, 1), (1.5, 3)]], {}),
    "none": ([], {}),
}


@pytest.mark.parametrize("name", OPENED)
def test_nodes_are_repeated(name):
    slits, expected = OPENED[name]
    count, nodes, triangles = opened_grid(slits)
    places, repeats = np.unique(nodes, axis=0, return_counts=True)
    found = {tuple(p): n for p, n in zip(places.tolist(), repeats.tolist(), strict=True) if n > 1}
    assert found == expected
    assert np.array_equal(nodes[:count], opened_grid([])[1])
    assert len(np.unique(triangles)) == len(nodes)
    mesh = build_mesh(nodes, triangles)
    assert mesh.triangle_areas.sum() == 36.0
    if slits and expected:
        assert not shapely.dwithin(
            shapely.MultiLineString(slits), shapely.points(middles(mesh)), 1e-9
        ).any()


def middles(mesh):
    """Midpoints of the hinges."""
    return mesh.edge_midpoints[mesh.hinge_edges[:, 0]]


SLITS = {
    "inside": (SHEET, lines([(-30, 10), (30, 10)]), 1),
    "cross": (SHEET, lines([(-30, 0), (30, 0)], [(0, -30), (0, 30)]), 1),
    "many": (
        SHEET,
        lines(*[[(x, y), (x + 18, y)] for x in (-42, -12, 18) for y in range(-40, 45, 10)]), 27,
    ),
    "from the rim": (SHEET, lines([(-50, 20), (10, 20)]), 0),
    "nearly from the rim": (SHEET, lines([(-49.99, 20), (10, 20)]), 0),
    "a little over the rim": (SHEET, lines([(-50.02, 20), (10, 20)]), 0),
    "from rim to hole": (HOLED, lines([(0, 10), (0, 50)]) & HOLED, 0),
    "beside a hole": (HOLED, lines([(20, -50), (20, 40)]), 0),
    "arc": (SHEET, shapely.Point(0, 0).buffer(0.03, 64).exterior & shapely.box(0, -1, 1, 0.02), 1),
    "zigzag": (SHEET, lines([(-30, 0), (-15, 20), (0, 0), (15, 20), (30, 0)]), 1),
    "short": (SHEET, lines([(0, 0), (1.8, 0)]), 1),
}  # fmt: skip


@pytest.mark.parametrize("name", SLITS)
def test_the_mesh_opens(name):
    outline, slits, holes = SLITS[name]
    holes += len(outline.interiors) - (name == "from rim to hole")
    closed = generate_mesh(outline, NOTHING, SIZE, slits=slits, open_slits=False)
    mesh = generate_mesh(outline, NOTHING, SIZE, slits=slits)
    assert np.array_equal(mesh.nodes[: len(closed.nodes)], closed.nodes)
    assert len(mesh.triangles) == len(closed.triangles)
    along = shapely.dwithin(slits, shapely.points(closed.edge_midpoints), 0.06 * SIZE)
    along &= shapely.dwithin(slits, shapely.points(closed.nodes[closed.edges, :2]), 5e-5).all(1)
    assert closed.edge_lengths[along].sum() == pytest.approx(slits.length, rel=2e-3)
    # No hinge spans a slit, each of whose edges is there twice.
    assert not shapely.dwithin(slits, shapely.points(middles(mesh)), 0.2e-3).any()
    assert len(mesh.edges) - len(closed.edges) == along.sum()
    nodes, edges, triangles = mesh.counts
    assert nodes - edges + triangles == 1 - holes
    assert np.degrees(mesh.minimum_angles.min()) > (15.0 if name == "short" else 30.0)
    assert mesh.mean_edge_length == pytest.approx(SIZE, rel=0.06)


def test_slits_cross_the_pattern_and_grade_the_mesh():
    pattern = shapely.box(-0.02, -0.05, 0.0, 0.05)
    slits = lines([(-35, 10), (35, 14)], [(-10, -30), (-10, -10)], [(0, -40), (0, -20)])
    mesh = generate_mesh(SHEET, pattern, 5e-3, slits=slits, boundary_size=1.5e-3)
    inside = shapely.contains_xy(pattern, *mesh.triangle_centroids.T)
    assert mesh.triangle_areas[inside].sum() == pytest.approx(pattern.area, rel=1e-6)
    assert np.degrees(mesh.minimum_angles.min()) > 28.0
    near = shapely.dwithin(slits, shapely.points(mesh.edge_midpoints), 1e-7)
    assert np.median(mesh.edge_lengths[near]) == pytest.approx(1.5e-3, rel=0.2)
    nodes, edges, triangles = mesh.counts
    assert nodes - edges + triangles == 1 - 3


def test_a_mesh_that_was_turned_opens_by_position():
    slits = lines([(-30, 5), (30, 5)], [(0, -20), (0, 20)])
    closed = generate_mesh(SHEET, NOTHING, SIZE, slits=slits, open_slits=False)
    mesh = generate_mesh(SHEET, NOTHING, SIZE, slits=slits)
    turn = np.array([[np.cos(1.0), np.sin(1.0)], [-np.sin(1.0), np.cos(1.0)]])
    nodes, triangles = open_slits(
        closed.nodes[:, :2] @ turn, closed.triangles, shapely.transform(slits, lambda xy: xy @ turn)
    )
    assert np.array_equal(triangles, mesh.triangles)
    np.testing.assert_allclose(nodes, mesh.nodes[:, :2] @ turn, atol=1e-15)


def test_two_halves_open_at_the_slit_between_them_alone():
    """A wedge whose slit lies on its locked side: the other half opens it."""
    half = shapely.box(0, -0.05, 0.05, 0.05)
    slits = lines([(0, -20), (0, 20)], [(10, 30), (40, 30)])
    part = generate_mesh(
        half, NOTHING, SIZE, slits=slits, open_slits=False, locked=lines([(0, -50), (0, 50)])
    )
    xy, count = part.nodes[:, :2], len(part.nodes)
    on_axis = np.abs(xy[:, 0]) < 1e-12
    number = np.where(on_axis, np.arange(count), count + np.cumsum(~on_axis) - 1)
    nodes = np.concatenate([xy, xy[~on_axis] * [-1, 1]])
    triangles = np.concatenate([part.triangles, number[part.triangles][:, ::-1]])
    both = shapely.union(slits, affinity.scale(slits, -1, 1, origin=(0, 0)))
    mesh = build_mesh(*open_slits(nodes, triangles, both))
    assert mesh.counts[0] - mesh.counts[1] + mesh.counts[2] == 1 - 3


# slits, what the message says
BAD = {
    "no lines": (SHEET, "slits must be a line or lines"),
    "not finite": (shapely.LineString([(0, 0), (np.inf, 0)]), "not a finite number"),
    "outside": (lines([(0, 0), (60, 0)]), r"a slit reaches outside the sheet near \(5"),
    "far outside": (lines([(60, 0), (70, 0)]), r"outside the sheet near \(6"),
    "too short": (lines([(10, 5), (10.5, 5)]), r"only 0.5 mm long near \(1.*at least 0.9 mm"),
    "ends too close": (lines([(-20, 7), (0, 7)], [(0.4, 7), (20, 7)]), r"too close .*\(0, 7\) mm"),
    "tip beside the rim": (lines([(0, 0), (49.5, 0)]), r"ends too close .*\(49.5, 0\) mm"),
    "parallel": (lines([(-20, 0), (20, 0)], [(-20, 0.8), (20, 0.8)]), "too close"),
    "along the rim": (lines([(-50, -20), (-50, 20)]), "runs along the rim"),
    "two pieces": (lines([(-50, 10), (50, 10)]), r"cut the sheet into separate pieces near \("),
    "loop": (lines([(0, 0), (20, 0), (20, 20), (0, 20), (0, 0)]), "separate pieces"),
    "stub": (lines([(0, -20), (0, 20)], [(-20, 0), (0.3, 0)]), "too close"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_slits_are_refused_in_one_line(name):
    slits, text = BAD[name]
    with pytest.raises(InputError, match=text) as caught:
        generate_mesh(SHEET, NOTHING, SIZE, slits=slits)
    assert "\n" not in str(caught.value)


def test_a_slit_beside_the_pattern():
    pattern = shapely.box(-0.02, -0.02, 0.02, 0.02)
    with pytest.raises(InputError, match="too close"):
        generate_mesh(SHEET, pattern, SIZE, slits=lines([(20.6, -15), (20.6, 15)]))
    mesh = generate_mesh(SHEET, pattern, SIZE, slits=lines([(20, -15), (20, 15)]))
    assert np.degrees(mesh.minimum_angles.min()) > 30.0
