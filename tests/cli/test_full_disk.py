"""Commands on a disk that takes no more: one line, exit code 2, and --resume when there is room."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path

import numpy as np
import pytest

import sheetmorph as sm
from room import room_for
from sheetmorph.cli.entry import main
from sheetmorph.core.errors import OutputError

DESIGN = """
name = "strip"
model = "published"
outline = { kind = "rectangle", width = "40 mm", height = "8 mm" }
pattern = [{ kind = "rectangle", width = "40 mm", height = "4 mm" }]
layers = [
  { name = "film", role = "active", thickness = "0.3 mm", young_modulus = "1 MPa" },
  { name = "PLA", role = "inert", where = "pattern", thickness = "1 mm", young_modulus = "3 MPa" },
]
actuation = { eps_pre = -0.1 }
mesh = { size = "4 mm" }
outputs = { pictures = false, animation = false, report = false, series = false }
"""


@pytest.fixture
def design(tmp_path: Path) -> Path:
    path = tmp_path / "strip.toml"
    path.write_text(DESIGN, encoding="utf-8")
    return path


def one_line(told: str) -> str:
    assert told.startswith("sheetmorph: ") and told.count("\n") == 1, told
    return told


@pytest.mark.parametrize("share", [0.0, 0.2, 0.9])
def test_a_run_goes_on_when_there_is_room(design, tmp_path, capsys, share) -> None:
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    assert main(["run", str(design), "-o", str(whole), "-q"]) == 0
    room = int(share * (whole / "result.h5").stat().st_size)
    with room_for(room):
        assert main(["run", str(design), "-o", str(cut), "-q"]) == 2
    told = one_line(capsys.readouterr().err)
    kept = list(cut.glob("states/state_*.npz"))
    assert ("--resume" in told) == bool(kept) == (share > 0.0)
    assert not (cut / "result.h5").exists()
    assert not [file for file in cut.rglob("*") if ".partial" in file.name or "lock" in file.name]
    again = ["--resume"] if kept else []
    assert main(["run", str(design), "-o", str(cut), "-q", *again]) == 0
    one, other = sm.Result.load(whole), sm.Result.load(cut)
    np.testing.assert_array_equal(one.positions, other.positions)


def test_force_removes_nothing_where_the_new_run_cannot_begin(design, tmp_path, capsys) -> None:
    folder = tmp_path / "run"
    assert main(["run", str(design), "-o", str(folder), "-q"]) == 0
    before = {file: file.read_bytes() for file in folder.iterdir() if file.is_file()}
    assert folder / "result.h5" in before
    with room_for(10):
        assert main(["run", str(design), "-o", str(folder), "-q", "--force"]) == 2
    one_line(capsys.readouterr().err)
    assert {file: file.read_bytes() for file in folder.iterdir() if file.is_file()} == before


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no full device")
@pytest.mark.parametrize("line", [["material", "list"], ["--help"]])
def test_an_output_that_takes_nothing(line, capsys, monkeypatch) -> None:
    with Path("/dev/full").open("w") as full:
        monkeypatch.setattr("sys.stdout", full)
        assert main(line) == 2
        assert full.closed  # or else Python would say so once more when it ends
    assert "No space left" in one_line(capsys.readouterr().err)


def test_an_upload_without_room_leaves_nothing(tmp_path) -> None:
    from sheetmorph.studio.uploads import stored

    async def chunks() -> AsyncIterator[bytes]:
        for _ in range(3):
            yield bytes(1 << 20)

    with room_for(1 << 21), pytest.raises(OutputError, match="temporary files"):
        asyncio.run(stored("scan", "hand.stl", None, chunks(), tmp_path))
    assert not list(tmp_path.iterdir())


def test_the_renderer_without_room_says_what_to_do(tmp_path, monkeypatch) -> None:
    from sheetmorph.show.render import RenderWorker

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "none-such"))
    with RenderWorker.start() as worker:
        assert worker.renderer == "drawn"
        assert worker.note is not None
        assert "TMPDIR" in worker.note and "apt-get" not in worker.note
