"""A disk that takes no more: whole or absent, one line, and nothing of what was there is lost.

The system itself refuses to write here, by its limit on the size of files.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from sheetmorph.core.compiled import kernel
from sheetmorph.core.errors import OutputError
from sheetmorph.core.files import resumable, write_bytes, write_text
from sheetmorph.core.lines import append_line, begin_lines, read_lines

resource = pytest.importorskip("resource", reason="Windows has no limit on the size of files")
HEADER = {"fingerprint": "x"}


@contextmanager
def room_for(size: int) -> Iterator[None]:
    """No file may grow beyond so many bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("room", [0, 1, 4095, 9999])
def test_a_file_is_whole_or_as_it_was(tmp_path: Path, room: int) -> None:
    old, new = tmp_path / "old.txt", tmp_path / "new.bin"
    write_text(old, "before")
    with room_for(room), pytest.raises(OutputError, match=r"too large.*free some space"):
        write_text(old, "x" * 10_000)
    with room_for(room), pytest.raises(OutputError, match="too large"):
        write_bytes(new, bytes(10_000))
    assert old.read_text() == "before"
    assert list(tmp_path.iterdir()) == [old]


def test_a_line_is_whole_or_absent_and_the_journal_goes_on(tmp_path: Path) -> None:
    path = tmp_path / "lines.jsonl"
    with room_for(3), pytest.raises(OutputError):
        begin_lines(path, HEADER)
    assert not path.exists()
    begin_lines(path, HEADER)
    append_line(path, {"a": 1})
    whole = path.read_bytes()
    with room_for(len(whole) + 20), pytest.raises(OutputError, match="then add --resume"):
        append_line(path, {"a": list(range(100))})
    assert path.read_bytes() == whole
    append_line(path, {"a": 2})
    found = read_lines(path, HEADER, job="fit", parts="design", most=1000)
    assert found == [(2, {"a": 1}), (3, {"a": 2})]


def test_a_kernel_needs_no_room_for_its_cache(tmp_path: Path) -> None:
    source = tmp_path / "kernels.py"
    source.write_text("def twice(x):\n    return 2 * x\n", encoding="utf-8")
    space: dict[str, object] = {"__name__": "kernels"}
    exec(compile(source.read_text("utf-8"), source, "exec"), space)  # noqa: S102
    twice = kernel(space["twice"])  # type: ignore[arg-type]
    with room_for(0):
        assert twice(3.0) == 6.0
    assert not [file for file in tmp_path.rglob("*.nb[ci]") if file.stat().st_size]
    assert twice(3) == 6
    assert list(tmp_path.rglob("*.nbi"))  # with room it is kept


def test_what_is_kept_is_told() -> None:
    with pytest.raises(OutputError, match=r"no room; then --resume goes on"), resumable():
        raise OutputError("no room")
