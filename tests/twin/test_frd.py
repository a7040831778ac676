"""Result files: whole blocks are read, cut ones left out, nonsense refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import sheetmorph as sm
from sheetmorph.twin import frd
from sheetmorph.twin.frd import read_displacements


def block(time: float, rows: list[tuple[int, float, float, float]], end: bool = True) -> str:
    lines = [
        f"  100CL  101{time:12.5E}{len(rows):12d}{'':20}0{1:5d}{'':11}1",
        " -4  DISP        4    1",
        " -5  D1          1    2    1    0",
        *(f" -1{node:10d}{x:12.5E}{y:12.5E}{z:12.5E}" for node, x, y, z in rows),
    ]
    return "\n".join([*lines, *([" -3"] if end else [])]) + "\n"


def test_blocks_are_read_to_the_last_whole_one(tmp_path: Path) -> None:
    path = tmp_path / "a.frd"
    head = "    1C\n    2C\n -1         1 1.00000E+00 0.00000E+00 0.00000E+00\n -3\n"
    first = block(1.0, [(7, -1.5e-3, -2e-4, 3e-2), (123456, 1.0, -2.0, -3.25)])
    path.write_text(head + first + block(2.0, [(7, 0, 0, 1)]) + block(3.0, [(7, 0, 0, 2)], False))
    found = read_displacements(path)
    assert [state.time for state in found] == [1.0, 2.0]
    np.testing.assert_array_equal(found[0].nodes, [7, 123456])
    np.testing.assert_allclose(found[0].values, [[-1.5e-3, -2e-4, 3e-2], [1, -2, -3.25]])


def test_an_empty_file_has_no_states(tmp_path: Path) -> None:
    path = tmp_path / "a.frd"
    path.write_text("")
    assert read_displacements(path) == []


def test_a_broken_number_is_told_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "a.frd"
    path.write_text(block(1.0, [(1, 0, 0, 0)]).replace("0.00000E+00\n", "0.00O00E+00\n"))
    with pytest.raises(sm.InputError, match="line 4"):
        read_displacements(path)


def test_a_missing_and_a_huge_file_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(sm.InputError, match="cannot be read"):
        read_displacements(tmp_path / "none.frd")
    path = tmp_path / "a.frd"
    path.write_text("x" * 100)
    monkeypatch.setattr(frd, "MOST_BYTES", 50)
    with pytest.raises(sm.InputError, match="too large"):
        read_displacements(path)
