"""Shapes: areas by formula, circles within their chord error, clipping, holes."""

from __future__ import annotations

import math

import pytest
import shapely

from sheetmorph.design.library import Bar, Star
from sheetmorph.design.shapes import (
    CIRCLE_SEGMENTS,
    Disc,
    Ellipse,
    Polygon,
    Rectangle,
)
from sheetmorph.design.spec import Design


def test_circles_have_a_small_chord_error():
    disc = Disc(kind="disc", radius="50 mm", centre=["10 mm", "0 mm"]).polygon()
    corners = shapely.get_coordinates(disc)[:-1]
    assert len(corners) == CIRCLE_SEGMENTS
    radii = [math.dist(corner, (0.01, 0.0)) for corner in corners]
    assert radii == pytest.approx([0.05] * len(radii), rel=1e-14)
    assert 1 - math.cos(math.pi / CIRCLE_SEGMENTS) < 1e-4
    assert disc.area == pytest.approx(math.pi * 0.05**2, rel=2e-4)


def test_ellipse_and_rectangle_turn():
    ellipse = Ellipse(
        kind="ellipse", half_width="20 mm", half_height="10 mm", rotation="90 deg"
    ).polygon()
    assert ellipse.bounds == pytest.approx((-0.01, -0.02, 0.01, 0.02), rel=1e-12)
    assert ellipse.area == pytest.approx(math.pi * 0.02 * 0.01, rel=2e-4)
    turned = Rectangle(kind="rectangle", width="20 mm", height="20 mm", rotation="45 deg").polygon()
    assert turned.bounds[2] == pytest.approx(0.01 * math.sqrt(2))


def test_bar_from_point_to_point():
    bar = Bar(kind="bar", start=["0 mm", "0 mm"], end=["3 mm", "4 mm"], half_width="1 mm").polygon()
    assert bar.area == pytest.approx(5e-3 * 2e-3)
    assert bar.centroid.coords[0] == pytest.approx((1.5e-3, 2e-3))


def test_star_of_four_arms_is_a_cross():
    cross = Star(kind="star", arms=4, arm_length="10 mm", half_width="1 mm").polygon()
    # Two bars of 20 mm x 2 mm less the square that they share.
    assert cross.area == pytest.approx(2 * 20e-3 * 2e-3 - 4e-6, rel=1e-9)
    assert cross.bounds == pytest.approx((-0.01, -0.01, 0.01, 0.01))


def test_first_arm_points_along_the_rotation():
    star = Star(kind="star", arms=3, arm_length="10 mm", half_width="1 mm", rotation="90 deg")
    assert star.polygon().bounds[3] == pytest.approx(0.01)
    hub = Star(kind="star", arms=1, arm_length="5 mm", half_width="1 mm", hub_radius="3 mm")
    assert hub.polygon().bounds[0] == pytest.approx(-3e-3)


def test_polygon_with_hole_in_numbers_or_quantities():
    points, holes = [[0, 0], [40, 0], [40, 30], [0, 30]], [[[10, 10], [20, 10], [20, 20]]]
    plain = Polygon(kind="polygon", unit="mm", points=points, holes=holes)
    assert plain.polygon().area == pytest.approx(1200e-6 - 50e-6)
    written = [[f"{x} mm", f"{y / 10} cm"] for x, y in points]
    assert Polygon(kind="polygon", points=written).points == plain.points


def test_clip_cuts_at_the_outline(design):
    long = design.with_values({"pattern.0.end": '["30 mm", "0 mm"]', "pattern.0.clip": True})
    assert long.pattern_polygon().bounds == pytest.approx((-0.01, -0.003, 0.02, 0.003))


def test_shapes_are_joined(base):
    disc = '[[pattern]]\nkind = "disc"\nradius = "2 mm"\ncentre = ["15 mm", "5 mm"]\n\n[[layers]]'
    design = Design.from_toml(base.replace("[[layers]]", disc, 1))
    assert len(design.pattern_polygon().geoms) == 2


def test_many_points_load_quickly(base):
    count = 5000
    points = [
        [
            round(9 * math.cos(2 * math.pi * k / count), 6),
            round(9 * math.sin(2 * math.pi * k / count), 6),
        ]
        for k in range(count)
    ]
    shape = f'[[pattern]]\nkind = "polygon"\nunit = "mm"\npoints = {points}\n\n[[layers]]'
    design = Design.from_toml(base.replace("[[layers]]", shape, 1))
    assert design.pattern[1].polygon().area == pytest.approx(math.pi * 81e-6, rel=1e-4)
