"""The process that computes for the studio: jobs come in at stdin, packets go out at stdout.

It is started with the memory it may have. Between the steps of a solve it looks whether its job
is still wanted; where it does not look in time, the server ends it and starts another.
"""

from __future__ import annotations

import contextlib
import os
import queue
import sys
import threading
from collections.abc import Callable
from typing import IO, Any

from sheetmorph.core.errors import SheetmorphError
from sheetmorph.core.events import Event, Progress
from sheetmorph.studio.frames import framed, head_of, pack, read_frame

Send = Callable[[bytes], None]


class CancelledError(Exception):
    """The job is not wanted any more."""


class Desk:
    """What a job sees of its surroundings: where answers go, and whether it is still wanted.

    Args:
        job: the number of the job.
        send: takes packets.
        cancelled: whether the job has been cancelled.
    """

    def __init__(self, job: int, send: Send, cancelled: Callable[[], bool]) -> None:
        self._job, self._send, self._cancelled = job, send, cancelled

    def answer(self, kind: str, head: dict[str, Any] | None = None, arrays: Any = None) -> None:
        """Send a packet.

        Raises:
            CancelledError: the job is not wanted any more.
        """
        self.check()
        self._send(pack({"kind": kind, "job": self._job, **(head or {})}, arrays))

    def check(self) -> None:
        """Go on only if the job is still wanted.

        Raises:
            CancelledError: it is not.
        """
        if self._cancelled():
            raise CancelledError

    def listen(self, event: Event) -> None:
        """Pass on the progress of a computation, and end it when it is not wanted."""
        self.check()
        if isinstance(event, Progress):
            self.answer("progress", {"fraction": event.fraction, "text": event.text})


def limit_memory(limit: int) -> bool:
    """Let this process have no more than `limit` bytes of memory.

    What the libraries have mapped already is not counted. Returns False where the system has
    no such limit (Windows, macOS).
    """
    if sys.platform != "linux":
        return False
    import resource

    with open("/proc/self/statm", encoding="ascii") as stream:  # noqa: PTH123
        mapped = int(stream.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (mapped + limit, mapped + limit))
    return True


def main(arguments: list[str]) -> None:
    """Compute until the pipe is closed."""
    output = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what libraries print is no packet
    from sheetmorph.studio.tasks import TASKS, Memory, warm_up

    if "--warm" in arguments:
        warm_up()
    limit_memory(int(arguments[0]))
    lock = threading.Lock()
    cancelled: set[int] = set()
    jobs: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()

    def send(packet: bytes) -> None:
        with lock:
            output.write(framed(packet))
            output.flush()

    threading.Thread(target=_read, args=(sys.stdin.buffer, jobs, cancelled), daemon=True).start()
    memory = Memory()
    send(pack({"kind": "ready", "job": 0}))
    while True:
        job = jobs.get()
        number = int(job["job"])
        desk = Desk(number, send, lambda number=number: number in cancelled)  # type: ignore[misc]
        ended = _run(lambda: TASKS[job["task"]](job, desk, memory), memory)  # noqa: B023
        send(pack({"kind": "done", "job": number, **ended}))
        cancelled.discard(number)


def _run(task: Callable[[], None], memory: Any) -> dict[str, Any]:
    """Run a task; how it ended, in words."""
    try:
        task()
    except CancelledError:
        return {"ended": "cancelled"}
    except SheetmorphError as error:
        return {"ended": "error", **describe(error)}
    except MemoryError:
        memory.clear()
        return {
            "ended": "error",
            "text": "this needs more memory than the studio allows one computation; take a larger "
            "mesh.size, or start the studio with a larger --memory",
        }
    except Exception as error:
        return {
            "ended": "error",
            "text": f"this went wrong inside: {type(error).__name__}: {error}",
        }
    return {"ended": "well"}


def describe(error: SheetmorphError) -> dict[str, Any]:
    """An error as the page shows it: its text, and the key of the design that it is about."""
    return {"text": str(error), "key": getattr(error, "key", None)}


def _read(stream: IO[bytes], jobs: queue.SimpleQueue[dict[str, Any]], cancelled: set[int]) -> None:
    """Take jobs and cancellations from the pipe; the server's end ends this process."""
    with contextlib.suppress(Exception):
        while (packet := read_frame(stream)) is not None:
            head = head_of(packet)
            if "cancel" in head:
                cancelled.add(int(head["cancel"]))
            else:
                jobs.put(head)
    os._exit(0)


if __name__ == "__main__":
    main(sys.argv[1:])
