"""The smeared indicator and the blended distance of a boundary."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from sheetmorph.design.boundary import Boundary

WIDTH = 0.8


@pytest.fixture(scope="module")
def region() -> shapely.Polygon:
    """A cross of two bars with a round hole, about ten long."""
    bar = shapely.box(-5, -1, 5, 1)
    cross = shapely.union(bar, shapely.affinity.rotate(bar, 70))
    return shapely.difference(cross, shapely.Point(0, 0).buffer(0.7, quad_segs=60))


@pytest.fixture(scope="module")
def points() -> np.ndarray:
    return np.random.default_rng(3).uniform(-6.0, 6.0, (2000, 2))


def test_the_indicator_is_the_mean_over_a_neighbourhood(
    region: shapely.Polygon, points: np.ndarray
) -> None:
    """Against a sum over 40,000 points of the weighted disc; 0 or 1 elsewhere."""
    found = Boundary.of(region).share(points, WIDTH)
    away = shapely.distance(shapely.points(points), region.boundary)
    inside = shapely.contains_xy(region, points)
    far = away > WIDTH / 2
    assert np.array_equal(found[far], inside[far].astype(float))
    grid = (np.arange(225) + 0.5) / 112.5 - 1.0
    disc = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    disc = disc[(disc**2).sum(axis=1) < 1.0] @ turn  # no side runs along a row
    weights = (1.0 - (disc**2).sum(axis=1)) ** 2
    near = np.flatnonzero(~far)[:12]
    for index in near:
        around = points[index] + 0.5 * WIDTH * disc
        mean = weights @ shapely.contains_xy(region, around) / weights.sum()
        assert found[index] == pytest.approx(mean, abs=2e-3)


def test_the_indicator_on_sides_and_corners() -> None:
    square = Boundary.of(shapely.box(0, 0, 1, 1))
    places = [[0.5, 0], [0.5, 1], [0, 0.5], [1, 0.5], [0, 0], [1, 1], [0.5, 0.5], [2, 0]]
    expected = [0.5, 0.5, 0.5, 0.5, 0.25, 0.25, 1.0, 0.0]
    assert square.share(np.array(places), 0.4) == pytest.approx(expected, abs=1e-9)


def test_the_distance_is_exact_where_one_side_is_near(
    region: shapely.Polygon, points: np.ndarray
) -> None:
    """Half of the points see one side alone; elsewhere it errs by a fraction of the width."""
    found = Boundary.of(region).away(points, WIDTH)
    away = shapely.distance(shapely.points(points), region.boundary)
    error = np.abs(found - away)[away > WIDTH / 2]
    assert np.median(error) < 0.01 * WIDTH
    assert error.max() < 0.2 * WIDTH
    side = Boundary.of(shapely.box(0, -100, 100, 100))
    distances = np.array([0.6, 2.0, 7.0])
    line = np.column_stack([-distances, np.zeros(3)])
    assert side.away(line, WIDTH) == pytest.approx(distances, rel=1e-12)


def test_a_small_width_gives_the_sharp_boundary(
    region: shapely.Polygon, points: np.ndarray
) -> None:
    edge = Boundary.of(region)
    away = shapely.distance(shapely.points(points), region.boundary)
    inside = shapely.contains_xy(region, points)
    assert np.array_equal(edge.share(points, 1e-6), inside.astype(float))
    assert edge.away(points, 1e-6) == pytest.approx(away, abs=1e-6)


def test_derivatives_by_the_corners(region: shapely.Polygon, points: np.ndarray) -> None:
    """Against central differences along a motion of all corners."""
    edge, rng = Boundary.of(region), np.random.default_rng(4)
    by_share, by_away = rng.standard_normal((2, len(points)))
    by_corner = edge.onto_corners(points, by_share, by_away, WIDTH)
    _, first = np.unique(edge.corners, axis=0, return_inverse=True)  # rings stay closed
    motion = rng.standard_normal((int(first.max()) + 1, 2))[first.ravel()]

    def total(step: float) -> float:
        moved = replace(edge, corners=edge.corners + step * motion)
        return by_share @ moved.share(points, WIDTH) + by_away @ moved.away(points, WIDTH)

    h = 1e-6
    expected = (total(h) - total(-h)) / (2.0 * h)
    assert float((by_corner * motion).sum()) == pytest.approx(expected, rel=1e-6)


def test_distances_are_smooth_where_two_sides_are_equally_near() -> None:
    """Between two bars the slope turns over the width; the exact distance has a crease."""
    bars = Boundary.of(shapely.MultiPolygon([shapely.box(0, 0, 1, 9), shapely.box(5, 0, 6, 9)]))
    x = 3.0 + np.array([-1e-3, 0.0, 1e-3])
    left, middle, right = bars.away(np.column_stack([x, np.full(3, 4.5)]), WIDTH)
    assert (left - 2 * middle + right) / 1e-6 == pytest.approx(0.0, abs=4.0 / WIDTH * 4)
    assert left == pytest.approx(right)
    assert middle == pytest.approx(2.0, abs=1e-4)


def test_sides_that_vanish_leave_the_distance_alone() -> None:
    """A corner on a straight side changes nothing, wherever it is."""
    whole = Boundary.of(shapely.Polygon([(0, 0), (4, 0), (4, 2), (0, 2)]))
    points = np.array([[2.0, -1.0], [3.9, -0.2], [5.0, 3.0]])
    for step in (1e-3, 1e-6):
        cut = Boundary.of(shapely.Polygon([(0, 0), (4 - step, 0), (4, step), (4, 2), (0, 2)]))
        moved = cut.away(points, WIDTH) - whole.away(points, WIDTH)
        assert np.abs(moved).max() < 20.0 * step
