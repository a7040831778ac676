# ruff: noqa: E501  (tables of drawings read better in long lines)
from __future__ import annotations

import math

import ezdxf
import numpy as np
import pytest
from ezdxf.math import rational_bspline_from_arc

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.read import read_drawing

FLAT = 5e-6
PI = math.pi
SQUARE = [(0, 0), (20, 0), (20, 20), (0, 20)]


def square(space, side=20.0, corner=(0.0, 0.0), layer="0", **more):
    x, y = corner
    points = [(x, y), (x + side, y), (x + side, y + side), (x, y + side)]
    space.add_lwpolyline(points, close=True, dxfattribs={"layer": layer, **more})


@pytest.mark.parametrize(
    ("code", "unit"), [(1, 0.0254), (2, 0.3048), (4, 1e-3), (5, 1e-2), (6, 1.0), (9, 2.54e-5), (13, 1e-6), (14, 0.1)]
)  # fmt: skip
def test_units(dxf, code, unit):
    side = 0.05 / unit
    area = dxf(lambda space: square(space, side), code).area()
    assert area.bounds == pytest.approx((0, 0, 0.05, 0.05), abs=1e-15)


def test_a_unit_is_needed_and_wins(dxf):
    with pytest.raises(InputError, match=r"does not say its unit; set unit.*allowed: um, mm, cm"):
        dxf(square, 0)
    with pytest.raises(InputError, match="INSUNITS = 7"):
        dxf(square, 7)
    with pytest.raises(InputError, match="no such unit"):
        dxf(square, 4, unit="furlong")
    assert dxf(square, 0, unit="cm").area().area == pytest.approx(0.04)
    drawing = dxf(square, 4, unit="in")
    assert drawing.unit == "in"
    assert drawing.area().area == pytest.approx((20 * 0.0254) ** 2)
    assert "says that a unit is 1 mm; read as in" in drawing.notes[0]


def lines_of(space, points, layer="0"):
    for a, b in zip(points, points[1:] + points[:1], strict=True):
        space.add_line(a, b, dxfattribs={"layer": layer})


def stadium(space):
    space.add_line((0, 0), (20, 0))
    space.add_arc((20, 5), 5, -90, 90)
    space.add_line((0, 10), (20, 10))
    space.add_arc((0, 5), 5, 90, 270)


def bulged(space):
    space.add_lwpolyline([(0, 0, 0), (20, 0, 1), (20, 10, 0), (0, 10, 1)], format="xyb", close=True)


def old_bulged(space):
    space.add_polyline2d([(0, 0, 0), (20, 0, 1), (20, 10, 0), (0, 10, 1)], format="xyb", close=True)


def spline_circle(space):
    curve = rational_bspline_from_arc((5, 5), 10, 0, 360)
    space.add_rational_spline(
        curve.control_points, curve.weights(), degree=curve.degree, knots=curve.knots()
    )


def hatch(space):
    fill = space.add_hatch(color=2)
    fill.paths.add_polyline_path([(0, 0), (30, 0), (30, 30), (0, 30)], is_closed=True)
    edge = fill.paths.add_edge_path()
    edge.add_arc((15, 15), 5, 0, 360)
    other = fill.paths.add_edge_path()
    other.add_arc((15, 15), 3, 0, 180)
    other.add_line((12, 15), (18, 15))


def hatch_with_clockwise_edges(space):
    fill = space.add_hatch(color=2)
    edge = fill.paths.add_edge_path()
    edge.add_line((0, 0), (10, 0))
    edge.add_arc((10, 5), 5, 270, 90, ccw=True)
    edge.add_line((10, 10), (0, 10))
    edge.add_ellipse((0, 5), (0, 5), 0.5, 0, 180)


def downward(space):
    space.add_lwpolyline(
        [(0, 0, 0), (-20, 0, -1), (-20, 10, 0), (0, 10, -1)],
        format="xyb",
        close=True,
        dxfattribs={"extrusion": (0, 0, -1)},
    )


def both_directions(space):
    space.add_arc((-20, 5), 5, 90, 270, dxfattribs={"extrusion": (0, 0, -1)})
    space.add_line((0, 0), (20, 0))
    space.add_line((20, 10), (0, 10))
    space.add_arc((0, 5), 5, 90, 270)


STADIUM = 200 + 25 * PI
# what is drawn, area [mm²], bounds [mm]
DRAWN = {
    "lines": (lambda s: lines_of(s, SQUARE), 400, (0, 0, 20, 20)),
    "stadium": (stadium, STADIUM, (-5, 0, 25, 10)),
    "bulges": (bulged, STADIUM, (-5, 0, 25, 10)),
    "old bulges": (old_bulged, STADIUM, (-5, 0, 25, 10)),
    "extruded downward": (downward, STADIUM, (-5, 0, 25, 10)),
    "arcs of both directions": (both_directions, STADIUM, (-5, 0, 25, 10)),
    "circle": (lambda s: s.add_circle((5, 5), 10), 100 * PI, (-5, -5, 15, 15)),
    "ellipse": (lambda s: s.add_ellipse((0, 0), (0, 20), 0.25), 100 * PI, (-5, -20, 5, 20)),
    "half an ellipse": (
        lambda s: (s.add_ellipse((0, 0), (20, 0), 0.25, 0, PI), s.add_line((-20, 0), (20, 0))),
        50 * PI, (-20, 0, 20, 5),
    ),
    "spline": (spline_circle, 100 * PI, (-5, -5, 15, 15)),
    "fitted spline": (
        lambda s: s.add_spline([(10 * math.cos(a), 10 * math.sin(a)) for a in np.linspace(0, 2 * PI, 60)]),
        100 * PI, (-10, -10, 10, 10),
    ),
    "solid": (lambda s: s.add_solid([(0, 0), (20, 0), (0, 20), (20, 20)]), 400, (0, 0, 20, 20)),
    "triangle": (lambda s: s.add_solid([(0, 0), (20, 0), (0, 20)]), 200, (0, 0, 20, 20)),
    "hatch": (hatch, 900 - 25 * PI + 4.5 * PI, (0, 0, 30, 30)),
    "hatch of edges": (hatch_with_clockwise_edges, 100 + 12.5 * PI + 12.5 * PI / 2, (-2.5, 0, 15, 10)),
    "hole and island": (
        lambda s: (square(s, 40), s.add_circle((20, 20), 15), square(s, 10, (15, 15))),
        1600 - 225 * PI + 100, (0, 0, 40, 40),
    ),
    "squares that meet in a corner": (
        lambda s: (lines_of(s, SQUARE), lines_of(s, [(20, 20), (30, 20), (30, 30), (20, 30)])),
        500, (0, 0, 30, 30),
    ),
    "raised": (lambda s: square(s, elevation=7.0), 400, (0, 0, 20, 20)),
}  # fmt: skip


@pytest.mark.parametrize("name", DRAWN)
def test_areas(dxf, name):
    draw, area, bounds = DRAWN[name]
    drawing = dxf(draw, flatness=1e-7)
    assert drawing.notes == ()
    found = drawing.area()
    most = 1.5e-2 if name != "fitted spline" else 0.2
    assert found.area * 1e6 == pytest.approx(area, abs=most)
    assert np.array(found.bounds) * 1e3 == pytest.approx(bounds, abs=1e-2)


def test_flatness(dxf):
    """A chord leaves out at most the flatness, so the area lacks at most that times the arc."""
    for flatness in (1e-7, 5e-6, 1e-4):
        lacks = STADIUM * 1e-6 - dxf(bulged, flatness=flatness).area().area
        assert 0.2 < lacks / (10e-3 * PI * flatness) < 1.0
    wavy = [(x, 5 * math.sin(x)) for x in range(0, 31, 2)]
    fine = dxf(lambda s: s.add_spline(wavy), flatness=1e-8).lines()
    coarse = dxf(lambda s: s.add_spline(wavy)).lines()
    assert coarse.hausdorff_distance(fine) < FLAT


def nested(space, **placing):
    inner = space.doc.blocks.new("INNER", base_point=(1, 0))
    inner.add_circle((1, 0), 1)
    inner.add_line((0, 2), (3, 2), dxfattribs={"layer": "slits"})
    outer = space.doc.blocks.new("OUTER")
    outer.add_blockref("INNER", (10, 0), dxfattribs={"xscale": 2, "yscale": 1, "rotation": 90})
    space.add_blockref("OUTER", (5, 5), dxfattribs={"layer": "holes", **placing})


@pytest.mark.parametrize(
    ("placing", "centre", "size"),
    [
        ({}, (15, 5), (2, 4)),
        ({"xscale": 3, "yscale": 3}, (35, 5), (6, 12)),
        ({"rotation": 90}, (5, 15), (4, 2)),
        ({"xscale": -1}, (-5, 5), (2, 4)),
        ({"xscale": -2, "yscale": 1, "rotation": 180}, (25, 5), (4, 4)),
        ({"extrusion": (0, 0, -1)}, (-15, 5), (2, 4)),
    ],
)
def test_nested_blocks(dxf, placing, centre, size):
    drawing = dxf(lambda space: nested(space, **placing))
    assert set(drawing.layers) == {"holes", "slits"}
    area = drawing.area("HOLES")
    box = np.array(area.bounds) * 1e3
    assert (box[:2] + box[2:]) / 2 == pytest.approx(centre, abs=6e-3)
    assert box[2:] - box[:2] == pytest.approx(size, abs=2e-2)
    assert area.area * 1e6 == pytest.approx(PI / 4 * size[0] * size[1], rel=1e-2)
    scale = abs(placing.get("xscale", 1)), abs(placing.get("yscale", 1))
    # The slit of 3 mm was doubled and turned upright within its block.
    assert drawing.lines("slits").length * 1e3 == pytest.approx(6 * scale[1])


def test_rows_of_blocks(dxf):
    def draw(space):
        space.doc.blocks.new("DOT").add_circle((0, 0), 1)
        space.add_blockref("DOT", (0, 0), dxfattribs={"row_count": 3, "column_count": 4, "row_spacing": 10, "column_spacing": 5})  # fmt: skip

    area = dxf(draw).area()
    assert len(area.geoms) == 12
    assert np.array(area.bounds) * 1e3 == pytest.approx((-1, -1, 16, 21), abs=1e-2)


def test_layers_and_lines(dxf):
    def draw(space):
        square(space, layer="Sheet")
        space.add_line((5, 5), (15, 5), dxfattribs={"layer": "SLITS"})
        space.add_line((15, 5), (15, 9), dxfattribs={"layer": "slits"})
        space.doc.layers.add("hidden").off()
        square(space, 90, layer="hidden")

    drawing = dxf(draw)
    assert drawing.area("SHEET").area == pytest.approx(4e-4)
    slits = drawing.lines("Slits")
    assert len(slits.geoms) == 1
    assert slits.length == pytest.approx(14e-3)
    assert drawing.lines("sheet").length == pytest.approx(0.08)
    assert drawing.notes == ("a hidden LWPOLYLINE on layer 'hidden' was ignored",)


def test_an_outline_spread_over_layers(dxf):
    def draw(space):
        for k, (a, b) in enumerate(zip(SQUARE, SQUARE[1:] + SQUARE[:1], strict=True)):
            space.add_line(a, b, dxfattribs={"layer": f"L{k}"})

    assert dxf(draw).area().area == pytest.approx(4e-4)


def test_what_is_mended_is_noted(dxf):
    def draw(space):
        space.add_line((0, 0), (20, 0))
        space.add_line((20, 0.004), (20, 20))
        space.add_line((20, 20), (0, 20))
        space.add_line((0, 20), (0, 0))
        space.add_line((0, 20), (20, 20))
        space.add_line((7, 8), (7, 8))
        space.add_lwpolyline([(3, 3), (6, 3), (6, 3), (6, 6)], close=True)
        space.add_circle((12, 12), 2)
        space.add_circle((12, 12), 2)
        space.add_text("A").set_placement((1, 2))
        space.add_line((0, 0, 0), (5, 5, 5))
        space.add_point((1, 1))

    drawing = dxf(draw)
    said = "\n".join(drawing.notes)
    for words in (
        "a gap of 0.004 mm at (20, 0.002) mm was closed",
        "the line at (0, 20) mm is drawn twice and was kept once",
        "a line of length zero at (7, 8) mm was dropped",
        "a segment of length zero at (6, 3) mm was dropped",
        "the contour at (14, 12) mm is drawn twice and was kept once",
        "TEXT on layer '0' at (1, 2) mm is no flat curve and was ignored",
        "LINE on layer '0' at (0, 0) mm leaves the plane and was ignored",
        "POINT on layer '0' at (1, 1) mm",
    ):
        assert words in said
    assert len(drawing.notes) == 8
    assert drawing.area().area * 1e6 == pytest.approx(400 - 4.5 - 4 * PI, abs=0.1)


def crossing(space):
    square(space)
    square(space, corner=(15, 5))


BROKEN = {
    "open": (lambda s: s.add_lwpolyline([(0, 0), (20, 0), (20, 20), (0.4, 0)]), r"open contour: ends at \(0, 0\) mm and \(0.4, 0\) mm are 0.4 mm apart.*allowed: gap of 0.01 mm"),
    "open by a little": (lambda s: (lines_of(s, [(0, 0), (5, 5), (9, 0)]), s.add_lwpolyline([(0, 30), (20, 30), (20, 40), (0, 30.02)])), r"\(0, 30\) mm and \(0, 30.02\) mm are 0.02 mm apart"),
    "branch": (lambda s: (lines_of(s, SQUARE), s.add_line((0, 0), (5, 5))), r"3 ends of lines meet at \(0, 0\) mm|open contour: ends at \(0, 0\) mm"),
    "crosses itself": (lambda s: s.add_lwpolyline([(0, 0), (20, 20), (20, 0), (0, 20)], close=True), r"a contour crosses itself at \(10, 10\) mm"),
    "two cross": (crossing, r"two contours cross at \(20, 5\) mm.*overlaps"),
    "lines alone": (lambda s: s.add_line((0, 0), (10, 0)), r"\(0, 0\) mm and \(10, 0\) mm are 10 mm apart"),
    "empty": (lambda s: None, "nothing that can be read"),
    "text alone": (lambda s: s.add_text("A"), "nothing that can be read"),
    "tiny": (lambda s: square(s, 0.05), r"the drawing is 0.05 mm wide; did you draw in m\? set unit = 'm'"),
    "huge": (lambda s: square(s, 120000), r"the drawing is 120 m wide; did you draw in um\? set unit = 'um'"),
    "not finite": (lambda s: s.add_line((0, 0), (1e300, 1e300)), "out of bounds"),
    "wild spline": (lambda s: s.add_spline_control_frame([(0, 0), (1e9, 4e8), (1, 5), (9e8, -3e9), (3, 3)]), "out of bounds|too many points"),
    "many points": (lambda s: s.add_circle((0, 0), 1e30), "out of bounds|too many points"),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_broken(dxf, name):
    draw, says = BROKEN[name]
    with pytest.raises(InputError, match=says) as caught:
        dxf(draw).area()
    assert "\n" not in str(caught.value)
    assert "drawing.dxf" in str(caught.value)


def test_unite_contours_that_cross(dxf):
    region = dxf(crossing).region(overlaps="union")
    assert region.shape.area * 1e6 == pytest.approx(800 - 75)
    assert region.notes == ("1 pairs of contours cross, one at (20, 5) mm: united",)
    with pytest.raises(InputError, match="overlaps"):
        dxf(crossing).area(overlaps="maybe")


def test_blocks_that_contain_blocks(dxf, monkeypatch):
    def itself(space):
        block = space.doc.blocks.new("A")
        block.add_blockref("A", (1, 0))
        space.add_blockref("A", (0, 0))

    def laughs(space):
        space.doc.blocks.new("B0").add_circle((0, 0), 1)
        for k in range(1, 10):
            block = space.doc.blocks.new(f"B{k}")
            for j in range(10):
                block.add_blockref(f"B{k - 1}", (j, 0))
        space.add_blockref("B9", (0, 0))

    def rows(space):
        space.doc.blocks.new("C").add_circle((0, 0), 1)
        counts = {"row_count": 30000, "column_count": 30000, "row_spacing": 1, "column_spacing": 1}
        space.add_blockref("C", (0, 0), dxfattribs=counts)

    def missing(space):
        square(space)
        space.add_blockref("NOBODY", (3, 4))

    with pytest.raises(InputError, match="nested too deeply at 'A'"):
        dxf(itself)
    monkeypatch.setattr("sheetmorph.drawing.dxf.MAX_COPIES", 300)
    for draw in (laughs, rows):
        with pytest.raises(InputError, match="too many blocks"):
            dxf(draw)
    assert "block 'NOBODY' at (3, 4) mm is missing" in dxf(missing).notes[0]


def test_binary_and_old_files(tmp_path):
    for release in ("R12", "R2000", "R2018"):
        document = ezdxf.new(release)
        document.header["$INSUNITS"] = 4
        lines_of(document.modelspace(), SQUARE)
        for kind in ("asc", "bin"):
            path = tmp_path / f"{release}{kind}.DXF"
            document.saveas(path, fmt=kind)
            assert read_drawing(path, unit="mm").area().area == pytest.approx(4e-4)


def test_many_loose_lines(dxf):
    """A contour of many pieces, each shorter than the gap: ends in one place go first."""

    def draw(space):
        angle = np.linspace(0.0, 2 * PI, 1501)[:-1]
        points = [(2 * math.cos(a), 2 * math.sin(a)) for a in angle]
        lines_of(space, points)

    drawing = dxf(draw)
    assert drawing.notes == ()
    area = drawing.area()
    assert area.area * 1e6 == pytest.approx(4 * PI, rel=1e-5)
    assert len(area.geoms) == 1
