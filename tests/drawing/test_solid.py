from __future__ import annotations

# ruff: noqa: E501
import struct
import sys
import zipfile

import lib3mf
import numpy as np
import pytest
import shapely
import trimesh

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.read import read_drawing

# In millimetres, as the files have it.
PLATE = shapely.box(-20, -10, 30, 25).difference(shapely.Point(3, 4).buffer(5, 30))
OTHER = shapely.box(40, 0, 50, 10)


def solid(flat, height=2.0):
    return trimesh.creation.extrude_polygon(flat, height)


def metres(flat, scale=1e-3):
    return shapely.affinity.scale(flat, scale, scale, origin=(0, 0))


def check(found, flat, scale=1e-3):
    want = metres(flat, scale)
    assert found.hausdorff_distance(want) < 1e-5 * scale
    assert found.area == pytest.approx(want.area, rel=1e-6)


@pytest.mark.parametrize("kind", ["stl", "stl_ascii"])
def test_plate_as_stl(tmp_path, kind):
    path = tmp_path / "a.stl"
    data = solid(PLATE).export(file_type=kind)
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    drawing = read_drawing(path)
    assert drawing.notes == ()
    assert drawing.unit == "mm"
    check(drawing.area(), PLATE)
    check(read_drawing(path, unit="cm").area(), PLATE, 1e-2)


def test_flat_surface_turned_either_way(tmp_path):
    vertices, faces = trimesh.creation.triangulate_polygon(PLATE, engine="earcut")
    for order in (faces, faces[:, ::-1]):
        mesh = trimesh.Trimesh(np.column_stack([vertices, np.full(len(vertices), 3.0)]), order)
        path = tmp_path / "a.stl"
        path.write_bytes(mesh.export(file_type="stl"))
        check(read_drawing(path).area(), PLATE)


def test_steps_and_slopes_are_noted(tmp_path):
    stepped = trimesh.util.concatenate([solid(PLATE), solid(OTHER, 5.0)])
    path = tmp_path / "a.stl"
    path.write_bytes(stepped.export(file_type="stl"))
    drawing = read_drawing(path)
    check(drawing.area(), PLATE.union(OTHER))
    assert "flat faces at 3 heights over 5 mm" in drawing.notes[0]
    cone = trimesh.creation.cone(10.0, 5.0)
    path.write_bytes(cone.export(file_type="stl"))
    assert "tilted" in read_drawing(path).notes[0]
    path.write_bytes(trimesh.creation.icosphere().export(file_type="stl"))
    with pytest.raises(InputError, match="no face that lies in a plane"):
        read_drawing(path)


def by_lib3mf(path, unit=None, **solids):
    model = lib3mf.get_wrapper().CreateModel()
    if unit is not None:
        model.SetUnit(unit)
    for name, mesh in solids.items():
        made = model.AddMeshObject()
        made.SetName(name)
        corners = [
            lib3mf.Position((lib3mf.ctypes.c_float * 3)(*map(float, v))) for v in mesh.vertices
        ]
        triangles = [
            lib3mf.Triangle((lib3mf.ctypes.c_uint32 * 3)(*map(int, f))) for f in mesh.faces
        ]
        made.SetGeometry(corners, triangles)
        transform = lib3mf.get_wrapper().GetTranslationTransform(0.0, 0.0, 7.0)
        model.AddBuildItem(made, transform)
    model.QueryWriter("3mf").WriteToFile(str(path))


def test_plates_by_lib3mf(tmp_path):
    path = tmp_path / "a.3mf"
    by_lib3mf(path, SHEET=solid(PLATE), PATTERN=solid(OTHER))
    drawing = read_drawing(path)
    assert drawing.notes == ()
    assert list(drawing.layers) == ["SHEET", "PATTERN"]
    check(drawing.area("SHEET"), PLATE)
    check(drawing.area("pattern"), OTHER)
    check(drawing.area(), PLATE.union(OTHER))
    with pytest.raises(InputError, match="did you mean 'SHEET'"):
        drawing.area("SHEETS")
    by_lib3mf(path, lib3mf.ModelUnit.Inch, SHEET=solid(PLATE))
    assert read_drawing(path).unit == "in"
    check(read_drawing(path).area(), PLATE, 0.0254)
    check(read_drawing(path, unit="mm").area(), PLATE)


MODEL = """<?xml version="1.0"?><model unit="{unit}" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">
<resources><object id="1" name="leaf"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="10" y="0" z="0"/>
<vertex x="0" y="10" z="0"/></vertices><triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh></object>
<object id="2" name="pair"><components><component objectid="1"/><component objectid="{inner}" transform="{transform}"/>
</components></object></resources><build><item objectid="{item}"/></build></model>"""  # fmt: skip
WHOLE = {"unit": "millimeter", "inner": 1, "transform": "0 1 0 -1 0 0 0 0 1 0 20 0", "item": 2}


OPC = "http://schemas.openxmlformats.org/package/2006/"
TYPES = f"""<Types xmlns="{OPC}content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>"""
LINKS = f"""<Relationships xmlns="{OPC}relationships"><Relationship Id="r" Target="/3D/3dmodel.model"
Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"""


def packed(path, text, name="3D/3dmodel.model"):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("[Content_Types].xml", TYPES)
        archive.writestr("_rels/.rels", LINKS)
        archive.writestr(name, text)


def test_components_are_placed(tmp_path):
    path = tmp_path / "a.3mf"
    packed(path, MODEL.format(**WHOLE))
    area = read_drawing(path).area("pair")
    assert area.area == pytest.approx(1e-4)
    assert area.bounds == pytest.approx((-0.01, 0, 0.01, 0.03))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"unit": "mile"}, "no such unit"),
        ({"inner": 2}, "Could not find Object associated to Component"),
        ({"inner": 7}, "Could not find Object associated to Component"),
        ({"item": 9}, "Could not find Object associated to the Build item"),
        ({"transform": "1 0 0"}, "Not enough values"),
        ({"transform": "1 0 0 0 1 0 0 0 1 1e999 0 0"}, "no readable 3MF"),
        ({"transform": "1 0 0 0 1 0 0 0 1 1e99 0 0"}, "not finite"),
        ({"transform": "1 0 0 0 1 0 0 0 1 1e9 0 0"}, "out of bounds"),
    ],
)
def test_broken_models(tmp_path, change, says):
    path = tmp_path / "a.3mf"
    packed(path, MODEL.format(**WHOLE | change))
    with pytest.raises(InputError, match=says):
        read_drawing(path)


def test_machines_without_lib3mf(tmp_path, monkeypatch):
    path = tmp_path / "a.3mf"
    packed(path, MODEL.format(**WHOLE))
    monkeypatch.setitem(sys.modules, "lib3mf", None)
    with pytest.raises(InputError, match="lib3mf is missing; save it as STL"):
        read_drawing(path)


def test_archives_that_burst(tmp_path):
    path = tmp_path / "a.3mf"
    packed(path, b"<model>" + b" " * (51 * 2**20) + b"</model>")
    with pytest.raises(InputError, match="too large"):
        read_drawing(path)
    packed(path, '<!DOCTYPE a [<!ENTITY b "c">]><model>&b;</model>')
    with pytest.raises(InputError, match="defines XML entities"):
        read_drawing(path)
    packed(path, "<model/>", "readme.txt")
    with pytest.raises(InputError, match="holds no model"):
        read_drawing(path)


@pytest.mark.parametrize(("copies", "levels"), [(1, 10), (9, 6)])
def test_components_that_multiply(tmp_path, copies, levels):
    whole = MODEL.format(**WHOLE)
    many = "".join(
        f'<object id="{k}"><components>'
        + f'<component objectid="{k - 1}"/>' * copies
        + "</components></object>"
        for k in range(3, 3 + levels)
    )
    path = tmp_path / "a.3mf"
    text = whole.replace("</resources>", many + "</resources>")
    packed(path, text.replace('<item objectid="2"/>', f'<item objectid="{2 + levels}"/>'))
    with pytest.raises(InputError, match="too many or nested too deeply"):
        read_drawing(path)


def test_triangles_are_counted_before_they_are_united(tmp_path, monkeypatch):
    monkeypatch.setattr("sheetmorph.drawing.solid.MAX_TRIANGLES", 100)
    data = solid(PLATE).export(file_type="stl")
    for name, content in (("a.stl", data), ("b.stl", solid(PLATE).export(file_type="stl_ascii"))):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        with pytest.raises(InputError, match="number of triangles is out of bounds"):
            read_drawing(path)
    by_lib3mf(tmp_path / "a.3mf", SHEET=solid(PLATE))
    with pytest.raises(InputError, match="number of triangles is out of bounds"):
        read_drawing(tmp_path / "a.3mf")


def test_stl_that_lies(tmp_path, capfd):
    path = tmp_path / "a.stl"
    path.write_bytes(bytes(80) + struct.pack("<I", 4_000_000_000) + bytes(50))
    with pytest.raises(InputError, match="4000000000 triangles are announced, 1 are there"):
        read_drawing(path)
    path.write_bytes(b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 nan\n"
                     b"vertex 0 1 0\nendloop\nendfacet\nendsolid a\n")  # fmt: skip
    with pytest.raises(InputError, match="not finite"):
        read_drawing(path)
    path.write_bytes(path.read_bytes().replace(b"nan", b"apple"))
    with pytest.raises(InputError, match="no readable STL"):
        read_drawing(path)
    path.write_bytes(
        solid(PLATE).export(file_type="stl_ascii").replace("normal 0", "normal x").encode()
    )
    check(read_drawing(path).area(), PLATE)
    assert capfd.readouterr() == ("", "")
    flat = solid(PLATE)
    flat.vertices[0] = np.nan
    path.write_bytes(trimesh.exchange.stl.export_stl(flat))
    with pytest.raises(InputError, match="not finite"):
        read_drawing(path)
