"""Candidates of a search: each measured once, by several processes, and kept on disk."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeVar

from sheetmorph import __version__
from sheetmorph.calibrate.misfit import Evaluation, Task
from sheetmorph.core.errors import ComputationError
from sheetmorph.core.lines import append_line, begin_lines, damaged, read_lines
from sheetmorph.core.processes import one_thread_each, processes

JOURNAL = "evaluations.jsonl"
_MAX_JOURNAL = 200_000_000

T = TypeVar("T")


class Evaluations:
    """A function of the parameters that remembers, in memory and in a journal.

    Attributes:
        task: what is measured.
        known: what was measured, in the order in which it came.
        fresh: how many of them were simulated by this object.
    """

    def __init__(
        self,
        task: Task,
        fingerprint: str,
        *,
        journal: Path | None = None,
        resume: bool = False,
        workers: int = 1,
        on_new: Callable[[Evaluation], None] = lambda evaluation: None,
    ) -> None:
        """Open the journal.

        Args:
            task: what is measured.
            fingerprint: of design, parameters, data and options; a journal of another is refused.
            journal: the file; nothing is kept when None.
            resume: take what the journal holds; otherwise it is begun anew.
            workers: processes that simulate; 1 is this one.
            on_new: told of every evaluation that was simulated.

        Raises:
            InputError: nothing to resume, or the journal is of another fit.
        """
        self.task, self.workers, self._on_new = task, workers, on_new
        self.known: dict[tuple[str, tuple[float, ...]], Evaluation] = {}
        self.fresh = 0
        self._epoch = fingerprint
        self._lock, self._stopped = threading.RLock(), False
        self._journal = journal
        self._pool: ProcessPoolExecutor | None = None
        if journal is None:
            return
        header = {"fingerprint": fingerprint, "version": __version__}
        if resume:
            self._read(journal, header)
        else:
            begin_lines(journal, header)

    def retarget(self, task: Task, epoch: str) -> None:
        """Measure against other poses from now on; what was measured before stays apart."""
        self.task, self._epoch = task, epoch
        self._close_pool()

    def here(self) -> list[Evaluation]:
        """What was measured against the present targets, in order."""
        with self._lock:
            return [found for (epoch, _), found in self.known.items() if epoch == self._epoch]

    def best(self) -> Evaluation:
        """The one with the least misfit."""
        return min(self.here(), key=lambda evaluation: evaluation.misfit)

    def __call__(self, values: Sequence[float]) -> Evaluation:
        """Measure one candidate, unless it is known.

        Raises:
            KeyboardInterrupt: interrupted.
            OutputError: the journal cannot be written.
            ComputationError: a process died.
        """
        key = (self._epoch, tuple(float(value) for value in values))
        with self._lock:
            if key in self.known:
                return self.known[key]
            if self._stopped:
                raise KeyboardInterrupt
            pending = self._submit(_evaluate, key[1]) if self.workers > 1 else None
        found = self.task.evaluate(key[1]) if pending is None else self._result(pending)
        self._keep(key, found)
        return found

    def chains(self, works: Sequence[Callable[[], T]]) -> list[T]:
        """Do several pieces of work, each of which measures one candidate after the other.

        They share the processes; what each of them returns does not depend on the others.
        """
        if self.workers == 1 or len(works) == 1:
            return [work() for work in works]
        with ThreadPoolExecutor(min(len(works), self.workers)) as threads:
            futures = [threads.submit(work) for work in works]
            try:
                return [future.result() for future in futures]
            except BaseException:
                self.stop()
                for future in futures:
                    future.cancel()
                raise

    def many(self, points: Iterable[Sequence[float]]) -> list[Evaluation]:
        """Measure several candidates."""
        return self.chains([lambda point=point: self(point) for point in points])  # type: ignore[misc]

    def apply(
        self, work: Callable[[Task, tuple[float, ...]], T], points: Iterable[Sequence[float]]
    ) -> list[T]:
        """What a function of the module level makes of candidates; it is not kept.

        Raises:
            KeyboardInterrupt: interrupted.
            ComputationError: a process died.
        """
        candidates = [tuple(map(float, values)) for values in points]
        if self.workers == 1:
            return [work(self.task, values) for values in candidates]
        with self._lock:
            if self._stopped:
                raise KeyboardInterrupt
            pending = [self._submit(_apply, work, values) for values in candidates]
        return [self._result(one) for one in pending]

    def stop(self) -> None:
        """Measure nothing more, and end the processes."""
        self._stopped = True
        self._close_pool()

    def __enter__(self) -> Evaluations:
        return self

    def __exit__(self, *error: object) -> None:
        self.stop()

    def _result(self, pending: Future[T]) -> T:
        try:
            return pending.result()
        except BrokenExecutor as error:
            self.stop()
            raise ComputationError(
                "a process that simulates has died; try --workers 1 (from a script, start the "
                'fit below `if __name__ == "__main__":`)'
            ) from error

    def _submit(self, work: Callable[..., T], *given: object) -> Future[T]:
        if self._pool is None:
            with one_thread_each():
                self._pool = processes(self.workers, _begin, self.task)
                self._pool.submit(int)  # all processes start here, with one thread each
        return self._pool.submit(work, *given)

    def _close_pool(self) -> None:
        pool, self._pool = self._pool, None
        if pool is not None:
            pool.shutdown(wait=not self._stopped, cancel_futures=True)

    def _keep(self, key: tuple[str, tuple[float, ...]], found: Evaluation) -> None:
        with self._lock:
            if key in self.known:
                return
            self.known[key] = found
            self.fresh += 1
            if self._journal is not None:
                append_line(self._journal, {"epoch": key[0], **asdict(found)})
            self._on_new(found)

    def _read(self, journal: Path, header: dict[str, str]) -> None:
        parts = "design, other data or other options"
        for number, line in read_lines(journal, header, job="fit", parts=parts, most=_MAX_JOURNAL):
            found = _found(line, len(self.task.parameters))
            if found is None:
                raise damaged(journal, number)
            self.known[(found[0], found[1].values)] = found[1]


_TASK: list[Task] = []


def _begin(task: Task) -> None:
    _TASK[:] = [task]


def _evaluate(values: tuple[float, ...]) -> Evaluation:
    return _TASK[0].evaluate(values)


def _apply(work: Callable[[Task, tuple[float, ...]], T], values: tuple[float, ...]) -> T:
    return work(_TASK[0], values)


def _found(line: Any, count: int) -> tuple[str, Evaluation] | None:
    """An evaluation as the journal has it; None when it is not one."""
    try:
        lists = {name: tuple(map(float, line[name])) for name in ("values", "parts", "rms")}
        scales = tuple(map(float, line["scales"]))
        misfit, seconds = float(line["misfit"]), float(line["seconds"])
        status, epoch = str(line["status"]), str(line["epoch"])
    except (KeyError, TypeError, ValueError):
        return None
    numbers = [misfit, seconds, *scales, *(n for entries in lists.values() for n in entries)]
    if len(lists["values"]) != count or not all(map(math.isfinite, numbers)):
        return None
    return epoch, Evaluation(
        misfit=misfit, scales=scales, status=status, seconds=seconds, **lists
    )  # fmt: skip
