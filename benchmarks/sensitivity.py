"""What sensitivities cost beside the run they belong to. Prints a table; processor time.

    python benchmarks/sensitivity.py

"fields" is the adjoint with the derivatives of all fields, thousands of numbers; "a key" is what
each key of the design adds. The paper's designs, whose meshes SHEETMORPH_REFERENCE_DATA names.
"""

from __future__ import annotations

from pathlib import Path
from statistics import median
from time import process_time

import sheetmorph as sm
from sheetmorph.study.sensitivity import distance_to, sensitivities

PUBLISHED = Path(__file__).resolve().parents[1] / "examples" / "published"
REPEAT = 5


def main() -> None:
    """Print a row for each design and model."""
    print("| design | model | numbers in fields | run [s] | fields | a key |")
    print("|---|---|---|---|---|---|")
    for name in ("petals", "bowl", "canoe"):
        design = sm.Design.load(PUBLISHED / f"{name}.toml")
        layered = design.with_values({"model": "laminate", "perturbation.direction": "down"})
        for one in (design, layered):
            sm.simulate(one)
            start = process_time()
            result = sm.simulate(one)
            run = process_time() - start
            objective = distance_to(result.mesh.nodes, result.mesh.node_areas)
            found = sensitivities(result, objective)
            count = sum(field.size for field in found.fields.values())
            spent = []
            for keys in ([], ["actuation.eps_pre"] * 10):
                times = []
                for _ in range(REPEAT):
                    start = process_time()
                    sensitivities(result, objective, keys)
                    times.append(process_time() - start)
                spent.append(median(times))
            key = (spent[1] - spent[0]) / 10
            print(
                f"| {name} | {one.model} | {count} | {run:.2f} | {spent[0] / run:.2f} of it "
                f"| {key / run:.3f} of it |",
                flush=True,
            )


if __name__ == "__main__":
    main()
