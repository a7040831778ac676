"""Random complete designs by seed: sheet, pattern, layers, actuation, supports, for trials."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
import tomlkit

from sheetmorph.core.errors import InputError
from sheetmorph.design.spec import Design
from sheetmorph.study.model import build_problem

MODELS = ("published", "laminate")
TRIALS = 40
"""Draws of one seed before it is given up; few seeds need more than three."""

TIGHTEST = 0.4
"""Largest angle [rad] by which layers may want to bend between a triangle and its side.

Beyond it the mesh is too coarse for what it shall show.
"""

Table = dict[str, Any]


def random_design(
    seed: int,
    *,
    model: Literal["published", "laminate", "any"] = "any",
    nodes: int = 500,
    strongest: float = -0.8,
    weakest: float = -0.05,
    time_limit: float = 600.0,
) -> Design:
    """A design of which everything is drawn by chance, within what a lab might make.

    Sheets of 40 to 160 mm (discs, ellipses, rectangles, polygons; one in ten with a hole), one or
    two shapes of the library as the pattern, a film of 0.15 to 0.6 mm with one to three inert
    layers of 0.05 to 1.5 mm above or below it and 0.3 to 30 times as stiff, a linear, exponential
    or (laminate) uniform profile of the actuation, held in the middle or free. The same
    numbers draw the same design everywhere.

    Args:
        seed: whole number from 0.
        model: that of the design; "any" draws it.
        nodes: wanted number of nodes of the mesh.
        strongest: free strain at one end of the range from which it is drawn.
        weakest: free strain at the other end.
        time_limit: of a run [s].

    Raises:
        InputError: a number is not allowed, or no design was found.
    """
    if model not in (*MODELS, "any"):
        raise InputError(
            "no such model", key="model", value=model, allowed=", ".join((*MODELS, "any"))
        )
    if not 50 <= nodes <= 20_000:
        raise InputError("is out of range", key="nodes", value=nodes, allowed="50 to 20000")
    last: InputError | None = None
    for trial in range(TRIALS):
        draw = _Draw(np.random.default_rng([seed, trial]))
        content = draw.content(seed, model, nodes, (strongest, weakest), time_limit)
        try:
            design = Design.from_toml(tomlkit.dumps(content))
            lean = build_problem(design).model.natural_lean
        except InputError as error:
            last = error
        else:
            if lean <= TIGHTEST:
                return design
            last = InputError("the layers want to curl tighter than the mesh can follow")
    assert last is not None  # noqa: S101
    raise InputError(f"no design of this seed is allowed: {last}", key="seed", value=seed)


class _Draw:
    """What one trial draws; lengths [mm] while drawing."""

    def __init__(self, chance: np.random.Generator) -> None:
        self.chance = chance

    def between(self, low: float, high: float) -> float:
        return float(self.chance.uniform(low, high))

    def ratio(self, low: float, high: float) -> float:
        """Between two positive numbers, evenly in their logarithm."""
        return math.exp(self.between(math.log(low), math.log(high)))

    def whole(self, low: int, high: int) -> int:
        return int(self.chance.integers(low, high + 1))

    def one(self, *choices: Any) -> Any:
        return choices[self.whole(0, len(choices) - 1)]

    def happens(self, probability: float) -> bool:
        return bool(self.chance.random() < probability)

    def content(
        self, seed: int, model: str, nodes: int, strains: tuple[float, float], limit: float
    ) -> Table:
        """The tables of a design file."""
        model = self.one(*MODELS) if model == "any" else model
        width, outline, area = self.outline()
        layers = self.layers()
        supports = self.supports(width, model)
        size = math.sqrt(2.0 / math.sqrt(3.0) * area / nodes)
        content: Table = {"name": f"random {seed}", "model": model, "outline": outline}
        content["pattern"] = [self.shape(width) for _ in range(1 + self.happens(0.2))]
        content["layers"] = layers
        content["actuation"] = self.actuation(strains, model)
        if supports:
            content["supports"] = supports
        content["perturbation"] = self.perturbation(bool(supports))
        content["mesh"] = {"size": _mm(size)}
        content["solver"] = {"time_limit": f"{limit!r} s"}
        return content

    def outline(self) -> tuple[float, Table, float]:
        """Half the smaller width [mm], the table, the area [mm²] without holes."""
        half = self.between(20, 50)
        kind = self.one("disc", "ellipse", "rectangle", "regular_polygon")
        table: Table = {"kind": kind}
        if kind == "disc":
            table["radius"], area = _mm(half), math.pi * half**2
        elif kind == "ellipse":
            long = half * self.between(1.05, 1.8)
            table |= {"half_width": _mm(long), "half_height": _mm(half)}
            area = math.pi * half * long
        elif kind == "rectangle":
            long = half * self.between(1.0, 2.2)
            table |= {"width": _mm(2 * long), "height": _mm(2 * half)}
            area = 4 * half * long
        else:
            sides = self.whole(3, 8)
            radius = half / math.cos(math.pi / sides) if sides > 3 else 1.5 * half
            table |= {"sides": sides, "radius": _mm(radius)}
            area = sides / 2 * radius**2 * math.sin(2 * math.pi / sides)
        if self.happens(0.1):
            hole: Table = {"kind": "disc", "radius": _mm(half * self.between(0.08, 0.2))}
            hole["centre"] = self.point(0.5 * half)
            table["cutouts"] = [hole]
        return half, table, area

    def point(self, reach: float) -> list[str]:
        return [_mm(self.between(-reach, reach)), _mm(self.between(-reach, reach))]

    def shape(self, half: float) -> Table:
        """One table of the pattern, clipped at the sheet."""
        kind = self.one(
            *("star", "bar", "twin_star", "cross", "lotus", "ring", "rings", "spiral"),
            *("stripes", "grid", "honeycomb", "random_polygons", "ellipse", "rectangle"),
        )
        thin = half * self.between(0.04, 0.14)  # half the width of a bar
        turn = f"{self.between(0, 180)!r} deg"
        table: Table = {"kind": kind, "clip": True}
        if kind == "star":
            table |= {"arms": self.whole(2, 8), "arm_length": _mm(half * self.between(0.5, 1.1))}
            table |= {"half_width": _mm(thin), "rotation": turn}
        elif kind == "bar":
            table |= {"start": self.point(0.9 * half), "end": self.point(0.9 * half)}
            table["half_width"] = _mm(thin)
        elif kind == "twin_star":
            table |= {"arms": self.whole(3, 6), "arm_length": _mm(half * self.between(0.4, 0.9))}
            table |= {"half_width": _mm(thin), "spacing": _mm(half * self.between(0.5, 1.2))}
        elif kind == "cross":
            table |= {"arms": self.whole(2, 5), "arm_length": _mm(half * self.between(0.4, 0.8))}
            table |= {"half_width": _mm(thin), "chamfer": _mm(thin * self.between(1, 2))}
        elif kind == "lotus":
            radius = half * self.between(0.6, 0.95)
            table |= {"petals": self.whole(3, 8), "disc_radius": _mm(0.3 * radius)}
            table |= {"radius": _mm(radius), "petal_half_width": _mm(1.3 * thin)}
        elif kind == "ring":
            table |= {"radius": _mm(half * self.between(0.4, 0.95)), "width": _mm(2 * thin)}
        elif kind == "rings":
            table |= {"count": self.whole(1, 3), "spacing": _mm(half * self.between(0.32, 0.45))}
            table |= {"width": _mm(2 * thin), "spokes": self.one(0, 3, 4, 6)}
        elif kind == "spiral":
            table |= {"turns": self.between(0.7, 2.5), "pitch": _mm(half * self.between(0.3, 0.5))}
            table["half_width"] = _mm(thin)
        elif kind in ("stripes", "grid"):
            table |= {"spacing": _mm(thin * self.between(4, 8)), "half_width": _mm(thin)}
            table |= {"rotation": turn, "margin": _mm(half * self.between(0, 0.2))}
        elif kind == "honeycomb":
            table |= {"cell_size": _mm(thin * self.between(4, 8)), "wall_width": _mm(2 * thin)}
            table["cells"] = self.one("whole", "cut")
        elif kind == "random_polygons":
            table |= {"seed": self.whole(0, 10**6), "polygons": self.whole(1, 4)}
            table |= {"lines": self.whole(3, 8), "line_width": _mm(2 * thin)}
            table["style"] = self.one("spokes", "outline", "both")
        elif kind == "ellipse":
            table |= {"half_width": _mm(half * self.between(0.2, 0.7)), "rotation": turn}
            table["half_height"] = _mm(half * self.between(0.2, 0.7))
        else:
            table |= {"width": _mm(half * self.between(0.3, 1.2)), "rotation": turn}
            table["height"] = _mm(half * self.between(0.3, 1.2))
        return table

    def layers(self) -> list[Table]:
        """A film, and one to three inert layers on it or below it."""
        film = self.ratio(0.3, 3.0)
        layers: list[Table] = [
            {
                "name": "film",
                "role": "active",
                "thickness": _mm(self.ratio(0.15, 0.6)),
                "young_modulus": f"{film!r} MPa",
                "poisson_ratio": self.between(0.2, 0.45),
            }
        ]
        for number in range(1 + self.happens(0.2) + self.happens(0.2)):
            inert: Table = {
                "name": f"inert {number}",
                "role": "inert",
                "thickness": _mm(self.ratio(0.2, 1.5) if number == 0 else self.ratio(0.05, 0.5)),
                "young_modulus": f"{film * self.ratio(0.3, 30.0)!r} MPa",
                "poisson_ratio": self.between(0.2, 0.45),
                "where": "pattern",
            }
            layers.insert(0 if self.happens(0.25) else len(layers), inert)
        return layers

    def actuation(self, strains: tuple[float, float], model: str) -> Table:
        table: Table = {"eps_pre": self.between(*strains)}
        table["profile"] = self.one(
            *("linear", "linear", "exponential"),
            *(("uniform",) if model == "laminate" else ()),
        )
        if table["profile"] == "exponential":
            table["gamma"] = self.ratio(0.1, 5.0)
        if model == "laminate" and table["profile"] != "uniform" and self.happens(0.3):
            table["under_pattern"] = self.between(0, 1)
        return table

    def supports(self, half: float, model: str) -> list[Table]:
        """A box about the middle in two designs of three, else none."""
        if not self.happens(2 / 3):
            return []
        reach = half * self.between(0.12, 0.25)
        table: Table = {"kind": self.one("box", "pattern_in_box")}
        table |= {"x": [_mm(-reach), _mm(reach)], "y": [_mm(-reach), _mm(reach)]}
        return [table]

    def perturbation(self, held: bool) -> Table:
        shape = self.one("bowl", "uniform") if held else "bowl"
        return {"shape": shape, "direction": self.one("up", "down")}


def _mm(length: float) -> str:
    return f"{length!r} mm"
