"""Parts on the bed: which face, which hand, where, and how they come back to the design."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from shapely.affinity import rotate

from sheetmorph.core.errors import InputError
from sheetmorph.fabricate.print3d import arrange, extruded, is_closed, lay_on_bed
from sheetmorph.fabricate.printer import GENERIC, PrinterProfile
from sheetmorph.fabricate.solid_files import bytes_3mf, bytes_stl
from sheetmorph.fabricate.stack import bonded_first, check_stack, glued_area, levels_of

HOOK = (
    '[[pattern]]\nkind = "polygon"\nunit = "mm"\n'
    "points = [[0, 0], [30, 0], [30, 5], [5, 5], [5, 20], [0, 20]]"
)


def parts_of(design, profile=GENERIC):
    return [lay_on_bed(level, profile) for level in levels_of(design) if level.part]


def moved(part):
    points = np.concatenate([body.points for body in part.bodies()])
    return points @ part.to_design[:3, :3].T + part.to_design[:3, 3]


@pytest.mark.parametrize("face", ["top", "bottom"])
def test_a_printed_part_comes_to_lie_as_designed(make, face: str) -> None:
    """By a rigid motion alone, for plastic cannot be mirrored by hand."""
    design = make(HOOK, below=("pattern",) if face == "bottom" else ())
    (part,) = parts_of(design)
    motion = part.to_design
    assert np.linalg.det(motion[:3, :3]) == pytest.approx(1.0)
    assert motion[:3, :3] @ motion[:3, :3].T == pytest.approx(np.eye(3))
    points = moved(part)
    # The film is 0.3 mm thick and its underside lies on z = 0; the part is 0.8 mm thick.
    low, high = (0.3e-3, 1.1e-3) if face == "top" else (-0.8e-3, 0.0)
    assert points[:, 2].min() == pytest.approx(low, abs=1e-12)
    assert points[:, 2].max() == pytest.approx(high, abs=1e-12)
    plan = shapely.transform(part.plan, lambda xy: xy @ motion[:2, :2].T + motion[:2, 3])
    assert plan.symmetric_difference(part.level.region).area < 1e-15
    # The face on the bed (z = 0 there) is the one that touches the film.
    on_bed = np.concatenate([body.points for body in part.bodies()])[:, 2] == 0.0
    assert points[on_bed, 2] == pytest.approx(0.3e-3 if face == "top" else 0.0, abs=1e-12)


def test_only_parts_of_the_underside_are_mirrored(make) -> None:
    (top,) = parts_of(make(HOOK))
    (bottom,) = parts_of(make(HOOK, below=("pattern",)))
    region = top.level.region

    def congruent(part, shape) -> bool:
        x, y = np.array(part.plan.bounds[:2]) - shape.bounds[:2]
        return shapely.affinity.translate(shape, x, y).symmetric_difference(part.plan).area < 1e-15

    mirrored = shapely.affinity.scale(region, -1.0, 1.0)
    assert congruent(top, region)
    assert not congruent(top, mirrored)
    assert congruent(bottom, mirrored)
    assert not congruent(bottom, region)


def test_parts_lie_on_the_middle_of_the_bed(two_faces) -> None:
    for part in parts_of(two_faces):
        low_x, low_y, high_x, high_y = part.plan.bounds
        assert 0.5 * (low_x + high_x) == pytest.approx(0.5 * GENERIC.bed_width)
        assert 0.5 * (low_y + high_y) == pytest.approx(0.5 * GENERIC.bed_depth)
        assert part.fits


def test_a_part_is_turned_only_if_it_must_be(make) -> None:
    text = (
        '[[pattern]]\nkind = "rectangle"\nwidth = "{length} mm"\nheight = "2 mm"\n[outline]\n'
        'kind = "rectangle"\nwidth = "400 mm"\nheight = "30 mm"'
    )
    bed = PrinterProfile("small", 0.4e-3, 0.1, 0.2, 0.8e-3, 0.2e-3)
    for length, angle, fits in ((95, 0.0, True), (180, 90.0, True), (300, 0.0, False)):
        (part,) = parts_of(make(text.format(length=length)), bed)
        assert (round(math.degrees(part.angle), 9), part.fits) == (angle, fits)
    (part,) = parts_of(make(text.format(length=215)), bed)  # along the diagonal alone
    assert part.fits
    assert 0 < math.degrees(part.angle) < 90
    assert shapely.box(0, 0, 0.1, 0.2).buffer(1e-8).covers(part.plan)


def test_plates_hold_all_parts_apart(two_faces, make) -> None:
    parts = parts_of(two_faces)
    (bed,) = arrange(parts, GENERIC)
    assert [part.name for part in bed] == [part.name for part in parts]
    assert bed[0].plan.distance(bed[1].plan) > 4.99e-3
    room = shapely.box(0, 0, GENERIC.bed_width, GENERIC.bed_depth)
    assert all(room.covers(part.plan) for part in bed)
    for part in bed:  # moved and perhaps turned, and still known how to come back
        assert moved(part)[:, :2].min(axis=0) == pytest.approx(part.level.region.bounds[:2])
        assert np.linalg.det(part.to_design[:3, :3]) == pytest.approx(1.0)
    small = PrinterProfile("small", 0.4e-3, 0.095, 0.095, 0.8e-3, 0.2e-3)
    discs = "".join(
        f'[[pattern]]\npart = "{name}"\nkind = "disc"\nradius = "23.5 mm"\n'
        f'centre = ["{x} mm", "0 mm"]\n'
        for name, x in (("a", -25), ("b", 25))
    )
    assert [len(bed) for bed in arrange(parts_of(make(discs), small), small)] == [1, 1]
    wide = make('[[pattern]]\nkind = "disc"\nradius = "49 mm"')
    assert arrange(parts_of(wide, small), small) == []


def test_the_same_parts_give_the_same_bytes(two_faces) -> None:
    one, other = (parts_of(two_faces)[0].bodies() for _ in range(2))
    assert bytes_3mf(one, {"Title": "x"}) == bytes_3mf(other, {"Title": "x"})
    assert bytes_stl(one) == bytes_stl(other)


@pytest.mark.parametrize("angle", [0, 10, 45])
def test_prisms_of_awkward_polygons_are_closed(angle: float) -> None:
    ring = shapely.Polygon(
        [(0, 0), (0.01, 0), (0.02, 0), (0.03, 0), (0.03, 0.03), (0, 0.03)],  # points in a line
        [
            [(0.005, 0.005), (0.01, 0.005), (0.01, 0.01), (0.005, 0.01)],
            [(0.01, 0.01), (0.02, 0.01), (0.02, 0.02), (0.01, 0.02)],  # touches the first
        ],
    )
    body = extruded(rotate(ring, angle), 1e-3, "ring")
    assert is_closed(body.triangles)
    corners = body.points[body.triangles]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume == pytest.approx(ring.area * 1e-3, rel=1e-9)


def test_an_open_surface_is_told_from_a_closed_one() -> None:
    body = extruded(shapely.box(0, 0, 1, 1), 1.0, "cube")
    assert is_closed(body.triangles)
    assert not is_closed(body.triangles[1:])
    flipped = body.triangles.copy()
    flipped[0] = flipped[0, ::-1]
    assert not is_closed(flipped)


def test_layers_lie_upon_each_other(two_faces) -> None:
    levels = levels_of(two_faces)
    assert [level.face for level in levels] == ["bottom", "film", "top"]
    assert [round(1e3 * level.low, 9) for level in levels] == [-0.8, 0.0, 0.3]
    assert [round(1e3 * level.high, 9) for level in levels] == [0.0, 0.3, 1.1]
    assert check_stack(levels) == []
    assert glued_area(levels) == pytest.approx(two_faces.layout.parts["arms"].area)


def test_parts_that_lie_half_upon_each_other_are_told(make) -> None:
    text = (
        '[[pattern]]\npart = "a"\nkind = "disc"\nradius = "10 mm"\n'
        '[[pattern]]\npart = "b"\nkind = "disc"\nradius = "10 mm"\ncentre = ["15 mm", "0 mm"]'
    )
    (told,) = check_stack(levels_of(make(text)))
    assert "cannot lie flat" in told
    assert "near (7.5, " in told
    assert check_stack(levels_of(make(text, below=("a",)))) == []


def test_a_sheet_over_a_part_is_told(make) -> None:
    design = make('[[pattern]]\nkind = "disc"\nradius = "10 mm"')
    text = design.source.replace(
        "[actuation]",
        '[[layers]]\nname = "cover"\nrole = "inert"\nthickness = "0.1 mm"\n'
        'young_modulus = "1 MPa"\n[actuation]',
    )
    levels = levels_of(type(design).from_toml(text))
    (told,) = check_stack(levels)
    assert told.startswith("cover covers the whole sheet and lies over inert pattern")
    assert [level.on for level in levels] == [(), ("polystyrene",), ("inert pattern",)]
    assert [level.layer.name for level in bonded_first(levels)] == ["polystyrene"]
    assert glued_area(levels) == pytest.approx(design.pattern_polygon().area)


def test_each_layer_is_glued_to_its_nearest_one(skinned) -> None:
    levels = levels_of(skinned)
    assert [(level.layer.name, level.on) for level in levels] == [
        ("outer", ("inner",)),
        ("inner", ("polystyrene",)),
        ("polystyrene", ()),
        ("skin", ("polystyrene",)),
        ("rib", ("skin",)),
    ]
    assert [level.layer.name for level in bonded_first(levels)] == ["polystyrene", "skin"]
    assert glued_area(levels) == pytest.approx(skinned.outline_polygon().area)
    assert round(1e3 * levels[-1].low, 9) == 0.4


def test_a_part_half_on_another_touches_both(make) -> None:
    text = (
        '[[pattern]]\npart = "a"\nkind = "disc"\nradius = "10 mm"\n'
        '[[pattern]]\npart = "b"\nkind = "disc"\nradius = "10 mm"\ncentre = ["15 mm", "0 mm"]'
    )
    assert levels_of(make(text))[-1].on == ("inert a", "polystyrene")


def test_a_part_between_films_is_refused(make) -> None:
    design = make('[[pattern]]\nkind = "disc"\nradius = "10 mm"')
    text = design.source.replace(
        "[actuation]",
        '[[layers]]\nname = "film b"\nrole = "active"\nthickness = "0.3 mm"\n'
        'young_modulus = "0.9 MPa"\n[actuation]',
    )
    with pytest.raises(InputError, match="inert pattern lies between two active films") as caught:
        levels_of(type(design).from_toml(text))
    assert (caught.value.key, caught.value.value) == ("layers[1].where", "pattern")


def test_a_whole_inert_sheet_between_films_is_bonded_like_a_film(bare) -> None:
    layer = '[[layers]]\nname = "{}"\nrole = "{}"\nthickness = "1 mm"\nyoung_modulus = "1 MPa"\n'
    more = layer.format("core", "inert") + layer.format("film b", "active") + "[actuation]"
    levels = levels_of(type(bare).from_toml(bare.source.replace("[actuation]", more)))
    assert [level.on for level in levels] == [(), ("polystyrene",), ("core",)]
    assert bonded_first(levels) == levels
    assert glued_area(levels) == pytest.approx(bare.outline_polygon().area)
