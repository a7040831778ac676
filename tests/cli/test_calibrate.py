"""The command `calibrate`: what it writes, refuses, and goes on with after it was killed."""

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
from sheetmorph.calibrate.curves import Curve
from sheetmorph.cli import entry, main
from sheetmorph.cli.calibrate import calibrate

if "calibrate" not in entry.cli.commands:
    entry.cli.add_command(calibrate)

PROGRAM = (
    "import sys; from sheetmorph.cli import entry; from sheetmorph.cli.calibrate import calibrate\n"
    "if 'calibrate' not in entry.cli.commands: entry.cli.add_command(calibrate)\n"
    "sys.exit(entry.main(sys.argv[1:]))"
)
QUICK = ["--starts", "2", "--workers", "1", "--no-intervals", "--no-pictures"]


@pytest.fixture(scope="module")
def result() -> sm.Result:
    design = sm.Design.from_toml(SMALL).with_values({"actuation.eps_pre": -0.47})
    return sm.simulate(design)


@pytest.fixture
def design(tmp_path: Path, result: sm.Result) -> Path:
    """A design file with a curve of h/d beside it, of the same design at −0.47."""
    at = np.linspace(0.1, 1.0, 12)
    values = Curve("", "actuation", at, np.zeros(12)).differences(result)
    rows = "".join(f"{a},{v}\n" for a, v in zip(at, values, strict=True))
    (tmp_path / "film.csv").write_text(f"actuation,h/d\n{rows}")
    file = tmp_path / "small.toml"
    file.write_text(SMALL)
    return file


def arguments(design: Path, folder: Path, *more: str) -> list[str]:
    film = str(design.parent / "film.csv")
    return ["calibrate", str(design), "--curve", film, "-o", str(folder), *QUICK, *more]


def test_a_fit_is_written_and_guarded(
    design: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "fit"
    fit = arguments(design, folder, "--fit", "eps_pre=-0.8:-0.2")
    assert main(fit) == 0
    out = capsys.readouterr().out
    assert "eps_pre = −0.47" in out and "misfit" in out and "film.csv" in out
    assert {path.name for path in folder.iterdir()} == {
        *("calibration.json", "evaluations.jsonl", "small-calibrated.toml")
    }
    told = json.loads((folder / "calibration.json").read_text("utf-8"))
    assert told["parameters"][0]["value"] == pytest.approx(-0.47, rel=0.005)
    assert told["misfit_percent"]["fit"] < 0.1 * told["misfit_percent"]["start"]
    fitted = sm.Design.load(folder / "small-calibrated.toml")
    assert fitted.eps_pre == told["parameters"][0]["value"]

    assert main(fit) == 2
    assert "--force" in capsys.readouterr().err
    (folder / "mine.txt").write_text("mine")
    assert main([*fit, "--resume", "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["simulations"] == 0 and again["parameters"] == told["parameters"]
    assert main([*fit, "--force", "-q"]) == 0
    captured = capsys.readouterr()
    assert captured.out == captured.err == ""
    assert (folder / "mine.txt").read_text("utf-8") == "mine"


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (["--fit", "eps=-0.8:-0.2"], "did you mean eps_pre"),
        (["--fit", "eps_pre=-0.2:-0.8"], "LOW below HIGH"),
        (["--fit", "eps_pre=-3:-0.2"], "does not allow"),
        ([], "nothing to fit"),
        (["--fit", "eps_pre", "--scan", "none.stl"], "none.stl"),
        (["--fit", "eps_pre", "--curve", "none.csv"], "none.csv"),
        (["--fit", "eps_pre", "--unit", "kg"], "--unit"),
        (["--fit", "eps_pre", "--workers", "0"], "--workers"),
        (["--fit", "eps_pre", "--confidence", "2"], "--confidence"),
        (["--fit", "eps_pre", "--resume"], "no unfinished fit"),
        (["--fit", "eps_pre", "--resume", "--force"], "exclude each other"),
        (["--fit", "eps_pre", "-o", " "], "-o wants a folder"),
    ],
)
def test_bad_input_ends_with_2_and_one_line(
    design: Path,
    tmp_path: Path,
    more: list[str],
    told: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(arguments(design, tmp_path / "fit", *more)) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert told in lines[-1] and len(lines) == 1
    assert not (tmp_path / "fit" / "calibration.json").exists()


def test_data_is_needed(design: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["calibrate", str(design), "--fit", "eps_pre"]) == 2
    assert "--scan or --curve" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize(("sent", "code"), [(signal.SIGINT, 130), (signal.SIGKILL, -9)])
def test_a_killed_fit_goes_on(
    design: Path, tmp_path: Path, sent: signal.Signals, code: int
) -> None:
    folder = tmp_path / "fit"
    fit = arguments(design, folder, "--fit", "eps_pre=-0.8:-0.2", "--starts", "40")
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *fit], stderr=subprocess.PIPE, text=True
    )
    journal = folder / "evaluations.jsonl"
    deadline = time.monotonic() + 60
    while not journal.is_file() or journal.read_bytes().count(b"\n") < 4:
        assert time.monotonic() < deadline
        time.sleep(0.02)
    os.kill(process.pid, sent)
    error = process.communicate(timeout=30)[1]
    assert process.returncode == code
    assert sent is signal.SIGKILL or "--resume" in error
    kept = len(journal.read_text("utf-8").splitlines()) - 1
    assert 3 <= kept < 40
    assert main(fit) == 2  # an unfinished fit is not thrown away
    assert main([*fit, "--resume", "-q"]) == 0
    told = json.loads((folder / "calibration.json").read_text("utf-8"))
    assert told["simulations"] <= told["evaluations"] - kept + 1
    assert told["parameters"][0]["value"] == pytest.approx(-0.47, rel=0.005)


@pytest.mark.slow
def test_a_scan_is_told_with_its_similarity(
    design: Path, tmp_path: Path, result: sm.Result, capsys: pytest.CaptureFixture[str]
) -> None:
    from sheetmorph.geometry.writers import write_stl

    scan = tmp_path / "scan.stl"
    write_stl(scan, result.mesh.triangles, 1e3 * result.positions[-1])
    folder = tmp_path / "fit"
    fit = ["calibrate", str(design), "--scan", str(scan), "--unit", "mm", "-o", str(folder)]
    assert main([*fit, "--fit", "eps_pre=-0.8:-0.2", "--starts", "2", "--workers", "1"]) == 0
    assert "SSIM" in capsys.readouterr().out
    told = json.loads((folder / "calibration.json").read_text("utf-8"))
    assert told["parameters"][0]["value"] == pytest.approx(-0.47, rel=0.002)
    assert told["scans"][0]["fit"]["ssim"] > 0.99
    assert told["scans"][0]["fit"]["scale"] == pytest.approx(1e-3)
    assert {"misfit.png", "profile.png"} <= {path.name for path in folder.iterdir()}
