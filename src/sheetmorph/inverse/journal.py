"""What a search has measured, kept on disk as it comes, so that it can go on."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

from sheetmorph import __version__
from sheetmorph.core.errors import InputError, OutputError
from sheetmorph.inverse.misfit import Evaluation, Job

JOURNAL = "evaluations.jsonl"
_MAX = 500_000_000


class Journal:
    """Evaluations by their jobs, in memory and in a file of one line each.

    Attributes:
        known: what was measured.
        fresh: how many of them by this object.
    """

    def __init__(self, path: Path | None, fingerprint: str, *, resume: bool = False) -> None:
        """Open the journal.

        Args:
            path: the file; None keeps nothing on disk.
            fingerprint: of target, families and options; a journal of another is refused.
            resume: take what the file holds; otherwise it is begun anew.

        Raises:
            InputError: nothing to resume, or it belongs to another search.
            OutputError: it cannot be written.
        """
        self.known: dict[Job, Evaluation] = {}
        self._path, self.fresh = path, 0
        if path is None:
            return
        header = {"fingerprint": fingerprint, "version": __version__}
        if resume:
            self._read(path, header)
            return
        with _writing(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(header) + "\n", encoding="utf-8")

    def keep(self, job: Job, found: Evaluation) -> None:
        """Remember an evaluation.

        Raises:
            OutputError: it cannot be written.
        """
        self.known[job] = found
        self.fresh += 1
        if self._path is None:
            return
        line = json.dumps({"job": asdict(job), "found": asdict(found)}) + "\n"
        with _writing(self._path), self._path.open("ab") as stream:
            stream.write(line.encode())
            stream.flush()
            os.fsync(stream.fileno())

    def _read(self, path: Path, header: dict[str, str]) -> None:
        """Take the whole lines of the file, and cut off a torn last one."""
        try:
            with path.open("rb") as stream:
                data = stream.read(_MAX)
        except OSError:
            raise InputError(
                "there is no unfinished search to resume here; run without --resume",
                file=path.parent,
            ) from None
        whole = data.rfind(b"\n") + 1
        lines = data[:whole].splitlines()
        if not lines or _line(lines[0]) != header:
            raise InputError(
                "the unfinished search here is of another target or other options; run without "
                "--resume, or into another folder with -o",
                file=path.parent,
            )
        for number, text in enumerate(lines[1:], 2):
            try:
                job, found = _entry(_line(text))
            except (KeyError, TypeError, ValueError):
                raise InputError(
                    f"line {number} of the journal is damaged; run without --resume", file=path
                ) from None
            self.known[job] = found
        if whole < len(data):
            with _writing(path), path.open("rb+") as stream:
                stream.truncate(whole)


def _entry(line: Any) -> tuple[Job, Evaluation]:
    job, found = line["job"], line["found"]
    for table in (job, found):
        table["point"] = _numbers(table["point"])
    job["near"], found["pose"] = _numbers(job["near"]), _numbers(found["pose"])
    found["residuals"] = _numbers(found["residuals"])
    for name in ("misfit", "distance", "aspect_ratio", "seconds"):
        (found[name],) = _numbers([found[name]])
    if not isinstance(found["status"], str) or job["family"] != found["family"]:
        raise ValueError(line)
    return Job(**job), Evaluation(**found)


def _numbers(values: Any) -> tuple[float, ...]:
    found = tuple(map(float, values))
    if not all(map(math.isfinite, found)):
        raise ValueError(values)
    return found


def _line(text: bytes) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return None


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error.strerror or error})") from error
