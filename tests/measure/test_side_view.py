"""From outlines to h and d: closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.surface import aspect_ratio, in_plane_width, side_view
from sheetmorph.measure.side_view import (
    Reference,
    angle_of,
    extents,
    jumps,
    level_of,
    place_of,
)


def ellipse(long: float, short: float, angle: float) -> np.ndarray:
    turn = np.linspace(0, 2 * np.pi, 3000, endpoint=False)
    x, y = long * np.cos(turn), short * np.sin(turn)
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([300 + c * x - s * y, 200 + s * x + c * y], axis=1)


@pytest.mark.parametrize("degrees", [-5.0, 0.0, 3.0, 25.0])
@pytest.mark.parametrize("short", [20.0, 0.2])
def test_the_level_is_the_long_axis_of_a_flat_outline(degrees, short):
    outline = ellipse(200.0, short, np.radians(degrees))
    assert np.degrees(level_of(outline)) == pytest.approx(degrees, abs=0.01)
    width, height = extents(outline, np.radians(degrees))
    assert (width, height) == (pytest.approx(400.0, abs=0.01), pytest.approx(2 * short))
    assert extents(outline, np.radians(degrees), 1.0)[0] == pytest.approx(401.0, abs=0.01)


def test_the_place_in_the_picture_is_along_and_across_the_level():
    outline = ellipse(50.0, 20.0, np.radians(90.0))
    assert place_of(outline, 0.0, 501, 301) == pytest.approx((50.0, -50.0), abs=0.01)
    assert place_of(outline, np.radians(90.0), 501, 301) == pytest.approx((50.0, 50.0), abs=0.01)


def test_a_tall_outline_has_no_level():
    assert level_of(ellipse(200.0, 80.0, 0.1)) is None


def test_a_level_line_may_run_either_way():
    assert angle_of((0, 0, 100, 10)) == angle_of((100, 10, 0, 0)) == pytest.approx(np.arctan(0.1))
    with pytest.raises(InputError, match="one point"):
        angle_of((5, 5, 5, 5))


def test_reference():
    assert Reference(0.05, (10, 200, 310, 205)).metre_per_pixel(640, 480) == pytest.approx(
        0.05 / np.hypot(300, 5)
    )
    for line, words in (
        ((10, 200, 700, 200), "must lie in the picture"),
        ((10, -1, 300, 200), "must lie in the picture"),
        ((10, 200, 10, 200), "one point"),
    ):
        with pytest.raises(InputError, match=words):
            Reference(0.05, line).metre_per_pixel(640, 480)
    with pytest.raises(InputError, match="above zero"):
        Reference(0.0, (10, 200, 300, 200)).metre_per_pixel(640, 480)


def test_jumps_are_told_from_motion():
    width = np.linspace(400, 300, 16)
    height = np.linspace(5, 210, 16)
    assert not jumps(height, width).any()
    height[6], width[11], width[2] = 380.0, 90.0, np.nan
    height[2] = np.nan
    assert np.flatnonzero(jumps(height, width)).tolist() == [6, 11]


def test_widths_of_a_turned_box():
    box = np.array([[x, y, z] for x in (0, 3) for y in (0, 4) for z in (0, 2.0)])
    assert in_plane_width(box, "x") == 3 and in_plane_width(box, "y") == 4
    assert in_plane_width(box, "side") == 3
    assert in_plane_width(box, "side", np.pi / 2) == pytest.approx(4)
    assert aspect_ratio(box, "side", np.arctan2(4, 3)) == pytest.approx(2 / 5)
    assert side_view(box, 0.0, np.radians(90))[1] == pytest.approx(4)  # from above
