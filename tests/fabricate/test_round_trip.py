"""What is written is what was designed: every file read back, by our readers and by others'."""

from __future__ import annotations

import io
import re
from pathlib import Path

import numpy as np
import pytest
import shapely
from shapely.geometry.base import BaseGeometry

from sheetmorph.design.spec import Design
from sheetmorph.drawing.read import read_drawing
from sheetmorph.drawing.write_dxf import dxf_bytes
from sheetmorph.drawing.write_svg import svg_bytes
from sheetmorph.fabricate import cut
from sheetmorph.fabricate.print3d import PrintedPart, lay_on_bed
from sheetmorph.fabricate.printer import GENERIC
from sheetmorph.fabricate.solid_files import bytes_3mf, bytes_stl
from sheetmorph.fabricate.stack import levels_of

PAGE = Path(__file__).resolve().parents[2] / "docs" / "patterns.md"

TEXTS = {
    "star": '[[pattern]]\nkind = "star"\narms = 6\narm_length = "44 mm"\nhalf_width = "5.9 mm"',
    "crossing bars": (
        '[[pattern]]\nkind = "bar"\nstart = ["-40 mm", "0 mm"]\nend = ["40 mm", "9 mm"]\n'
        'half_width = "2 mm"\n[[pattern]]\nkind = "bar"\nstart = ["0 mm", "-40 mm"]\n'
        'end = ["3 mm", "40 mm"]\nhalf_width = "2 mm"'
    ),
    "islands": (
        '[[pattern]]\nkind = "disc"\nradius = "4 mm"\ncentre = ["30 mm", "0 mm"]\n'
        "polar_array = { count = 7 }"
    ),
    "ring with an island in it": (
        '[[pattern]]\nkind = "disc"\nradius = "40 mm"\n[[pattern]]\nkind = "disc"\n'
        'radius = "30 mm"\noperation = "difference"\n[[pattern]]\nkind = "disc"\nradius = "10 mm"'
    ),
    "holes": (
        '[[pattern]]\nkind = "rectangle"\nwidth = "60 mm"\nheight = "60 mm"\n[[pattern]]\n'
        'kind = "regular_polygon"\nsides = 6\nradius = "5 mm"\noperation = "difference"\n'
        'centre = ["-20 mm", "-20 mm"]\n'
        'grid_array = { columns = 3, rows = 3, dx = "20 mm", dy = "20 mm" }'
    ),
    "fillets": (
        '[[pattern]]\nkind = "star"\narms = 4\narm_length = "40 mm"\nhalf_width = "4 mm"\n'
        'fillet = "5 mm"\ncorner_radius = "2 mm"'
    ),
    "cut off at a rim with a slit": (
        '[[pattern]]\nkind = "star"\narms = 4\narm_length = "70 mm"\nhalf_width = "5 mm"\n'
        'rotation = "45 deg"\nclip = true\n[outline]\nkind = "rectangle"\nwidth = "100 mm"\n'
        'height = "90 mm"\nslits = [[["-20 mm", "0 mm"], ["20 mm", "0 mm"], ["20 mm", "9 mm"]]]'
    ),
    "cutouts": (
        '[[pattern]]\nkind = "ellipse"\nhalf_width = "10 mm"\nhalf_height = "30 mm"\n[outline]\n'
        'kind = "ellipse"\nhalf_width = "60 mm"\nhalf_height = "40 mm"\n[[outline.cutouts]]\n'
        'kind = "rectangle"\nwidth = "10 mm"\nheight = "12 mm"\ncentre = ["30 mm", "0 mm"]\n'
        '[[outline.cutouts]]\nkind = "disc"\nradius = "6 mm"\ncentre = ["-30 mm", "0 mm"]'
    ),
    "two parts": (
        '[[pattern]]\npart = "left"\nkind = "rectangle"\nwidth = "20 mm"\nheight = "50 mm"\n'
        'centre = ["-20 mm", "3 mm"]\n[[pattern]]\npart = "right"\nkind = "polygon"\nunit = "mm"\n'
        "points = [[5, 0], [35, 5], [20, 30]]"
    ),
}


def _examples() -> dict[str, str]:
    if not PAGE.is_file():
        return {}
    found = re.findall(r"^```toml\n# ([^\n]+)\n(.*?)^```", PAGE.read_text("utf-8"), re.M | re.S)
    return {f"page: {name}": text for name, text in found if 'kind = "drawing"' not in text}


EXAMPLES = _examples()
ALL = TEXTS | EXAMPLES
WITH_PAGE = [*TEXTS, *(pytest.param(name, marks=pytest.mark.slow) for name in EXAMPLES)]


def same(found: BaseGeometry, wanted: BaseGeometry) -> None:
    """Within 0.01 mm everywhere, and within 1e-4 of the area."""
    assert shapely.hausdorff_distance(found.boundary, wanted.boundary) < 1e-5
    assert found.symmetric_difference(wanted).area < 1e-4 * wanted.area


def printed_parts(design: Design) -> list[PrintedPart]:
    return [lay_on_bed(level, GENERIC) for level in levels_of(design) if level.part]


def in_design(region: BaseGeometry, part: PrintedPart) -> BaseGeometry:
    """The plan on the bed, taken to its place in the design."""
    motion = part.to_design
    return shapely.transform(region, lambda xy: xy @ motion[:2, :2].T + motion[:2, 3])


@pytest.mark.parametrize("name", WITH_PAGE)
@pytest.mark.parametrize("face", ["top", "bottom"])
def test_files_read_back_are_the_design(name: str, face: str, make, tmp_path: Path) -> None:
    parts = re.findall(r'^part = "([^"]+)"$', ALL[name], re.M)
    below = ("pattern", *parts) if face == "bottom" else ()
    design = make(ALL[name], below=below, folder=PAGE.parent)
    if face == "top":
        _check_drawings(design, tmp_path)
    for part in printed_parts(design):
        bodies = part.bodies()
        (tmp_path / "part.3mf").write_bytes(bytes_3mf(bodies, {}))
        (tmp_path / "part.stl").write_bytes(bytes_stl(bodies))
        for file in ("part.3mf", "part.stl"):
            plan = read_drawing(tmp_path / file).area()
            same(in_design(plan, part), part.level.region)


def _check_drawings(design: Design, folder: Path) -> None:
    layers = cut.pattern_layers(design)
    for ending, write in ((".dxf", dxf_bytes), (".svg", svg_bytes)):
        sheet, pattern = (folder / f"{name}{ending}" for name in ("sheet", "pattern"))
        sheet.write_bytes(write(cut.sheet_inks(design, 0.0)))
        pattern.write_bytes(write(cut.pattern_inks(design, 0.0)[0]))
        drawing = read_drawing(sheet)
        found = drawing.area(cut.SHEET)
        if design.outline_polygon().interiors:
            found = found.difference(drawing.area(cut.HOLES))
        same(found, design.outline_polygon())
        slits = design.layout.slits
        if not slits.is_empty:
            assert shapely.hausdorff_distance(drawing.lines(cut.SLITS), slits) < 1e-8
        for part, region in design.layout.parts.items():
            same(read_drawing(pattern).area(layers[part]), region)


@pytest.mark.parametrize("name", WITH_PAGE)
def test_bodies_are_closed_and_have_their_volume(name: str, make) -> None:
    import trimesh

    design = make(ALL[name], folder=PAGE.parent)
    for part in printed_parts(design):
        volume, wanted = 0.0, part.level.region.area * part.thickness
        for body in part.bodies():
            mesh = trimesh.Trimesh(body.points, body.triangles, process=False)
            assert mesh.is_watertight
            assert mesh.is_winding_consistent
            assert mesh.volume > 0
            volume += mesh.volume
        assert volume == pytest.approx(wanted, rel=1e-6)
        mesh = trimesh.load_mesh(io.BytesIO(bytes_stl(part.bodies())), file_type="stl")
        assert mesh.is_watertight
        assert mesh.volume == pytest.approx(1e9 * wanted, rel=1e-5)  # single precision
        assert mesh.bounds[0][2] == 0.0


@pytest.mark.parametrize("name", TEXTS)
def test_others_read_the_3mf(name: str, make) -> None:
    import lib3mf

    for part in printed_parts(make(TEXTS[name])):
        data = bytes_3mf(part.bodies(), {"Title": "a & <b>"})
        model = lib3mf.get_wrapper().CreateModel()
        reader = model.QueryReader("3mf")
        reader.SetStrictModeActive(True)
        reader.ReadFromBuffer(data)
        assert reader.GetWarningCount() == 0
        assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter
        assert model.GetMetaDataGroup().GetMetaData(0).GetValue() == "a & <b>"
        objects = model.GetMeshObjects()
        count = 0
        while objects.MoveNext():
            mesh = objects.GetCurrentMeshObject()
            assert mesh.IsManifoldAndOriented()
            assert mesh.GetName().startswith(part.name)
            count += 1
        assert count == len(part.plan.geoms) == model.GetBuildItems().Count()


@pytest.mark.parametrize("name", TEXTS)
def test_others_read_the_drawings(name: str, make) -> None:
    import ezdxf
    import resvg_py
    from PIL import Image

    design = make(TEXTS[name])
    inks = cut.sheet_inks(design, 0.0)
    document = ezdxf.read(io.StringIO(dxf_bytes(inks).decode("utf-8")))
    assert not document.audit().errors
    assert not document.audit().fixes
    assert document.units == ezdxf.units.MM
    layers = {entity.dxf.layer for entity in document.modelspace()}
    assert {cut.SHEET, cut.MARKS} <= layers
    # The drawn extent in pixels: crosses from tip to tip.
    text = svg_bytes(inks, margin=2e-3).decode("utf-8").replace('width="0.01"', 'width="0.3"')
    png = resvg_py.svg_to_bytes(svg_string=text, background="#ffffff", dpi=254.0)
    dark = np.asarray(Image.open(io.BytesIO(bytes(png))).convert("L")) < 200
    rows, columns = (np.flatnonzero(dark.any(axis=axis)) for axis in (1, 0))
    low_x, low_y, high_x, high_y = design.outline_polygon().bounds
    reach = 2 * (cut.MARK_DISTANCE + 0.5 * cut.MARK_SIZE)
    assert np.ptp(columns) == pytest.approx(1e4 * (high_x - low_x + reach), abs=3.0)
    assert np.ptp(rows) == pytest.approx(1e4 * (high_y - low_y + reach), abs=3.0)


def test_there_are_patterns_enough() -> None:
    assert len(TEXTS) >= 9
    if PAGE.is_file():
        assert len(ALL) >= 20
