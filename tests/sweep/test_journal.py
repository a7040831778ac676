"""The journal keeps what it was given, once, for one sweep at a time."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import sheetmorph as sm
from sheetmorph.sweep.journal import FILE, Journal
from sheetmorph.sweep.task import Outcome


def outcome(number: int, word: str = "first") -> Outcome:
    arrays = {"ramp": np.array([0.5, number])} if number % 2 else None
    return Outcome({"index": number, "word": word}, arrays)


def test_designs_come_back_in_order_and_once(tmp_path: Path) -> None:
    with Journal.begin(tmp_path / "new", "abc") as journal:
        journal.keep([outcome(3), outcome(0)])
        journal.keep([outcome(1), outcome(3, "second")])
    with Journal.resume(tmp_path / "new", "abc") as journal:
        assert journal.numbers() == {0, 1, 3}
        assert [(row["index"], row["word"]) for row in journal.rows()] == [
            (0, "first"), (1, "first"), (3, "first"),
        ]  # fmt: skip
        arrays = dict(journal.arrays())
        assert arrays[0] is None
        assert arrays[3] is not None
        assert arrays[3]["ramp"].tolist() == [0.5, 3.0]
        journal.remove()
    assert list((tmp_path / "new").iterdir()) == []


def test_what_is_kept_survives_a_kill(tmp_path: Path) -> None:
    script = (
        "import os, sys; from pathlib import Path; from sheetmorph.sweep.journal import Journal\n"
        "from sheetmorph.sweep.task import Outcome\n"
        "journal = Journal.begin(Path(sys.argv[1]), 'abc')\n"
        "journal.keep([Outcome({'index': 7}, None)])\n"
        "journal._connection.execute('BEGIN IMMEDIATE')\n"
        "journal._connection.execute(\"INSERT INTO designs VALUES (8, '{}', NULL)\")\n"
        "os.kill(os.getpid(), 9)\n"
    )
    done = subprocess.run([sys.executable, "-c", script, str(tmp_path)], check=False)
    assert done.returncode == -9
    with Journal.resume(tmp_path, "abc") as journal:
        assert journal.numbers() == {7}


def test_a_second_sweep_is_kept_out(tmp_path: Path) -> None:
    with Journal.begin(tmp_path, "abc"):
        for second in (Journal.begin, Journal.resume):
            with pytest.raises(sm.InputError, match="another sweep is at work"):
                second(tmp_path, "abc")
    Journal.resume(tmp_path, "abc").close()


def test_what_cannot_be_resumed_says_why(tmp_path: Path) -> None:
    with pytest.raises(sm.InputError, match="no unfinished sweep"):
        Journal.resume(tmp_path, "abc")
    Journal.begin(tmp_path, "abc").close()
    with pytest.raises(sm.InputError, match="another design"):
        Journal.resume(tmp_path, "abd")
    (tmp_path / FILE).write_bytes(b"no database at all, whatever its name says" * 50)
    with pytest.raises(sm.InputError, match="damaged"):
        Journal.resume(tmp_path, "abc")
