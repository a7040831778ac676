"""The main job through the command line, in this process and in one that is killed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from small import SMALL

import sheetmorph as sm
from sheetmorph.cli import main

PLAIN = "[outputs]\npictures = false\nanimation = false\nreport = false\nseries = false\n"


@pytest.fixture
def design(tmp_path: Path) -> Path:
    file = tmp_path / "small.toml"
    file.write_text(SMALL + PLAIN)
    return file


@pytest.mark.slow
def test_everything_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", "my bowl", "--preset", "bowl"]) == 0
    assert main(["run", "my bowl.toml", "-o", "out"]) == 0
    text = capsys.readouterr().out
    assert "completed" in text and "stable" in text and "mm" in text
    out = tmp_path / "out"
    assert {p.name for p in out.iterdir()} == {
        *("result.h5", "summary.json", "shape.stl", "series", "pictures", "animation.gif"),
        "report.html",
    }
    summary = json.loads((out / "summary.json").read_text("utf-8"))
    assert summary["status"] == "completed"
    assert summary["stable"] is True
    assert summary["name"] == "my bowl"
    assert summary["seconds"]["wall"] > summary["seconds"]["total"]
    assert 900 < summary["nodes"] < 1050
    result = sm.Result.load(out)
    assert len(list((out / "series").glob("*.vtu"))) == len(result.positions)
    import meshio

    last = meshio.read(sorted((out / "series").glob("*.vtu"))[-1])
    np.testing.assert_allclose(last.points, result.positions[-1], atol=1e-12)
    assert set(last.point_data) >= {"height_m", "mean_curvature_per_m"}
    assert set(last.cell_data) >= {"strain", "thermal_strain", "in_pattern"}
    shape = meshio.read(out / "shape.stl")
    assert len(shape.cells_dict["triangle"]) == summary["triangles"]
    page = (out / "report.html").read_text("utf-8")
    assert "http://" not in page.split("References")[0].replace("http://www.w3.org", "")


def test_json_and_quiet(design: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(design), "-o", str(tmp_path / "a"), "--json"]) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out) == json.loads(
        (tmp_path / "a" / "summary.json").read_text("utf-8")
    )
    assert captured.err == ""
    assert main(["run", str(design), "-o", str(tmp_path / "b"), "--quiet"]) == 0
    captured = capsys.readouterr()
    assert captured.out == captured.err == ""


def test_overrides(design: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    arguments = ["--set", "actuation.eps_pre=-0.2", "--set", "layers.0.thickness=0.25 mm"]
    assert main(["run", str(design), "-o", str(out), "-q", *arguments]) == 0
    result = sm.Result.load(out)
    assert result.design.eps_pre == -0.2
    assert result.design.layers[0].thickness == 0.25e-3
    assert main(["run", str(design), "-o", str(out), "-q", "--force"]) == 0
    assert sm.Result.load(out).design.eps_pre == -0.4


def test_a_new_run_leaves_nothing_of_the_old_one(design: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert main(["run", str(design), "-o", str(out), "-q", "--set", "outputs.series=true"]) == 0
    (out / "notes.txt").write_text("of the user")
    assert (out / "series" / "shape.pvd").is_file()
    assert main(["run", str(design), "-o", str(out), "-q", "--force"]) == 0
    assert {p.name for p in out.iterdir()} == {
        *("result.h5", "summary.json", "shape.stl", "notes.txt", "series"),
    }
    assert list((out / "series").iterdir()) == []
    # A design that cannot be run destroys nothing.
    broken = ["--set", "supports=[{kind='nodes', nodes=[999999, 1, 2]}]", "--force"]
    assert main(["run", str(design), "-o", str(out), "-q", *broken]) == 2
    assert sm.Result.load(out).status == "completed"


@pytest.mark.parametrize("force", [[], ["--force"]])
def test_what_is_not_of_a_run_is_never_touched(
    design: Path, tmp_path: Path, force: list[str]
) -> None:
    """A folder of the user's with names like ours: -o . in a project, say."""
    mine = [tmp_path / name for name in ("pictures/cat.png", "pictures/top.png", "report.html")]
    for path in mine:
        path.parent.mkdir(exist_ok=True)
        path.write_text("of the user")
    assert main(["run", str(design), "-o", str(tmp_path), "-q", *force]) == 0
    assert main(["run", str(design), "-o", str(tmp_path), "-q", "--force"]) == 0
    assert (tmp_path / "pictures" / "cat.png").read_text("utf-8") == "of the user"
    assert design.exists()


def test_a_computation_that_fails_ends_with_1(
    design: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    failing = ["run", str(design), "-o", str(out), "-q", "--set", "solver.max_steps=3"]
    assert main(failing) == 1
    line = capsys.readouterr().err
    assert line.count("\n") == 1
    assert "too_many_steps" in line and "solver.max_steps" in line
    # The last good state is kept, and with the limit raised the run goes on.
    partial = sm.Result.load(out)
    assert 0 < partial.summary["actuation_reached"] < 1
    assert main(["run", str(design), "-o", str(out), "-q", "--resume"]) == 0
    whole = sm.simulate(sm.Design.load(design))
    np.testing.assert_array_equal(sm.Result.load(out).positions, whole.positions)


def test_check(design: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = sorted(design.parent.iterdir())
    assert main(["check", str(design)]) == 0
    text = capsys.readouterr().out
    for word in ("nodes", "triangles", "mm²", "D ", "k_s"):
        assert word in text
    assert main(["check", str(design), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["mesh"]["nodes"] > 100
    assert sorted(design.parent.iterdir()) == before


@pytest.mark.parametrize("command", [[], ["new"], ["check"], ["run"]])
def test_help_has_an_example(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*command, "--help"]) == 0
    text = capsys.readouterr().out
    assert "sheetmorph" in text
    assert "Example" in text or "Start here" in text


def test_choices_are_those_of_the_packages_that_make_them() -> None:
    from sheetmorph.cli.fabricate import PAPERS, PRINTERS
    from sheetmorph.cli.new import PRESETS
    from sheetmorph.design import presets
    from sheetmorph.fabricate import options, printer

    assert presets.PRESETS == PRESETS
    assert tuple(options.PAPERS) == PAPERS
    assert tuple(printer.PROFILES) == PRINTERS


def test_help_imports_nothing_heavy() -> None:
    """What keeps --help fast: no NumPy, no Numba, no VTK, no pydantic at start."""
    code = (
        "import sys; from sheetmorph.cli import main; main(['--help']);"
        "print([m for m in ('numpy', 'numba', 'pydantic', 'vtkmodules', 'h5py', 'matplotlib')"
        " if m in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "[]"


def start(design: Path, out: Path, *more: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "sheetmorph", "run", str(design), "-o", str(out), *more],
        stderr=subprocess.PIPE,
    )


def finish(process: subprocess.Popen[bytes]) -> tuple[int, str]:
    """Exit code and what it said."""
    _, err = process.communicate(timeout=120)
    return process.returncode, err.decode()


def wait_for_state(out: Path, index: int, process: subprocess.Popen[bytes]) -> None:
    deadline = time.monotonic() + 120
    while not (out / "states" / f"state_{index:05d}.npz").exists():
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.005)


LONG = ["--set", "mesh.size=0.6 mm", "-q"]  # about 4,000 nodes, some seconds


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals are those of POSIX")
def test_killed_and_resumed_to_the_same_bits(design: Path, tmp_path: Path) -> None:
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    assert finish(start(design, whole, *LONG)) == (0, "")
    for index in (1, 4):
        again = ["--resume"] if index > 1 else []
        process = start(design, cut, *LONG, *again)
        wait_for_state(cut, index, process)
        process.send_signal(signal.SIGKILL)
        finish(process)
        assert not (cut / "result.h5").exists()
    # Without --resume or --force the states are safe.
    code, said = finish(start(design, cut, *LONG))
    assert code == 2
    assert "--resume" in said
    assert finish(start(design, cut, *LONG, "--resume")) == (0, "")
    a, b = sm.Result.load(whole), sm.Result.load(cut)
    np.testing.assert_array_equal(a.positions, b.positions)
    assert not (cut / "states").exists()


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals are those of POSIX")
def test_interrupted_ends_cleanly(design: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    process = start(design, out, *LONG)
    wait_for_state(out, 2, process)
    process.send_signal(signal.SIGINT)
    code, said = finish(process)
    assert code == 130
    assert said.count("\n") == 1
    assert "--resume" in said
    assert list((out / "states").glob("state_*.npz"))
    assert not (out / "result.h5").exists()
