"""A disk that takes no more: whole or absent, one line, and nothing of what was there is lost.

The system itself refuses to write here, by its limit on the size of files.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from room import room_for
from sheetmorph.core.compiled import kernel
from sheetmorph.core.errors import OutputError
from sheetmorph.core.files import resumable, write_bytes, write_text
from sheetmorph.core.hdf5 import writing_hdf5
from sheetmorph.core.lines import append_line, begin_lines, read_lines

HEADER = {"fingerprint": "x"}


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


def fill(file: h5py.File, check: Callable[[], None]) -> None:
    """Small arrays and one that grows, packed, as in results and sweeps."""
    for k in range(20):
        file.create_dataset(f"group/{k}", data=np.arange(300.0) + k)
    random = np.random.default_rng(1)
    for k in range(6):
        data = random.random((400, 3))
        if k == 0:
            options = {"maxshape": (None, 3), "chunks": (512, 3), "compression": "gzip"}
            file.create_dataset("grown", data=data, **options)
        else:
            file["grown"].resize(400 * (k + 1), axis=0)
            file["grown"][400 * k :] = data
        check()
    file.attrs["format"] = "test"


@pytest.mark.parametrize("share", [0.0, 0.001, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97, 0.999])
def test_an_hdf5_file_without_room_is_no_end_of_the_process(tmp_path: Path, share: float) -> None:
    path = tmp_path / "a.h5"
    with writing_hdf5(path) as (file, check):
        fill(file, check)
    before = path.read_bytes()
    room = int(share * len(before))
    for look in (lambda check: lambda: None, lambda check: check):
        with (
            room_for(room),
            pytest.raises(OutputError, match=r"too large.*-o"),
            writing_hdf5(path) as (file, check),
        ):
            fill(file, look(check))
    gc.collect()
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_an_hdf5_file_holds_what_was_written(tmp_path: Path) -> None:
    ours, theirs = tmp_path / "ours.h5", tmp_path / "theirs.h5"
    with writing_hdf5(ours) as (file, check):
        fill(file, check)
    with h5py.File(theirs, "w") as file:
        fill(file, lambda: None)
    assert ours.stat().st_size <= 1.05 * theirs.stat().st_size
    with h5py.File(ours) as one, h5py.File(theirs) as other:
        assert dict(one.attrs) == dict(other.attrs) == {"format": "test"}
        names = [f"group/{k}" for k in range(20)] + ["grown"]
        assert [*one, *one["group"]] == [*other, *other["group"]]
        for name in names:
            np.testing.assert_array_equal(one[name][()], other[name][()])
