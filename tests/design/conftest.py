"""A small design and a regular mesh for it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import SheetMesh
from sheetmorph.geometry.topology import build_mesh

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples" / "published"

BASE = """\
name = "strip"
model = "published"

[outline]
kind = "rectangle"
width = "40 mm"
height = "20 mm"

[[pattern]]
kind = "bar"
start = ["-10 mm", "0 mm"]
end = ["10 mm", "0 mm"]
half_width = "3 mm"

[[layers]]
name = "film"
role = "active"
thickness = "0.3 mm"
young_modulus = "0.8911 MPa"
poisson_ratio = 0.33
density = "1050 kg/m^3"
where = "everywhere"

[[layers]]
name = "PLA"
role = "inert"
thickness = "1.0 mm"
young_modulus = "2.6733 MPa"
poisson_ratio = 0.33
density = "1250 kg/m^3"
where = "pattern"

[actuation]
eps_pre = -0.3 # free shrinkage
profile = "linear"
distance = "bilayer_edges"

[[supports]]
kind = "box"
x = ["-5 mm", "5 mm"]
y = ["-5 mm", "5 mm"]

[perturbation]
shape = "uniform"
force_per_node = "1e-6 N"

[mesh]
size = "2 mm"

[published]
coupling = 1.0

[solver]
max_step = 0.2
"""


@pytest.fixture
def base() -> str:
    """TOML text of a bar on a 40 mm x 20 mm sheet."""
    return BASE


@pytest.fixture
def design() -> Design:
    """The design of `base`."""
    return Design.from_toml(BASE)


@pytest.fixture(scope="session")
def examples() -> Path:
    """The folder of the paper's designs on the released meshes."""
    return EXAMPLES


@pytest.fixture(scope="session")
def strip() -> SheetMesh:
    """A regular mesh of the base design's sheet, of 2 mm squares cut in two."""
    return _grid(0.04, 0.02, 0.002)


@pytest.fixture(scope="session")
def grid() -> Callable[[float, float, float], SheetMesh]:
    """Makes such meshes: width, height, step [m]."""
    return _grid


def _grid(width: float, height: float, step: float) -> SheetMesh:
    """A rectangle about the origin in squares, each cut along a diagonal."""
    columns, rows = round(width / step) + 1, round(height / step) + 1
    x = np.linspace(-width / 2, width / 2, columns)
    y = np.linspace(-height / 2, height / 2, rows)
    nodes = np.array([(a, b) for b in y for a in x])
    corner = np.array([(r * columns + c) for r in range(rows - 1) for c in range(columns - 1)])
    lower = np.column_stack([corner, corner + 1, corner + columns + 1])
    upper = np.column_stack([corner, corner + columns + 1, corner + columns])
    return build_mesh(nodes, np.concatenate([lower, upper]))
