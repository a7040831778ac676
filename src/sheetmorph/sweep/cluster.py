"""Who computes: a Dask cluster on this machine, or one that is there already."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import islice
from threading import Event, Thread
from time import monotonic
from typing import TYPE_CHECKING, Any

from sheetmorph import __version__
from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.core.events import Listener, Notice
from sheetmorph.core.processes import THREADS
from sheetmorph.sweep.extra import needed
from sheetmorph.sweep.plan import Task
from sheetmorph.sweep.task import Outcome, lost, solve

if TYPE_CHECKING:
    from distributed import Client, Future

RETRIES = 3
"""How often a design is tried again after its worker died, before it is tried alone."""
PATIENCE = 60
"""Seconds to wait for a scheduler, and for its first worker."""
_ASKED_AGAIN = 3.0
"""Seconds after which workers that are missing are asked for again."""
_AHEAD = 4
"""Designs per thread that are at the workers or on their way to them.

Enough that workers do not wait while the journal does for a slow disk.
"""


@contextmanager
def cluster(workers: int, scheduler: str | None, on_event: Listener) -> Iterator[Client]:
    """A client of a cluster; one that was started here ends with the block.

    Args:
        workers: processes of a local cluster, with one thread each.
        scheduler: address of an existing one, such as "tcp://10.0.0.1:8786"; None for a local one.
        on_event: told of the dashboard.

    Raises:
        InputError: Dask is not installed; the scheduler does not answer, has no workers, or they
            have another version of sheetmorph.
    """
    with needed():
        import dask
        import distributed
    if scheduler is not None:
        with _quiet(), _existing(distributed, scheduler) as client:
            on_event(Notice(f"dashboard: {client.dashboard_link}"))
            yield client
        return
    variables = dict.fromkeys(THREADS, "1")
    settings = {
        "distributed.scheduler.allowed-failures": RETRIES,
        "distributed.worker.daemon": True,
        "distributed.comm.timeouts.connect": "10s",  # a worker that is dead does not answer
        "distributed.admin.tick.limit": "1h",  # a busy machine is no news
        "distributed.worker.profile.enabled": False,  # samples every 10 ms, and nobody looks
        "distributed.admin.system-monitor.interval": "2s",
        "distributed.admin.tick.interval": "1s",
        "distributed.worker.memory.monitor-interval": "1s",
    }
    with dask.config.set(settings), _quiet():
        local = distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            env=variables,
            silence_logs=logging.CRITICAL,
        )
        with local, distributed.Client(local) as client, _kept_up(local, workers):
            client.register_plugin(_deaf(distributed))
            if local.dashboard_link:
                on_event(Notice(f"dashboard: {local.dashboard_link}"))
            yield client


@contextmanager
def _kept_up(local: Any, workers: int) -> Iterator[None]:
    """Ask for the workers again and again.

    Dask replaces a worker that dies, but not one that dies or dawdles while it starts.
    """
    over = Event()

    def ask() -> None:
        while not over.wait(_ASKED_AGAIN):
            local.scale(workers)

    thread = Thread(target=ask, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


@contextmanager
def _existing(distributed: Any, scheduler: str) -> Iterator[Client]:
    try:
        client = distributed.Client(scheduler, timeout=PATIENCE)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(
            f"the scheduler does not answer ({error})",
            key="--scheduler",
            value=scheduler,
            allowed="an address such as tcp://10.0.0.1:8786",
        ) from None
    with client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise InputError(
                f"the scheduler has no workers after {PATIENCE} s",
                key="--scheduler",
                value=scheduler,
            ) from None
        found = client.run(_version, on_error="return")
        for worker, version in found.items():
            if version != __version__:
                raise InputError(
                    f"worker {worker} has no sheetmorph {__version__} ({version})",
                    key="--scheduler",
                    value=scheduler,
                )
        yield client


def solved(client: Client, tasks: Iterator[Task]) -> Iterator[list[Outcome]]:
    """Compute designs; whatever happens, each of them comes out once.

    A design whose worker died is tried again; one that outlived none of its workers is tried
    once more when all others are done, so that no neighbour on the same worker is blamed in its
    place, and then becomes a row that says so.

    Args:
        client: of the cluster.
        tasks: what to compute; taken as workers become free.

    Raises:
        ComputationError: the scheduler is lost.
    """
    from distributed import KilledWorker, as_completed

    sent: dict[str, Task] = {}
    suspects: list[Task] = []
    running = as_completed([])
    room = _Room(client)

    def send() -> bool:
        futures = []
        for task in islice(tasks, max(0, room.size() - len(sent))):
            future = client.submit(solve, task, key=f"design-{task.index}", pure=False)
            sent[future.key] = task
            futures.append(future)
        running.update(futures)
        return bool(futures)

    while _reached(send) or sent:
        batch: list[Future] = next(running.batches())
        done: list[Outcome] = []
        for future in batch:
            task = sent.pop(future.key)
            try:
                done.append(future.result())
            except KilledWorker:
                suspects.append(task)
            except Exception as error:
                if future.status in ("cancelled", "lost"):
                    raise _no_scheduler() from error
                done.append(lost(task, f"{type(error).__name__}: {error}"))
            future.release()
        if done:
            yield done
    for task in suspects:
        yield [_alone(client, task)]


def _reached(send: Callable[[], bool]) -> bool:
    try:
        return send()
    except OSError as error:
        raise _no_scheduler() from error


def _alone(client: Client, task: Task) -> Outcome:
    from distributed import KilledWorker

    future = client.submit(solve, task, key=f"design-{task.index}-alone", pure=False)
    try:
        outcome = future.result()
    except KilledWorker:
        reason = "every worker that computed it died, also with no other design under way"
        return lost(task, reason)
    except Exception as error:
        if future.status in ("cancelled", "lost"):
            raise _no_scheduler() from error
        return lost(task, f"{type(error).__name__}: {error}")
    assert isinstance(outcome, Outcome)  # noqa: S101  what solve returns
    return outcome


class _Room:
    """How many designs may be under way; asked anew now and then, since workers come and go."""

    def __init__(self, client: Client) -> None:
        self._client, self._size, self._asked = client, 0, -1e9

    def size(self) -> int:
        if monotonic() - self._asked > 2.0:
            threads = sum(self._client.nthreads().values())
            self._size = max(_AHEAD, _AHEAD * threads, self._size if threads == 0 else 0)
            self._asked = monotonic()
        return self._size


def _no_scheduler() -> ComputationError:
    return ComputationError("the scheduler is lost; add --resume to go on")


def _version() -> str:
    return __version__


def _deaf(distributed: Any) -> Any:
    """What each local worker does first: leave it to the main process to decide about Ctrl-C."""

    class Deaf(distributed.WorkerPlugin):  # type: ignore[misc]
        name = "sheetmorph-deaf"

        def setup(self, worker: Any) -> None:
            import signal

            with suppress(ValueError):  # not in the main thread
                signal.signal(signal.SIGINT, signal.SIG_IGN)

    return Deaf()


@contextmanager
def _quiet() -> Iterator[None]:
    """Dask tells of every lost worker, with traces; here a lost worker is no news."""
    logger = logging.getLogger("distributed")
    before = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.setLevel(before)


def usual_workers() -> int:
    """Processes of a local cluster where nobody says how many: those we may run on."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
