"""A search on several workers: the same as on one, whatever dies on the way."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event, Thread
from typing import Any

import pytest

from sheetmorph.cli import entry
from sheetmorph.inverse.journal import JOURNAL
from sheetmorph.sweep import cluster as clusters

SEARCH = [
    *("saddle:0.4", "--family", "ring", "--sheet", "100 mm", "--fix", "radius=0.9"),
    *("--set", "mesh.size=11 mm", "--budget", "12", "--descents", "0"),
    *("--no-pictures", "--no-fabricate", "--json"),
]
LEFT = 3
"""Designs that a search has measured before it is cut off."""


class Watched:
    """The local cluster of a command, seen from outside.

    Attributes:
        kill: how many workers are killed at once while they measure, when some design is done.
        killed: their process numbers.
        done: how many tasks each process has done that lives at the end.
    """

    def __init__(self, kill: int = 0) -> None:
        self.kill = kill
        self.killed: set[int] = set()
        self.done: dict[int, int] = {}

    @contextmanager
    def __call__(self, *arguments: Any) -> Iterator[Any]:
        """In the place of `sweep.cluster.cluster`, and the same."""
        over = Event()
        with CLUSTER(*arguments) as client:
            client.wait_for_workers(2)
            watch = Thread(target=self._strike, args=(client.cluster, over))
            watch.start()
            try:
                yield client
            finally:
                over.set()
                watch.join()
                client.wait_for_workers(2)
                self.done = dict(client.run(_done).values())

    def _strike(self, local: Any, over: Event) -> None:
        while self.kill and not over.wait(0.01):
            tasks = [one for one in list(local.scheduler.tasks.values()) if _measures(one)]
            busy = {one.processing_on.address for one in tasks if one.processing_on}
            at_work = [one for one in local.workers.values() if one.worker_address in busy]
            if len(at_work) < self.kill or not any(one.state == "memory" for one in tasks):
                continue
            for nanny in at_work[: self.kill]:
                self.killed.add(nanny.pid)
                os.kill(nanny.pid, signal.SIGKILL)
            return


CLUSTER = clusters.cluster


def _measures(task: Any) -> bool:
    return str(task.key).startswith("evaluate")


def _done(dask_worker: Any) -> tuple[int, int]:
    """Process number of a worker, and how many tasks it has done."""
    import os

    return os.getpid(), dask_worker.state.executed_count


def search(capsys: pytest.CaptureFixture[str], folder: Path, *more: str) -> dict[str, Any]:
    """What the command tells."""
    assert entry.main(["design", *SEARCH, "-o", str(folder), *more]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def measured(folder: Path) -> dict[str, str]:
    """What was found of every design that was measured, by the design; each once."""
    lines = [json.loads(line) for line in (folder / JOURNAL).read_text("utf-8").splitlines()[1:]]
    for line in lines:
        line["found"].pop("seconds")
    found = {json.dumps(line["job"]): json.dumps(line["found"]) for line in lines}
    assert len(found) == len(lines)
    return found


@pytest.mark.slow
def test_two_workers_go_on_to_what_one_finds_though_both_are_killed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same candidates and the same best, from a journal that breaks off in a line."""
    whole, pair = tmp_path / "whole", tmp_path / "pair"
    alone = search(capsys, whole, "--workers", "1")
    pair.mkdir()
    lines = (whole / JOURNAL).read_text("utf-8").splitlines(keepends=True)
    (pair / JOURNAL).write_text("".join(lines[: LEFT + 1]) + lines[LEFT + 1][:30], "utf-8")

    both = Watched(kill=2)
    monkeypatch.setattr(clusters, "cluster", both)
    again = search(capsys, pair, "--workers", "2", "--resume")
    assert len(both.killed) == 2
    assert len(both.done) == 2
    assert both.killed.isdisjoint(both.done)
    assert min(both.done.values()) >= 2  # one of them may be the target, which all need
    assert again["computed"] == alone["evaluations"] - LEFT
    assert measured(pair) == measured(whole)
    for key in ("values", "distance_m", "evaluations", "failed"):
        assert again[key] == alone[key]
