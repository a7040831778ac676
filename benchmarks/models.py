"""What a Newton iteration of the laminate model costs beside one of the published model.

    python benchmarks/models.py [--repeat 15]

One iteration is a Hessian with gradient and energy, a factorisation, a back-substitution and the
gradient of the line search, at the same mesh: those of the published designs, which
SHEETMORPH_REFERENCE_DATA names, and one ten times finer made here. Processor time, medians.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from statistics import median
from time import process_time

import numpy as np

from sheetmorph.design.spec import Design
from sheetmorph.solve.constraints import HeldDofs
from sheetmorph.solve.linear import make_solver
from sheetmorph.solve.system import System
from sheetmorph.study.model import Problem, build_problem

PUBLISHED = Path(__file__).resolve().parents[1] / "examples" / "published"
CASES: dict[str, dict[str, object]] = {
    "petals": {},
    "bowl": {},
    "canoe": {},
    "petals, 1 mm": {"mesh.reference_file": None, "mesh.unit": None, "mesh.size": "1 mm"},
}


def system_of(problem: Problem) -> System:
    """The free problem at half the actuation."""
    pattern = problem.total.pattern
    linear = make_solver(pattern, problem.design.solver.linear_solver)
    return System(problem.total.at(0.5, 1.0), HeldDofs.of(pattern, problem.held_dofs), linear)


def seconds_of(problem: Problem, repeat: int) -> tuple[float, float]:
    """Median processor time of assembly and of the linear solver in one iteration [s]."""
    system = system_of(problem)
    rng = np.random.default_rng(0)
    x = problem.start + 1e-5 * rng.standard_normal(problem.start.size)
    _, gradient, data = system.hessian(x, convex=True)
    system.factorise(data)
    assembly, linear = [], []
    for _ in range(repeat):
        start = process_time()
        system.hessian(x)
        system.gradient(x)
        between = process_time()
        system.factorise(data)
        system.solve(gradient)
        assembly.append(between - start)
        linear.append(process_time() - between)
    return median(assembly), median(linear)


def main() -> None:
    """Print a table of both models."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=15)
    repeat = parser.parse_args().repeat
    print("| design | nodes | published [ms] | laminate [ms] | assembly | linear | together |")
    print("|---|---|---|---|---|---|---|")
    for name, values in CASES.items():
        design = Design.load(PUBLISHED / f"{name.split(',')[0]}.toml").with_values(values)
        layered = design.with_values({"model": "laminate", "published": None})
        problems = [build_problem(one) for one in (design, layered)]
        (a0, l0), (a1, l1) = (seconds_of(problem, repeat) for problem in problems)
        print(
            f"| {name} | {len(problems[0].mesh.nodes)} | {1e3 * (a0 + l0):.2f} "
            f"| {1e3 * (a1 + l1):.2f} | {a1 / a0:.2f} | {l1 / l0:.2f} "
            f"| {(a1 + l1) / (a0 + l0):.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
