"""Which folders a command may write into."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from sheetmorph.core.errors import InputError, OutputError
from sheetmorph.show.guard import check_folder

NAMES = ("data.json", "pictures/a.png")


def check(folder: Path, *, force: bool = False, ours: bool = True, inputs: tuple = ()) -> None:
    check_folder(folder, NAMES, "thing", ours=lambda _file: ours, force=force, inputs=inputs)


def test_new_and_unrelated_folders_are_free(tmp_path: Path) -> None:
    check(tmp_path / "a" / "b")
    (tmp_path / "mine.txt").write_text("mine")
    check(tmp_path, ours=False)


def test_files_of_its_own_need_force(tmp_path: Path) -> None:
    (tmp_path / "data.json").write_text("{}")
    with pytest.raises(InputError, match="holds a thing; add --force"):
        check(tmp_path)
    check(tmp_path, force=True)


@pytest.mark.parametrize("force", [False, True])
def test_files_of_others_stay(tmp_path: Path, force: bool) -> None:
    (tmp_path / "pictures").mkdir()
    (tmp_path / "pictures" / "a.png").write_text("mine")
    with pytest.raises(InputError, match=r"a\.png: .*no thing wrote it"):
        check(tmp_path, force=force, ours=False)


def test_a_folder_in_the_place_of_a_file_stays(tmp_path: Path) -> None:
    (tmp_path / "data.json").mkdir()
    with pytest.raises(InputError, match="no thing wrote it"):
        check(tmp_path, force=True)


def test_inputs_are_not_written_over(tmp_path: Path) -> None:
    (tmp_path / "data.json").write_text("readings")
    with pytest.raises(InputError, match="written over"):
        check(tmp_path, force=True, inputs=(tmp_path / "pictures" / ".." / "data.json",))


def test_a_file_and_a_folder_without_rights(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="this is a file"):
        check(tmp_path / "file")
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(OutputError, match="nothing can be written"):
        check(tmp_path / "new")
