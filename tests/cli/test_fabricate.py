"""From a drawing to a folder of parts, through the command line."""

from __future__ import annotations

import json
import shutil
from itertools import pairwise
from pathlib import Path

import ezdxf
import pytest
from small import SMALL

import sheetmorph as sm
from sheetmorph.cli import main
from sheetmorph.drawing.read import read_drawing

LEAF = Path(__file__).resolve().parents[2] / "examples" / "leaf" / "leaf.svg"


@pytest.fixture
def small(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "small.toml"
    file.write_text(SMALL)
    return file


def open_plate(file: Path) -> None:
    """A DXF that names no unit, of a sheet with a gap of 0.2 and a closed pattern."""
    document = ezdxf.new()
    document.header["$INSUNITS"] = 0
    space = document.modelspace()
    corners = [(0, 0), (60, 0), (60, 40), (0, 40), (0, 0.2)]
    for start, end in pairwise(corners):
        space.add_line(start, end, dxfattribs={"layer": "SHEET"})
    rib = [(10, 15), (50, 15), (50, 25), (10, 25)]
    space.add_lwpolyline(rib, close=True, dxfattribs={"layer": "PATTERN"})
    document.saveas(file)


def test_unit_and_gap_of_a_drawing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    open_plate(Path("plate.dxf"))
    wanted = ["--unit", "mm", "--gap", "0.3 mm"]
    assert main(["new", "plate", "--drawing", "plate.dxf", *wanted]) == 0
    design = sm.Design.load("plate.toml")
    assert design.outline_polygon().area == pytest.approx(2400e-6, rel=0.01)
    assert design.pattern_polygon().area == pytest.approx(400e-6, rel=1e-9)
    assert any("0.2" in note for note in design.notes)


def test_a_drawing_becomes_parts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(LEAF, tmp_path)
    assert main(["new", "leaf", "--drawing", "leaf.svg"]) == 0
    assert main(["check", "leaf.toml"]) == 0
    assert "leaf.svg: painted shapes overlap" in capsys.readouterr().out
    assert main(["fabricate", "leaf.toml", "--no-prediction", "--paper", "a4"]) == 0
    parts = tmp_path / "fabricate" / "leaf"
    drawn = read_drawing(LEAF).area("SHEET")
    cut = read_drawing(parts / "cut" / "sheet.dxf").area("SHEET")
    assert cut.symmetric_difference(drawn).area < 1e-4 * drawn.area
    assert not (parts / "template-letter.pdf").exists()


def test_the_assembly_sheet_tells_the_shape(
    small: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", "small.toml", "-o", "run", "-q", "--set", "outputs.animation=false"]) == 0
    capsys.readouterr()
    assert main(["fabricate", "small.toml", "-o", "parts", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert {"assembly.html", "assembly.pdf", "cut/sheet.dxf"} <= set(told["files"])
    summary = json.loads(Path("run/summary.json").read_text(encoding="utf-8"))
    page = Path("parts/assembly.html").read_text("utf-8")
    assert f"{1e3 * summary['height_m']:.1f}" in page
    assert "data:image/png;base64," in page
    assert main(["fabricate", "small.toml", "-o", "same", "--result", "run", "-q"]) == 0
    assert Path("same/assembly.html").read_bytes() == Path("parts/assembly.html").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "wanted"),
    [
        (["--nozzle", "0.4"], "--nozzle"),
        (["--bed", "200 mm"], "--bed"),
        (["--kerf", "9 mm"], "--kerf: is out of range"),
        (["--copies", "3"], '--stock "300 mm, 200 mm"'),
        (["--copies", "3", "--stock", "30 mm, 20 mm"], "sheetmorph: --stock: "),
        (["--result", "run", "--no-prediction"], "exclude each other"),
        (["--stock", "30 mm, 20 parsec"], "--stock"),
        (["--printer", "typewriter"], "generic-0.4"),
        (["--paper", "a9"], "a4"),
        (["--result", "nowhere"], "nowhere"),
        (["-o", ""], "-o wants a folder"),
        (["-o", "small.toml"], "is a file"),
        (["--set", "actuation.eps=-0.3"], "eps_pre"),
    ],
)
def test_bad_arguments_write_nothing(
    small: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], wanted: str
) -> None:
    before = set(small.parent.rglob("*"))
    assert main(["fabricate", "small.toml", *arguments]) == 2
    said = capsys.readouterr().err.strip()
    assert said.startswith("sheetmorph: ")
    assert "\n" not in said
    assert wanted in said
    assert set(small.parent.rglob("*")) == before


def test_a_run_of_another_design_is_no_prediction(
    small: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    quick = ["--set", "outputs.animation=false", "--set", "outputs.pictures=false"]
    assert main(["run", "small.toml", "-o", "run", "-q", *quick]) == 0
    other = ["--set", "actuation.eps_pre=-0.2", "--result", "run"]
    assert main(["fabricate", "small.toml", *other]) == 2
    assert "another design" in capsys.readouterr().err


def test_parts_are_not_overwritten_unasked(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    quick = ["fabricate", "small.toml", "-o", "parts", "--no-prediction", "--paper", "a4"]
    assert main(quick) == 0
    assert main(quick) == 2
    assert "--force" in capsys.readouterr().err
    Path("parts/mine.txt").write_text("mine", encoding="utf-8")
    assert main([*quick, "--force"]) == 0
    assert Path("parts/mine.txt").read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize(
    ("arguments", "wanted"),
    [
        (["new", "x", "--drawing", "gone.svg"], "gone.svg"),
        (["new", "x", "--drawing", "text.svg"], "text.svg"),
        (["new", "x", "--drawing", "leaf.svg", "--pattern", "RIBS"], "RIBS"),
        (["new", "sub/x", "--drawing", "leaf.svg"], "one folder"),
        (["new", "x", "--sheet", "A"], "--drawing"),
        (["new", "x", "--unit", "mm"], "--drawing"),
        (["new", "x", "--drawing", "plate.dxf"], "--unit"),
        (["new", "x", "--drawing", "plate.dxf", "--unit", "parsec"], "--unit"),
        (["new", "x", "--drawing", "plate.dxf", "--unit", "mm"], "--gap"),
        (["new", "x", "--drawing", "plate.dxf", "--unit", "mm", "--gap", "1"], "--gap"),
        (["new", "x", "--drawing", "plate.stl"], "no layers"),
    ],
)
def test_bad_drawings(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    wanted: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(LEAF, tmp_path)
    Path("text.svg").write_text("no drawing", encoding="utf-8")
    Path("plate.stl").write_text("solid", encoding="utf-8")
    open_plate(Path("plate.dxf"))
    assert main(arguments) == 2
    said = capsys.readouterr().err.strip()
    assert "\n" not in said
    assert wanted in said
    assert not Path("x.toml").exists()


def test_set_mends_a_file_that_is_not_valid_as_it_stands(small: Path) -> None:
    small.write_text(SMALL.replace("eps_pre = -0.4", "eps_pre = -4"), encoding="utf-8")
    assert main(["check", "small.toml"]) == 2
    assert main(["check", "small.toml", "--set", "actuation.eps_pre=-0.4"]) == 0


def test_a_shape_that_is_not_reached_is_told(
    small: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["fabricate", "small.toml", "-o", "p", "--set", "solver.max_steps=1"]) == 1
    said = capsys.readouterr().err
    assert "the files are written, but no shape: The computation ended at" in said
    page = Path("p/assembly.html").read_text("utf-8")
    assert "too many steps" in page
    assert "too_many_steps" not in page
    assert "data:image/png" not in page
