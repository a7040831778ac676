from __future__ import annotations

import numpy as np
import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.topology import build_mesh

SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
TWO = [[0, 1, 2], [0, 2, 3]]


def test_edges_and_hinges_of_two_triangles():
    mesh = build_mesh(SQUARE, TWO)
    assert mesh.counts == (4, 5, 2)
    assert mesh.edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]
    assert mesh.hinges.tolist() == [[0, 2, 3, 1]]
    assert mesh.edges[mesh.hinge_edges[0]].tolist() == [[0, 2], [0, 3], [0, 1], [2, 3], [1, 2]]
    assert mesh.triangle_areas.sum() == 1.0
    assert mesh.node_areas.sum() == pytest.approx(1.0)
    assert np.degrees(mesh.minimum_angles) == pytest.approx([45.0, 45.0])


def test_edge_order_and_direction_are_kept():
    edges = [[3, 2], [2, 0], [1, 0], [0, 3], [2, 1]]
    mesh = build_mesh(SQUARE, TWO, edges)
    assert mesh.edges.tolist() == edges
    # Seen along 2→0, node 1 is on the left.
    assert mesh.hinges.tolist() == [[2, 0, 1, 3]]
    back = mesh.with_hinges_reversed(np.array([True]))
    assert back.hinges.tolist() == [[0, 2, 3, 1]]
    assert back.edges[1].tolist() == [0, 2]


def test_hinges_surround_their_edges(meshes):
    for mesh in meshes.values():
        a, b, c, d = (mesh.nodes[mesh.hinges[:, k], :2] for k in range(4))
        along = b - a
        for side, sign in ((c, 1.0), (d, -1.0)):
            off = side - a
            assert (sign * (along[:, 0] * off[:, 1] - along[:, 1] * off[:, 0]) > 0).all()
        for column, pair in enumerate([(0, 1), (0, 2), (0, 3), (1, 2), (1, 3)]):
            listed = np.sort(mesh.edges[mesh.hinge_edges[:, column]], axis=1)
            assert np.array_equal(listed, np.sort(mesh.hinges[:, list(pair)], axis=1))
        nodes, edges, triangles = mesh.counts
        assert nodes - edges + triangles == 1  # Euler: a disc
        assert 3 * triangles == edges + len(mesh.hinges)


# nodes, triangles, edges, what the message says
BAD = {
    "NaN node": ([[0, 0], [1, 0], [np.nan, 1]], [[0, 1, 2]], None, "node 2 .*not a finite"),
    "infinite node": ([[0, 0], [1, 0], [np.inf, 1]], [[0, 1, 2]], None, "node 2 .*not a finite"),
    "huge node": ([[0, 0], [1, 0], [1e200, 1]], [[0, 1, 2]], None, "node 2 .*far too large"),
    "not flat": (
        [[0, 0, 0], [1, 0, 0], [1, 1, 0.2], [0, 1, 0]], TWO, None, "not flat: node 2 is 0.2 m",
    ),
    "too few nodes": ([[0, 0], [1, 0]], [[0, 1, 1]], None, "at least 3 nodes"),
    "no triangles": (SQUARE, np.empty((0, 3), int), None, "at least one triangle"),
    "fractional corner": (SQUARE, [[0, 1, 2.5]], None, "whole numbers"),
    "flipped triangle": (SQUARE, [[0, 1, 2], [0, 3, 2]], None, "triangle 1 is flipped"),
    "degenerate triangle": (
        [[0, 0], [1, 0], [2, 0], [0, 1]], [[0, 2, 3], [0, 1, 2]], None, "triangle 1 is degenerate",
    ),
    "triangle with one node twice": (SQUARE, [[0, 1, 2], [0, 2, 2]], None, "degenerate"),
    "index out of range": (SQUARE, [[0, 1, 2], [0, 2, 4]], None, "triangle 1 refers to a node"),
    "negative index": (SQUARE, [[0, 1, 2], [0, 2, -1]], None, "triangle 1 refers to a node"),
    "unused node": ([*SQUARE, [5, 5]], TWO, None, "node 4 belongs to no triangle"),
    "three triangles on an edge": (
        [[0, 0], [1, 0], [0.5, 1], [0.5, 2], [0.5, -1]],
        [[0, 1, 2], [0, 1, 3], [1, 0, 4]], None, "edge 0–1 is not manifold",
    ),
    "two triangles on one side": (
        [[0, 0], [1, 0], [0.5, 1], [0.5, 2]], [[0, 1, 2], [0, 1, 3]], None, "overlap",
    ),
    "two pieces": (
        [*SQUARE, [5, 0], [6, 0], [5, 1]], [*TWO, [4, 5, 6]], None, "in 2 pieces",
    ),
    "missing edge": (SQUARE, TWO, [[0, 1], [1, 2], [2, 3], [3, 0]], "edge 0–2 is missing"),
    "edge twice": (
        SQUARE, TWO, [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2], [2, 0]], "listed more than once",
    ),
    "extra edge": (
        SQUARE, TWO, [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2], [1, 3]], "is no side of a triangle",
    ),
    "edge out of range": (SQUARE, TWO, [[0, 9]], "edge 0 refers to a node"),
    "edges of three": (SQUARE, TWO, [[0, 1, 2]], "pairs of node numbers"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_meshes_are_refused_in_one_line(name):
    nodes, triangles, edges, text = BAD[name]
    with pytest.raises(InputError, match=text) as caught:
        build_mesh(nodes, triangles, edges)
    assert "\n" not in str(caught.value)
