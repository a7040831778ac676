from __future__ import annotations

import io
import math
import re
from pathlib import Path

import ezdxf
import numpy as np
import pytest
import resvg_py
import shapely
from matplotlib.image import imread

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.read import read_drawing
from sheetmorph.drawing.write import Ink, dxf_bytes, svg_bytes

DISC = shapely.Point(0.013, -0.02).buffer(0.03, 90)
ANGLE = np.linspace(0.0, 2.0 * math.pi, 400, endpoint=False)
WAVE = shapely.Polygon(
    np.stack([np.cos(ANGLE), np.sin(ANGLE)], axis=1) * (0.04 + 0.006 * np.sin(7 * ANGLE))[:, None]
)
RING = DISC.difference(DISC.centroid.buffer(0.02, 77))
AREAS = {
    "disc": DISC,
    "wave": WAVE,
    "ring": RING,
    "island in a hole": RING.union(DISC.centroid.buffer(0.01, 33)),
    "island of an island": RING.union(DISC.centroid.buffer(0.015)).difference(
        DISC.centroid.buffer(0.004)
    ),
    "two parts": shapely.MultiPolygon([shapely.box(0, 0, 0.01, 0.02), shapely.box(1, 1, 1.3, 1.1)]),
    "two that touch": shapely.box(0, 0, 0.01, 0.01).union(shapely.box(0.01, 0.01, 0.02, 0.02)),
    "hole that touches": shapely.Polygon(
        [(0, 0), (0.03, 0), (0.03, 0.03), (0, 0.03)],
        [[(0.015, 0), (0.02, 0.01), (0.01, 0.01)]],
    ),
    "grid of holes": shapely.box(-0.05, -0.05, 0.05, 0.05).difference(
        shapely.union_all(
            [
                shapely.Point(x, y).buffer(0.002)
                for x in np.linspace(-0.04, 0.04, 7)
                for y in (-0.03, 0.01)
            ]
        )
    ),
    "thin": shapely.box(-0.2, 0.001, 0.3, 0.00101),
    "far": shapely.affinity.translate(WAVE, -3.3333333, 2.1234567891),
    "third": shapely.affinity.rotate(shapely.box(0, 0, 1 / 3, 1 / 7), 17.0),
}
LINES = shapely.MultiLineString(
    [[(0, 0), (0.01, 0.02)], [(-0.01, 0.001), (-0.02, 1 / 300), (-0.03, 0.001)]]
)
WRITERS = {".dxf": dxf_bytes, ".svg": svg_bytes}

LEAF = Path(__file__).resolve().parents[2] / "examples" / "leaf" / "leaf.svg"


@pytest.mark.parametrize("ending", WRITERS)
@pytest.mark.parametrize("name", AREAS)
def test_areas_come_back(tmp_path, name, ending):
    area = AREAS[name]
    path = tmp_path / f"a{ending}"
    path.write_bytes(WRITERS[ending]([Ink("SHEET", (area,)), Ink("slits", (LINES,), "blue")]))
    drawing = read_drawing(path)
    assert drawing.notes == ()
    assert drawing.unit == "mm"
    back = drawing.area("SHEET")
    assert back.is_valid
    assert back.hausdorff_distance(area) < 1e-9
    assert back.area == pytest.approx(area.area, rel=1e-7)
    assert back.symmetric_difference(area).area < 1e-9 * area.length
    assert drawing.lines("slits").hausdorff_distance(LINES) < 1e-9


def test_closed_lines_and_collections(tmp_path):
    square = shapely.LinearRing([(0, 0), (0.01, 0), (0.01, 0.01), (0, 0.01)])
    mixed = shapely.GeometryCollection(
        [shapely.MultiPolygon([shapely.box(0.02, 0, 0.03, 0.01)]), square]
    )
    for ending, write in WRITERS.items():
        path = tmp_path / f"a{ending}"
        path.write_bytes(write([Ink("a", (mixed,))]))
        assert read_drawing(path).area("a").area == pytest.approx(2e-4, rel=1e-9)


@pytest.mark.parametrize("name", ["wave", "island in a hole", "two parts", "grid of holes"])
def test_svg_looks_right_elsewhere(name):
    area = AREAS[name]
    text = svg_bytes([Ink("a", (area,), "#000000")], margin=0.002).decode()
    low, high = np.array(area.bounds[:2]) - 0.002, np.array(area.bounds[2:]) + 0.002
    filled = text.replace('fill="none"', 'fill="black"').replace(
        'stroke="#000000"', 'stroke="none"'
    )
    width = 900
    png = resvg_py.svg_to_bytes(svg_string=filled, background="white", width=width, dpi=96)
    dark = 1.0 - imread(io.BytesIO(bytes(png)))[:, :, 0]
    # The renderer rounds the page to whole pixels before it scales it.
    down, across = (high - low)[::-1] / dark.shape
    assert down == pytest.approx(across, rel=4e-3)
    assert dark.sum() * across * down == pytest.approx(area.area, rel=4e-3)
    # It stands upright: the centre of what is dark lies where the centroid does.
    rows, columns = np.indices(dark.shape)
    x = low[0] + across * ((dark * columns).sum() / dark.sum() + 0.5)
    y = high[1] - down * ((dark * rows).sum() / dark.sum() + 0.5)
    assert (x, y) == pytest.approx((area.centroid.x, area.centroid.y), abs=1.5 * across)


def test_dxf_is_clean_and_in_millimetres():
    data = dxf_bytes([Ink("SHEET", (RING,)), Ink("Hinge 1", (LINES,), "#0000ff")])
    document = ezdxf.read(io.StringIO(data.decode()))
    audit = document.audit()
    assert not audit.errors
    assert not audit.fixes
    assert document.header["$INSUNITS"] == 4
    assert document.dxfversion == "AC1024"
    assert document.layers.get("Hinge 1").rgb == (0, 0, 255)
    polylines = list(document.modelspace())
    assert {entity.dxftype() for entity in polylines} == {"LWPOLYLINE"}
    assert [entity.closed for entity in polylines] == [True, True, False, False]
    assert {entity.dxf.lineweight for entity in polylines} == {0}


def test_bytes_are_the_same_every_time():
    inks = [Ink("SHEET", (RING,)), Ink("b", (LINES,))]
    for write in WRITERS.values():
        assert write(inks) == write(inks)
    assert b"202" not in re.sub(rb"\d+\.\d+", b"", svg_bytes(inks))
    from ezdxf._options import options

    assert not options.write_fixed_meta_data_for_testing


def test_numbers_and_page_of_svg():
    text = svg_bytes(
        [Ink("a & b".replace("&", "+"), (shapely.box(-0.01, 0.02, 0.03, 0.05),))],
        margin=0.005,
        title="1 < 2",
    ).decode()
    assert 'width="50mm" height="40mm" viewBox="-15 -55 50 40"' in text
    assert 'data-sheetmorph-origin="-15 15"' in text
    assert "<title>1 &lt; 2</title>" in text
    assert 'stroke-width="0.01"' in text


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Ink("", ()), "no name for a layer"),
        (lambda: Ink("a<b", ()), "no name for a layer"),
        (lambda: Ink("a", (), "rouge"), "no such colour"),
        (lambda: Ink("a", (shapely.Point(0, 0),)), "only areas and lines"),
        (lambda: Ink("a", (shapely.box(0, 0, 1, 2e3),)), "out of bounds"),
        (lambda: svg_bytes([]), "nothing to draw"),
        (lambda: svg_bytes([Ink("a", (DISC,))], margin=math.nan), "margin"),
        (lambda: dxf_bytes([Ink("a", (DISC,)), Ink("A", (DISC,))]), "the same name"),
    ],
)
def test_what_cannot_be_written(make, says):
    with pytest.raises(InputError, match=says):
        make()


def test_leaf():
    drawing = read_drawing(LEAF)
    assert drawing.notes == ()
    sheet, veins = drawing.area("SHEET"), drawing.area("PATTERN", strokes=True)
    assert (len(sheet.geoms), len(veins.geoms)) == (1, 1)
    assert sheet.contains(veins)
    assert drawing.area("veins", strokes=True).equals(veins)
    # Veins that start in one point of the midrib come back as one line.
    assert len(drawing.lines("PATTERN").geoms) == 4
    names = ["midrib", *(f"vein{k}" for k in range(1, 7))]
    lengths = [drawing.lines(name).length for name in names]
    widths = [2.4e-3] + 6 * [1.5e-3]
    whole = sum(n * w + math.pi * w * w / 4 for n, w in zip(lengths, widths, strict=True))
    assert 0.94 * whole < veins.area < whole
    # The render's green and the area agree.
    text = LEAF.read_text("utf-8")
    text = text.replace("stroke:#3f7d2c", "stroke:none").replace("#2d6a1f", "#000000")
    png = resvg_py.svg_to_bytes(svg_string=text, background="white", width=1200, dpi=96)
    image = imread(io.BytesIO(bytes(png)))[:, :, :3]
    pixel = (0.12 / image.shape[1]) ** 2
    assert (image.min(axis=2) < 0.9).sum() * pixel == pytest.approx(sheet.area, rel=2e-3)
    assert (image.max(axis=2) < 0.4).sum() * pixel == pytest.approx(veins.area, rel=1e-2)
