"""Files of strangers are read within bounds, and refused in one line that names them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.core.strangers import check_size, ending_of, read_bytes, read_text

READERS = {".stl": 1, ".ply": 2}


def test_the_ending_is_found_whatever_its_case(tmp_path: Path) -> None:
    assert ending_of(tmp_path / "a.STL", READERS, "format") == ".stl"


@pytest.mark.parametrize(
    ("name", "said"),
    [("a.slt", r"did you mean \.stl\?"), ("a", "got 'no ending'.*allowed: .stl, .ply")],
)
def test_other_endings_are_refused(tmp_path: Path, name: str, said: str) -> None:
    with pytest.raises(InputError, match=f"{name}: no such mesh format.*{said}"):
        ending_of(tmp_path / name, READERS, "mesh format")


def test_what_is_within_bounds_is_read_whole(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_bytes(b"\xef\xbb\xbf" + "εₚᵣₑ".encode())
    size = file.stat().st_size
    check_size(file, size)
    assert read_bytes(file, size) == file.read_bytes()
    assert read_text(file, size, "a text") == "εₚᵣₑ"


Reader = Callable[[Path, int], object]
READ: dict[str, Reader] = {
    "size": check_size,
    "bytes": read_bytes,
    "text": lambda file, most: read_text(file, most, "a text"),
}


@pytest.mark.parametrize("read", READ.values(), ids=READ)
def test_what_is_no_such_file_is_refused(tmp_path: Path, read: Reader) -> None:
    file = tmp_path / "file"
    with pytest.raises(InputError, match="file: there is no such file"):
        read(file, 10)
    with pytest.raises(InputError, match=r"is a folder, not a text|is not a file"):
        read(tmp_path, 10)
    file.write_bytes(b"12345678901")
    with pytest.raises(InputError, match=r"file: the file is too large.*allowed: ≤ 1e-05 MB"):
        read(file, 10)


@pytest.mark.parametrize("read", [READ["size"], READ["bytes"]])
def test_empty_files_are_refused(tmp_path: Path, read: Reader) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="file: the file is empty"):
        read(tmp_path / "file", 10)


def test_a_file_that_grows_while_it_is_read_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "file"
    file.write_bytes(b"12345678901")
    monkeypatch.setattr("sheetmorph.core.strangers.check_size", lambda *_: None)
    with pytest.raises(InputError, match="too large; cut it"):
        read_bytes(file, 10, "cut it")


def test_text_that_is_none_names_the_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"one\ntwo \xff\n")
    with pytest.raises(InputError, match=r"file: is not UTF-8 text \(line 2\)"):
        read_text(tmp_path / "file", 100, "a text")
