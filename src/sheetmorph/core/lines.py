"""A journal of lines: one JSON value a line, on disk as soon as it is known."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from sheetmorph.core.errors import InputError
from sheetmorph.core.files import GO_ON, write_text, writing


def begin_lines(path: Path, header: dict[str, str]) -> None:
    """Begin a journal with its header, in the place of what is there.

    Raises:
        OutputError: it cannot be written.
    """
    write_text(path, json.dumps(header) + "\n")


def append_line(path: Path, value: dict[str, Any]) -> None:
    """Add a line, and wait until the disk has it: whole or not at all.

    Raises:
        OutputError: it cannot be written.
    """
    rest = memoryview((json.dumps(value) + "\n").encode())
    with writing(path, GO_ON), path.open("ab", buffering=0) as stream:
        before = stream.tell()
        try:
            while rest:  # a disk that is nearly full takes a part
                rest = rest[stream.write(rest) :]
            os.fsync(stream.fileno())
        except OSError:
            stream.truncate(before)
            raise


def read_lines(
    path: Path, header: dict[str, str], *, job: str, parts: str, most: int
) -> list[tuple[int, Any]]:
    """Numbers and values of the whole lines after the header; a torn last line is cut off.

    Args:
        path: the journal.
        header: what its first line must be.
        job: what is gone on with, for messages: "fit".
        parts: what the header stands for, for messages: "design or other options".
        most: bytes that are read at most.

    Returns:
        Line numbers from 2 on, with their values: None for a line that is no JSON.

    Raises:
        InputError: there is no journal, or it has another header.
        OutputError: a torn line cannot be cut off.
    """
    try:
        with path.open("rb") as stream:
            data = stream.read(most)
    except OSError:
        raise InputError(
            f"there is no unfinished {job} to resume here; run without --resume", file=path.parent
        ) from None
    whole = data.rfind(b"\n") + 1
    lines = [_value(text) for text in data[:whole].splitlines()]
    if not lines or lines[0] != header:
        raise InputError(
            f"the unfinished {job} here is of another {parts}; run without --resume, or into "
            "another folder with -o",
            file=path.parent,
        )
    if whole < len(data):
        with writing(path, GO_ON), path.open("rb+") as stream:
            stream.truncate(whole)
    return list(enumerate(lines[1:], 2))


def damaged(path: Path, number: int) -> InputError:
    """What to raise where a line is not what was written."""
    return InputError(f"line {number} of the journal is damaged; run without --resume", file=path)


def _value(text: bytes) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return None
