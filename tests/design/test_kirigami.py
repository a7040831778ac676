"""Random polygons: always within the sheet, of one piece, wide enough, the same for a seed."""

from __future__ import annotations

import random

import pytest
import shapely

from sheetmorph.core.errors import InputError
from sheetmorph.design.families import random_kirigami
from sheetmorph.design.kirigami import RandomPolygons
from sheetmorph.design.presets import preset_text
from sheetmorph.design.spec import Design
from sheetmorph.geometry.quality import mesh_quality

KNOWN = (2274.3, 1208.3)
SQUARE = shapely.box(-0.05, -0.05, 0.05, 0.05)
SHEETS = {
    "disc": shapely.Point(0.02, 0.01).buffer(0.05, 60),
    "square": SQUARE,
    "strip": shapely.box(0, 0, 0.2, 0.03),
    "hole": SQUARE.difference(shapely.Point(0.01, 0).buffer(0.02, 60)),
    "angle": SQUARE.difference(shapely.box(0, 0, 0.06, 0.06)),
}


def pattern(sheet="disc", **keys):
    """The pattern of these keys on a sheet [m]."""
    given = {"kind": "random_polygons", "seed": 1, "line_width": "3 mm"} | keys
    return RandomPolygons.model_validate(given).region(SHEETS[sheet])


def change(shape, radius):
    """Relative change of the area by closing (or opening, with a negative radius) by a disc."""
    done = shape.buffer(radius, quad_segs=8).buffer(-radius, quad_segs=8)
    return abs(done.area - shape.area) / shape.area


def some_parameters(count):
    dice = random.Random(2024)
    for seed in range(count):
        width = dice.uniform(1, 6)
        yield {
            "sheet": dice.choice(list(SHEETS)),
            "seed": seed,
            "line_width": f"{width} mm",
            "lines": dice.randint(3, 9),
            "polygons": dice.randint(1, 4),
            "style": dice.choice(["spokes", "outline", "both"]),
            "connected": dice.random() < 0.6,
            "minimum_feature": f"{dice.choice([0.3, 0.5, 0.9]) * width} mm",
        }


def test_three_hundred_patterns_are_valid():
    for keys in some_parameters(300):
        sheet = SHEETS[keys["sheet"]]
        shape = pattern(**keys)
        assert shape.is_valid, keys
        assert sheet.contains(shape), keys
        assert shape.distance(sheet.boundary) > 0.99e-3 * float(keys["line_width"][:-3]), keys
        assert 0 < shape.area < 0.9 * sheet.area, keys
        assert not keys["connected"] or isinstance(shape, shapely.Polygon), keys
        radius = 0.5e-3 * float(keys["minimum_feature"][:-3])
        assert change(shape, -radius) < 0.005, keys  # ribs
        assert change(shape, radius) < 0.005, keys  # gaps


def test_the_measure_finds_thin_ribs_and_gaps():
    bar = shapely.box(0, 0, 0.03, 0.003)
    thin = bar.union(shapely.box(0, 0, 0.0005, 0.03))
    assert change(thin, -0.75e-3) > 0.1
    assert change(bar.union(shapely.box(0, 0.0035, 0.03, 0.006)), 0.75e-3) > 0.05


def test_a_seed_gives_the_same_bits():
    shape = pattern(seed=5, style="both", polygons=4)
    again = pattern(seed=5, style="both", polygons=4)
    assert shapely.to_wkb(shape) == shapely.to_wkb(again)
    assert not pattern(seed=6, style="both", polygons=4).equals(shape)
    # Known values [mm², mm]: the generator is part of what a design file means.
    assert (1e6 * shape.area, 1e3 * shape.length) == pytest.approx(KNOWN, abs=0.1)


def test_parameters_mean_what_they_say():
    assert pattern(lines=12, style="spokes").area > pattern(lines=3, style="spokes").area
    small, large = (pattern(polygons=1, radius=f"{r} mm") for r in (10, 25))
    assert small.length < large.length
    ring = pattern(polygons=1, style="outline", radius="15 mm", lines=5)
    assert len(ring.interiors) == 1
    apart = pattern(polygons=5, radius="5 mm", connected=False)
    assert len(apart.geoms) > 1
    assert isinstance(pattern(polygons=5, radius="5 mm"), shapely.Polygon)
    dense = pattern(coverage=[0.35, 0.4], style="both", polygons=5)
    assert 0.35 <= dense.area / SHEETS["disc"].area <= 0.4


@pytest.mark.parametrize(
    ("keys", "key", "text"),
    [
        ({"line_width": "60 mm"}, "line_width", "no room"),
        ({"margin": "0 mm"}, "margin", "narrower than the smallest gap"),
        ({"minimum_feature": "5 mm"}, "minimum_feature", "leaves nothing of the lines"),
        ({"coverage": [0.5, 0.5]}, "coverage", "smaller share"),
        ({"coverage": [0.89, 0.9], "radius": "10 mm"}, "coverage", "more polygons"),
        ({"coverage": [0.0, 0.01]}, "coverage", "fewer polygons"),
        ({"seed": -1}, "seed", "out of range"),
        ({"seed": 1.5}, "seed", "whole number"),
        ({"lines": 2}, "lines", "out of range"),
    ],
)
def test_parameters_that_cannot_be(keys, key, text):
    design = Design.from_toml(preset_text("kirigami"))
    with pytest.raises(InputError, match=text) as caught:
        design.with_values({f"pattern.0.{name}": value for name, value in keys.items()})
    assert caught.value.key == f"pattern[0].{key}"
    assert "\n" not in str(caught.value)


def test_islands_that_no_bar_can_join():
    """Two rooms behind a wall of the sheet: one pattern with a part in each is refused."""
    rooms = shapely.union_all(
        [
            shapely.box(0, 0, 0.04, 0.04),
            shapely.box(0.06, 0, 0.1, 0.04),
            shapely.box(0.03, 0.018, 0.07, 0.022),
        ]
    )
    keys = {"kind": "random_polygons", "seed": 1, "line_width": "3 mm", "polygons": 5}
    keys |= {"radius": "3 mm"}
    apart = RandomPolygons.model_validate(keys | {"connected": False}).region(rooms)
    assert apart.bounds[2] - apart.bounds[0] > 0.06
    with pytest.raises(Exception, match="cannot be joined"):
        RandomPolygons.model_validate(keys).region(rooms)


def test_the_family_sets_its_keys():
    design = random_kirigami(7, lines=8, line_width=5e-3, thickness=1e-3, sheet_radius=40e-3)
    piece = design.pattern[0]
    assert (piece.seed, piece.lines, piece.line_width) == (7, 8, 5e-3)
    assert design.layers[1].thickness == 1e-3
    assert design.outline.radius == 40e-3
    assert design.supports[0].x == (-8e-3, 8e-3)
    assert design.spec.mesh.size == pytest.approx(3e-3)
    same = random_kirigami(7, lines=8, line_width=5e-3, sheet_radius=40e-3).with_values(
        {"layers.PLA.thickness": "1 mm"}
    )
    assert same.hash == design.hash
    assert random_kirigami(8, lines=8).hash != random_kirigami(7, lines=8).hash
    with pytest.raises(InputError, match="line_width"):
        random_kirigami(1, line_width=-1.0)


@pytest.mark.parametrize(
    "style", ["spokes", "outline", pytest.param("both", marks=pytest.mark.slow)]
)
def test_family_can_be_meshed(style):
    design = random_kirigami(3, style=style, line_width=5e-3)
    assert mesh_quality(design.build_mesh()).min_angle >= 25
