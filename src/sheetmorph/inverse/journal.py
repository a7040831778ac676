"""What a search has measured, kept on disk as it comes, so that it can go on."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from sheetmorph import __version__
from sheetmorph.core.lines import append_line, begin_lines, damaged, read_lines
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
        begin_lines(path, header)

    def keep(self, job: Job, found: Evaluation) -> None:
        """Remember an evaluation.

        Raises:
            OutputError: it cannot be written.
        """
        self.known[job] = found
        self.fresh += 1
        if self._path is not None:
            append_line(self._path, {"job": asdict(job), "found": asdict(found)})

    def _read(self, path: Path, header: dict[str, str]) -> None:
        parts = "target or other options"
        for number, line in read_lines(path, header, job="search", parts=parts, most=_MAX):
            try:
                job, found = _entry(line)
            except (KeyError, TypeError, ValueError):
                raise damaged(path, number) from None
            self.known[job] = found


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
