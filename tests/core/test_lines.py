"""Journals of lines: whole lines are kept, torn ones cut off, those of other jobs refused."""

from __future__ import annotations

import json

import pytest

from sheetmorph.core.errors import InputError, OutputError
from sheetmorph.core.lines import append_line, begin_lines, read_lines

HEADER = {"fingerprint": "x"}


def read(path, header=HEADER):
    return read_lines(path, header, job="fit", parts="design", most=10_000)


def test_what_was_kept_is_read_and_a_torn_line_is_cut_off(tmp_path):
    path = tmp_path / "new" / "lines.jsonl"
    begin_lines(path, HEADER)
    append_line(path, {"a": 1.5})
    append_line(path, {"a": 2.5})
    whole = path.read_bytes()
    path.write_bytes(whole + b'{"a": 3')
    assert read(path) == [(2, {"a": 1.5}), (3, {"a": 2.5})]
    assert path.read_bytes() == whole


def test_a_line_that_is_no_json_is_none(tmp_path):
    path = tmp_path / "lines.jsonl"
    path.write_text(json.dumps(HEADER) + "\n{x\n" + "[" * 5000 + "\n", "utf-8")
    assert read(path) == [(2, None), (3, None)]


def test_none_and_one_of_another_job_are_refused_and_left_alone(tmp_path):
    path = tmp_path / "lines.jsonl"
    with pytest.raises(InputError, match="no unfinished fit"):
        read(path)
    begin_lines(path, {"fingerprint": "y"})
    with path.open("ab") as stream:
        stream.write(b"torn")
    before = path.read_bytes()
    with pytest.raises(InputError, match="another design"):
        read(path)
    assert path.read_bytes() == before


def test_a_place_that_cannot_be_written_is_told(tmp_path):
    with pytest.raises(OutputError, match="cannot be written"):
        begin_lines(tmp_path, HEADER)
    with pytest.raises(OutputError, match="cannot be written"):
        append_line(tmp_path, {})
