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


def with_worker(memory: int, what: Callable[[Worker], Awaitable[Any]]) -> Any:
    """Do something with a worker, and end it."""

    async def work() -> Any:
        worker = Worker(memory, warm=True)
        try:
            return await what(worker)
        finally:
            await worker.close()

    return asyncio.run(work())


@pytest.mark.skipif(sys.platform != "linux", reason="the limit is one of Linux")
def test_a_computation_has_the_memory_that_it_is_given_and_no_more() -> None:
    kinds: list[str] = []

    async def solve_twice(worker: Worker) -> list[dict[str, Any]]:
        large = {**JOB, "values": {"mesh.size": "0.4 mm"}}
        return [
            await worker.run(job, lambda head, packet: kinds.append(head["kind"]), Ticket())
            for job in (large, JOB)
        ]

    large, small = with_worker(60 * 2**20, solve_twice)
    assert "memory" in (large.get("text") or "memory" * (large["ended"] == "died"))
    assert large["ended"] in ("error", "died")
    assert small["ended"] == "well"
    assert kinds[-1] == "scene"


def test_a_job_is_cancelled_between_steps_and_the_worker_goes_on() -> None:
    async def cancel(worker: Worker) -> tuple[dict[str, Any], dict[str, Any], int | None, float]:
        ticket = Ticket()
        slow = {**JOB, "values": {"mesh.size": "0.6 mm"}}
        asked: list[float] = []

        def stop(head: dict[str, Any], packet: bytes) -> None:
            if head["kind"] == "progress" and not asked:
                asked.append(time.monotonic())
                ticket.cancel()

        first = await worker.run(slow, stop, ticket)
        waited = time.monotonic() - asked[0]
        pid = worker.pid
        second = await worker.run(JOB, lambda head, packet: None, Ticket())
        assert worker.pid == pid
        return first, second, pid, waited

    first, second, pid, waited = with_worker(2**32, cancel)
    assert (first["ended"], second["ended"]) == ("cancelled", "well")
    assert pid is not None
    assert waited < pool.GRACE


def test_a_worker_that_does_not_listen_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pool, "GRACE", 0.0)

    async def cancel(worker: Worker) -> tuple[dict[str, Any], dict[str, Any]]:
        ticket = Ticket()
        slow = {**JOB, "values": {"mesh.size": "0.6 mm"}}

        def stop(head: dict[str, Any], packet: bytes) -> None:
            if head["kind"] == "design":  # the mesh, which follows, cannot be interrupted
                ticket.cancel()

        first = await worker.run(slow, stop, ticket)
        return first, await worker.run(JOB, lambda head, packet: None, Ticket())

    first, second = with_worker(2**32, cancel)
    assert (first["ended"], second["ended"]) == ("cancelled", "well")


def test_a_job_that_takes_too_long_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pool, "LONGEST", 0.01)
    ended = with_worker(2**32, lambda worker: worker.run(JOB, lambda h, p: None, Ticket()))
    assert ended["ended"] == "died"
    assert "more than 0.01 s" in ended["text"]


def test_a_cancelled_ticket_costs_nothing() -> None:
    ticket = Ticket()
    ticket.cancel()
    ended = with_worker(2**32, lambda worker: worker.run(JOB, lambda h, p: None, ticket))
    assert ended["ended"] == "cancelled"
