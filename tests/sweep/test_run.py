"""Sweeps on a cluster: complete, resumable, the same whatever dies on the way."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import psutil
import pyarrow.parquet as pq
import pytest
from many import differences, written

import sheetmorph as sm
from sheetmorph.core.events import Event, Notice, Progress
from sheetmorph.sweep import cluster as clusters
from sheetmorph.sweep.cluster import cluster, solved
from sheetmorph.sweep.plan import Plan, Task
from sheetmorph.sweep.run import progress_text, run_sweep
from sheetmorph.sweep.task import Outcome

RANDOM = """
[family]
kind = "random_kirigami"
sheet_radius = "20 mm"
polygons = 1
mesh_size = "5 mm"
[list]
family.seed = { from = 0, to = 19, step = 1 }
[grid]
actuation.eps_pre = [-0.2, -0.3]
"""
"""Forty designs."""
GROWTH = 80_000
"""Bytes of the journal, a few designs, between two disturbances."""
FEW = RANDOM.replace("19", "3")
SWEEP = (sys.executable, "-m", "sheetmorph", "sweep")


def workers_of(pid: int) -> list[int]:
    """The worker processes of a sweep."""
    found = []
    for child in psutil.Process(pid).children(recursive=True):
        try:
            if "spawn_main" in " ".join(child.cmdline()):
                found.append(child.pid)
        except psutil.Error:  # gone meanwhile
            continue
    return found


def end_all(pids: set[int]) -> None:
    """SIGKILL."""
    for pid in pids:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


@dataclass(frozen=True)
class Undisturbed:
    """The forty designs, computed by workers that nobody kills, and what was told meanwhile."""

    out: Path
    told: list[Event]


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Undisturbed:
    """On the scheduler of somebody else, which goes on."""
    from distributed import LocalCluster

    folder = tmp_path_factory.mktemp("undisturbed")
    plan, told = Plan.load(written(folder, RANDOM)), list[Event]()
    with LocalCluster(
        n_workers=1, threads_per_worker=2, host="127.0.0.1", dashboard_address="127.0.0.1:0"
    ) as local:
        address = local.scheduler_address
        tally = run_sweep(plan, folder / "out", scheduler=address, on_event=told.append)
        assert local.scheduler.workers
    assert (tally.present, tally.computed) == (40, 40)
    rows = pq.read_table(folder / "out" / "results.parquet").to_pylist()
    failed = [row for row in rows if row["status"] != "completed"]
    assert tally.failed == len(failed) == 8  # four patterns leave too few nodes to hold
    assert all(row["status"] == "refused" and "supports" in row["reason"] for row in failed)
    return Undisturbed(folder / "out", told)


@pytest.mark.slow
def test_progress_and_the_dashboard_are_told(undisturbed: Undisturbed) -> None:
    told = undisturbed.told
    assert any(isinstance(event, Notice) and "dashboard" in event.text for event in told)
    shares = [event.fraction for event in told if isinstance(event, Progress)]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


@pytest.mark.slow
def test_killed_workers_change_nothing(undisturbed: Undisturbed, tmp_path: Path) -> None:
    file = written(tmp_path, RANDOM)
    process = subprocess.Popen([*SWEEP, str(file), "-o", str(tmp_path / "out"), "--workers", "2"])
    journal = tmp_path / "out" / "unfinished.sqlite"
    kills, size = 0, 0
    known: set[int] = set()
    while process.poll() is None:
        time.sleep(0.1)
        with suppress(FileNotFoundError, psutil.Error):  # it ends
            if journal.stat().st_size < size + GROWTH:
                continue
            size = journal.stat().st_size
            alive = workers_of(process.pid)
            if kills:
                end_all(set(alive[kills % 2 :][:1]))
            else:  # all of them at once, and those that come in their place as they start
                known = set(alive)
                end_all(known)
                while not (young := set(workers_of(process.pid)) - known):
                    time.sleep(0.02)
                end_all(young)
            kills += 1
    assert process.returncode == 0
    assert kills >= 2
    assert differences(undisturbed.out, tmp_path / "out") == []
    assert not (tmp_path / "out" / "unfinished.sqlite").exists()


def until_grown(journal: Path, process: subprocess.Popen[str]) -> None:
    """Wait until a sweep at work has kept some designs more."""
    size = journal.stat().st_size if journal.is_file() else 0
    deadline = time.monotonic() + 120
    while not (journal.is_file() and journal.stat().st_size > size + GROWTH):
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.05)


@pytest.mark.slow
def test_a_sweep_that_is_killed_and_interrupted_goes_on_with_what_is_missing(
    undisturbed: Undisturbed, tmp_path: Path
) -> None:
    file, out = written(tmp_path, RANDOM), tmp_path / "out"
    command = [*SWEEP, str(file), "-o", str(out), "--workers", "2"]
    journal = out / "unfinished.sqlite"
    process = subprocess.Popen(command, text=True)
    until_grown(journal, process)
    children = workers_of(process.pid)
    process.kill()
    process.wait()
    gone = time.monotonic() + 30
    while any(psutil.pid_exists(child) for child in children) and time.monotonic() < gone:
        time.sleep(0.1)  # workers end when their parent has
    assert not any(psutil.pid_exists(child) for child in children)
    assert subprocess.run(command, capture_output=True, check=False).returncode == 2

    process = subprocess.Popen(
        [*command, "--resume"], stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    until_grown(journal, process)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the workers too
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "interrupted with" in said and "--resume" in said
    assert "Traceback" not in said
    early = pq.read_table(out / "results.parquet").num_rows
    assert 0 < early < 40

    tally = run_sweep(Plan.load(file), out, workers=2, resume=True)
    assert (tally.present, tally.computed) == (40, 40 - early)
    assert differences(undisturbed.out, out) == []
    again = run_sweep(Plan.load(file), out, workers=2, resume=True)
    assert (again.present, again.computed) == (40, 0)


@pytest.mark.slow
def test_a_design_that_kills_its_workers_is_a_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its neighbours on the same worker are not blamed."""
    monkeypatch.setattr(clusters, "RETRIES", 1)

    @dataclass(frozen=True, eq=False)
    class Deadly(Task):  # defined here, so that it goes to the workers by value
        def make(self) -> sm.Design:
            os.kill(os.getpid(), signal.SIGKILL)
            raise AssertionError

    plan = Plan.load(written(tmp_path, FEW))

    def tasks() -> Iterator[Task]:
        for index in range(len(plan)):
            task = plan.task(index)
            yield Deadly(**vars(task)) if index == 3 else task

    rows: dict[int, Outcome] = {}
    with cluster(2, None, lambda event: None) as client:
        for outcomes in solved(client, tasks()):
            for outcome in outcomes:
                assert rows.setdefault(outcome.row["index"], outcome) is outcome
    assert sorted(rows) == list(range(8))
    assert {k for k, one in rows.items() if one.row["status"] == "worker_lost"} == {3}
    assert "every worker that computed it died" in rows[3].row["reason"]


@pytest.mark.slow
def test_a_scheduler_that_is_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clusters, "PATIENCE", 10)
    script = (
        "import time; from distributed import LocalCluster\n"
        "if __name__ == '__main__':\n"
        "    cluster = LocalCluster(n_workers=1, threads_per_worker=1, host='127.0.0.1',\n"
        "                           dashboard_address='127.0.0.1:0')\n"
        "    print(cluster.scheduler_address, flush=True)\n"
        "    time.sleep(600)\n"
    )
    (tmp_path / "cluster.py").write_text(script)
    command = [sys.executable, str(tmp_path / "cluster.py")]
    others = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert others.stdout is not None
    address = others.stdout.readline().strip()
    plan, out = Plan.load(written(tmp_path, FEW)), tmp_path / "out"

    def kill_it(event: Event) -> None:
        if isinstance(event, Progress) and event.fraction > 0:
            others.kill()

    try:
        with pytest.raises(sm.ComputationError, match="scheduler is lost; add --resume"):
            run_sweep(plan, out, scheduler=address, on_event=kill_it)
    finally:
        others.kill()
        others.wait()
        others.stdout.close()
    tally = run_sweep(plan, out, workers=1, resume=True)
    assert tally.present == 8
    assert 0 < tally.computed < 8


def test_a_scheduler_that_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clusters, "PATIENCE", 1)
    plan = Plan.load(written(tmp_path, FEW))
    with pytest.raises(sm.InputError, match="does not answer"):
        run_sweep(plan, tmp_path / "out", scheduler="tcp://127.0.0.1:9")
    with pytest.raises(sm.InputError, match="scheduler"):
        run_sweep(plan, tmp_path / "two", scheduler="nonsense")


def test_a_folder_with_something_in_it(tmp_path: Path) -> None:
    plan = Plan.load(written(tmp_path, FEW))
    place = tmp_path / "mine"
    place.mkdir()
    (place / "results.parquet").write_text("mine")
    for force in (False, True):
        with pytest.raises(sm.InputError, match="no sweep wrote it"):
            run_sweep(plan, place, force=force)
    assert (place / "results.parquet").read_text("utf-8") == "mine"
    with pytest.raises(sm.InputError, match="no unfinished sweep"):
        run_sweep(plan, tmp_path / "new", resume=True)
    with pytest.raises(sm.InputError, match="is a file"):
        run_sweep(plan, tmp_path / "small.toml")
    with pytest.raises(sm.InputError, match="--workers"):
        run_sweep(plan, tmp_path / "new", workers=0)


def test_progress_in_words() -> None:
    assert progress_text(3, 10, 0, 0, 0.0) == "3 of 10"
    assert progress_text(412, 1000, 3, 81, 10.0) == "412 of 1000, 8.1 /s, 1 min 13 s left, 3 failed"
    assert progress_text(1, 1000, 0, 1, 30.0) == "1 of 1000, 2.0 /min, 8 h 19 min left"
    assert progress_text(9, 10, 0, 9, 9.0) == "9 of 10, 1.0 /s, 1 s left"
