"""A sweep of small random designs: undisturbed, with workers killed, on one core and on two.

    .venv/bin/python benchmarks/sweep.py                    # 1,000 designs, a kill every 30 s
    .venv/bin/python benchmarks/sweep.py --designs 60 --kill-every 5

Prints the time of each run, whether the tables and the states are the same to the last bit
(but for the columns of seconds), and the parallel efficiency. Wall-clock efficiency wants a
machine that does nothing else; beside it stand two numbers that hold on a busy one: the
processor time of a design with one worker over that with two, and the share of the time in
which the workers had a design.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np
import psutil
import pyarrow.parquet as pq

SWEEP = """
[family]
kind = "random_kirigami"
sheet_radius = "20 mm"
polygons = 1
mesh_size = "{mesh}"
[list]
family.seed = {{ from = 0, to = {last}, step = 1 }}
[grid]
actuation.eps_pre = [-0.3]
supports.0.x = [["-6 mm", "6 mm"]]
supports.0.y = [["-6 mm", "6 mm"]]
"""


def run(folder: Path, out: str, workers: int, kill_every: float | None) -> dict[str, float]:
    """One sweep by the command line; kills a worker now and then."""
    command = [sys.executable, "-m", "sheetmorph", "sweep", str(folder / "random.toml"), "--json"]
    command += ["-o", str(folder / out), "--workers", str(workers)]
    began = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)  # noqa: S603
    kills, last = 0, time.perf_counter()
    while process.poll() is None:
        time.sleep(0.1)
        if kill_every and time.perf_counter() - last > kill_every:
            kills += kill_one(process.pid)
            last = time.perf_counter()
    wall = time.perf_counter() - began
    assert process.returncode == 0 and process.stdout is not None
    table = pq.read_table(folder / out / "results.parquet")
    seconds = np.array(table["seconds"].to_pylist(), dtype=float)
    return {
        "designs": table.num_rows,
        "failed": json.loads(process.stdout.read())["failed"],
        "wall": wall,
        "busy": float(np.nansum(seconds)) / (workers * wall),
        "cpu": float(np.nansum(table["seconds.cpu"].to_numpy(zero_copy_only=False))),
        "kills": kills,
    }


def kill_one(pid: int) -> int:
    """SIGKILL one of the workers of a sweep; 1 when there was one."""
    workers = [p for p in psutil.Process(pid).children(recursive=True) if is_worker(p)]
    if not workers:
        return 0
    os.kill(random.choice(workers).pid, signal.SIGKILL)  # noqa: S311
    return 1


def is_worker(process: psutil.Process) -> bool:
    """Whether it is a worker, not a helper of multiprocessing."""
    try:
        return "spawn_main" in " ".join(process.cmdline())
    except psutil.Error:
        return False


def same(one: Path, other: Path) -> bool:
    """Whether two sweeps are the same, but for the columns of seconds."""
    tables = [pq.read_table(place / "results.parquet") for place in (one, other)]
    names = [name for name in tables[0].column_names if "seconds" not in name]
    if tables[0].column_names != tables[1].column_names:
        return False
    with h5py.File(one / "states.h5") as a, h5py.File(other / "states.h5") as b:
        states = all(np.array_equal(a[name][()], b[name][()]) for name in a)
    return states and tables[0].select(names).equals(tables[1].select(names))


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--designs", type=int, default=1000)
    parser.add_argument("--kill-every", type=float, default=30.0)
    parser.add_argument("--mesh", default="5 mm")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        text = SWEEP.format(last=options.designs - 1, mesh=options.mesh)
        (folder / "random.toml").write_text(text)
        runs = {}
        every = options.kill_every
        for out, workers, kills in (("two", 2, None), ("killed", 2, every), ("one", 1, None)):
            runs[out] = run(folder, out, workers, kills)
            r = runs[out]
            print(
                f"{out:7} {workers} workers, {r['kills']} kills: {r['designs']} designs, "
                f"{r['failed']} failed, {r['wall']:.1f} s, processor time of the designs "
                f"{r['cpu']:.1f} s, workers had a design {r['busy']:.1%} of the time",
                flush=True,
            )
        print(f"two is one:    {same(folder / 'one', folder / 'two')}")
        print(f"killed is two: {same(folder / 'two', folder / 'killed')}")
        wall = runs["one"]["wall"] / (2 * runs["two"]["wall"])
        cpu = runs["one"]["cpu"] / runs["two"]["cpu"]
        print(f"parallel efficiency {wall:.1%} by the clock, load {os.getloadavg()[0]:.1f}")
        print(f"processor time with one worker over that with two {cpu:.1%}")


if __name__ == "__main__":
    main()
