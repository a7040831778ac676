"""What sensitivities cost beside the run they belong to. Prints a table; processor time.

    python benchmarks/sensitivity.py

The paper's designs, whose meshes SHEETMORPH_REFERENCE_DATA names, with a smeared pattern and a
few oval pads added to it, so that there are thirty parameters of pattern, layers and actuation.
"fields" is the adjoint with the derivatives by all fields, thousands of numbers, rest positions and
corners of the pattern among them; "30 keys" the derivatives by the keys alone, without the fields
they do not need.
"""

from __future__ import annotations

from pathlib import Path
from statistics import median
from time import process_time

import sheetmorph as sm
from sheetmorph.study.sensitivity import distance_to, sensitivities

PUBLISHED = Path(__file__).resolve().parents[1] / "examples" / "published"
REPEAT = 7
PADS = 4
SMEARED = {
    "mesh.pattern_smoothing": "6 mm",
    "actuation.distance": "pattern_boundary",
    "actuation.profile": "exponential",
    "actuation.gamma": 1.5,
    "perturbation.direction": "down",
}
KEYS = [
    "actuation.eps_pre",
    "actuation.gamma",
    *(
        f"layers.{layer}.{key}"
        for layer in (0, 1)
        for key in ("thickness", "young_modulus", "poisson_ratio")
    ),
    "pattern.0.half_width",
    "pattern.0.arm_length",
    "pattern.0.rotation",
    "pattern.0.centre.0",
    "pattern.0.centre.1",
    *(
        f"pattern.{pad + 1}.{key}"
        for pad in range(PADS)
        for key in ("half_width", "half_height", "centre.0", "centre.1")
    ),
    "published.coupling",
]


def smeared(name: str, model: str) -> sm.Design:
    """A published design with a smeared pattern and pads."""
    design = sm.Design.load(PUBLISHED / f"{name}.toml")
    low_x, low_y, high_x, high_y = design.outline_polygon().bounds
    first = dict(design.with_values({}).spec.pattern[0].model_dump(mode="json", exclude_unset=True))
    pads = [
        {
            "kind": "ellipse",
            "half_width": "3 mm",
            "half_height": "4 mm",
            "centre": [
                f"{low_x + (0.25 + 0.5 * (pad % 2)) * (high_x - low_x)} m",
                f"{low_y + (0.25 + 0.5 * (pad // 2)) * (high_y - low_y)} m",
            ],
        }
        for pad in range(PADS)
    ]
    return design.with_values({"model": model, **SMEARED, "pattern": [in_text(first), *pads]})


def in_text(shape: dict[str, object]) -> dict[str, object]:
    """A shape with units again."""
    return {
        key: value
        if not isinstance(value, float | list)
        else f"{value} rad"
        if key == "rotation"
        else [f"{part} m" for part in value]
        if isinstance(value, list)
        else f"{value} m"
        for key, value in shape.items()
    }


def seconds(result: sm.Result, keys: list[str], fields: tuple[str, ...] | None) -> float:
    """Median processor time of the sensitivities [s]."""
    objective = distance_to(result.mesh.nodes, result.mesh.node_areas)
    times = []
    for _ in range(REPEAT):
        start = process_time()
        sensitivities(result, objective, keys, fields=fields)
        times.append(process_time() - start)
    return median(times)


def main() -> None:
    """Print a row for each design and model."""
    assert len(KEYS) == 30
    print("| design | model | numbers in fields | run | fields | 30 keys | fields and keys |")
    print("|---|---|---|---|---|---|---|")
    for name in ("petals", "bowl", "canoe"):
        for model in ("published", "laminate"):
            design = smeared(name, model)
            mesh = design.build_mesh()
            sm.simulate(design, mesh=mesh)
            start = process_time()
            result = sm.simulate(design, mesh=mesh)
            run = process_time() - start
            if result.status != "completed":
                print(f"| {name} | {model} | – | {result.status} | – | – | – |", flush=True)
                continue
            objective = distance_to(result.mesh.nodes, result.mesh.node_areas)
            found = sensitivities(result, objective)
            count = sum(array.size for array in (*found.fields.values(), *found.boundary.values()))
            costs = [
                seconds(result, keys, fields) / run
                for keys, fields in (([], None), (KEYS, ()), (KEYS, None))
            ]
            shown = " | ".join(f"{cost:.2f} of it" for cost in costs)
            print(f"| {name} | {model} | {count} | {run:.2f} s | {shown} |", flush=True)


if __name__ == "__main__":
    main()
