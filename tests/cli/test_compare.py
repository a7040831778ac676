"""The command `compare`: from a run and a scan to a folder of numbers and pictures."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from small import SMALL

import sheetmorph as sm
from sheetmorph.cli import main
from sheetmorph.compare import comparison
from sheetmorph.compare.align import Effort, align
from sheetmorph.geometry.writers import write_stl

FILES = {"comparison.json", "comparison.html", "aligned_scan.stl"}
PICTURES = {"overlay.png", "distance.png", "ssim.png", "histogram.png"}
QUICK = ["--no-pictures", "--grid", "24", "--window", "5"]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a run, its shape in centimetres, turned and moved, and what is no scan."""
    place = tmp_path_factory.mktemp("compare")
    (place / "small.toml").write_text(SMALL)
    quick = ["--set", "outputs.animation=false", "--set", "outputs.pictures=false"]
    assert main(["run", str(place / "small.toml"), "-o", str(place / "run"), "-q", *quick]) == 0
    result = sm.Result.load(place / "run")
    turn = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    points = 100.0 * result.positions[-1] @ turn.T + [3.0, -8.0, 2.0]
    write_stl(place / "scan.stl", result.mesh.triangles, points)
    (place / "cut.stl").write_bytes((place / "scan.stl").read_bytes()[:500])
    (place / "words.stl").write_text("no mesh")
    (place / "cloud.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n0 0 0\n"
    )
    (place / "notes.docx").write_text("words")
    (place / "empty").mkdir()
    return place


@pytest.fixture
def here(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder with links to what was made, in which nothing may be left behind."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SHEETMORPH_RENDERER", "drawn")
    brisk = partial(align, effort=Effort(starts=96, kept=6, points=1000))
    monkeypatch.setattr(comparison, "align", brisk)
    for path in made.iterdir():
        (tmp_path / path.name).symlink_to(path)
    yield tmp_path


def said_by(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """The one line with which bad input is refused."""
    assert main(["compare", *arguments]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("sheetmorph: ")
    assert said.err.count("\n") == 1
    return said.err


def test_a_copy_in_another_unit_is_found_again(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["compare", "run", "scan.stl", *QUICK]) == 0
    told = capsys.readouterr().out
    data = json.loads(Path("scan-comparison/comparison.json").read_text("utf-8"))
    assert data["scale"] == pytest.approx(0.01, rel=2e-3)
    assert data["ssim"] > 0.99
    for way in ("scan_to_shape", "shape_to_scan"):
        assert data["rms_mm"][way] < 0.1
        assert data["hausdorff_mm"][way] >= data["rms_mm"][way]
    assert data["grid"] == 24
    assert data["window"] == 5
    assert data["seconds"] > 0
    assert len(data["translation_m"]) == 3
    turn = np.array(data["rotation"])
    assert np.allclose(turn @ turn.T, np.eye(3), atol=1e-6)
    assert set(data["ssim_baselines"]) >= {"flat_sheet", "spherical_cap"}
    assert f"SSIM       {data['ssim']:.3f} (grid 24, window 5); flat sheet " in told
    assert "comparison in scan-comparison/ (open comparison.html)" in told
    assert {path.name for path in Path("scan-comparison").iterdir()} == FILES
    # scale · rotation · x + translation_m of the file's own points is aligned_scan.stl
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    before, after = (
        np.frombuffer(Path(name).read_bytes()[84:], record)["corners"].reshape(-1, 3)
        for name in ("scan.stl", "scan-comparison/aligned_scan.stl")
    )
    moved = data["scale"] * before @ turn.T + data["translation_m"]
    for axis in range(3):
        assert np.abs(np.sort(moved[:, axis]) - np.sort(after[:, axis])).max() < 1e-5


@pytest.mark.parametrize(
    "size",
    [
        ["--known-length", "10 = 100 mm"],
        pytest.param(["--unit", "cm"], marks=pytest.mark.slow),
        pytest.param(["--scale", "0.01"], marks=pytest.mark.slow),
    ],
)
def test_a_known_size_is_kept(here: Path, size: list[str]) -> None:
    assert main(["compare", "run", "scan.stl", "-o", "c", "-q", *QUICK, *size]) == 0
    data = json.loads(Path("c/comparison.json").read_text("utf-8"))
    assert data["scale"] == pytest.approx(0.01, rel=1e-9)
    assert data["ssim"] > 0.99


@pytest.mark.slow
def test_a_wrong_size_is_not_mended(here: Path) -> None:
    assert main(["compare", "run", "scan.stl", "-o", "c", "-q", *QUICK, "--scale", "0.011"]) == 0
    data = json.loads(Path("c/comparison.json").read_text("utf-8"))
    assert data["scale"] == pytest.approx(0.011, rel=1e-9)
    assert data["rms_mm"]["scan_to_shape"] > 0.3


@pytest.mark.slow
def test_two_runs_and_another_state(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", "run", "run", "-o", "same", "--json", *QUICK]) == 0
    same = json.loads(capsys.readouterr().out)
    assert same == json.loads(Path("same/comparison.json").read_text("utf-8"))
    assert same["scale"] == 1.0
    assert same["ssim"] > 0.999
    assert main(["compare", "run", "run", "-o", "flat", "-q", *QUICK, "--state", "0"]) == 0
    flat = json.loads(Path("flat/comparison.json").read_text("utf-8"))
    assert flat["scale"] == 1.0
    assert flat["ssim"] < same["ssim"] - 0.05


@pytest.mark.slow
def test_meshes_may_stand_for_a_run(here: Path) -> None:
    series = sorted(Path("run/series").glob("shape_*.vtu"))[-1]
    for shape in ("run/shape.stl", str(series)):
        arguments = ["compare", shape, "scan.stl", "-o", "c", "-q", "--force", *QUICK]
        assert main(arguments) == 0
        data = json.loads(Path("c/comparison.json").read_text("utf-8"))
        assert data["scale"] == pytest.approx(0.01, rel=2e-3)


def test_a_comparison_is_not_overwritten_unasked(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    quick = ["run", "scan.stl", "-o", "c", *QUICK]
    Path("c/pictures").mkdir(parents=True)
    Path("c/comparison.json").write_text("{}", encoding="utf-8")
    Path("c/mine.txt").write_text("mine", encoding="utf-8")
    Path("c/pictures/ssim.png").write_text("of an earlier comparison", encoding="utf-8")
    assert "--force" in said_by(capsys, *quick)
    assert main(["compare", *quick, "--force", "-q"]) == 0
    assert json.loads(Path("c/comparison.json").read_text("utf-8"))["ssim"] > 0.99
    assert Path("c/mine.txt").read_text(encoding="utf-8") == "mine"
    assert not Path("c/pictures/ssim.png").exists()


def test_files_that_no_comparison_wrote_are_left_alone(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("c/pictures").mkdir(parents=True)
    Path("c/pictures/overlay.png").write_text("mine", encoding="utf-8")
    for force in ([], ["--force"]):
        said = said_by(capsys, "run", "scan.stl", "-o", "c", *force)
        assert "c/pictures/overlay.png" in said
    assert Path("c/pictures/overlay.png").read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize(
    ("arguments", "wanted"),
    [
        (["gone", "scan.stl"], "gone: there is no such file"),
        (["run", "gone.stl"], "gone.stl: there is no such file"),
        (["run", "cut.stl"], "cut.stl"),
        (["run", "words.stl"], "words.stl"),
        (["run", "cloud.ply"], "cloud.ply"),
        (["run", "notes.docx"], "notes.docx"),
        (["notes.docx", "scan.stl"], ".stl"),
        (["empty", "scan.stl"], "empty: this folder holds no result.h5"),
        (["run", "empty"], "empty: this folder holds no result.h5"),
        (["run", "scan.stl", "--unit", "mm", "--scale", "0.001"], "exclude each other"),
        (["run", "scan.stl", "--unit", "mm", "--known-length", "1=1 m"], "exclude each other"),
        (["run", "scan.stl", "--unit", "parsec"], "--unit"),
        (["run", "scan.stl", "--unit", "kg"], "--unit"),
        (["run", "scan.stl", "--scale", "0"], "--scale"),
        (["run", "scan.stl", "--scale", "-1"], "--scale"),
        (["run", "scan.stl", "--scale", "nan"], "--scale"),
        (["run", "scan.stl", "--scale", "1e999"], "--scale"),
        (["run", "scan.stl", "--known-length", "523"], "--known-length"),
        (["run", "scan.stl", "--known-length", "523=100"], "--known-length"),
        (["run", "scan.stl", "--known-length", "0=100 mm"], "--known-length"),
        (["run", "run", "--unit", "mm"], "a run is in metres"),
        (["run", "scan.stl", "--shape-unit", "mm"], "a run is in metres"),
        (["run", "scan.stl", "--face", "upper"], "outer"),
        (["run", "scan.stl", "--crop", "0,1,0,1"], "--crop"),
        (["run", "scan.stl", "--crop", "1,0,0,1,0,1"], "--crop"),
        (["run", "scan.stl", "--crop", "900,901,0,1,0,1"], "--crop: no triangle"),
        (["run", "scan.stl", "--grid", "1"], "--grid"),
        (["run", "scan.stl", "--grid", "100000"], "--grid"),
        (["run", "scan.stl", "--window", "0"], "--window"),
        (["run", "scan.stl", "--state", "999"], "--state"),
        (["run", "scan.stl", "--state", "last"], "--state"),
        (["run", "scan.stl", "--state", "-0.99"], "--state"),
        (["scan.stl", "scan.stl", "--state", "0"], "--state is for runs"),
        (["run", "scan.stl", "-o", ""], "-o wants a folder"),
        (["run", "scan.stl", "-o", "small.toml"], "is a file"),
        pytest.param(
            ["run", "scan.stl", "-o", "/proc/nowhere"], "/proc/nowhere", marks=pytest.mark.slow
        ),
        (["run"], "Missing argument"),
    ],
)
def test_bad_input_is_one_line_and_writes_nothing(
    here: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], wanted: str
) -> None:
    before = {path.name for path in here.rglob("*")}
    assert wanted in said_by(capsys, *arguments, *([] if arguments[-1] == "run" else QUICK[:1]))
    assert {path.name for path in here.rglob("*")} == before


@pytest.mark.slow
def test_the_reference_scan(
    here: Path, reference: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The scan of a real sheet, against another sheet: all files, and sober numbers."""
    shutil.copy(reference / "petals_scan.stl", "petals_scan.stl")
    assert main(["compare", "run", "petals_scan.stl", "-o", "c"]) == 0
    assert {path.name for path in Path("c").iterdir()} == FILES | {"pictures"}
    assert {path.name for path in Path("c/pictures").iterdir()} == PICTURES
    data = json.loads(Path("c/comparison.json").read_text("utf-8"))
    assert 0 < data["ssim"] < 0.98
    assert data["face"] == "both"
    assert data["rms_mm"]["scan_to_shape"] < 0.1 * data["size_mm"]
    assert Path("c/comparison.html").read_text("utf-8").count("data:image/png") == 4


def test_a_mesh_in_another_unit_than_metres_is_told(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    result = sm.Result.load(here / "run")
    write_stl(here / "shape.stl", result.mesh.triangles, 1e3 * result.positions[-1])
    assert main(["compare", "shape.stl", "scan.stl", "-o", "c", *QUICK]) == 0
    assert "m large as it was read" in capsys.readouterr().err
    command = ["compare", "shape.stl", "scan.stl", "-o", "d", "--shape-unit", "mm", *QUICK]
    assert main(command) == 0
    assert "as it was read" not in capsys.readouterr().err


def test_the_scan_is_not_written_over(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "d").mkdir()
    (here / "d" / "aligned_scan.stl").write_bytes((here / "scan.stl").read_bytes())
    (here / "d" / "comparison.json").write_text("{}")
    said = said_by(capsys, "run", "d/aligned_scan.stl", "-o", "d", "--force", *QUICK)
    assert "written over" in said
