"""Distances, normals and curvature of surfaces where they lie, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sheetmorph.compare.distances import bending, distances, symmetric_rms
from sheetmorph.compare.pose import Similarity, best_similarity
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import InputError


def sphere(radius: float, subdivisions: int = 4) -> Surface:
    ball = trimesh.creation.icosphere(subdivisions, radius)
    return Surface(ball.vertices, ball.faces)


def square(side: float, height: float = 0.0, cells: int = 20) -> Surface:
    x, y = np.meshgrid(*[np.linspace(-side / 2, side / 2, cells + 1)] * 2, indexing="ij")
    points = np.stack([x, y, np.full_like(x, height)], axis=-1).reshape(-1, 3)
    a = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    b, c, d = a + cells + 1, a + cells + 2, a + 1
    return Surface(points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def shift(*by: float) -> Similarity:
    return Similarity(1.0, np.eye(3), np.array(by))


def test_concentric_spheres() -> None:
    there, back = distances(sphere(0.05), sphere(0.04))
    for way in (there, back):
        assert way.rms == pytest.approx(0.01, rel=2e-2)
        assert way.mean == pytest.approx(0.01, rel=2e-2)
        assert way.percentile_95 == pytest.approx(0.01, rel=2e-2)
        assert way.maximum == pytest.approx(0.01, rel=2e-2)
        assert np.degrees(way.normal_rms) < 2.5  # triangles are 4 degrees wide
    # Outside of the small one, inside of the large one; curvatures 1/R, less 1/R.
    assert there.signed.min() > 0.0 > back.signed.max()
    assert np.mean(there.curvature_difference) == pytest.approx(1 / 0.05 - 1 / 0.04, rel=2e-2)
    assert np.mean(back.curvature_difference) == pytest.approx(1 / 0.04 - 1 / 0.05, rel=2e-2)
    assert there.curvature_rms == pytest.approx(5.0, rel=3e-2)


def test_the_curvature_does_not_care_how_the_triangles_are_turned() -> None:
    ball = sphere(0.05)
    inside_out = Surface(ball.points, ball.triangles[:, ::-1])
    there, _ = distances(inside_out, sphere(0.04))
    assert there.curvature_rms == pytest.approx(5.0, rel=3e-2)
    assert np.degrees(there.normal_rms) < 2.5


def test_curvature_of_a_rough_sphere_is_averaged() -> None:
    ball = sphere(0.05, 5)
    rough = ball.points * (1.0 + 2e-3 * np.random.default_rng(0).normal(size=(len(ball.points), 1)))
    smooth = bending(Surface(rough, ball.triangles), 0.01)
    assert np.median(smooth.curvature) == pytest.approx(20.0, rel=0.1)
    assert np.std(smooth.curvature) < 5.0
    raw = Surface(rough, ball.triangles).mean_curvature
    assert np.std(raw) > 5 * np.std(smooth.curvature)


def test_parallel_planes() -> None:
    low, high = square(0.1), square(0.1, 0.003)
    there, back = distances(low, high, 2000)
    for way in (there, back):
        np.testing.assert_allclose(way.distance, 0.003, rtol=1e-9)
        assert way.maximum == pytest.approx(0.003)
        assert way.normal_rms == pytest.approx(0.0, abs=1e-7)
        assert way.curvature_rms == pytest.approx(0.0, abs=1e-6)
    assert (there.signed < 0).all()
    assert (back.signed > 0).all()


def test_hausdorff_is_one_sided_and_reaches_the_corners() -> None:
    small, large = square(0.1), square(0.2)
    there, back = distances(small, large)
    assert there.maximum == pytest.approx(0.0, abs=1e-12)
    assert back.maximum == pytest.approx(np.hypot(0.05, 0.05), rel=1e-9)
    # ∫ over the large square of the squared distance to the small one, in closed form.
    side, corner = 4 * 0.1 * 0.05**3 / 3, 4 * 2 * 0.05 * 0.05**3 / 3
    assert back.rms == pytest.approx(np.sqrt((side + corner) / 0.04), rel=1e-2)
    assert symmetric_rms(small, large) == pytest.approx(back.rms / np.sqrt(2), rel=2e-2)


def test_tilted_planes_and_the_normal_angle() -> None:
    angle = np.radians(20.0)
    turn = np.array(
        [[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]]
    )
    tilted = square(0.1).moved(Similarity(1.0, turn, np.zeros(3)))
    there, back = distances(tilted, square(0.1))
    assert there.normal_mean == pytest.approx(angle, rel=1e-9)
    assert back.normal_rms == pytest.approx(angle, rel=1e-9)


def test_samples_are_even_and_repeatable() -> None:
    surface = square(0.1)
    first, second = surface.sample(4000, seed=3), surface.sample(4000, seed=3)
    np.testing.assert_array_equal(first.points, second.points)
    assert surface.nearest(first.points).distance.max() < 1e-15
    np.testing.assert_allclose(first.points.mean(axis=0), 0.0, atol=1e-3)
    counts = np.bincount(first.triangle, minlength=len(surface.triangles))
    assert counts.min() >= 3  # five per triangle on average
    assert counts.max() <= 7


def test_nearest_is_exact_far_from_the_origin() -> None:
    away = np.array([3e4, -2e4, 1e4])
    ball = sphere(0.05).moved(shift(*away))
    near = ball.nearest(away + np.array([[0.2, 0.0, 0.0], [0.0, 0.0, 0.0]]))
    assert near.distance[0] == pytest.approx(0.15, rel=1e-6)
    assert near.distance[1] == pytest.approx(0.05, rel=1e-2)


def test_similarities_are_a_group() -> None:
    rng = np.random.default_rng(0)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    first = Similarity(0.19, turn * np.sign(np.linalg.det(turn)), rng.normal(size=3))
    second = Similarity(3.0, -np.eye(3), rng.normal(size=3))
    x = rng.normal(size=(5, 3))
    np.testing.assert_allclose(first.inverse().apply(first.apply(x)), x, atol=1e-14)
    np.testing.assert_allclose(second.after(first).apply(x), second.apply(first.apply(x)))
    assert second.mirrors
    assert not first.mirrors
    fitted = best_similarity(x, first.apply(x))
    np.testing.assert_allclose(fitted.apply(x), first.apply(x), atol=1e-13)
    assert best_similarity(x, second.apply(x)).mirrors is False


def test_a_mirrored_surface_keeps_its_outside() -> None:
    mirrored = sphere(0.05).moved(Similarity(1.0, np.diag([-1.0, 1, 1]), np.zeros(3)))
    centres = mirrored.points[mirrored.triangles].mean(axis=1)
    assert ((centres * mirrored.normals).sum(axis=1) > 0).all()


def test_measures_of_a_surface() -> None:
    surface = square(2.0)
    assert surface.area == pytest.approx(4.0)
    assert surface.size == pytest.approx(np.sqrt(8.0))
    assert surface.radius == pytest.approx(np.sqrt(2.0 / 3.0))
    np.testing.assert_allclose(surface.centroid, 0.0, atol=1e-15)
    assert len(surface.rim_edges) == 80
    assert surface.rim_triangles.sum() == 4 * 38


@pytest.mark.parametrize(
    ("points", "triangles", "match"),
    [
        (np.zeros((3, 3)), [[0, 1, 2]], "no area"),
        ([[0, 0, 0], [1, 1, 1], [2, 2, 2]], [[0, 1, 2]], "no area"),
        ([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]], "finite"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]], "does not exist"),
        ([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]], "3 coordinates"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.zeros((0, 3)), "triangles"),
    ],
)
def test_what_is_no_surface_is_refused(points: object, triangles: object, match: str) -> None:
    with pytest.raises(InputError, match=match):
        Surface(np.asarray(points, dtype=float), np.asarray(triangles, dtype=np.int64))
