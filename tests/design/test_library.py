"""The library of patterns: areas and extents in closed form, symmetry, keys, broken parameters."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from pydantic import TypeAdapter
from shapely.affinity import affine_transform, rotate, translate

from pages import page_examples
from sheetmorph.core.errors import InputError
from sheetmorph.design.outlines import PatternShape
from sheetmorph.design.presets import preset_text
from sheetmorph.design.spec import Design
from sheetmorph.geometry.quality import mesh_quality

SHEET = shapely.box(-0.06, -0.06, 0.06, 0.06)
BIG = shapely.box(-0.3, -0.3, 0.3, 0.3)
READ = TypeAdapter(PatternShape)

STAR = {"kind": "star", "arms": 6, "arm_length": "44.595 mm", "half_width": "2.787 mm"}
TWIN = STAR | {"kind": "twin_star", "spacing": "55.74 mm"}
CROSS = {"kind": "cross", "arm_length": "30 mm", "half_width": "3 mm", "chamfer": "8 mm"}
LOTUS = {"kind": "lotus", "petals": 5, "disc_radius": "12 mm", "radius": "40 mm"}
LOTUS |= {"petal_length": "30 mm", "petal_half_width": "6 mm"}
RING = {"kind": "ring", "radius": "30 mm", "width": "5 mm"}
RINGS = {"kind": "rings", "count": 3, "spacing": "12 mm", "width": "3 mm"}
SPIRAL = {"kind": "spiral", "turns": 3, "pitch": "12 mm", "half_width": "2 mm"}
STRIPES = {"kind": "stripes", "spacing": "10 mm", "half_width": "2 mm"}
GRID = STRIPES | {"kind": "grid"}
HONEYCOMB = {"kind": "honeycomb", "cell_size": "12 mm", "wall_width": "3 mm"}
KINDS = (STAR, TWIN, CROSS, LOTUS, RING, RINGS, SPIRAL, STRIPES, GRID, HONEYCOMB)


def drawn(piece, sheet=SHEET, **keys):
    """The region of a piece with some keys changed [m]."""
    return READ.validate_python({**piece, **keys}).region(sheet)


def edges(shape):
    """Lengths of the edges of all rings [m]."""
    rings = shapely.get_rings(shapely.get_parts(shape))
    points = [shapely.get_coordinates(ring) for ring in rings]
    return np.concatenate([np.linalg.norm(np.diff(ring, axis=0), axis=1) for ring in points])


def differ(one, other):
    """Area in which two shapes differ, as a fraction."""
    return one.symmetric_difference(other).area / one.area


@pytest.mark.parametrize("piece", KINDS, ids=lambda piece: piece["kind"])
@pytest.mark.parametrize("scale", [0.01, 1.0, 3.0])
def test_contours_are_simple_and_have_no_tiny_edges(piece, scale):
    keys = {
        key: f"{scale * float(value.split()[0])} mm"
        for key, value in piece.items()
        if isinstance(value, str) and value.endswith("mm")
    }
    sheet = affine_transform(SHEET, [scale, 0, 0, scale, 0, 0])
    shape = drawn(piece, sheet, **keys)
    assert shape.is_valid
    assert shape.area > 0
    assert edges(shape).min() > 0.999e-6


@pytest.mark.parametrize(
    "piece", [STAR, TWIN, CROSS, LOTUS, SPIRAL, RINGS | {"spokes": 5}], ids=lambda p: p["kind"]
)
def test_rotation_and_centre_move_the_shape(piece):
    before = drawn(piece, rotation="0 deg")
    after = drawn(piece, rotation="25 deg", centre=["7 mm", "-3 mm"])
    assert differ(after, translate(rotate(before, 25, (0, 0)), 7e-3, -3e-3)) < 1e-3  # chords


@pytest.mark.parametrize(
    ("piece", "count"),
    [(STAR, 6), (TWIN, 2), (CROSS, 4), (LOTUS, 5), (RINGS | {"spokes": 5}, 5), (GRID, 4)],
    ids=lambda value: value["kind"] if isinstance(value, dict) else "",
)
def test_a_turn_maps_the_shape_onto_itself(piece, count):
    shape = drawn(piece)
    assert differ(shape, rotate(shape, 360 / count, (0, 0))) < 2e-4


def test_star_by_inclusion_and_exclusion():
    n, length, w = 6, 44.595e-3, 2.787e-3
    # n half bars; neighbours share the kite between their inner corner and the centre, which the
    # hexagon of the inner corners sums up: 2n triangles of height w and half base w·tan(π/n).
    outside = length - w / math.tan(math.pi / n)
    area = 2 * n * w * outside + n * w**2 / math.tan(math.pi / n)
    assert drawn(STAR).area == pytest.approx(area, rel=1e-9)
    assert drawn(STAR).bounds[2] == pytest.approx(length)


def test_round_tips_are_half_circles():
    square = drawn(STAR).area
    round_tip = drawn(STAR, tip="round")
    w = 2.787e-3
    assert square - round_tip.area == pytest.approx(6 * w**2 * (2 - math.pi / 2), rel=1e-3)
    assert round_tip.bounds[2] == pytest.approx(44.595e-3)


def test_twin_star_is_the_pattern_of_the_canoe():
    preset = Design.from_toml(preset_text("canoe")).pattern_polygon()
    assert differ(preset, drawn(TWIN)) < 1e-9


def test_twin_star_spine():
    wide = drawn(TWIN, spine_half_width="5 mm", arms=3, arm_length="10 mm")
    assert shapely.box(-0.02, -5e-3, 0.02, 5e-3).within(wide.buffer(1e-9))


def test_cross_has_the_two_numbers_of_the_paper():
    """Straight arms of 56.7 mm, and 99.99 mm from tip to tip of neighbours."""
    design_c = {"arm_length": "56.7 mm", "half_width": "5.9 mm", "chamfer": "14.004 mm"}
    shape = drawn(CROSS, shapely.box(-1, -1, 1, 1), **design_c)
    low_x, low_y, high_x, high_y = shape.bounds
    assert high_x - low_x == pytest.approx(99.99e-3, abs=1e-5)
    assert high_y - low_y == pytest.approx(99.99e-3, abs=1e-5)
    flat = rotate(shape, -45, (0, 0))
    beyond = flat.intersection(shapely.box(56.7e-3, -1, 1, 1))
    assert beyond.area == pytest.approx(14.004e-3**2, rel=1e-6)  # a right-angled triangle
    before = flat.intersection(shapely.box(40e-3, -1, 56.6e-3, 1))
    assert before.bounds[3] == pytest.approx(5.9e-3)


def test_cross_area():
    w, length, c = 3e-3, 30e-3, 8e-3
    assert drawn(CROSS).area == pytest.approx(8 * w * length - 4 * w**2 + 4 * c**2, rel=1e-9)
    pointed = drawn({key: value for key, value in CROSS.items() if key != "chamfer"})
    assert pointed.area == pytest.approx(8 * w * length - 4 * w**2 + 4 * w**2, rel=1e-9)


def test_lotus_of_one_petal_is_a_disc_and_a_lens():
    one = LOTUS | {"petals": 1}
    ellipse = drawn(one, petal_length="30 mm").difference(shapely.Point(0, 0).buffer(0.013))
    assert ellipse.bounds[2] == pytest.approx(40e-3)
    assert ellipse.bounds[3] == pytest.approx(6e-3, rel=1e-3)
    a, b = 15e-3, 6e-3
    radius = (a * a + b * b) / (2 * b)
    lens = 2 * (radius**2 * math.asin(a / radius) - (radius - b) * a)
    # The whole petal, from a disc that it only touches: what both share is computed apart.
    pointed = drawn(one, form="pointed", disc_radius="10.1 mm")
    disc = math.pi * 10.1e-3**2
    assert pointed.area == pytest.approx(disc + lens, rel=1e-3)


def test_petals_are_ellipses():
    apart = drawn(LOTUS, petals=4, disc_radius="10.1 mm")
    ellipses = 4 * math.pi * 15e-3 * 6e-3
    assert apart.area == pytest.approx(ellipses + math.pi * 10.1e-3**2, rel=2e-3)


def test_ring_and_rings():
    polygon = 120 * math.sin(math.pi / 120)  # area of 240 chords over that of their circle, by r²
    assert drawn(RING).area == pytest.approx(polygon * (30e-3**2 - 25e-3**2), rel=1e-4)
    outer = [12e-3, 24e-3, 36e-3]
    area = sum(polygon * (r**2 - (r - 3e-3) ** 2) for r in outer)
    apart = drawn(RINGS)
    assert apart.area == pytest.approx(area, rel=1e-4)
    assert len(apart.geoms) == 3
    joined = drawn(RINGS, spokes=6)
    assert isinstance(joined, shapely.Polygon)
    # Each spoke fills the two gaps of 9 mm, 3 mm wide.
    assert joined.area - apart.area == pytest.approx(6 * 2 * 9e-3 * 3e-3, rel=0.01)
    assert drawn(RINGS, first_radius="5 mm").bounds[2] == pytest.approx(29e-3)


def test_spiral_is_as_long_as_its_middle_line():
    shape = drawn(SPIRAL)
    angle = np.linspace(0, 6 * math.pi, 200_001)
    growth = 12e-3 / (2 * math.pi)
    speed = np.hypot(12e-3 + growth * angle, growth)
    length = np.trapezoid(speed, angle)
    assert shape.area == pytest.approx(4e-3 * length, rel=2e-4)
    radius = 12e-3 + growth * angle
    middle = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])[::1000]
    inside = shapely.distance(shape.exterior, shapely.points(middle[1:-1]))
    assert inside.max() == pytest.approx(2e-3, abs=5e-6)  # the error of the chords


def test_stripes_and_grid_fill_their_share():
    assert drawn(STRIPES, BIG, rotation="20 deg").area / BIG.area == pytest.approx(0.4, rel=3e-3)
    share = drawn(GRID, BIG, rotation="20 deg", angle="70 deg").area / BIG.area
    assert share == pytest.approx(1 - 0.6**2, rel=3e-3)
    moved = drawn(STRIPES, rotation="90 deg", offset="4 mm")
    middles = [part.centroid.x for part in moved.geoms if part.area > 3e-4]
    assert len(middles) >= 11
    assert [(x + 4e-3) / 10e-3 for x in middles] == pytest.approx(
        [round((x + 4e-3) / 10e-3) for x in middles], abs=1e-6
    )


def test_honeycomb_walls_fill_their_share():
    shape = drawn(HONEYCOMB, BIG, rotation="7 deg", cells="cut")
    assert shape.area / BIG.area == pytest.approx(1 - (12 / 15) ** 2, rel=5e-3)
    whole = drawn(HONEYCOMB)
    hexagon = math.sqrt(0.75) * 12e-3**2
    assert [shapely.Polygon(ring).area for ring in whole.interiors] == pytest.approx(
        [hexagon] * len(whole.interiors)
    )
    assert whole.distance(SHEET.boundary) > 0
    # Two neighbours lie 15 mm apart: the wall between them is 3 mm wide, at 7.5 mm.
    wall = drawn(HONEYCOMB).intersection(shapely.LineString([(0, 0), (15e-3, 0)]))
    assert wall.bounds == pytest.approx((6e-3, 0, 9e-3, 0), abs=1e-9)


@pytest.mark.parametrize("piece", [STRIPES, GRID, HONEYCOMB], ids=lambda piece: piece["kind"])
def test_a_margin_stays_free(piece):
    disc = shapely.Point(0.1, 0.05).buffer(0.05, 60)
    ring = disc.difference(shapely.Point(0.1, 0.05).buffer(0.015, 60))
    for sheet in (disc, ring):
        free = drawn(piece, sheet, margin="4 mm")
        assert free.distance(sheet.boundary) > 3.99e-3
        full = drawn(piece, sheet)
        assert full.difference(sheet.buffer(2e-5)).area == 0
        assert full.area > free.area


def test_fillet_and_corner_radius():
    cross = {"kind": "star", "arms": 4, "arm_length": "20 mm", "half_width": "4 mm"}
    plain, r = drawn(cross).area, 3e-3
    corner = r * r * (1 - math.pi / 4)
    filled = drawn(cross, fillet="3 mm").area - plain
    assert filled == pytest.approx(4 * corner, rel=2e-3)  # four re-entrant right angles
    cut = plain - drawn(cross, corner_radius="3 mm").area
    assert cut == pytest.approx(8 * corner, rel=2e-3)  # eight salient ones


def test_copies():
    bar = {"kind": "bar", "start": ["2 mm", "1 mm"], "end": ["8 mm", "3 mm"], "half_width": "1 mm"}
    one = drawn(bar)
    mirrored = drawn(bar, mirror={"angle": "90 deg"})
    assert differ(mirrored, one.union(affine_transform(one, [-1, 0, 0, 1, 0, 0]))) < 1e-12
    line = drawn(bar, mirror={"angle": "0 deg", "point": ["0 mm", "10 mm"]})
    assert differ(line, one.union(affine_transform(one, [1, 0, 0, -1, 0, 0.02]))) < 1e-12
    grid = drawn(bar, grid_array={"columns": 3, "rows": 2, "dx": "10 mm", "dy": "-9 mm"})
    assert grid.area == pytest.approx(6 * one.area)
    assert grid.bounds[2] == pytest.approx(one.bounds[2] + 0.02)
    polar = drawn(bar, polar_array={"count": 5})
    assert differ(polar, shapely.union_all([rotate(one, 72 * k, (0, 0)) for k in range(5)])) < 1e-12
    fan = drawn(bar, polar_array={"count": 2, "step": "90 deg", "centre": ["9 mm", "9 mm"]})
    assert differ(fan, one.union(rotate(one, 90, (9e-3, 9e-3)))) < 1e-12


@pytest.mark.parametrize(
    ("piece", "keys", "key", "text"),
    [
        (STAR, {"arm_length": "2 mm", "tip": "round"}, "arm_length", "too short"),
        (CROSS, {"chamfer": "2 mm"}, "chamfer", "narrower than the arm"),
        (LOTUS, {"radius": "10 mm"}, "radius", "end inside the disc"),
        (LOTUS, {"petal_length": "20 mm"}, "petal_length", "do not reach the disc"),
        (LOTUS, {"petal_length": "50 mm"}, "petal_length", "past the centre"),
        (LOTUS, {"petal_half_width": "20 mm"}, "petal_half_width", "wider than long"),
        (RING, {"width": "30 mm"}, "width", "no hole"),
        (RINGS, {"width": "12 mm"}, "width", "no gap"),
        (RINGS, {"first_radius": "2 mm"}, "width", "innermost ring has no hole"),
        (RINGS, {"count": 1, "spokes": 3}, "spokes", "needs no spokes"),
        (SPIRAL, {"half_width": "6 mm"}, "half_width", "no gap"),
        (SPIRAL, {"inner_radius": "1 mm"}, "inner_radius", "too narrow inside"),
        (SPIRAL, {"turns": "3"}, "turns", "number"),
        (STRIPES, {"half_width": "5 mm"}, "half_width", "no gap"),
        (STRIPES, {"margin": "80 mm"}, "margin", "no room"),
        (STRIPES, {"spacing": "21 um", "half_width": "10 um"}, "spacing", "too many stripes"),
        (GRID, {"angle": "5 deg"}, "angle", "out of range"),
        (HONEYCOMB, {"cell_size": "0.1 mm", "wall_width": "0.1 mm"}, "cell_size", "too many"),
    ],
)
def test_parameters_that_cannot_be(base, piece, keys, key, text):
    lines = "\n".join(f"{name} = {value!r}" for name, value in {**piece, **keys}.items())
    broken = base.replace("[[layers]]", f"[[pattern]]\n{lines}\n\n[[layers]]", 1)
    with pytest.raises(InputError, match=text) as caught:
        Design.from_toml(broken).layout  # noqa: B018  draws the pattern
    assert caught.value.key == f"pattern[1].{key}"
    assert "\n" not in str(caught.value)


EXAMPLES = page_examples()
QUICK = {"star", "twin_star", "lotus", "spiral", "honeycomb", "two parts", "slits"}
"""Examples that are meshed in every run; the others take half a minute together."""


def meshed(example):
    return pytest.param(
        example,
        id=example.caption,
        marks=[] if example.caption in QUICK else [pytest.mark.slow],
    )


def test_examples_of_the_page_are_designs():
    assert {example.caption for example in EXAMPLES} >= QUICK
    for example in EXAMPLES:
        layout = example.design().layout
        assert layout.pattern.area > 0, example.caption
        assert edges(layout.pattern).min() > 1e-7, example.caption


@pytest.mark.parametrize("example", [meshed(example) for example in EXAMPLES])
def test_examples_of_the_page_can_be_meshed(example):
    design = example.design()
    mesh = design.build_mesh()
    assert mesh_quality(mesh).min_angle >= 25
    area = design.outline_polygon().area
    assert float(mesh.triangle_areas.sum()) == pytest.approx(area, rel=0.01)


def test_every_kind_has_an_example():
    shown = {piece.kind for example in EXAMPLES for piece in example.design().pattern}
    kinds = {piece["kind"] for piece in KINDS} | {"bar", "disc", "random_polygons"}
    assert kinds <= shown
