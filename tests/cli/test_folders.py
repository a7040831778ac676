"""The folder that -o names: long jobs have it to themselves; files of others are left alone."""

from __future__ import annotations

from pathlib import Path

import pytest
import trimesh
from small import SMALL

from sheetmorph.cli import main
from sheetmorph.core.locks import sole_user

COMMANDS = {
    "branches": ["small.toml"],
    "calibrate": ["small.toml", "--fit", "eps_pre", "--curve", "curve.csv"],
    "compare": ["disc.stl", "disc.stl"],
    "design": ["bowl"],
    "fabricate": ["small.toml", "--no-prediction"],
    "history": ["--film", "table.csv"],
    "paper": ["--only", "mesh"],
    "run": ["small.toml"],
    "verify": ["--only", "timoshenko"],
}


@pytest.fixture(autouse=True)
def inputs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("small.toml").write_text(SMALL, encoding="utf-8")
    Path("curve.csv").write_text("eps_pre, h/d\n-0.1, 0.1\n-0.2, 0.2\n", encoding="utf-8")
    trimesh.creation.icosphere(1).export("disc.stl")


@pytest.mark.parametrize("command", COMMANDS)
def test_a_second_job_is_kept_out(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = {path.name for path in tmp_path.iterdir()}
    with sole_user("out"):
        assert main([command, *COMMANDS[command], "-o", "out"]) == 2
        assert [path.name for path in Path("out").iterdir()] == [".sheetmorph.lock"]
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1
    assert "another job of sheetmorph is at work in this folder" in err
    assert {path.name for path in tmp_path.iterdir()} == before


@pytest.mark.parametrize(
    "line",
    [
        *([command, *more] for command, more in COMMANDS.items()),
        ["sweep", "sweep.toml"],
        ["plot", "sweep"],
        ["material", "shrink", "rows.csv"],
        ["material", "cantilever", "rows.csv"],
        ["verify", "small.toml", "--fe", "abaqus"],
    ],
    ids=lambda line: "-".join(line[:2]),
)
def test_a_folder_has_a_name(line: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*line, "-o", " "]) == 2
    assert "-o wants a folder, such as" in capsys.readouterr().err


@pytest.mark.parametrize("content", ['{"format": "another"}', "[" * 100_000], ids=["other", "deep"])
@pytest.mark.parametrize(
    ("command", "name"),
    [("branches", "branches.json"), ("paper", "paper.json"), ("verify", "proofs.json")],
)
def test_numbers_that_no_such_command_wrote_are_left_alone(
    command: str, name: str, content: str, capsys: pytest.CaptureFixture[str]
) -> None:
    file = Path("out") / name
    file.parent.mkdir()
    file.write_text(content, encoding="utf-8")
    assert main([command, *COMMANDS[command], "-o", "out", "--force"]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and f"{name}: this file would be replaced" in err
    assert file.read_text("utf-8") == content
