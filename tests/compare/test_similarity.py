"""Structural similarity of distance fields."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.similarity import Grid, ssim, ssim_of_fields
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import InputError


@pytest.fixture(scope="module")
def bowl() -> Surface:
    ball = trimesh.creation.icosphere(3, 0.05)
    ball.update_faces(ball.triangles_center[:, 2] < 0.01)
    return Surface(ball.vertices, ball.faces)


def shifted(surface: Surface, by: float) -> Surface:
    return surface.moved(Similarity(1.0, np.eye(3), np.array([0.0, 0.0, by])))


def test_a_surface_is_like_itself(bowl: Surface) -> None:
    same = ssim(bowl, bowl, 24, 5)
    assert same.value == pytest.approx(1.0, abs=1e-12)
    assert same.field.shape == (24, 24, 24)


def test_symmetric_and_falling_with_a_shift(bowl: Surface) -> None:
    values = [ssim(bowl, shifted(bowl, by), 24, 5).value for by in (0.0, 0.002, 0.005, 0.015)]
    assert values == sorted(values, reverse=True)
    assert values[-1] < 0.9 * values[0]
    moved = shifted(bowl, 0.005)
    assert ssim(bowl, moved, 24, 5).value == pytest.approx(ssim(moved, bowl, 24, 5).value)


def test_it_does_not_depend_on_the_unit(bowl: Surface) -> None:
    other = shifted(bowl, 0.004)
    inches = Similarity(1 / 0.0254, np.eye(3), np.zeros(3))
    expected = ssim(bowl, other, 20, 5).value
    assert ssim(bowl.moved(inches), other.moved(inches), 20, 5).value == pytest.approx(expected)


@pytest.mark.parametrize("window", [3, 7, 11])
def test_against_scikit_image(bowl: Surface, window: int) -> None:
    """The same local values; it averages only where the window does not reach over the edge."""
    from skimage.metrics import structural_similarity

    grid = Grid.around(bowl, other := shifted(bowl, 0.004), 24)
    a, b = grid.distance(bowl), grid.distance(other)
    ours = ssim_of_fields(grid, a, b, window)
    value, field = structural_similarity(
        a / a.max(),
        b / b.max(),
        win_size=window,
        data_range=1.0,
        use_sample_covariance=False,
        full=True,
    )
    np.testing.assert_allclose(ours.field, field, atol=1e-10)
    edge = (window - 1) // 2
    inside = ours.field[edge:-edge, edge:-edge, edge:-edge]
    assert inside.mean() == pytest.approx(value, abs=1e-10)


def test_the_grid_is_the_joint_box_and_a_twentieth(bowl: Surface) -> None:
    grid = Grid.around(bowl, shifted(bowl, 0.04), 10)
    low = np.minimum(bowl.box[0], bowl.box[0] + [0, 0, 0.04])
    width = np.maximum(bowl.box[1], bowl.box[1] + [0, 0, 0.04]) - low
    np.testing.assert_allclose(grid.origin, low - 0.05 * width)
    np.testing.assert_allclose(grid.origin + 9 * grid.spacing, low + 1.05 * width)


def test_flat_surfaces_have_a_box(bowl: Surface) -> None:
    flat = Surface(bowl.points * [1, 1, 0], bowl.triangles)
    result = ssim(flat, flat, 8, 3)
    assert result.value == pytest.approx(1.0)
    assert (result.spacing > 0).all()


@pytest.mark.parametrize(("grid", "window"), [(64, 65), (64, 1), (2, 2), (1000, 10), (10, 0)])
def test_grids_and_windows_that_do_not_fit(bowl: Surface, grid: int, window: int) -> None:
    with pytest.raises(InputError, match=r"grid|window"):
        ssim(bowl, bowl, grid, window)
