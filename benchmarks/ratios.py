"""Is it as fast as it was? Costs of a few jobs, in units of a kernel that is timed beside them.

    python benchmarks/ratios.py              compare with benchmarks/baseline.json; never fails
    python benchmarks/ratios.py --write      make this the baseline

The unit is a fixed piece of NumPy and SciPy work (products of matrices, sorting, a sparse LU), so
that the ratios can be compared between machines to some extent. Both are processor times, the
kernel is timed before every job, and the least of several rounds counts. A change of less than 30 %
says nothing: the table marks what is beyond.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from time import process_time

for variable in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np
import scipy.sparse
from scipy.sparse.linalg import splu

import sheetmorph as sm
from sheetmorph.core.machine import processor
from sheetmorph.design import meshing
from sheetmorph.design.presets import preset_text
from sheetmorph.study.model import build_problem

BASELINE = Path(__file__).with_name("baseline.json")
NOTABLE = 1.3


def kernel() -> None:
    """About a tenth of a second of arrays, of which no part is ours."""
    rng = np.random.default_rng(0)
    square = rng.standard_normal((500, 500))
    for _ in range(2):
        square = np.tanh(square @ square.T / 500.0)
    np.sort(rng.standard_normal(300_000))
    line = scipy.sparse.diags([-1.0, 2.001, -1.0], [-1, 0, 1], shape=(80, 80))
    plane = scipy.sparse.kronsum(line, line).tocsc()
    splu(plane, permc_spec="MMD_AT_PLUS_A").solve(np.ones(plane.shape[0]))


def jobs() -> dict[str, Callable[[], object]]:
    """What is timed: name to job, everything compiled and read."""
    texts = {name: preset_text(name, name) for name in ("bowl", "petals", "kirigami")}
    designs = {name: sm.Design.from_toml(text) for name, text in texts.items()}
    meshes = {name: design.build_mesh() for name, design in designs.items()}
    laminate = designs["petals"].with_values({"model": "laminate", "actuation.eps_pre": -0.3})

    def evaluations(design: sm.Design) -> Callable[[], object]:
        problem = build_problem(design, meshes["petals"])
        total = problem.total.at(0.5, 1.0)
        return lambda: [total.evaluate(problem.start, 2) for _ in range(40)]

    chosen: dict[str, Callable[[], object]] = {
        "read a design 3 times": lambda: [sm.Design.from_toml(texts["bowl"]) for _ in range(3)],
        "mesh of the bowl": lambda: mesh_anew(designs["bowl"]),
        "40 Hessians, published": evaluations(designs["petals"]),
        "40 Hessians, laminate": evaluations(laminate),
        "bowl, published": lambda: sm.simulate(designs["bowl"], mesh=meshes["bowl"]),
        "petals, published": lambda: sm.simulate(designs["petals"], mesh=meshes["petals"]),
        "petals at -0.3, laminate": lambda: sm.simulate(laminate, mesh=meshes["petals"]),
    }
    for job in chosen.values():
        job()
    return chosen


def mesh_anew(design: sm.Design) -> object:
    """The mesh of a design, made and not remembered."""
    meshing._remembered.cache_clear()
    return design.build_mesh()


def cost(job: Callable[[], object]) -> float:
    """Processor time [s]."""
    began = process_time()
    job()
    return process_time() - began


def measured(rounds: int) -> tuple[float, dict[str, float]]:
    """Seconds of the kernel, and the jobs in its units."""
    chosen = jobs()
    kernel()
    units: list[float] = []
    seconds: dict[str, list[float]] = {name: [] for name in chosen}
    for _ in range(rounds):
        for name, job in chosen.items():
            units.append(cost(kernel))
            seconds[name].append(cost(job))
    unit = min(units)
    return unit, {name: min(values) / unit for name, values in seconds.items()}


def main() -> None:
    """Print the table, or write the baseline."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    unit, ratios = measured(arguments.rounds)
    machine = {"processor": processor(), "python": sys.version.split()[0]}
    if arguments.write:
        content = {**machine, "sheetmorph": sm.__version__, "kernel_s": unit, "ratios": ratios}
        BASELINE.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8", newline="\n")
    before = {"processor": "no baseline", "ratios": {}}
    if BASELINE.exists():
        before = json.loads(BASELINE.read_text("utf-8"))
    print(f"speed on {machine['processor']}, kernel {unit:.3f} s; before: {before['processor']}")
    print(f"{'job':28} {'kernels':>8} {'before':>8} {'ratio':>6}")
    for name, ratio in ratios.items():
        old = before["ratios"].get(name)
        change = "" if old is None else f"{ratio / old:6.2f}"
        mark = "  slower" if old and ratio > NOTABLE * old else ""
        mark = "  faster" if old and ratio < old / NOTABLE else mark
        print(f"{name:28} {ratio:8.2f} {old or float('nan'):8.2f} {change:>6}{mark}")


if __name__ == "__main__":
    main()
