"""The processes that compute for the studio, seen from the server: hand out, cancel, replace."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import os
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

from sheetmorph.core.processes import THREADS
from sheetmorph.studio.frames import MAX_PACKET, framed, head_of, pack

GRACE = 5.0
"""Seconds that a worker has to notice that its job is cancelled."""
LONGEST = 900.0
"""Seconds that a job may take in all."""

OnPacket = Callable[[dict[str, Any], bytes], None]
Ended = dict[str, Any]

_numbers = itertools.count(1)


class Worker:
    """One process, which does one job at a time and is started anew when it dies.

    Args:
        memory: bytes that it may have.
        warm: solve something small first, so that the first job is quick.
    """

    def __init__(self, memory: int, warm: bool) -> None:
        self._memory, self._warm = memory, warm
        self._process: asyncio.subprocess.Process | None = None
        self._job: int | None = None
        self._given_up = False  # the process is being killed, and may seem alive for a while
        self._ending: set[asyncio.Task[None]] = set()

    @property
    def pid(self) -> int | None:
        """Its process; None while there is none."""
        return None if self._process is None else self._process.pid

    async def start(self) -> None:
        """Start the process, if there is none."""
        alive = self._process is not None and self._process.returncode is None
        if alive and not self._given_up:
            return
        self.kill()
        command = [sys.executable, "-m", "sheetmorph.studio.worker", str(self._memory)]
        self._process = await asyncio.create_subprocess_exec(
            *command,
            *(["--warm"] if self._warm else []),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.DEVNULL,
            env={**os.environ, **dict.fromkeys(THREADS, "1")},
            limit=2**20,
            start_new_session=True,  # Ctrl-C is for the server to decide about
        )

    async def run(self, content: dict[str, Any], on_packet: OnPacket, ticket: Ticket) -> Ended:
        """Do a job; packets go to `on_packet` as they come.

        Returns:
            How it ended: `ended` is "well", "error" (with `text`), "cancelled" or "died".
        """
        await self.start()
        number = next(_numbers)
        self._job = number
        ticket.worker = self
        if ticket.cancelled:
            self._job = None
            return {"ended": "cancelled"}
        try:
            await self._send({**content, "job": number})
            async with asyncio.timeout(LONGEST):
                while True:
                    packet = await self._receive()
                    head = head_of(packet)
                    if head["kind"] == "ready" or head["job"] != number:
                        continue
                    if head["kind"] == "done":
                        return head
                    on_packet(head, packet)
        except TimeoutError:
            self.kill()
            return {"ended": "died", "text": f"the computation took more than {LONGEST:g} s"}
        except (asyncio.IncompleteReadError, ConnectionError, OSError):
            self.kill()
            return {"ended": "cancelled" if ticket.cancelled else "died"}
        except BaseException:
            self.kill()  # whoever waited is gone; what the job still says must reach nobody
            raise
        finally:
            self._job = None
            ticket.worker = None

    def cancel(self) -> None:
        """Ask the process to end its job, and end the process when it does not."""
        number = self._job
        if number is None or self._process is None or self._process.stdin is None:
            return
        with contextlib.suppress(ConnectionError, RuntimeError):
            self._process.stdin.write(framed(pack({"cancel": number})))
        asyncio.get_running_loop().call_later(GRACE, self._give_up, number)

    def kill(self) -> None:
        """End the process; `close` waits for it."""
        process, self._process = self._process, None
        self._given_up = False
        if process is not None:
            with contextlib.suppress(ProcessLookupError):
                process.kill()
            if process.stdin is not None:
                process.stdin.close()
            task = asyncio.get_running_loop().create_task(_drained(process))
            self._ending.add(task)
            task.add_done_callback(self._ending.discard)

    async def close(self) -> None:
        """End the process and wait for it."""
        self.kill()
        await asyncio.gather(*self._ending)

    def _give_up(self, number: int) -> None:
        if self._job == number and self._process is not None:
            self._given_up = True  # a job that ends just now must not leave it to the next one
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()

    async def _send(self, content: dict[str, Any]) -> None:
        process = self._process
        if process is None or process.stdin is None:
            raise ConnectionError
        process.stdin.write(framed(pack(content)))
        await process.stdin.drain()

    async def _receive(self) -> bytes:
        process = self._process
        if process is None or process.stdout is None:
            raise ConnectionError
        length = int.from_bytes(await process.stdout.readexactly(4), "little")
        if length > MAX_PACKET:
            raise ConnectionError
        return await process.stdout.readexactly(length)


async def _drained(process: asyncio.subprocess.Process) -> None:
    """Wait for the end of a process and of what it had written."""
    with contextlib.suppress(Exception):
        await process.communicate()
    await process.wait()


class Ticket:
    """A job that may be cancelled, wherever it is."""

    def __init__(self) -> None:
        self.cancelled = False
        self.worker: Worker | None = None

    def cancel(self) -> None:
        """Say that the job is not wanted any more."""
        if not self.cancelled:
            self.cancelled = True
            if self.worker is not None:
                self.worker.cancel()


class Pool:
    """Workers that all sessions share; whoever asked first is served first.

    Args:
        count: how many.
        memory: bytes that each may have.
        warm: have them ready before the first job.
    """

    def __init__(self, count: int, memory: int, warm: bool) -> None:
        self.workers = [Worker(memory, warm) for _ in range(count)]
        self._free: asyncio.Queue[Worker] = asyncio.Queue()
        for worker in self.workers:
            self._free.put_nowait(worker)

    async def start(self) -> None:
        """Start the processes."""
        await asyncio.gather(*(worker.start() for worker in self.workers))

    @asynccontextmanager
    async def worker(self) -> AsyncIterator[Worker]:
        """A worker that is free; waits for one."""
        worker = await self._free.get()
        try:
            yield worker
        finally:
            self._free.put_nowait(worker)

    async def close(self) -> None:
        """End the processes."""
        await asyncio.gather(*(worker.close() for worker in self.workers))
