"""Whatever the bytes: a drawing or one line that says what is wrong with them."""

# ruff: noqa: E501
from __future__ import annotations

import io
import random

import ezdxf
import pytest
import shapely
import trimesh

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.read import READERS, read_drawing
from sheetmorph.drawing.write import Ink, dxf_bytes, svg_bytes

RING = shapely.Point(0.01, 0.02).buffer(0.03, 4).difference(shapely.box(0, 0.01, 0.02, 0.03))


def rich_dxf(kind):
    document = ezdxf.new("R2000")
    document.header["$INSUNITS"] = 4
    space = document.modelspace()
    block = document.blocks.new("B")
    block.add_circle((1, 1), 2)
    space.add_blockref("B", (20, 3), dxfattribs={"xscale": 2, "rotation": 30})
    space.add_lwpolyline([(0, 0, 0.3), (9, 0, 0), (9, 9, 0)], format="xyb", close=True)
    space.add_spline([(30, 0), (40, 10), (50, 0), (40, -10), (30, 0)])
    space.add_ellipse((60, 0), (5, 0), 0.5)
    fill = space.add_hatch()
    fill.paths.add_edge_path().add_arc((70, 0), 3, 0, 360)
    stream = io.StringIO() if kind == "asc" else io.BytesIO()
    document.write(stream, fmt=kind)
    data = stream.getvalue()
    return data if isinstance(data, bytes) else data.encode()


def three_mf():
    solid = trimesh.creation.extrude_polygon(shapely.affinity.scale(RING, 1e3, 1e3), 1.0)
    return trimesh.Scene([solid]).export(file_type="3mf")


def stl(kind):
    solid = trimesh.creation.extrude_polygon(shapely.affinity.scale(RING, 1e3, 1e3), 1.0)
    data = solid.export(file_type=kind)
    return data if isinstance(data, bytes) else data.encode()


STYLED = b"""<svg xmlns="http://www.w3.org/2000/svg" width="90mm" height="90mm" viewBox="0 0 90 90">
<style>.a { fill: red; stroke: blue } g > #b { fill: none }</style><defs><symbol id="s" viewBox="0 0 9 9">
<path d="M0 0h9v9h-9z"/></symbol></defs><g transform="rotate(30 9 9)" class="a"><use href="#s" width="20" height="20"/>
<path id="b" d="M30 30A9 9 0 0 1 50 50C1 2 3 4 5 6Q7 8 9 10z" stroke-width="2"/></g></svg>"""
FILES = {
    "svg": (".svg", lambda: svg_bytes([Ink("SHEET", (RING,))])),
    "styled svg": (".svg", lambda: STYLED),
    "dxf": (".dxf", lambda: rich_dxf("asc")),
    "small dxf": (".dxf", lambda: dxf_bytes([Ink("SHEET", (RING,))])),
    "binary dxf": (".dxf", lambda: rich_dxf("bin")),
    "stl": (".stl", lambda: stl("stl")),
    "text stl": (".stl", lambda: stl("stl_ascii")),
    "3mf": (".3mf", three_mf),
}


def accepts(path):
    """Whether a file is read; anything but an InputError of one line is a failure."""
    try:
        drawing = read_drawing(path)
        drawing.area(strokes=True)
        drawing.lines()
    except InputError as error:
        assert "\n" not in str(error)
        assert path.name in str(error)
        return False
    return True


@pytest.mark.parametrize("name", FILES)
def test_cut_off(tmp_path, name):
    ending, make = FILES[name]
    data = make()
    path = tmp_path / f"a{ending}"
    path.write_bytes(data)
    assert accepts(path) or name in ("dxf", "binary dxf")
    for k in range(25):
        path.write_bytes(data[: len(data) * k // 25])
        assert not accepts(path), k


@pytest.mark.parametrize("name", FILES)
def test_flipped_bytes(tmp_path, name):
    ending, make = FILES[name]
    data = make()
    chance = random.Random(f"{name} 1")
    path = tmp_path / f"a{ending}"
    for k in range(8 if name in ("dxf", "binary dxf", "small dxf") else 40):
        changed = bytearray(data)
        # The end of a large DXF holds the entities; what comes before is boilerplate.
        first = len(data) * 2 // 3 if "dxf" in name and k % 2 else 0
        for _ in range(chance.choice((1, 5, 50))):
            changed[chance.randrange(first, len(data))] = chance.randrange(256)
        path.write_bytes(bytes(changed))
        accepts(path)


@pytest.mark.parametrize("ending", READERS)
def test_what_is_no_drawing(tmp_path, ending):
    chance = random.Random(2)
    path = tmp_path / f"a{ending}"
    with pytest.raises(InputError, match="there is no such file"):
        read_drawing(path)
    with pytest.raises(InputError, match="is not a file"):
        (tmp_path / f"b{ending}").mkdir()
        read_drawing(tmp_path / f"b{ending}")
    for data in (
        b"",
        b"\0" * 500,
        b"hello",
        chance.randbytes(3000),
        b"\xff\xfe" + "é".encode("utf-16"),
    ):
        path.write_bytes(data)
        assert not accepts(path)
    with path.open("wb") as stream:
        stream.truncate(21 * 2**20)
    with pytest.raises(InputError, match="too large"):
        read_drawing(path)


def test_what_cannot_be_asked(tmp_path):
    path = tmp_path / "a.svg"
    path.write_bytes(STYLED)
    for options, says in (
        ({"unit": "parsec"}, "no such unit"),
        ({"flatness": 0.0}, "flatness"),
        ({"flatness": float("nan")}, "flatness"),
        ({"gap": -1.0}, "gap"),
    ):
        with pytest.raises(InputError, match=says):
            read_drawing(path, **options)
    with pytest.raises(InputError, match=r"did you mean \.svg"):
        read_drawing(tmp_path / "a.svgz")
