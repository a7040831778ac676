"""The command `paper`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from sheetmorph.cli.paper import paper
from sheetmorph.core.errors import InputError


def call(*arguments: str) -> None:
    paper.main([*arguments], prog_name="sheetmorph paper", standalone_mode=False)


@pytest.fixture(autouse=True)
def _alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No reference data, and pictures without a child process."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("SHEETMORPH_REFERENCE_DATA", raising=False)
    monkeypatch.setenv("SHEETMORPH_RENDERER", "drawn")


def test_a_report_without_the_papers_meshes(capsys: pytest.CaptureFixture[str]) -> None:
    call("--only", "constants", "--only", "elements", "--workers", "1")
    told = capsys.readouterr().out
    assert "meshes made here" in told
    assert "not redone" in told
    assert Path("paper-report/paper.html").is_file()
    data = json.loads(Path("paper-report/paper.json").read_text("utf-8"))
    assert [section["key"] for section in data["sections"]] == ["constants", "elements"]
    with pytest.raises(InputError, match="--force"):
        call("--only", "elements")
    call("--only", "elements", "--force", "--quiet")
    assert capsys.readouterr().out == ""
    data = json.loads(Path("paper-report/paper.json").read_text("utf-8"))
    assert [section["key"] for section in data["sections"]] == ["elements"]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--only", "shape"], "did you mean shapes"),
        (["-o", " "], "-o wants a folder"),
        (["--reference", "nowhere"], "bowl_mesh.txt"),
        (["--scan", "nowhere.stl"], "no such file"),
    ],
)
def test_bad_options_end_before_anything_is_computed(arguments: list[str], told: str) -> None:
    with pytest.raises(InputError, match=told):
        call(*arguments)
    assert list(Path().iterdir()) == []


def test_help_has_an_example(capsys: pytest.CaptureFixture[str]) -> None:
    call("--help")
    assert "sheetmorph paper --only shapes" in capsys.readouterr().out


@pytest.mark.slow
def test_the_papers_shapes_and_meshes(reference: Path) -> None:
    call("--only", "shapes", "--only", "mesh", "--reference", str(reference), "--quiet")
    data = json.loads(Path("paper-report/paper.json").read_text("utf-8"))
    rows = {row["id"]: row for row in data["rows"]}
    assert rows["mesh-bowl"]["verdict"] == "agrees"
    assert rows["released-petals"]["ours"] < 1e-10
    assert all(rows[f"stable-{name}"]["verdict"] == "agrees" for name in ("bowl", "canoe"))
    assert rows["mesh-863-970"]["ours"] > 0.97
    assert rows["mesh-970-1080"]["ours"] > 0.99
    assert Path("paper-report/paper.html").stat().st_size < 15e6
