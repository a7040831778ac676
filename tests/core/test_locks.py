"""One job at a time in a folder."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from sheetmorph.core.errors import InputError, OutputError
from sheetmorph.core.locks import sole_user

WAIT = """
import sys
from sheetmorph.core.locks import sole_user
with sole_user(sys.argv[1]):
    print("in", flush=True)
    sys.stdin.read()
"""


def test_another_process_is_kept_out_until_it_is_killed(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    child = subprocess.Popen(
        [sys.executable, "-c", WAIT, folder], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    with child:
        assert child.stdout is not None
        assert child.stdout.readline().strip() == b"in"
        with pytest.raises(InputError, match="another job"), sole_user(folder):
            pass
        child.kill()
    with sole_user(folder), sole_user(tmp_path):
        pass
    assert not list(folder.iterdir())


def test_a_place_that_is_none(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x", encoding="utf-8")
    with pytest.raises(OutputError, match="-o"), sole_user(tmp_path / "file" / "under"):
        pass


def test_folders_that_were_made_for_nothing_are_removed(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    with sole_user(tmp_path / "there" / "new" / "deep"):
        pass
    assert [*tmp_path.rglob("*")] == [tmp_path / "there"]
    with sole_user(tmp_path / "there" / "new" / "deep"):
        (tmp_path / "there" / "new" / "file").touch()
    assert (tmp_path / "there" / "new" / "file").exists()
    assert not (tmp_path / "there" / "new" / "deep").exists()
