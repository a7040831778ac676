"""The tree of boxes against libigl and against answers by hand."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import igl
import numpy as np
import pytest

from sheetmorph.compare import tree
from sheetmorph.compare.baselines import cap
from sheetmorph.compare.tree import CHUNK, Tree
from sheetmorph.geometry.mesh import Floats


def _soup(count: int, seed: int) -> tuple[Floats, np.ndarray]:
    """Triangles of all sizes and forms, some of them long or nearly without area."""
    random = np.random.default_rng(seed)
    middle = random.normal(size=(count, 1, 3))
    size = 10.0 ** random.uniform(-3.0, 0.0, size=(count, 1, 1))
    flat = 10.0 ** random.uniform(-4.0, 0.0, size=(count, 1, 3))
    corners = middle + size * flat * random.normal(size=(count, 3, 3))
    return corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


@pytest.mark.parametrize("count", [1, 2, 3, 5, 8, 9, 100, 1023, 3000])
def test_as_libigl_finds_it(count: int) -> None:
    points, triangles = _soup(count, count)
    queries = np.random.default_rng(1).normal(scale=1.5, size=(3000, 3))
    square, triangle, found = Tree.over(points, triangles).nearest(queries)
    expected, _, there = igl.point_mesh_squared_distance(queries, points, triangles)
    np.testing.assert_allclose(np.sqrt(square), np.sqrt(expected), rtol=0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(queries - found, axis=1), np.sqrt(square), atol=1e-14)
    np.testing.assert_allclose(found, there, atol=1e-6)
    # The triangle that is named holds the point.
    single = [igl.point_mesh_squared_distance(found[k : k + 1], points, triangles[[triangle[k]]])[0]
              for k in range(0, 3000, 50)]  # fmt: skip
    assert np.max(single) < 1e-24


def test_points_on_the_surface_and_far_away() -> None:
    surface = cap(1.0, 1.2)
    middle = surface.points[surface.triangles].mean(axis=1)
    assert surface.nearest(middle).distance.max() < 1e-15
    np.testing.assert_array_equal(surface.nearest(middle).triangle, np.arange(len(middle)))
    assert surface.nearest(surface.points).distance.max() < 1e-15
    away = np.array([[0.0, 0.0, 1e4]])
    np.testing.assert_allclose(surface.nearest(away).distance, 1e4, rtol=1e-15)
    assert len(surface.nearest(np.empty((0, 3))).distance) == 0


@pytest.mark.parametrize("height", [1e-3, 1e-6, 1e-9, 1e-11])
def test_triangles_that_are_nearly_lines(height: float) -> None:
    # Directions in the plane are known to the rounding over the height, or not at all.
    for third in ([0.5, height, 0.0], [1.0, height, 0.0]):
        points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], third])
        one = Tree.over(points, np.array([[0, 1, 2]]))
        shares = np.random.default_rng(0).dirichlet([1.0, 1.0, 1.0], size=200)
        on = shares @ points
        for above in (0.0, 1e-3, 0.7):
            square = one.nearest(on + np.array([0.0, 0.0, above]))[0]
            assert np.abs(np.sqrt(square) - above).max() <= min(height, 2e-16 / height) + 1e-15


def test_every_part_of_a_triangle() -> None:
    points = np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0]])
    one = Tree.over(points, np.array([[0, 1, 2]]))
    queries = np.array([[1.0, 1.0, 2.0], [-1.0, -1.0, 0.0], [6.0, 0.0, 0.0], [0.0, 5.0, 0.0],
                        [2.0, -3.0, 0.0], [-2.0, 1.0, 0.0], [5.0, 5.5, 0.0]])  # fmt: skip
    square, triangle, found = one.nearest(queries)
    np.testing.assert_allclose(np.sqrt(square), [2.0, np.sqrt(2.0), 2.0, 2.0, 3.0, 2.0, 5.0])
    expected = [[1, 1, 0], [0, 0, 0], [4, 0, 0], [0, 3, 0], [2, 0, 0], [0, 1, 0], [2, 1.5, 0]]
    np.testing.assert_allclose(found, expected, atol=1e-15)
    assert (triangle == 0).all()


def test_the_answer_does_not_depend_on_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    # On the axis of the cap and at its corners many triangles are equally near.
    surface = cap(1.0, 1.5)
    queries = np.concatenate([np.zeros((CHUNK, 3)), surface.points, 1.1 * surface.points] * 3)
    one = Tree.over(surface.points, surface.triangles)
    monkeypatch.setattr(tree.config, "NUMBA_NUM_THREADS", 1)
    alone = one.nearest(queries)
    monkeypatch.setattr(tree.config, "NUMBA_NUM_THREADS", 4)
    with ThreadPoolExecutor(4) as pool:
        monkeypatch.setattr(tree, "_threads", lambda: pool)
        together = one.nearest(queries)
    for first, second in zip(alone, together, strict=True):
        np.testing.assert_array_equal(first, second)
