"""What layers alone decide: equal ones are one, and turning the stack over mirrors the shape."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats
from sheetmorph.proofs.proof import Check, Proof
from sheetmorph.proofs.sheets import solved

SHEET = """
name = "layers"
model = "laminate"
[outline]
kind = "disc"
radius = "20 mm"
[[pattern]]
kind = "bar"
start = ["-15 mm", "0 mm"]
end = ["15 mm", "0 mm"]
half_width = "3 mm"
[actuation]
eps_pre = -0.3
[mesh]
size = "2.5 mm"
"""

EXTENT = 40e-3
LIMIT = 1e-13


def prove(reference: Path | None = None) -> Proof:
    """Whole shapes of one sheet, its layers written in several ways."""
    film, bar = ("film", "active", 0.3, 1.0), ("bar", "inert", 0.6, 3.0)
    plain = _shape([film, bar])
    split = _shape(
        [
            *(("film", "active", 0.1, 1.0), ("film 2", "active", 0.2, 1.0)),
            *(("bar", "inert", 0.2, 3.0), ("bar 2", "inert", 0.4, 3.0)),
        ]
    )
    turned = _shape([bar, film], direction="down")
    apart = float(np.abs(split - plain).max()) / EXTENT
    mirrored = float(np.abs(turned * [1.0, 1.0, -1.0] - plain).max()) / EXTENT
    height = float(np.ptp(plain[:, 2])) / EXTENT
    return Proof(
        name="layers",
        title="Equal layers, and layers turned over",
        statement=(
            "A film of 0.3 mm that shrinks by 30 % and thickens, with a stiffer bar of 0.6 mm upon "
            "it. Both are cut into two layers of the same material, and then the stack is turned "
            "over: the first must change nothing, the second must give the mirror image, for the "
            "layers decide which face curls inward. Distances are the largest of any node over "
            "the diameter of the flat sheet."
        ),
        source="by definition",
        checks=(
            Check("actuated", "height over diameter", 0.1, height, kind="at least"),
            Check("equal", "four layers against the same two", 0.0, apart, LIMIT, "absolute"),
            Check("turned", "turned over against mirrored", 0.0, mirrored, LIMIT, "absolute"),
        ),
    )


def _shape(layers: list[tuple[str, str, float, float]], direction: str = "up") -> Floats:
    """Final positions of the sheet with these layers: name, role, thickness [mm], modulus [MPa]."""
    tables = ""
    for name, role, thickness, modulus in layers:
        where = "pattern" if name.startswith("bar") else "everywhere"
        tables += (
            f'[[layers]]\nname = "{name}"\nrole = "{role}"\nwhere = "{where}"\n'
            f'thickness = "{thickness} mm"\nyoung_modulus = "{modulus} MPa"\n'
        )
    design = Design.from_toml(f'{SHEET}{tables}[perturbation]\ndirection = "{direction}"\n')
    return np.asarray(solved(design).positions[-1])
