"""The flat sheet and the spherical cap that a prediction has to beat."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sheetmorph.compare.baselines import cap, lay_cap, lay_flat_sheet
from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import InputError


def posed(surface: Surface, seed: int, scale: float = 1.0) -> Surface:
    rng = np.random.default_rng(seed)
    turn = Rotation.from_quat(rng.normal(size=4)).as_matrix()
    return surface.moved(Similarity(scale, turn, rng.normal(size=3)))


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.2, 2.5, np.pi])
def test_a_cap_has_the_area_it_should(angle: float) -> None:
    surface = cap(0.01, angle)
    assert surface.area == pytest.approx(0.01, rel=0.02)
    if angle:
        radius = np.sqrt(0.01 / (2 * np.pi * (1 - np.cos(angle))))
        from_centre = np.linalg.norm(surface.points + np.array([0, 0, radius]), axis=1)
        np.testing.assert_allclose(from_centre, radius, rtol=1e-12)
        assert np.ptp(surface.points[:, 2]) == pytest.approx(radius * (1 - np.cos(angle)))
    assert (surface.normals[:48, 2] > 0).all()


@pytest.mark.parametrize("angle", [0.4, 1.1, 1.9])
def test_the_cap_of_a_cap_is_that_cap(angle: float) -> None:
    scan = posed(cap(0.01, angle), 1, 5.0)
    laid, pose, found = lay_cap(scan, 0.01, None)
    assert found == pytest.approx(angle, abs=0.05)
    assert pose.scale == pytest.approx(0.2, rel=0.02)
    assert scan.nearest(laid.points).distance.max() < 0.03 * scan.size


def test_the_cap_of_a_flat_sheet_is_flat() -> None:
    _, _, found = lay_cap(posed(cap(0.01, 0.0), 2), 0.01, None)
    assert found < 0.1


def test_a_known_scale_is_held_by_the_baselines() -> None:
    scan = posed(cap(0.01, 1.0), 3)
    assert lay_cap(scan, 0.01, 1.0)[1].scale == pytest.approx(1.0, rel=1e-12)
    assert lay_flat_sheet(scan, cap(0.02, 0.0), 1.0)[1].scale == pytest.approx(1.0, rel=1e-12)


def test_a_flat_sheet_lies_through_the_middle_of_a_dome() -> None:
    scan = cap(0.01, 1.0)
    laid, _ = lay_flat_sheet(scan, cap(0.01, 0.0), 1.0)
    assert np.abs(laid.normals[:, 2]).min() > 0.99
    low, high = scan.box[:, 2]
    assert low < laid.centroid[2] < high


@pytest.mark.parametrize(("area", "angle"), [(0.0, 1.0), (-1.0, 1.0), (1.0, -0.1), (1.0, 4.0)])
def test_caps_that_cannot_be(area: float, angle: float) -> None:
    with pytest.raises(InputError):
        cap(area, angle)
