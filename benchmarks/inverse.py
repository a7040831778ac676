"""Inverse design: hidden designs found again, and shapes on order.

    python benchmarks/inverse.py hidden [--part K/N] [--budget 60 --descents 2]
                                                       # 20 shapes of designs drawn by chance
    python benchmarks/inverse.py orders                # bowls, saddles, canoes …, with `fabricate`

Writes a table, one line as each is done; the folders of `orders` go to benchmarks/results/inverse.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
from scipy.spatial.transform import Rotation

from sheetmorph.cli import entry
from sheetmorph.compare.pose import Similarity
from sheetmorph.inverse.families import FAMILIES, SIZE, Space, space_of
from sheetmorph.inverse.find import SearchOptions, find_design
from sheetmorph.inverse.limits import Limits
from sheetmorph.inverse.misfit import shape_of
from sheetmorph.inverse.targets import Target
from sheetmorph.study.simulate import simulate

FAMILY_OF = ("star", "lotus", "ring", "cross", "canoe") * 4
WIDTH = 0.06
"""The hidden sheets are 90 to 130 mm large."""
MESH = {"mesh.size": "5 mm"}
"""Of the hidden designs and of those that are found: 300 to 500 nodes."""
GOOD = 0.01
QUICK = ("--descents", "1", "--accuracy", "1")
SLENDER = ("--fix", "aspect=0.5", "--set", "mesh.size=5.5 mm", "--seed", "3")
SHORT = ("--fix", "arm_length=0.207", "--fix", "spacing=0.914", "--fix", "half_width=0.109")
ORDERS = (
    ("bowl:0.5", "free", ("--budget", "60", "--descents", "1")),
    ("bowl:0.35", "star", ("--budget", "60", "--descents", "1")),
    ("bowl:0.4", "star", ("--sheet", "100 mm", "--budget", "36", *QUICK)),
    ("saddle:0.4", "free", ("--budget", "24", "--steps", "4", *QUICK)),
    ("saddle:0.4", "ring", ("--budget", "36", *QUICK)),
    ("cylinder:0.3", "stripes", ("--budget", "48", *QUICK)),
    ("letter:L:0.4", "free", ("--budget", "24", "--steps", "4", *QUICK)),
    ("canoe:2.0:0.35", "canoe", (*SLENDER, "--budget", "60", *QUICK)),
    (
        "canoe:2.0:0.35",
        "canoe",
        (*SHORT, "--fix", "aspect=0.507", *SLENDER[2:4], "--budget", "12", *QUICK),
    ),
    ("canoe:1.5:0.5", "canoe", ("--budget", "36", "--set", "mesh.size=4.5 mm", *QUICK)),
    ("canoe:2.0:0.6", "canoe", ("--budget", "36", "--set", "mesh.size=4.5 mm", *QUICK)),
)


def hidden(number: int) -> tuple[Target, Space, tuple[float, ...]]:
    """A shape of a design drawn by chance from a family, in a pose drawn by chance."""
    random = np.random.default_rng(1000 + number)
    family = FAMILIES[FAMILY_OF[number]]
    space = space_of(family, WIDTH, Limits(), overrides=MESH)
    while True:
        unit = random.uniform(0.15, 0.85, len(space.parameters))
        point = space.low + unit * (space.high - space.low)
        point[[one.name for one in space.parameters].index(SIZE)] = random.uniform(0.09, 0.13)
        values = tuple(
            float(round(x)) if one.whole else float(x)
            for x, one in zip(point, space.parameters, strict=True)
        )
        result = simulate(space.design(values, f"hidden {number}"))
        if result.status == "completed" and result.summary["aspect_ratio"] > 0.1:
            break
    turn = Rotation.random(rng=random).as_matrix()
    pose = Similarity(1.0, turn, random.uniform(-0.1, 0.1, 3))
    surface = shape_of(result).moved(pose)
    return (
        Target(f"hidden {number}", surface, f"{family.name} of seed {1000 + number}"),
        space,
        values,
    )


def find_again(number: int, budget: int = 60, descents: int = 2) -> tuple[float, str]:
    """The distance that is left, and a line of the table."""
    target, _, values = hidden(number)
    own = shape_width(target)
    began, used = perf_counter(), process_time()
    sized = Target(target.name, target.surface, target.text)
    options = SearchOptions(
        families=(FAMILY_OF[number],),
        budget=budget,
        descents=descents,
        accuracy=0.007,
        overrides=MESH,
        seed=number,
    )
    found = find_design(_with_width(sized, own), options)
    told = ", ".join(
        f"{name} {value:.3g} ({true:.3g})"
        for (name, value), true in zip(
            ((one, found.values[one]) for one in _names(number)), values, strict=True
        )
    )
    return found.distance, (
        f"| {number + 1} | {FAMILY_OF[number]} | {100 * found.distance:.2f} | "
        f"{found.to_json()['found']['aspect_ratio']:.3f} | {told} | {found.evaluations} | "
        f"{process_time() - used:.0f} | {perf_counter() - began:.0f} |"
    )


def shape_width(target: Target) -> float:
    """Largest distance of two points: the target lies in any pose, so its plan says nothing."""
    from scipy.spatial import ConvexHull
    from scipy.spatial.distance import pdist

    points = target.surface.points
    return float(pdist(points[ConvexHull(points).vertices]).max())


def _with_width(target: Target, width: float) -> Target:
    made = Target(target.name, target.surface, target.text)
    made.__dict__["width"] = width
    return made


def _names(number: int) -> list[str]:
    return [one.name for one in space_of(FAMILIES[FAMILY_OF[number]], WIDTH, Limits()).parameters]


def run_hidden(part: str, budget: int, descents: int) -> None:
    """Find the hidden designs of one part of the list."""
    mine, parts = (int(text) for text in part.split("/"))
    numbers = [k for k in range(len(FAMILY_OF)) if k % parts == mine - 1]
    print("| # | family | distance [%] | h/d | found (hidden) | designs | processor [s] | [s] |")
    distances = []
    for number in numbers:
        distance, line = find_again(number, budget, descents)
        distances.append(distance)
        print(line, flush=True)
    good = sum(one < GOOD for one in distances)
    print(f"{good} of {len(distances)} nearer than {100 * GOOD:g} %")


def run_orders() -> None:
    """Find designs for named shapes by the command line, and tell how they came out."""
    folder = Path(__file__).parent / "results" / "inverse"
    for number, (target, family, more) in enumerate(ORDERS):
        place = folder / f"{number + 1:02}-{target.replace(':', '-')}-{family}"
        began = process_time()
        arguments = ["design", target, "--family", family, "-o", str(place), "--force", *more]
        code = entry.main([*arguments, "--workers", "1", "--quiet"])
        data = json.loads((place / "inverse.json").read_text("utf-8"))
        wanted, found = data["wanted"], data["found"]
        print(
            f"{target} by {family}: exit {code}, distance {data['distance_percent']:.2f} %, "
            f"h/d {found['aspect_ratio']:.3f}, length/width "
            f"{found['length_m'] / found['width_m']:.3f} (wanted "
            f"{wanted['length_m'] / wanted['width_m']:.3f}), {data['evaluations']} designs, "
            f"{process_time() - began:.0f} s of processor time, fabricate: "
            f"{len(list((place / 'fabricate').rglob('*.*')))} files",
            flush=True,
        )


def main() -> int:
    """Run one of the two."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("hidden", "orders"))
    parser.add_argument("--part", default="1/1")
    parser.add_argument("--budget", type=int, default=60)
    parser.add_argument("--descents", type=int, default=2)
    given = parser.parse_args()
    if given.what == "hidden":
        run_hidden(given.part, given.budget, given.descents)
    else:
        run_orders()
    return 0


if __name__ == "__main__":
    sys.exit(main())
