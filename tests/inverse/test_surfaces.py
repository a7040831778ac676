"""Named surfaces against their closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from sheetmorph.geometry.surface import aspect_ratio, in_plane_width
from sheetmorph.inverse import surfaces
from sheetmorph.inverse.letters import STROKES, letter


@pytest.mark.parametrize("depth", [0.05, 0.3, 0.5])
def test_bowl_is_a_part_of_a_sphere(depth: float) -> None:
    points = surfaces.bowl(depth).points
    # A cap of height h over a rim of radius a is of a sphere with R = (a² + h²)/2h.
    radius = (0.25 + depth**2) / (2.0 * depth)
    assert np.linalg.norm(points - [0.0, 0.0, radius], axis=1) == pytest.approx(radius, rel=1e-12)
    assert np.ptp(points[:, 2]) == pytest.approx(depth, rel=1e-12)
    assert in_plane_width(points) == pytest.approx(1.0, rel=1e-12)


def test_a_bowl_deeper_than_a_hemisphere_is_an_ellipsoid() -> None:
    x, y, z = surfaces.bowl(0.8).points.T
    assert 4 * (x**2 + y**2) + ((z - 0.8) / 0.8) ** 2 == pytest.approx(1.0, rel=1e-12)


def test_areas_of_a_hemisphere_and_a_cone() -> None:
    assert surfaces.bowl(0.5).area == pytest.approx(2 * np.pi * 0.25, rel=3e-3)
    assert surfaces.cone(0.5).area == pytest.approx(np.pi * 0.5 * np.sqrt(0.5), rel=3e-3)


def test_dome_cone_and_saddle_are_what_they_say() -> None:
    for surface, height in (
        (surfaces.dome(0.4), lambda x, y: -0.4 * 4 * (x**2 + y**2)),
        (surfaces.cone(0.4), lambda x, y: -0.4 * 2 * np.hypot(x, y)),
        (surfaces.saddle(0.4), lambda x, y: 0.2 * 4 * (x**2 - y**2)),
    ):
        x, y, z = surface.points.T
        assert z == pytest.approx(height(x, y), abs=1e-12)
        assert aspect_ratio(surface.points) == pytest.approx(0.4, rel=1e-9)


def test_cylinder_is_round_and_its_chord_is_one() -> None:
    x, y, z = surfaces.cylinder(0.25).points.T
    radius = (0.25 + 0.25**2) / 0.5
    middle = 0.25 - radius
    assert x**2 + (z - middle) ** 2 == pytest.approx(radius**2, rel=1e-12)
    assert (np.ptp(x), np.ptp(y), np.ptp(z)) == pytest.approx((1.0, 1.0, 0.25), rel=1e-12)


def test_canoe_has_its_slenderness_and_a_level_rim() -> None:
    points = surfaces.canoe(2.5, 0.4).points
    length, width = in_plane_width(points), in_plane_width(points, "feret_min")
    assert length / width == pytest.approx(2.5, rel=2e-4)  # the rim has 144 sides
    on_rim = np.isclose((2 * points[:, 0]) ** 2 + (5 * points[:, 1]) ** 2, 1.0)
    assert on_rim.sum() == 6 * surfaces.RINGS
    assert points[on_rim, 2] == pytest.approx(0.4 / 2.5, rel=1e-12)


@pytest.mark.parametrize("name", ["C", "T"])
def test_rim_of_a_letter_is_high_and_its_middle_low(name: str) -> None:
    tray = letter(name, 0.5)
    assert in_plane_width(tray.points) == pytest.approx(1.0, rel=1e-12)
    rim = np.unique(tray.rim_edges)
    z = tray.points[:, 2] - tray.points[:, 2].min()
    assert z[rim] == pytest.approx(z.max(), rel=1e-6)
    assert len(STROKES[name][0]) > 1
