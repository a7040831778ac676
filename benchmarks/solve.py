"""What a solve costs, and where the time goes. Prints tables; asserts nothing.

    python benchmarks/solve.py                the published designs, one core
    python benchmarks/solve.py --growth       bowls from 1,000 to 100,000 nodes
    python benchmarks/solve.py --solvers      the linear solvers against one another

Times are medians of repeated solves from flat to final, without imports, reading, writing and
compilation; "bare" is factorisations and back-substitutions alone. "processor s" is the processor
time of all that `simulate` does, with reading the mesh and setting up: it does not grow when the
machine does other work, and the ratios to others' times are those of it.
"""

from __future__ import annotations

import argparse
import os
import platform
import statistics
import sys
from pathlib import Path
from time import process_time

for variable in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import sheetmorph as sm

PUBLISHED = Path(__file__).resolve().parents[1] / "examples" / "published"
TARGETS = {"bowl": 0.5, "petals": 0.2}
GROWTH = {1_000: 3.09, 3_000: 1.77, 10_000: 0.953, 30_000: 0.5505, 100_000: 0.2993}
"""About so many nodes with this mesh.size [mm]."""
AUTHORS_CPU_SECONDS = {"bowl": 1569.0, "petals": 309.0}
"""Processor time of the program that the authors released, one core of a machine like this."""
PAPER_SECONDS = {"bowl": (420.0, 738.0), "petals": (183.0, 218.0)}
"""The paper's own method and its finite elements, as it states them; it names no machine."""


def main() -> None:
    """Run the chosen benchmark."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--growth", action="store_true")
    parser.add_argument("--solvers", action="store_true")
    parser.add_argument("--largest", type=int, default=100_000, help="nodes of the largest bowl")
    parser.add_argument("--repeat", type=int, default=7)
    arguments = parser.parse_args()
    print(f"# {machine()}, sheetmorph {sm.__version__}")
    if arguments.growth:
        growth(arguments.largest)
    elif arguments.solvers:
        solvers(arguments.repeat)
    else:
        published(arguments.repeat)


def published(repeat: int) -> None:
    """The three published designs at full actuation."""
    print(
        "design  nodes  total s  processor s  assembly  factorise  solve  other  factorisations  "
        "total/bare"
    )
    for name in ("bowl", "canoe", "petals"):
        design = sm.Design.load(PUBLISHED / f"{name}.toml")
        sm.simulate(design)  # compiles, warms caches
        summaries, processor = [], []
        for _ in range(repeat):
            began = process_time()
            summaries.append(sm.simulate(design).summary)
            processor.append(process_time() - began)
        row, used = median_of(summaries), statistics.median(processor)
        print(
            f"{name:7} {row['nodes']:5} {row['total']:8.3f} {used:12.3f} {row['assembly']:9.3f} "
            f"{row['factorise']:10.3f} {row['solve']:6.3f} {row['other']:6.3f} "
            f"{row['factorisations']:15} {row['total'] / (row['factorise'] + row['solve']):11.2f}"
        )
        if name in AUTHORS_CPU_SECONDS:
            method, elements = PAPER_SECONDS[name]
            print(
                f"        target {TARGETS[name]} s in all; authors' program "
                f"{AUTHORS_CPU_SECONDS[name] / used:,.0f} times as long, paper's method "
                f"{method / used:,.0f}, its finite elements {elements / used:,.0f}"
            )


def solvers(repeat: int) -> None:
    """The bowl with each linear solver that is installed."""
    from sheetmorph.solve.linear import available

    print("solver                 total s  factorise  ms per factorisation")
    for name in available():
        design = sm.Design.load(PUBLISHED / "bowl.toml").with_values({"solver.linear_solver": name})
        sm.simulate(design)
        row = median_of([sm.simulate(design).summary for _ in range(repeat)])
        each = 1e3 * row["factorise"] / row["factorisations"]
        print(f"{row['solver']:22} {row['total']:7.3f} {row['factorise']:10.3f} {each:21.2f}")


def growth(largest: int) -> None:
    """The bowl preset on finer and finer meshes."""
    from sheetmorph.design.presets import preset_text

    base = sm.Design.from_toml(preset_text("bowl"))
    print(
        "  nodes  mesh s   total s  assembly  factorise    solve  factorisations  peak GiB  status"
    )
    for nodes, size in GROWTH.items():
        if nodes > largest:
            break
        design = base.with_values({"mesh.size": f"{size} mm"})
        summary = sm.simulate(design).summary
        seconds = summary["seconds"]
        peak = peak_memory()
        print(
            f"{summary['nodes']:7} {seconds['wall'] - seconds['total']:7.2f} "
            f"{seconds['total']:9.2f} {seconds['assembly']:9.2f} {seconds['factorise']:10.2f} "
            f"{seconds['solve']:8.2f} {summary['factorisations']:15} {peak:9.2f}  "
            f"{summary['status']}, {'stable' if summary['stable'] else 'unstable'}",
            flush=True,
        )


def peak_memory() -> float:
    """Largest resident memory of this process so far [GiB]; not a number on Windows."""
    try:
        import resource
    except ImportError:
        return float("nan")
    unit = 2**30 if sys.platform == "darwin" else 2**20
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit


def median_of(summaries: list[dict]) -> dict:
    """Counts of the first, medians of the seconds."""
    first = summaries[0]
    medians = {
        part: statistics.median(s["seconds"][part] for s in summaries) for part in first["seconds"]
    }
    return {**first, **medians}


def machine() -> str:
    """Processor and number of cores."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
        name = next(
            line.split(":")[1].strip() for line in text.splitlines() if "model name" in line
        )
    except (OSError, StopIteration):
        name = platform.processor()
    return f"{name}, {os.cpu_count()} cores, Python {platform.python_version()}"


if __name__ == "__main__":
    main()
