"""The whole of a sweep: from its plan to a folder with a table and shapes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from sheetmorph.core.errors import InputError
from sheetmorph.core.events import Event, Listener, Progress, Started, silent
from sheetmorph.core.files import resumable, writing
from sheetmorph.sweep import journal as journals
from sheetmorph.sweep import states, table
from sheetmorph.sweep.cluster import cluster, solved, usual_workers
from sheetmorph.sweep.extra import needed
from sheetmorph.sweep.journal import Journal
from sheetmorph.sweep.plan import Plan, Task

MOST_WORKERS = 1024
_PAUSE, _SHARE = 30.0, 0.02
"""An interim table is written after this pause at least, and with this share of the time."""


@dataclass(frozen=True)
class Tally:
    """How a sweep went.

    Attributes:
        designs: of the sweep.
        present: of them are in the table.
        failed: of those did not complete.
        computed: by this call.
        seconds: it took.
        interrupted: True when it was stopped by the user.
    """

    designs: int
    present: int
    failed: int
    computed: int
    seconds: float
    interrupted: bool = False


def run_sweep(
    plan: Plan,
    folder: str | Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    resume: bool = False,
    force: bool = False,
    on_event: Listener = silent,
) -> Tally:
    """Compute all designs of a plan and write `results.parquet` and `states.h5`.

    Args:
        plan: what to compute.
        folder: where to write.
        workers: processes on this machine; as many as there are processors by default.
        scheduler: address of a Dask scheduler to use in their place.
        resume: go on with the sweep that was cut off in the folder.
        force: replace the sweep that is in the folder.
        on_event: told of the progress.

    Returns:
        How it went. Ctrl-C ends it early, with what there is in the table.

    Raises:
        InputError: the folder holds a sweep and neither `resume` nor `force` is set; or there
            is nothing to resume; or libraries, scheduler or workers are not there.
        OutputError: something cannot be written.
        ComputationError: the scheduler is lost.
    """
    began = perf_counter()
    with needed():
        import distributed  # noqa: F401
        import pyarrow  # noqa: F401
    count = usual_workers() if workers is None else workers
    if not 1 <= count <= MOST_WORKERS:
        raise InputError(
            "must be a whole number", key="--workers", value=workers, allowed=f"1 to {MOST_WORKERS}"
        )
    place = Path(folder)
    if _check(plan, place, resume, force):
        on_event(Started(plan.name))
        return Tally(len(plan), len(plan), _failed(place), 0, perf_counter() - began)
    with _journal(plan, place, resume) as journal:
        progress = _Progress(plan, journal, place, on_event)
        try:
            if progress.missing:
                with cluster(count, scheduler, on_event) as client:
                    for outcomes in solved(client, progress.tasks()):
                        journal.keep(outcomes)
                        progress.tell([str(one.row["status"]) for one in outcomes])
        except KeyboardInterrupt:
            table.write_table(plan, journal.rows, place / table.FILE, complete=False)
            return progress.tally(perf_counter() - began, interrupted=True)
        on_event(Progress(1.0, "writing"))
        with resumable():
            if plan.states != "none":
                packed = journal.arrays()
                states.write_states(packed, len(plan), plan.fingerprint, place / states.FILE)
            table.write_table(plan, journal.rows, place / table.FILE, complete=True)
        journal.remove()
    return progress.tally(perf_counter() - began)


def _journal(plan: Plan, place: Path, resume: bool) -> Journal:
    if resume:
        return Journal.resume(place, plan.fingerprint)
    journal = Journal.begin(place, plan.fingerprint)
    with writing(place):
        for name in (table.FILE, states.FILE):
            (place / name).unlink(missing_ok=True)
    return journal


def _check(plan: Plan, place: Path, resume: bool, force: bool) -> bool:
    """Refuse to replace what is in the folder; True when the very sweep is finished there."""
    if place.exists() and not place.is_dir():
        raise InputError("this is a file; choose another folder with -o", file=place)
    unfinished = (place / journals.FILE).is_file()
    present = [place / name for name in (table.FILE, states.FILE) if (place / name).exists()]
    about = None
    if present:
        try:
            about = table.read_about(place / table.FILE)
        except InputError:
            if not unfinished:
                raise InputError(
                    "this file would be replaced, and no sweep wrote it; choose another folder "
                    "with -o",
                    file=present[0],
                ) from None
    if resume and not unfinished and about is not None and about["complete"]:
        if about["fingerprint"] == plan.fingerprint:
            return True
        raise InputError(
            "this folder holds another sweep; add --force to replace it, or choose another with -o",
            file=place,
        )
    if resume or force:
        return False
    if unfinished:
        raise InputError(
            "this folder holds an unfinished sweep; add --resume to go on, or --force to start "
            "anew",
            file=place,
        )
    if about is not None:
        raise InputError(
            "this folder holds a sweep; add --force to replace it, or choose another with -o",
            file=place,
        )
    return False


def _failed(place: Path) -> int:
    import pyarrow.parquet as pq

    status = pq.read_table(place / table.FILE, columns=["status"])["status"].to_pylist()
    return sum(one != "completed" for one in status)


class _Progress:
    """What is there, what is missing, how fast it goes."""

    def __init__(self, plan: Plan, journal: Journal, place: Path, on_event: Listener) -> None:
        self._plan, self._journal, self._place, self._on_event = plan, journal, place, on_event
        self._known = journal.numbers()
        self._present = len(self._known)
        self._failed = sum(row["status"] != "completed" for row in journal.rows())
        self._computed = self._first = 0
        self._start = self._written = perf_counter()
        self._took = 0.0
        on_event(Started(plan.name))
        self._say(f"{self._present} of {len(plan)}, starting workers")

    @property
    def missing(self) -> int:
        return len(self._plan) - self._present

    def tasks(self) -> Iterator[Task]:
        return (
            self._plan.task(index) for index in range(len(self._plan)) if index not in self._known
        )

    def tell(self, statuses: list[str]) -> None:
        if not self._computed:  # workers take a while to start, which says nothing of the rate
            self._start, self._first = perf_counter(), len(statuses)
        self._computed += len(statuses)
        self._present += len(statuses)
        self._failed += sum(status != "completed" for status in statuses)
        now = perf_counter()
        self._say(
            progress_text(
                self._present,
                len(self._plan),
                self._failed,
                self._computed - self._first,
                now - self._start,
            )
        )
        if now - self._written > max(_PAUSE, self._took / _SHARE):
            path = self._place / table.FILE
            table.write_table(self._plan, self._journal.rows, path, complete=False)
            self._written = perf_counter()
            self._took = self._written - now

    def tally(self, seconds: float, interrupted: bool = False) -> Tally:
        return Tally(
            len(self._plan), self._present, self._failed, self._computed, seconds, interrupted
        )

    def _say(self, text: str) -> None:
        event: Event = Progress(self._present / len(self._plan), text)
        self._on_event(event)


def progress_text(present: int, designs: int, failed: int, computed: int, seconds: float) -> str:
    """How far a sweep is, with rate and time left: `412 of 1000, 8.1 /s, 1 min 13 s left`."""
    text = f"{present} of {designs}"
    if computed and seconds > 0:
        rate = computed / seconds
        left = round((designs - present) / rate)
        hours, minutes = left // 3600, left // 60 % 60
        clock = (
            f"{hours} h {minutes} min"
            if hours
            else (f"{minutes} min {left % 60} s" if minutes else f"{left} s")
        )
        per = f"{rate:.1f} /s" if rate >= 1 else f"{60 * rate:.1f} /min"
        text += f", {per}, {clock} left"
    return text + (f", {failed} failed" if failed else "")
