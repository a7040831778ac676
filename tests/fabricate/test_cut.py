"""Cut lines: the kerf on the right side, and marks that touch nothing."""

from __future__ import annotations

import re

import pytest
import shapely

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.write_svg import svg_bytes
from sheetmorph.fabricate import cut


def swept(path: shapely.MultiPolygon, kerf: float) -> shapely.Geometry:
    """What a cutter of a width takes away along the contours of a path."""
    return path.boundary.buffer(0.5 * kerf, quad_segs=64)


@pytest.mark.parametrize("kerf", [0.05e-3, 0.2e-3, 1e-3])
def test_what_the_cutter_leaves_is_the_sheet(two_faces, kerf: float) -> None:
    sheet = two_faces.outline_polygon()
    path = cut.cut_region(sheet, kerf, "sheet")
    left = shapely.difference(path, swept(path, kerf))
    # All but the material in inner corners sharper than the round cutter.
    assert left.symmetric_difference(sheet).area < 1e-6 * sheet.area
    assert path.area > sheet.area
    hole, cut_hole = (shapely.Polygon(s.interiors[0]) for s in (sheet, path.geoms[0]))
    assert hole.contains(cut_hole)
    assert hole.boundary.distance(cut_hole) == pytest.approx(0.5 * kerf, rel=1e-6)


def test_sharp_corners_stay_sharp() -> None:
    path = cut.cut_region(shapely.box(0, 0, 0.1, 0.05), 0.2e-3, "box")
    wanted = shapely.box(-0.1e-3, -0.1e-3, 0.1001, 0.0501)
    assert path.symmetric_difference(wanted).area < 1e-15
    assert shapely.get_num_coordinates(path) == 5
    assert cut.cut_region(shapely.box(0, 0, 1, 1), 0.0, "box").area == 1.0


def test_a_kerf_too_wide_is_refused() -> None:
    plate = shapely.box(0, 0, 0.1, 0.1)
    hole = shapely.box(0.05, 0.02, 0.0504, 0.06)
    with pytest.raises(InputError, match=r"hole of sheet at \(50\.2, 40\) mm is narrower"):
        cut.cut_region(plate.difference(hole), 0.5e-3, "sheet")
    two = shapely.MultiPolygon([plate, shapely.box(0.1003, 0, 0.2, 0.1)])
    with pytest.raises(InputError, match="closer to each other than the kerf"):
        cut.cut_region(two, 0.5e-3, "parts")
    assert len(cut.cut_region(two, 0.2e-3, "parts").geoms) == 2


def test_layers_come_in_the_order_of_cutting(two_faces, bare) -> None:
    inks = cut.sheet_inks(two_faces, 0.0)
    assert [ink.name for ink in inks] == ["SLITS", "HOLES", "SHEET", "MARKS"]
    assert [ink.name for ink in cut.sheet_inks(bare, 0.0)] == ["SHEET", "MARKS"]
    assert len({ink.colour for ink in inks}) == 4
    slits = cut.sheet_inks(two_faces, 0.4e-3)[0].shapes[0]
    assert slits.equals(two_faces.layout.slits)


def test_marks_are_the_same_in_both_files_and_touch_no_part(two_faces) -> None:
    sheet, pattern = cut.sheet_inks(two_faces, 1e-3)[-1], cut.pattern_inks(two_faces, 1e-3)[0][-1]
    assert sheet.name == pattern.name == cut.MARKS
    assert sheet.shapes[0].equals(pattern.shapes[0])
    marks = sheet.shapes[0]
    outline = two_faces.outline_polygon()
    assert marks.distance(outline.envelope) > 5e-3
    # Neither turned nor mirrored do they fall upon themselves.
    x, y = (outline.centroid.x, outline.centroid.y)
    for a, d in ((-1, 1), (1, -1), (-1, -1)):
        turned = shapely.affinity.scale(marks, a, d, origin=outline.envelope.centroid)
        assert shapely.hausdorff_distance(turned, marks) > 1e-3, (x, y)


def test_layers_of_parts_have_names_that_differ(make) -> None:
    discs = "".join(
        f'[[pattern]]\npart = "{name}"\nkind = "disc"\nradius = "3 mm"\n'
        f'centre = ["{8 * k} mm", "0 mm"]\n'
        for k, name in enumerate(("pattern", "PATTERN", "marks", "a"))
    )
    layers = cut.pattern_layers(make(discs))
    assert layers == {"pattern": "PATTERN", "PATTERN": "PATTERN-2", "marks": "marks-2", "a": "a"}


def test_the_side_of_the_kerf_is_said() -> None:
    assert "without kerf compensation" in cut.describe_kerf(0.0)
    assert "0.1 mm outside" in cut.describe_kerf(0.2e-3)
    assert "0.1 mm inside holes; slits are not moved" in cut.describe_kerf(0.2e-3)


def test_parts_that_cannot_be_cut_are_left_out(make) -> None:
    slotted = (
        '[[pattern]]\npart = "{}"\nkind = "disc"\nradius = "9 mm"\n[[pattern]]\npart = "{}"\n'
        'kind = "disc"\nradius = "0.2 mm"\noperation = "difference"\n'
    )
    plain = '[[pattern]]\npart = "b"\nkind = "disc"\nradius = "5 mm"\ncentre = ["30 mm", "0 mm"]\n'
    both = make(slotted.format("a", "a") + plain)
    inks, told = cut.pattern_inks(both, 0.5e-3)
    assert [ink.name for ink in inks] == ["b", cut.MARKS]
    assert inks[0].colour == cut.pattern_inks(both, 0.1e-3)[0][1].colour
    (sentence,) = told
    assert sentence.startswith(
        "cut/pattern leaves out the part a: the hole of the part a at (0, 0)"
    )
    assert cut.pattern_inks(make(slotted.format("a", "a")), 0.5e-3)[0] == []
    assert cut.pattern_inks(both, 0.1e-3)[1] == []


@pytest.mark.parametrize("kerf", [0.0, 1e-3])
def test_the_two_drawings_lie_upon_each_other(two_faces, kerf: float) -> None:
    """Same page, same origin, same marks: a viewer or a laser needs no alignment."""
    head = [
        re.search(r"<svg [^>]*>", svg_bytes(inks, margin=2e-3).decode("utf-8"))[0]
        for inks in (cut.sheet_inks(two_faces, kerf), cut.pattern_inks(two_faces, kerf)[0])
    ]
    assert head[0] == head[1]
