"""The designs of a search, measured side by side, each of them once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol

from sheetmorph.core.errors import ComputationError
from sheetmorph.core.events import Listener
from sheetmorph.inverse.journal import Journal
from sheetmorph.inverse.misfit import FAILED, Evaluation, Job

if TYPE_CHECKING:
    from distributed import Client


class Measure(Protocol):
    """What measures a design; goes to other processes as it is."""

    def evaluate(self, job: Job) -> Evaluation:
        """Simulate the design of a job, and measure it."""
        ...


class Evaluations:
    """A function of jobs that remembers, in this process or on a cluster.

    Attributes:
        measure: what is measured.
    """

    def __init__(
        self,
        measure: Measure,
        journal: Journal,
        *,
        client: Client | None = None,
        on_new: Callable[[Job, Evaluation], None] = lambda job, found: None,
    ) -> None:
        """Take what the journal knows.

        Args:
            measure: what is measured.
            journal: keeps every evaluation.
            client: of the cluster; None for this process alone.
            on_new: told once of every evaluation, those of the journal too, in the order in which
                the search asks for them.
        """
        self.measure = measure
        self._journal, self._client, self._on_new = journal, client, on_new
        self._told: set[Job] = set()
        # Submitted and not scattered: what all workers that held it took along comes back.
        self._sent: Any = None if client is None else client.submit(_same, measure, pure=False)

    def many(self, jobs: Sequence[Job]) -> list[Evaluation]:
        """Measure designs side by side; the order of the answers is that of the jobs.

        Raises:
            KeyboardInterrupt: interrupted; what was measured is kept.
            OutputError: the journal cannot be written.
            ComputationError: the scheduler is lost.
        """
        missing = list(dict.fromkeys(job for job in jobs if job not in self._journal.known))
        for job, found in self._measured(missing):
            self._journal.keep(job, found)
        answers = [self._journal.known[job] for job in jobs]
        for job, found in zip(jobs, answers, strict=True):
            if job not in self._told:
                self._told.add(job)
                self._on_new(job, found)
        return answers

    def __call__(self, job: Job) -> Evaluation:
        """Measure one design."""
        return self.many([job])[0]

    def _measured(self, jobs: list[Job]) -> Iterator[tuple[Job, Evaluation]]:
        if self._client is None:
            for job in jobs:
                yield job, self.measure.evaluate(job)
            return
        from distributed import KilledWorker, as_completed

        futures = {self._client.submit(evaluate, self._sent, job, pure=False): job for job in jobs}
        try:
            for future in as_completed(list(futures)):
                job = futures[future]
                try:
                    yield job, future.result()
                except KilledWorker:
                    yield job, Evaluation(job.family, job.point, 2.0 * FAILED, status="worker_died")
                except Exception as error:
                    if future.status in ("cancelled", "lost"):
                        raise ComputationError(
                            "the scheduler is lost; add --resume to go on"
                        ) from error
                    raise
        finally:
            for future in futures:
                future.release()


def _same(measure: Measure) -> Measure:
    """What is measured; brings it to the workers."""
    return measure


def evaluate(measure: Measure, job: Job) -> Evaluation:
    """Measure a design; what a worker is sent."""
    return measure.evaluate(job)


@contextmanager
def workers(count: int, scheduler: str | None, on_event: Listener) -> Iterator[Client | None]:
    """A cluster of so many processes; None, and no cluster at all, for one.

    Raises:
        InputError: as for `sweep.cluster.cluster`.
    """
    if count == 1 and scheduler is None:
        yield None
        return
    from sheetmorph.sweep.cluster import cluster

    with cluster(count, scheduler, on_event) as client:
        yield client
