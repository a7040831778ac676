"""Workers: bounded in memory and time, cancelled, replaced."""

from __future__ import annotations

import asyncio
import sys
import time
from collections.abc import Awaitable, Callable
from typing import Any

import pytest
from small import SMALL

from sheetmorph.studio import pool
from sheetmorph.studio.pool import Ticket, Worker

JOB = {"task": "design", "text": SMALL, "levels": ["full"]}


def with_worker(memory: int, what: Callable[[Worker], Awaitable[None]]) -> None:
    """Do something with a worker, and end it."""

    async def work() -> None:
        worker = Worker(memory, warm=True)
        try:
            await what(worker)
        finally:
            await worker.close()

    asyncio.run(work())


def nobody(head: dict[str, Any], packet: bytes) -> None:
    """Take no notice of packets."""


@pytest.mark.skipif(sys.platform != "linux", reason="the limit is one of Linux")
def test_a_computation_has_the_memory_that_it_is_given_and_no_more() -> None:

    async def solve_twice(worker: Worker) -> None:
        large = {**JOB, "values": {"mesh.size": "0.4 mm"}}
        ended = await worker.run(large, nobody, Ticket())
        # A library that is refused memory may end its process instead of telling.
        told = ended["ended"] == "error" and "memory" in ended["text"]
        assert told or ended["ended"] == "died"
        assert (await worker.run(JOB, nobody, Ticket()))["ended"] == "well"

    with_worker(60 * 2**20, solve_twice)


def test_jobs_are_cancelled_and_workers_replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    """Several stories of one worker, because each start takes seconds."""
    slow = {**JOB, "values": {"mesh.size": "0.6 mm"}}

    async def between_steps(worker: Worker) -> None:
        ticket, asked = Ticket(), []

        def stop(head: dict[str, Any], packet: bytes) -> None:
            if head["kind"] == "progress" and not asked:
                asked.append(time.monotonic())
                ticket.cancel()

        ended = await worker.run(slow, stop, ticket)
        assert time.monotonic() - asked[0] < pool.GRACE
        pid = worker.pid
        assert ended["ended"] == "cancelled"
        assert (await worker.run(JOB, nobody, Ticket()))["ended"] == "well"
        assert worker.pid == pid is not None

    async def before_it_began(worker: Worker) -> None:
        ticket = Ticket()
        ticket.cancel()
        assert (await worker.run(JOB, nobody, ticket))["ended"] == "cancelled"

    async def in_a_mesh_that_cannot_be_interrupted(worker: Worker) -> None:
        monkeypatch.setattr(pool, "GRACE", 0.0)
        ticket, pid = Ticket(), worker.pid

        def stop(head: dict[str, Any], packet: bytes) -> None:
            if head["kind"] == "design":
                ticket.cancel()

        assert (await worker.run(slow, stop, ticket))["ended"] == "cancelled"
        assert (await worker.run(JOB, nobody, Ticket()))["ended"] == "well"
        assert worker.pid != pid

    async def given_up_just_as_it_ended(worker: Worker) -> None:
        pid = worker.pid
        worker._job = -1
        worker._give_up(-1)
        assert (await worker.run(JOB, nobody, Ticket()))["ended"] == "well"
        assert worker.pid != pid

    async def too_long(worker: Worker) -> None:
        monkeypatch.setattr(pool, "LONGEST", 0.01)
        ended = await worker.run(JOB, nobody, Ticket())
        assert (ended["ended"], "more than 0.01 s" in ended["text"]) == ("died", True)

    async def all_of_them(worker: Worker) -> None:
        await between_steps(worker)
        await before_it_began(worker)
        await in_a_mesh_that_cannot_be_interrupted(worker)
        await given_up_just_as_it_ended(worker)
        await too_long(worker)

    with_worker(2**32, all_of_them)
