"""What a printer cannot make is found, with its place and its width."""

from __future__ import annotations

import pytest
import shapely

from sheetmorph.core.errors import InputError
from sheetmorph.fabricate.printability import check_part, narrow_places, small_holes
from sheetmorph.fabricate.printer import GENERIC, PROFILES, PrinterProfile, find_profile

BAR = '[[pattern]]\nkind = "rectangle"\nwidth = "40 mm"\nheight = "{}"\n'


def told(make, text: str, profile: PrinterProfile = GENERIC) -> list[str]:
    (part,) = make(text).inert_parts
    return check_part(part, profile)


@pytest.mark.parametrize("width", [0.2, 0.35, 0.6, 0.79])
def test_a_neck_is_measured_where_it_is(width: float) -> None:
    blocks = [shapely.box(-20, -5, -5, 5), shapely.box(5, -5, 20, 5)]
    neck = shapely.box(-5, -0.5 * width, 5, 0.5 * width)
    shape = shapely.affinity.scale(shapely.union_all([*blocks, neck]), 1e-3, 1e-3, origin=(0, 0))
    shape = shapely.affinity.rotate(shape, 20, origin=(0, 0))
    (place,) = narrow_places(shape, 0.8e-3)
    assert place.width == pytest.approx(1e-3 * width, abs=3e-6)
    assert abs(complex(place.x, place.y)) < 6e-3


def test_wedges_are_narrow_only_where_they_end_thin() -> None:
    wedge = shapely.Polygon([(0, 0), (20e-3, 0.1e-3), (20e-3, 1.5e-3)])
    (place,) = narrow_places(wedge, 0.8e-3)
    assert place.x < 12e-3
    for corners in (3, 4, 5, 6, 12, 240):
        disc = shapely.Point(0, 0).buffer(10e-3, quad_segs=corners)
        assert narrow_places(disc, 0.8e-3) == []
    assert narrow_places(shapely.Polygon([(0, 0), (0.03, 0), (0.015, 0.026)]), 0.8e-3) == []


def test_the_patterns_of_the_paper_can_be_printed(bowl) -> None:
    (line,) = check_part(bowl.inert_parts[0], GENERIC)
    assert "0.7 mm is no multiple of the layer height 0.2 mm: it becomes 0.8 mm (4 layers)" in line
    assert "choose layers of 0.175 mm" in line
    fine = find_profile("generic-0.4", layer_height=0.175e-3)
    assert check_part(bowl.inert_parts[0], fine) == []


def test_what_is_narrower_than_the_nozzle_is_lost(make) -> None:
    (line,) = told(make, BAR.format("0.3 mm"))
    assert "only 0.3 mm wide near (0, 0) mm, narrower than the nozzle of 0.4 mm" in line
    assert "will not be printed" in line
    (line,) = told(make, BAR.format("0.6 mm"))
    assert "single weak line" in line
    assert told(make, BAR.format("0.9 mm")) == []
    (line,) = told(make, BAR.format("0.9 mm"), find_profile("bambu-p1s", minimum_feature=1.2e-3))
    assert "single weak line; make it 1.2 mm" in line


def test_narrow_gaps_fuse(make) -> None:
    text = BAR.format("6 mm") + (
        '[[pattern]]\nkind = "rectangle"\nwidth = "40 mm"\nheight = "6 mm"\n'
        'centre = ["0 mm", "6.5 mm"]'
    )
    lines = told(make, text)
    assert any("gap near (0, 3.2) mm is 0.5 mm wide" in line for line in lines)
    assert any("2 loose pieces" in line for line in lines)
    assert not any("gap" in line for line in told(make, text.replace("6.5 mm", "7.5 mm")))


def test_small_holes_close_and_are_not_told_twice(make) -> None:
    text = BAR.format("20 mm") + (
        '[[pattern]]\nkind = "disc"\nradius = "0.3 mm"\ncentre = ["5 mm", "2 mm"]\n'
        'operation = "difference"'
    )
    (line,) = told(make, text)
    assert "the hole at (5, 2) mm is 0.6 mm across" in line
    assert told(make, text.replace("0.3 mm", "0.6 mm")) == []
    ring = shapely.Point(0, 0).buffer(5e-3).difference(shapely.Point(0, 0).buffer(1e-3))
    (hole,) = small_holes(ring, 2.2e-3)
    assert hole.width == pytest.approx(2e-3, rel=0.03)


def test_long_lists_are_cut_short(make) -> None:
    text = (
        '[[pattern]]\nkind = "rectangle"\nwidth = "3 mm"\nheight = "0.3 mm"\n'
        'centre = ["-30 mm", "0 mm"]\ngrid_array = { columns = 9, dx = "6 mm" }'
    )
    lines = [line for line in told(make, text) if "narrower than the nozzle" in line]
    assert len(lines) == 4
    assert lines[-1].endswith("(5 more places like this)")


def test_profiles_and_their_overrides() -> None:
    assert set(PROFILES) == {"generic-0.4", "bambu-p1s", "prusa-mk4"}
    mk4 = find_profile("prusa-mk4", nozzle_width=0.6e-3, bed_width=None)
    assert (mk4.nozzle_width, mk4.bed_width, mk4.bed_depth) == (0.6e-3, 0.25, 0.21)
    with pytest.raises(InputError, match="did you mean prusa-mk4"):
        find_profile("prusa")
    for key, value in (
        ("nozzle_width", -1.0),
        ("bed_width", float("nan")),
        ("layer_height", 0.5e-3),
        ("minimum_feature", 1.0),
    ):
        with pytest.raises(InputError, match=key):
            find_profile("generic-0.4", **{key: value})


def test_corners_that_touch_are_told(make) -> None:
    text = (
        '[[pattern]]\nkind = "rectangle"\nwidth = "10 mm"\nheight = "10 mm"\n[[pattern]]\n'
        'kind = "rectangle"\nwidth = "10 mm"\nheight = "10 mm"\ncentre = ["10 mm", "10 mm"]'
    )
    lines = told(make, text)
    assert any("at (5, 5) mm it meets itself in a single point" in line for line in lines)
    apart = told(make, text.replace('["10 mm", "10 mm"]', '["12 mm", "12 mm"]'))
    assert not any("single point" in line for line in apart)


def test_very_many_narrow_places_are_found_in_time(make) -> None:
    text = (
        '[[pattern]]\nkind = "rectangle"\nwidth = "1 mm"\nheight = "0.3 mm"\n'
        'centre = ["-30 mm", "-30 mm"]\n'
        'grid_array = { columns = 20, rows = 20, dx = "3 mm", dy = "3 mm" }'
    )
    lines = [line for line in told(make, text) if "narrower than the nozzle" in line]
    assert lines[-1].endswith("(396 more places like this)")
