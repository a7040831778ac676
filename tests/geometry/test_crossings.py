"""Crossing triangles: against linear algebra pair by pair, and in shapes with known answers."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from sheetmorph.geometry.crossings import crossing_pairs
from sheetmorph.geometry.structured import rectangle


def pairs(nodes, triangles) -> list[tuple[int, int]]:
    found = crossing_pairs(np.array(nodes, dtype=float), np.array(triangles, dtype=np.int32))
    return [tuple(map(int, pair)) for pair in found]


def meets(start, end, triangle) -> bool:
    """Whether a segment passes through a triangle: three equations for three unknowns."""
    a, b, c = triangle
    try:
        t, u, v = np.linalg.solve(np.column_stack([start - end, b - a, c - a]), start - a)
    except np.linalg.LinAlgError:
        return False
    return bool(0 < t < 1 and u > 0 and v > 0 and u + v < 1)


def brute(nodes, triangles) -> list[tuple[int, int]]:
    found = []
    for i, j in combinations(range(len(triangles)), 2):
        crossed = False
        for mine, other in ((i, j), (j, i)):
            for p in range(3):
                ends = triangles[mine][[p, (p + 1) % 3]]
                if not set(ends) & set(triangles[other]):
                    crossed |= meets(*nodes[ends], nodes[triangles[other]])
        if crossed:
            found.append((i, j))
    return found


@pytest.mark.parametrize("seed", range(2))
def test_as_pair_by_pair_algebra(seed: int) -> None:
    rng = np.random.default_rng(seed)
    nodes = rng.uniform(size=(60, 3))
    triangles = np.array([rng.choice(60, 3, replace=False) for _ in range(60)], dtype=np.int32)
    expected = [
        (i, j) for i, j in brute(nodes, triangles) if len(set(triangles[i]) & set(triangles[j])) < 2
    ]
    assert len(expected) > 50
    assert pairs(nodes, triangles) == expected


UPRIGHT = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, -1], [0.2, 0.2, 1], [0.3, 0.3, 1]]


def test_a_triangle_through_another() -> None:
    assert pairs(UPRIGHT, [[0, 1, 2], [3, 4, 5]]) == [(0, 1)]


def test_touching_is_not_crossing() -> None:
    standing = np.array(UPRIGHT)
    standing[3, 2] = 0.0
    assert pairs(standing, [[0, 1, 2], [3, 4, 5]]) == []


def test_a_flat_sheet_does_not_cross_itself() -> None:
    mesh = rectangle(1.0, 1.0, 6, 6, "alternating")
    assert pairs(mesh.nodes, mesh.triangles) == []


def test_neighbours_at_a_corner_may_cross_and_at_an_edge_may_not() -> None:
    """The far sides of two triangles that meet at a corner; a fold alone is no crossing."""
    nodes = [[0, 0, 0], [1, -1, 0], [1, 1, 0], [1, 0, -1], [1, 0, 1]]
    nodes[3][0] = nodes[4][0] = 0.5
    assert pairs(nodes, [[0, 1, 2], [0, 3, 4]]) == [(0, 1)]
    fold = [[0, 0, 0], [1, 0, 0], [0, 1, 0.1], [0.1, 1, 0]]
    assert pairs(fold, [[0, 1, 2], [0, 1, 3]]) == []


def test_a_roll_of_more_than_a_turn_that_closes_on_itself() -> None:
    """A strip rolled to a circle overlaps from a full turn on; a spiral with the same turns not."""
    strip = rectangle(1.0, 0.1, 60, 4, "alternating")
    along, across = strip.nodes[:, 0] - strip.nodes[:, 0].min(), strip.nodes[:, 1]

    def rolled(turns: float, rise: float) -> int:
        radius = (1.0 - rise * along) / (2.0 * np.pi * turns)
        angle = 2.0 * np.pi * turns * along
        shape = np.column_stack([radius * np.sin(angle), across, radius * np.cos(angle)])
        return len(crossing_pairs(shape, strip.triangles))

    assert rolled(0.95, 0.0) == 0
    assert rolled(1.3, 0.0) > 10
    assert rolled(1.3, 0.4) == 0
