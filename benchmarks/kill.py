"""Kill -9 at random moments of run, sweep and calibrate; going on must give the same results.

    python benchmarks/kill.py run sweep calibrate --kills 100

A job is started, killed after a random part of the time it takes, and gone on with as its message
says, up to five times in a row; then it may finish, and its result is compared with that of a job
that no one killed: to the last bit, but for times and counts of work. After every kill all
files that are there must be whole. Prints a line for each kind of job; exit code 1 if anything
differs. POSIX only: the jobs are forks, so that the time goes into jobs and not into imports.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import h5py
import numpy as np

import sheetmorph as sm
from sheetmorph.cli.entry import main as command
from sheetmorph.design.presets import preset_text
from sheetmorph.study.simulate import simulate

IN_A_ROW = 5
TIMES = ("seconds", "simulations")
QUIET = "[outputs]\npictures = false\nanimation = false\nreport = false\nseries = true\n"
SWEEP = """design = "design.toml"
[list]
actuation.eps_pre = { from = -0.3, to = -0.1, count = 12 }
"""


def inputs(place: Path) -> None:
    """The design and what the jobs read beside it."""
    text = preset_text("petals", "design").split("[outputs]")[0] + QUIET
    design = sm.Design.from_toml(text).with_values({"mesh.size": "12 mm"})
    design.save(place / "design.toml")
    (place / "sweep.toml").write_text(SWEEP, encoding="utf-8")
    found = simulate(design.with_values({"actuation.eps_pre": -0.2}))
    rows = [
        f"{-0.2 * ramp:.6f}, {ratio:.6f}"
        for ramp, ratio in zip(found.ramp[1:-1], found.aspect_ratio[1:-1], strict=True)
    ]
    (place / "curve.csv").write_text("eps_pre, h/d\n" + "\n".join(rows), encoding="utf-8")


def arguments(kind: str, inside: Path, folder: Path) -> list[str]:
    """The command line of a job, without what it says of earlier ones."""
    return {
        "run": ["run", str(inside / "design.toml"), "-o", str(folder), "-q"],
        "sweep": [
            *("sweep", str(inside / "sweep.toml"), "-o", str(folder), "--workers", "2", "-q"),
        ],
        "calibrate": [
            *("calibrate", str(inside / "design.toml"), "-o", str(folder), "--no-pictures", "-q"),
            *("--curve", str(inside / "curve.csv"), "--workers", "1", "--starts", "1"),
            *("--fit", "moduli_ratio=2:4", "--no-intervals"),
        ],
    }[kind]


def start(line: list[str]) -> int:
    """Run a command line in a fork with a process group of its own; its process id."""
    child = os.fork()
    if child:
        return child
    os.setsid()
    code = 1
    try:
        sys.argv = ["sheetmorph", *line]
        with open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere):  # noqa: PTH123
            code = command(line)
    finally:
        os._exit(code)


def finished(child: int, seconds: float) -> int | None:
    """Exit code of a job; None where it was killed at the end of the time."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.002)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None


def whole(folder: Path) -> None:
    """Every file in the folder can be read."""
    for file in folder.rglob("*"):
        if ".partial" in file.name:
            continue  # beside the name of what it would have become
        if file.suffix == ".npz":
            with np.load(file) as data:
                assert all(np.isfinite(data[name]).all() for name in data.files)
        elif file.suffix == ".h5":
            with h5py.File(file) as h5:
                assert h5.attrs["format"]
        elif file.suffix == ".json":
            json.loads(file.read_text("utf-8"))
        elif file.suffix == ".parquet":
            import pyarrow.parquet as pq

            pq.read_table(file)


def content(kind: str, folder: Path) -> object:
    """What a finished job found, without times."""
    if kind == "run":
        result = sm.Result.load(folder)
        return [getattr(result, name).tobytes() for name in ("positions", "ramp", "scalars")]
    if kind == "sweep":
        import pyarrow.parquet as pq

        table = pq.read_table(folder / "results.parquet")
        names = [name for name in table.column_names if not name.startswith("seconds")]
        with h5py.File(folder / "states.h5") as h5:
            shapes = h5["positions"][()].tobytes()
        return table.select(names).to_pylist(), shapes
    numbers = json.loads((folder / "calibration.json").read_text("utf-8"))
    return json.dumps(without_times(numbers), sort_keys=True)


def without_times(value: object) -> object:
    """The same numbers without times and counts of work."""
    if isinstance(value, dict):
        return {
            key: without_times(inner)
            for key, inner in value.items()
            if not any(word in key for word in TIMES)
        }
    return [without_times(inner) for inner in value] if isinstance(value, list) else value


def goes_on(kind: str, folder: Path) -> list[str]:
    """What the message of the job tells to add."""
    unfinished = {
        "run": folder / "states" / "journal.json",
        "sweep": folder / "unfinished.sqlite",
        "calibrate": folder / "evaluations.jsonl",
    }[kind]
    if kind == "run" and unfinished.exists():
        states = (folder / "states").glob("state_*.npz")
        return ["--resume"] if any(states) else ["--force"]
    return ["--resume"] if unfinished.exists() and unfinished.stat().st_size else ["--force"]


def trial(kind: str, kills: int, seed: int) -> bool:
    """Kill one kind of job so often; True when all went well."""
    chance = random.Random(seed)  # noqa: S311
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        inputs(place)
        began = time.monotonic()
        line = arguments(kind, place, place / "whole")
        assert finished(start(line), 600.0) == 0
        took = time.monotonic() - began
        wanted = content(kind, place / "whole")
        done = jobs = resumed = 0
        wrong: list[str] = []
        while done < kills:
            folder = place / f"job{jobs}"
            jobs += 1
            options: list[str] = []
            for _ in range(IN_A_ROW):
                child = start([*arguments(kind, place, folder), *options])
                code = finished(child, chance.uniform(0.0, 1.1 * took))
                if code is not None:
                    break
                done += 1
                try:
                    whole(folder)
                except (AssertionError, OSError, ValueError, KeyError) as error:
                    wrong.append(f"a file is not whole ({error})")
                options = goes_on(kind, folder)
                resumed += options == ["--resume"]
            else:
                code = finished(start([*arguments(kind, place, folder), *options]), 600.0)
            if code != 0:
                wrong.append(f"ended with exit code {code} after {options}")
            elif content(kind, folder) != wanted:
                wrong.append("another result")
            shutil.rmtree(folder)
    print(
        f"{kind}: killed {done} times in {jobs} jobs of {took:.1f} s, gone on with --resume "
        f"{resumed} times, " + ("all results the same" if not wrong else "; ".join(wrong)),
        flush=True,
    )
    return not wrong


def main() -> int:
    """Run the chosen trials."""
    parser = argparse.ArgumentParser(description=__doc__)
    kinds: tuple[str, ...] = ("run", "sweep", "calibrate")
    parser.add_argument("jobs", nargs="+", choices=kinds)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    went_well = [trial(kind, chosen.kills, chosen.seed) for kind in chosen.jobs]
    return 0 if all(went_well) else 1


if __name__ == "__main__":
    sys.exit(main())
