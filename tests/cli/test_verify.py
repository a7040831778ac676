"""The command `verify`: a design and its finite-element twin; a script stands in for the solver."""

from __future__ import annotations

import json
import os
import sys
from functools import partial
from pathlib import Path

import meshio
import numpy as np
import pytest
from scipy.spatial.distance import pdist
from twin_designs import BILAYER

from sheetmorph.cli import main
from sheetmorph.compare import comparison
from sheetmorph.compare.align import Effort, align
from sheetmorph.twin.ccx import VARIABLE

QUICK = ["--no-pictures", "--steps", "2"]

STAND_IN = """
import pathlib, sys, time
if sys.argv[1] == "-v":
    print("This is Version 7.5"); sys.exit()
job = sys.argv[1]
nodes, surface, reading = {}, [], ""
for line in pathlib.Path(job + ".inp").read_text("utf-8").splitlines():
    if line.startswith("*"):
        reading = line
    elif reading == "*NODE, NSET=ALL":
        number, x, y, z = line.split(",")
        nodes[int(number)] = (float(x), float(y))
    elif reading == "*NSET, NSET=SURFACE":
        surface += [int(cell) for cell in line.split(",") if cell]
status = "SUMMARY\\n"
result = ""
for step in range(1, STEPS + 1):
    status += f"{step} 1 1 5 {step:.6E} 1.0 1.0\\n"
    result += f"  100CL  101{step:12.5E}{len(surface):12d}\\n -4  DISP        4    1\\n"
    for number in surface:
        x, y = nodes[number]
        z = 0.01 * step * (x * x + y * y)
        result += f" -1{number:10d}{-0.02 * step * x:12.5E}{-0.02 * step * y:12.5E}{z:12.5E}\\n"
    result += " -3\\n"
pathlib.Path(job + ".frd").write_text(result)
pathlib.Path(job + ".sta").write_text(status)
END
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a design, where nothing is drawn and the solver is not installed."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    brisk = partial(align, effort=Effort(starts=96, kept=6, points=1000))
    monkeypatch.setattr(comparison, "align", brisk)
    (tmp_path / "twin.toml").write_text(BILAYER)
    return tmp_path


def install(folder: Path, steps: int, end: str = 'print("Job finished")') -> None:
    if os.name != "posix":
        pytest.skip("the stand-in is a script of a shell")
    path = folder / "ccx"
    code = STAND_IN.replace("STEPS", str(steps)).replace("END", end)
    path.write_text(f"#!{sys.executable}\n{code}")
    path.chmod(0o755)


def test_a_twin_is_computed_and_compared(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    install(here, 4)
    assert main(["verify", "twin.toml", "--fe", "calculix", *QUICK]) == 0
    said = capsys.readouterr().out
    assert "CalculiX 7.5 (natural law), followed to the end" in said
    assert "comparison in twin-twin/" in said
    folder = here / "twin-twin"
    data = json.loads((folder / "comparison.json").read_text("utf-8"))
    assert data["twin"]["twin"]["ended"] == "completed"
    assert data["twin"]["node_rms_mm"] > 0.1
    assert 0.0 < data["ssim"] < 1.0
    assert (folder / "comparison.html").is_file()
    # The stand-in shrinks the sheet of 12 × 8 mm by 8 % and bends it alike at all corners.
    points = meshio.read(folder / "aligned_scan.stl").points
    assert pdist(points).max() == pytest.approx(0.92 * np.hypot(12e-3, 8e-3), rel=1e-4)


def test_json_is_all_that_is_printed(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    install(here, 4)
    assert main(["verify", "twin.toml", "--fe", "calculix", *QUICK, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["twin"]["twin"]["solver"] == "CalculiX 7.5"


def test_a_twin_is_replaced_by_force_alone(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    install(here, 4)
    command = ["verify", "twin.toml", "--fe", "calculix", *QUICK, "-q"]
    assert main(command) == 0
    assert main(command) == 2
    assert "add --force to replace it" in capsys.readouterr().err
    assert main([*command, "--force"]) == 0


def test_a_run_that_is_stopped_is_compared_where_it_was(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    install(here, 2, "time.sleep(60)")
    command = ["verify", "twin.toml", "--fe", "calculix", *QUICK, "--time-limit", "1.5 s"]
    assert main(command) == 0
    said = capsys.readouterr().out
    assert "stopped by the time limit" in said
    assert "eps_pre    -0.1 of -0.2" in said


def test_a_run_that_reaches_nothing_says_why(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    install(here, 0, 'print(" *ERROR: no hope"); sys.exit(201)')
    assert main(["verify", "twin.toml", "--fe", "calculix", *QUICK]) == 1
    said = capsys.readouterr().err
    assert "CalculiX reached no step (no hope); see twin-twin/calculix/twin.log" in said


def test_absence_of_the_solver_says_how_to_install(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["verify", "twin.toml", "--fe", "calculix"]) == 2
    assert "sudo apt-get install calculix-ccx" in capsys.readouterr().err
    assert not (here / "twin-twin").exists()


def test_the_deck_alone_needs_no_solver(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["verify", "twin.toml", "--fe", "calculix", "--deck-only", "--steps", "3"]
    assert main(command) == 0
    assert "5 steps; run it with: ccx twin" in capsys.readouterr().out
    assert (here / "twin-twin" / "calculix" / "twin.inp").read_text("utf-8").count("*STEP") == 5
    assert main(command) == 2
    assert "add --force" in capsys.readouterr().err


def test_the_abaqus_deck_is_written(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "twin.toml", "--fe", "abaqus", "-o", "deck"]) == 0
    assert "keywords and references checked" in capsys.readouterr().out
    assert "*HYPERELASTIC, MOONEY-RIVLIN" in (here / "deck" / "abaqus" / "twin.inp").read_text(
        "utf-8"
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--fe", "calculix"], "DESIGN: name the file of a design"),
        (["twin.toml"], "--fe: say which program computes the twin; allowed: calculix or abaqus"),
        (["twin.toml", "--fe", "ansys"], "'ansys' is not one of"),
        (["none.toml", "--fe", "abaqus"], "none.toml"),
        (["twin.toml", "--fe", "abaqus", "-o", " "], "-o wants a folder"),
        (["twin.toml", "--fe", "calculix", "--time-limit", "5 mm"], "--time-limit"),
        (["twin.toml", "--fe", "calculix", "--time-limit", "0 s"], "--time-limit: must be"),
        (["twin.toml", "--fe", "calculix", "--steps", "0"], "--steps"),
    ],
)
def test_bad_input_is_told_in_one_line(
    here: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    install(here, 4)
    assert main(["verify", *arguments]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1
