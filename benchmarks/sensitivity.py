"""What sensitivities cost beside the run they belong to. Prints a table; processor time.

    python benchmarks/sensitivity.py [NAME ...]      # petals, bowl, canoe, pads, weight

The paper's designs, whose meshes SHEETMORPH_REFERENCE_DATA names, with a smeared pattern and oval
pads added to it: four of them, so that there are 30 parameters of pattern, layers and actuation,
and on the bowl 72, for 302; once the bowl has a weight. "fields" is the adjoint with the
derivatives by all fields, thousands of numbers, rest positions and corners of the pattern among
them; "keys" the derivatives by the keys alone, without the fields they do not need.
"""

from __future__ import annotations

import sys
from pathlib import Path
from statistics import median
from time import process_time

import numpy as np

import sheetmorph as sm
from sheetmorph.study.sensitivity import distance_to, sensitivities

PUBLISHED = Path(__file__).resolve().parents[1] / "examples" / "published"
REPEAT = 7
RUNS = 3
FEW, MANY = 4, 72
WEIGHT = {
    "layers.0.density": "1050 kg/m^3",
    "layers.1.density": "1250 kg/m^3",
    "gravity.magnitude": "9.81 m/s^2",
}
SHEETS = {
    "petals": ("petals", FEW, {}),
    "bowl": ("bowl", FEW, {}),
    "canoe": ("canoe", FEW, {}),
    "pads": ("bowl", MANY, {"actuation.eps_pre": -0.5}),
    "weight": ("bowl", FEW, WEIGHT),
}
"""Published design, number of pads, further keys."""
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
    "published.coupling",
]


def keys_of(pads: int) -> list[str]:
    """The keys above, and four of each pad."""
    names = ("half_width", "half_height", "centre.0", "centre.1")
    return [*KEYS, *(f"pattern.{pad + 1}.{name}" for pad in range(pads) for name in names)]


def smeared(name: str, model: str, pads: int = FEW) -> sm.Design:
    """A published design with a smeared pattern and pads, those of many ones smaller."""
    design = sm.Design.load(PUBLISHED / f"{name}.toml")
    low_x, low_y, high_x, high_y = design.outline_polygon().bounds
    first = dict(design.with_values({}).spec.pattern[0].model_dump(mode="json", exclude_unset=True))
    if pads == FEW:
        sizes = ("3 mm", "4 mm")
        places = [(0.25 + 0.5 * (pad % 2), 0.25 + 0.5 * (pad // 2)) for pad in range(pads)]
    else:  # spread evenly over a disc, by the golden angle
        sizes = ("1.2 mm", "1.6 mm")
        steps = np.arange(pads) + 0.5
        r, t = 0.45 * np.sqrt(steps / pads), np.pi * (3.0 - np.sqrt(5.0)) * steps
        places = [(0.5 + x, 0.5 + y) for x, y in zip(r * np.cos(t), r * np.sin(t), strict=True)]
    tables = [
        {
            "kind": "ellipse",
            "half_width": sizes[0],
            "half_height": sizes[1],
            "centre": [
                f"{low_x + x * (high_x - low_x)} m",
                f"{low_y + y * (high_y - low_y)} m",
            ],
        }
        for x, y in places
    ]
    return design.with_values({"model": model, **SMEARED, "pattern": [in_text(first), *tables]})


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
    wanted = sys.argv[1:] or list(SHEETS)
    print("| design | model | numbers in fields | run | fields | keys | | fields and keys |")
    print("|---|---|---|---|---|---|---|---|")
    for row in wanted:
        name, pads, more = SHEETS[row]
        for model in ("published", "laminate"):
            design, keys = smeared(name, model, pads).with_values(more), keys_of(pads)
            mesh = design.build_mesh()
            sm.simulate(design, mesh=mesh)
            runs = []
            for _ in range(RUNS):
                start = process_time()
                result = sm.simulate(design, mesh=mesh)
                runs.append(process_time() - start)
            run = median(runs)
            also = f", {pads} pads" if pads != FEW else ", with weight" if more else ""
            told = f"| {name}{also} | {model} "
            if result.status != "completed":
                print(f"{told}| – | {result.status} | – | – | – | – |", flush=True)
                continue
            objective = distance_to(result.mesh.nodes, result.mesh.node_areas)
            found = sensitivities(result, objective, keys)
            count = sum(array.size for array in (*found.fields.values(), *found.boundary.values()))
            costs = [
                seconds(result, some, fields) / run
                for some, fields in (([], None), (keys, ()), (keys, None))
            ]
            fields, alone, both = (f"{cost:.2f} of it" for cost in costs)
            print(
                f"{told}| {count} | {run:.2f} s | {fields} | {len(keys)} | {alone} | {both} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
