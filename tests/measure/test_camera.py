"""What a camera makes of shapes: closed forms, and what can be undone."""

from __future__ import annotations

import numpy as np
import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.surface import side_view
from sheetmorph.measure.camera import (
    Shapes,
    SideCamera,
    caps,
    corrected,
    correction,
    elevation_of,
    shapes_of,
)


def cap(ratio: float, count: int = 200) -> np.ndarray:
    """Points of a spherical cap on a rim of diameter 1, bottom at z = 0, shape (N, 3)."""
    radius = (0.25 + ratio**2) / (2 * ratio)
    polar = np.linspace(0.0, np.arccos(1.0 - ratio / radius), count)[:, None]
    turn = np.linspace(0.0, 2 * np.pi, count)[None, :]
    x, y = radius * np.sin(polar) * np.cos(turn), radius * np.sin(polar) * np.sin(turn)
    return np.stack([x, y, radius * (1 - np.cos(polar)) + 0 * turn], axis=-1).reshape(-1, 3)


@pytest.mark.parametrize("ratio", [0.1, 0.25, 0.5])
@pytest.mark.parametrize("degrees", [2.0, 5.0, 10.0])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_cap_is_found_again_from_its_tilted_view(ratio, degrees, sign):
    elevation = np.radians(degrees)
    width, height = side_view(cap(ratio), 0.0, sign * elevation)  # from above or from below
    # R (1 - cos) + h cos + (d/2) sin: the far rim above, the sphere below.
    radius = (0.25 + ratio**2) / (2 * ratio)
    seen = radius * (1 - np.cos(elevation)) + ratio * np.cos(elevation) + 0.5 * np.sin(elevation)
    assert height / width == pytest.approx(seen, rel=1e-3)
    table = correction(caps(), SideCamera(elevation))
    assert table.ratio(height / width) == pytest.approx(ratio, rel=4e-3)


@pytest.mark.parametrize("ratio", [0.3, 0.5, 0.8])
def test_caps_are_as_wide_and_high_as_they_say(ratio):
    shapes = caps(2.0, 0.5)
    table = correction(shapes, SideCamera())
    k = np.argmin(abs(table.true - ratio))
    assert np.ptp(shapes.positions[k], axis=0) == pytest.approx(
        [2.0, 1.0, 2.0 * table.true[k]], rel=1e-3
    )
    assert (shapes.flat_width, shapes.flat_depth) == pytest.approx((2.0, 0.5))


def test_a_flat_disc_seen_from_above_has_no_height():
    table = correction(caps(), SideCamera(np.radians(5.0)))
    assert table.ratio(np.sin(np.radians(5.0))) == pytest.approx(0.0, abs=1e-9)
    assert table.ratio(0.5 * np.sin(np.radians(5.0))) == 0.0
    assert np.isnan(table.ratio(np.nan))


def test_a_camera_that_is_near_sees_the_near_rim_larger():
    """A ring at the height 0.2 above a point: the rim beside the camera, half a width nearer."""
    turn = np.linspace(0.0, 2 * np.pi, 400)
    ring = np.stack([0.5 * np.cos(turn), 0.5 * np.sin(turn), 0.2 + 0 * turn], axis=1)
    points = np.vstack([ring, [[0.0, 0.0, 0.0]]])
    seen = SideCamera(distance=6.0).project(points)
    near = 6.0 / 5.5
    # The ring appears from 0.1 to 0.1 near; the point at -0.1; all about the middle of the whole.
    assert np.ptp(seen[:, 1]) == pytest.approx(0.1 * near + 0.1, rel=0.01)
    middle = 0.5 * (seen[:, 1].max() + seen[:, 1].min())
    assert middle == pytest.approx(0.0, abs=1e-3)
    # Off the axis by a twentieth of its distance, it is seen from 2.9 degrees below.
    low = SideCamera(np.arctan(0.05), 6.0, (0.0, 0.3)).project(points)
    flat = SideCamera(0.0, 6.0, (0.0, 0.0)).project(points)
    assert np.ptp(low[:, 1]) == pytest.approx(np.ptp(flat[:, 1]), rel=0.01)


@pytest.mark.parametrize("distance", [0.0, 5.0])
def test_what_a_camera_sees_of_known_shapes_is_undone_exactly(distance):
    states = np.array([cap(0.3, 60) * [1, 1, t] for t in (0.0, 0.2, 0.5, 1.0, 1.2)])
    shapes = Shapes(states, caps().outline)
    camera = SideCamera(0.1, distance, (0.2, -0.1))
    views = camera.project(states)
    width, height = np.ptp(views, axis=1).T
    places = np.tile([0.2, -0.1], (5, 1))
    ratio, true_width = corrected(height / width, width, places, shapes, camera)
    true = side_view(states)
    np.testing.assert_allclose(ratio[2:], (true[:, 1] / true[:, 0])[2:], rtol=1e-6)
    np.testing.assert_allclose(true_width[2:], true[2:, 0], rtol=1e-6)
    assert abs(height / width - ratio)[2:].min() > 0.02  # there was something to undo
    table = correction(shapes, camera)
    beyond = table.seen[-1] + 0.1
    assert table.ratio(beyond) == pytest.approx(table.true[-1] + 0.1)


@pytest.mark.parametrize("degrees", [0.5, 1.0, 6.0, 12.0])
@pytest.mark.parametrize("distance", [0.0, 4.0])
def test_the_elevation_comes_from_the_area_of_a_flat_sheet(degrees, distance):
    shapes, angle, thickness = caps(1.0, 0.7), np.radians(degrees), 0.01
    seen = SideCamera(angle, distance).project(
        np.column_stack([shapes.outline, np.zeros(len(shapes.outline))])
    )
    width, height = np.ptp(seen, axis=0)
    area = 0.25 * np.pi * width * height + thickness * width * np.cos(angle)
    found = elevation_of(area, width, shapes, SideCamera(distance=distance), thickness)
    assert found == pytest.approx(angle, abs=2e-4)


def test_a_level_camera_far_below_the_sheet_is_level_all_the_same():
    camera = SideCamera(distance=6.0, offset=(0.0, 0.3))
    assert elevation_of(0.0, 1.0, caps(), camera) == pytest.approx(np.arctan(0.05))


def test_a_sheet_that_is_not_flat_gives_no_elevation():
    with pytest.raises(InputError, match="--tilt"):
        elevation_of(0.4, 1.0, caps(), SideCamera())


def test_the_rim_of_a_run_is_that_of_its_flat_sheet_turned():
    square = np.array([[0, 0, 0], [3, 0, 0], [3, 1, 0], [0, 1, 0]], dtype=float)
    shapes = shapes_of(np.array([square, 2 * square]), [[0, 1, 2], [0, 2, 3]], 0.5 * np.pi)
    assert (shapes.flat_width, shapes.flat_depth) == pytest.approx((1.0, 3.0))
    assert len(shapes.outline) == 4
