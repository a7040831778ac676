"""The folder: all of it or an error, the same twice, and nobody else's files touched."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import shapely

from sheetmorph.core.errors import InputError
from sheetmorph.core.events import Notice, Progress
from sheetmorph.drawing.read import read_drawing
from sheetmorph.fabricate.names import distinct, part_names, safe_name
from sheetmorph.fabricate.options import FabricationOptions
from sheetmorph.fabricate.package import MANIFEST, check_folder, fabricate_design
from sheetmorph.fabricate.printer import PrinterProfile

QUICK = FabricationOptions(papers=("a4",))


def contents(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_the_whole_package(two_faces, tmp_path) -> None:
    events = []
    options = FabricationOptions(kerf=0.1e-3, copies=4, stock_width=0.3, stock_height=0.2)
    package = fabricate_design(two_faces, tmp_path / "out", options=options, on_event=events.append)
    found = contents(tmp_path / "out")
    assert set(found) == {
        *(f"parts/inert-{part}.{ending}" for part in ("arms", "rail") for ending in ("3mf", "stl")),
        "parts/plate.3mf",
        *(f"cut/{name}.{e}" for name in ("sheet", "pattern", "nest") for e in ("dxf", "svg")),
        "template-a4.pdf",
        "template-letter.pdf",
        "assembly.html",
        "assembly.pdf",
        MANIFEST,
    }
    assert {path.relative_to(package.folder).as_posix() for path in package.files} == set(found)
    assert [e.text for e in events if isinstance(e, Notice)] == list(package.warnings)
    steps = [event.fraction for event in events if isinstance(event, Progress)]
    assert steps == sorted(steps)
    assert steps[-1] == 1.0
    fabricate_design(two_faces, tmp_path / "again", options=options)
    assert contents(tmp_path / "again") == found
    nest = read_drawing(tmp_path / "out/cut/nest.dxf")
    sheets = nest.area("SHEET")
    assert len(sheets.geoms) == 4
    assert len(nest.area("HOLES").geoms) == 4
    assert len(nest.lines("SLITS").geoms) == 4
    assert all(sheets.covers(slit) for slit in nest.lines("SLITS").geoms)
    assert shapely.box(0, 0, 0.3, 0.2).buffer(1e-9).covers(sheets)
    plate = read_drawing(tmp_path / "out/parts/plate.3mf").area()
    assert plate.area == pytest.approx(two_faces.layout.parts["arms"].area + 540e-6, rel=1e-6)


def test_a_sheet_without_pattern_has_no_parts(bare, tmp_path) -> None:
    package = fabricate_design(bare, tmp_path / "out", options=QUICK)
    names = set(contents(package.folder))
    assert names == {
        "cut/sheet.dxf",
        "cut/sheet.svg",
        "template-a4.pdf",
        "assembly.html",
        "assembly.pdf",
        MANIFEST,
    }
    assert any("no pattern" in warning for warning in package.warnings)


def test_several_sheets_of_stock_and_a_bed_too_small(two_faces, tmp_path) -> None:
    options = FabricationOptions(
        printer=PrinterProfile("tiny", 0.4e-3, 0.06, 0.06, 0.8e-3, 0.2e-3),
        copies=3,
        stock_width=0.13,
        stock_height=0.09,
        papers=(),
    )
    package = fabricate_design(two_faces, tmp_path / "out", options=options)
    names = set(contents(package.folder))
    assert {"cut/nest-1.dxf", "cut/nest-2.svg", "cut/nest-3.dxf"} <= names
    assert "parts/inert-rail.3mf" in names
    rail, _ = [warning for warning in package.warnings if "larger than the bed" in warning]
    assert rail.startswith("inert rail: ")
    assert "tiny (60 × 60 mm)" in rail
    assert "parts/plate.3mf" not in names


def test_an_existing_package_is_replaced_only_by_force(two_faces, bare, tmp_path) -> None:
    folder = tmp_path / "out"
    fabricate_design(two_faces, folder, options=QUICK)
    before = contents(folder)
    (folder / "notes.txt").write_text("mine")
    (folder / "parts" / "mine.3mf").write_text("mine")
    with pytest.raises(InputError, match="--force"):
        fabricate_design(bare, folder, options=QUICK)
    with pytest.raises(InputError, match="--force"):
        check_folder(folder)
    check_folder(folder, force=True)
    fabricate_design(bare, folder, options=QUICK, force=True)
    left = contents(folder)
    assert left.pop("notes.txt") == left.pop("parts/mine.3mf") == b"mine"
    assert set(left) == {name for name in before if not name.startswith(("parts/", "cut/pat"))}
    assert json.loads(left[MANIFEST])["files"] == sorted(set(left) - {MANIFEST})


def test_folders_of_others_are_never_touched(bare, tmp_path) -> None:
    folder = tmp_path / "theirs"
    (folder / "cut").mkdir(parents=True)
    (folder / "cut" / "sheet.svg").write_text("theirs")
    for force in (False, True):
        with pytest.raises(InputError, match="not written by this command"):
            fabricate_design(bare, folder, options=QUICK, force=force)
    assert contents(folder) == {"cut/sheet.svg": b"theirs"}
    with pytest.raises(InputError, match="this is a file"):
        fabricate_design(bare, folder / "cut" / "sheet.svg", options=QUICK)
    (tmp_path / "empty").mkdir()
    fabricate_design(bare, tmp_path / "empty", options=QUICK)


def test_a_file_of_theirs_in_a_folder_of_ours_is_not_replaced(bare, two_faces, tmp_path) -> None:
    folder = tmp_path / "out"
    fabricate_design(bare, folder, options=QUICK)
    (folder / "cut" / "pattern.dxf").write_text("theirs")
    before = contents(folder)
    with pytest.raises(InputError, match=r"pattern\.dxf: this file was not written"):
        fabricate_design(two_faces, folder, options=QUICK, force=True)
    assert contents(folder) == before


@pytest.mark.parametrize(
    "manifest",
    [
        "",
        "[]",
        "{",
        '{"files": ["cut/sheet.dxf"]}',
        '{"format": "sheetmorph package", "files": ["../victim.txt"]}',
        '{"format": "sheetmorph package", "files": ["cut/../../victim.txt"]}',
        '{"format": "sheetmorph package", "files": ["/etc/passwd"]}',
        '{"format": "sheetmorph package", "files": [3]}',
        '{"format": "sheetmorph package", "files": "assembly.html"}',
        "[" * 100_000,
    ],
)
def test_a_list_that_is_not_ours_is_refused(bare, tmp_path, manifest: str) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    victim = tmp_path / "victim.txt"
    victim.write_text("keep")
    (folder / MANIFEST).write_text(manifest)
    with pytest.raises(InputError, match="choose another folder"):
        fabricate_design(bare, folder, options=QUICK, force=True)
    assert victim.read_text("utf-8") == "keep"
    assert (folder / MANIFEST).read_text("utf-8") == manifest


def test_links_are_not_followed(bare, tmp_path) -> None:
    folder, elsewhere = tmp_path / "out", tmp_path / "elsewhere"
    fabricate_design(bare, folder, options=QUICK)
    (folder / "cut").rename(elsewhere)
    (folder / "cut").symlink_to(elsewhere, target_is_directory=True)
    before = contents(elsewhere)
    with pytest.raises(InputError, match="no folder of ours"):
        fabricate_design(bare, folder, options=QUICK, force=True)
    assert contents(elsewhere) == before


def test_nothing_is_written_when_the_design_cannot_be_made(two_faces, make, tmp_path) -> None:
    small = FabricationOptions(stock_width=0.05, stock_height=0.05, papers=())
    with pytest.raises(InputError, match="does not fit a stock"):
        fabricate_design(two_faces, tmp_path / "out", options=small)
    text = (
        '[outline]\nkind = "disc"\nradius = "50 mm"\n'
        'cutouts = [{ kind = "disc", radius = "0.2 mm" }]\n'
    )
    wide = FabricationOptions(kerf=0.5e-3, papers=())
    with pytest.raises(InputError, match=r"kerf: the hole of the sheet at \(0, 0\) mm"):
        fabricate_design(make(text), tmp_path / "out", options=wide)
    assert not (tmp_path / "out").exists()


def test_a_kerf_too_wide_for_a_printed_part_is_told(make, tmp_path) -> None:
    text = (
        '[[pattern]]\nkind = "disc"\nradius = "9 mm"\n[[pattern]]\nkind = "disc"\n'
        'radius = "0.2 mm"\noperation = "difference"'
    )
    wide = FabricationOptions(kerf=0.5e-3, papers=())
    package = fabricate_design(make(text), tmp_path / "out", options=wide)
    names = set(contents(package.folder))
    assert "parts/inert-pattern.3mf" in names
    assert "cut/sheet.dxf" in names
    assert not any(name.startswith("cut/pattern") for name in names)
    assert any("cut/pattern leaves out the part pattern" in told for told in package.warnings)
    page = (package.folder / "assembly.html").read_text("utf-8")
    assert "coincide with those of cut/pattern" not in page
    assert "cut/pattern.dxf" not in page


@pytest.mark.parametrize("plates", [1, 2])
def test_no_layer_takes_the_name_of_a_plate(two_faces, tmp_path, plates: int) -> None:
    values = {"layers.0.name": "plate", "layers.2.name": "plate-1"}
    bed = 0.2 if plates == 1 else 0.09
    options = FabricationOptions(
        printer=PrinterProfile("x", 0.4e-3, bed, bed, 0.8e-3, 0.2e-3), papers=()
    )
    package = fabricate_design(two_faces.with_values(values), tmp_path / "out", options=options)
    arranged = ["plate"] if plates == 1 else ["plate-1", "plate-2"]
    wanted = {"plate-part", "plate-1-part", *arranged}
    assert {p.stem for p in package.files if p.suffix == ".3mf"} == wanted
    layout = two_faces.layout.parts
    for name, part in (("plate-part", "rail"), ("plate-1-part", "arms")):
        found = read_drawing(package.folder / f"parts/{name}.3mf").area()
        assert found.area == pytest.approx(layout[part].area, rel=1e-6)
    page = (package.folder / "assembly.html").read_text("utf-8")
    together = " and ".join(f"parts/{name}.3mf" for name in arranged)
    single = "parts/plate-part.3mf and parts/plate-1-part.3mf"
    assert f"Print {together} (parts arranged on the bed), or {single}, in the" in page


def test_only_plates_that_exist_are_named(two_faces, tmp_path) -> None:
    options = FabricationOptions(
        printer=PrinterProfile("tiny", 0.4e-3, 0.06, 0.06, 0.8e-3, 0.2e-3), papers=()
    )
    package = fabricate_design(two_faces, tmp_path / "out", options=options)
    page = (package.folder / "assembly.html").read_text("utf-8")
    assert "plate.3mf" not in page
    assert "Print parts/inert-rail.3mf and parts/inert-arms.3mf, in the orientation" in page
    assert "inert rail and inert arms are larger than that bed" in page


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"kerf": -1e-3}, "kerf"),
        ({"kerf": float("nan")}, "kerf"),
        ({"copies": 0}, "copies"),
        ({"copies": 2}, "how large a sheet of stock"),
        ({"stock_width": 0.3}, "two sides"),
        ({"stock_width": 0.3, "stock_height": 99.0}, "stock_height"),
        ({"spacing": -1.0}, "spacing"),
        ({"papers": ("a3",)}, "a4, letter"),
    ],
)
def test_options_are_checked(values: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        FabricationOptions(**values)


def test_names_are_safe() -> None:
    assert safe_name("../../etc/passwd") == "etc-passwd"
    assert safe_name("Tür (PLA) №7") == "Tur-PLA-No7"
    assert safe_name("中文") == "part"
    assert safe_name("con") == "con-"
    assert len(safe_name("x" * 500)) == 60
    assert distinct(["A", "a", "A-2", "b"]) == ["A", "a-2", "A-2-2", "b"]
    assert distinct(["sheet"], taken=["sheet"]) == ["sheet-2"]
    layers = ["plate", "PLATE", "plate-12", "plate x", "plate-part"]
    assert part_names(layers) == [
        "plate-part",
        "PLATE-part-2",
        "plate-12-part",
        "plate-x",
        "plate-part-3",
    ]


def test_a_slit_through_a_part_is_told(make, tmp_path) -> None:
    text = """
[outline]
kind = "disc"
radius = "50 mm"
slits = [[["10 mm", "-20 mm"], ["10 mm", "20 mm"]]]
[[pattern]]
kind = "bar"
start = ["START mm", "0 mm"]
end = ["30 mm", "0 mm"]
half_width = "3 mm"
"""
    crossed = fabricate_design(make(text.replace("START", "0")), tmp_path / "a", options=QUICK)
    assert any("a slit runs through it near (10, " in warning for warning in crossed.warnings)
    beside = fabricate_design(make(text.replace("START", "15")), tmp_path / "b", options=QUICK)
    assert not any("slit" in warning for warning in beside.warnings)


def test_without_lib3mf_there_are_stl_files(two_faces, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr("sheetmorph.fabricate.contents.writes_3mf", lambda: False)
    package = fabricate_design(two_faces, tmp_path / "out", options=QUICK)
    endings = {path.suffix for path in (tmp_path / "out" / "parts").iterdir()}
    assert endings == {".stl"}
    assert any("lib3mf" in warning for warning in package.warnings)
    page = (tmp_path / "out" / "assembly.html").read_text("utf-8")
    assert ".stl" in page
    assert ".3mf" not in page
