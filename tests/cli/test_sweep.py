"""`sheetmorph sweep` and `sheetmorph plot` through the command line."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from many import STARS, written
from PIL import Image

from sheetmorph.cli import main
from sheetmorph.sweep.dataset import Sweep

MIXED = STARS.replace('["0.5 mm", "0.9 mm"]', '["0.5 mm", "0.9 mm", "-1 mm"]')
"""Six designs, two of which are refused."""


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a sweep."""
    folder = tmp_path_factory.mktemp("cli")
    command = ["sweep", str(written(folder, MIXED)), "-o", str(folder / "out"), "--workers", "1"]
    assert main([*command, "-q"]) == 0
    return folder / "out"


def test_a_sweep_says_how_it_went(
    out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file = out.parent / "stars.toml"
    assert {path.name for path in out.iterdir()} >= {"results.parquet", "states.h5"}
    assert main(["sweep", str(file), "-o", str(out)]) == 2
    assert "--force" in capsys.readouterr().err
    assert main(["sweep", str(file), "-o", str(out), "--resume", "--json"]) == 0
    tally = json.loads(capsys.readouterr().out)
    assert (tally["designs"], tally["present"], tally["failed"], tally["computed"]) == (6, 6, 2, 0)
    assert main(["sweep", str(file), "-o", str(out), "--resume", "--set", "mesh.size=4"]) == 2
    monkeypatch.chdir(tmp_path)
    assert main(["sweep", str(file), "--workers", "1", "--set", "solver.max_steps=400"]) == 0
    captured = capsys.readouterr()
    assert "6 designs, 2 did not complete" in captured.out
    assert "dashboard: http://127.0.0.1:" in captured.err
    statuses = Sweep.load(tmp_path / "sweeps" / "stars").table["status"].to_pylist()
    assert sorted(statuses) == 4 * ["completed"] + 2 * ["refused"]


@pytest.mark.parametrize(
    ("extra", "word"),
    [
        (["--workers", "0"], "--workers"),
        (["--workers", "2", "--scheduler", "tcp://127.0.0.1:9"], "exclude"),
        (["-o", " "], "-o"),
        (["--set", "eps_pre"], "KEY=VALUE"),
    ],
)
def test_bad_options_end_with_2(
    tmp_path: Path, extra: list[str], word: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["sweep", str(written(tmp_path)), "-o", str(tmp_path / "new"), *extra]) == 2
    said = capsys.readouterr().err
    assert word in said
    assert said.count("\n") == 1
    assert not (tmp_path / "new").exists()


def test_what_is_not_installed_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert main(["sweep", str(written(tmp_path)), "-o", str(tmp_path / "new")]) == 2
    assert 'pip install "sheetmorph[sweep]"' in capsys.readouterr().err


@pytest.mark.parametrize("command", ["sweep", "plot"])
def test_help_has_an_example(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, "--help"]) == 0
    assert "Example" in capsys.readouterr().out


def test_plots(out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    x, y, colour = "layers.print.thickness", "aspect_ratio", "actuation.eps_pre"
    assert main(["plot", str(out), x, y, colour]) == 0
    picture = out / "plots" / f"{y}-{x}-{colour}.png"
    assert str(picture.name) in capsys.readouterr().out
    pixels = np.asarray(Image.open(picture))
    assert pixels.shape == (660, 1000, 3)
    assert main(["plot", str(out), x, y, colour]) == 2
    assert "--force" in capsys.readouterr().err
    assert main(["plot", str(out), x, y, colour, "--force", "-q"]) == 0
    assert main(["plot", str(out), "-o", str(tmp_path / "all"), "--shapes", "3", "--by", y]) == 0
    assert {path.name for path in (tmp_path / "all").iterdir()} == {"shapes.png", "parallel.html"}
    assert main(["plot", str(out), "--columns"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert "layers.print.thickness [m]" in said
    assert "aspect_ratio" in said


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["aspect_ratio"], "two columns"),
        (["aspect_ratios", "height_m"], "did you mean aspect_ratio"),
        (["--shapes", "0"], "--shapes"),
        (["--by", "nothing"], "no such column"),
        (["--column", "nothing"], "no such column"),
    ],
)
def test_plots_that_are_refused(
    out: Path, tmp_path: Path, arguments: list[str], word: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["plot", str(out), "-o", str(tmp_path / "new"), *arguments]) == 2
    assert word in capsys.readouterr().err
    assert main(["plot", str(tmp_path), "aspect_ratio", "height_m"]) == 2
