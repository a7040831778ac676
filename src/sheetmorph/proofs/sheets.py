"""What the proofs share: runs that must complete, states at stops, shapes read as numbers."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.design.files import reference_folder
from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.study.result import Result
from sheetmorph.study.simulate import simulate

TABLES = "shell_benchmarks.json"
PLANES = """
[[supports]]
kind = "symmetry"
plane = "x"
[[supports]]
kind = "symmetry"
plane = "y"
"""
"""Tables of a design of which a quarter is computed."""

QUARTER = f"""{PLANES}
[[supports]]
kind = "box"
x = ["0 mm", "0 mm"]
y = ["0 mm", "0 mm"]
hold = ["z"]
"""
"""The same with the middle held, where no load holds it."""

STEPS = """
[solver]
initial_step = 0.025
max_step = 0.05
min_step = 1e-5
tolerance = 1e-9
"""
"""Small steps and a tight tolerance, for published tables of load steps."""


def solved(design: Design, mesh: SheetMesh | None = None, stops: Sequence[float] = ()) -> Result:
    """The result of a run that reached its end.

    Raises:
        ComputationError: it did not; the message says how it ended.
    """
    result = simulate(design, mesh=mesh, stops=stops)
    if result.status != "completed":
        raise ComputationError(
            f"{design.name} ended with {result.status} {result.summary['detail']}".strip()
        )
    return result


def states_at(result: Result, ramps: Sequence[float]) -> list[int]:
    """Index of the first state at each of these fractions of the actuation."""
    return [int(np.flatnonzero(np.isclose(result.ramp, t, rtol=0, atol=1e-9))[0]) for t in ramps]


def nearest_node(mesh: SheetMesh, place: Sequence[float]) -> int:
    """Index of the node nearest to a place [m]."""
    return int(np.argmin(((mesh.nodes - np.asarray(place)) ** 2).sum(axis=1)))


def circle_curvature(points: Floats) -> float:
    """Curvature of the circle that fits points in a plane best [1/m].

    Args:
        points: shape (n, 2) [m]. The algebraic fit of Kåsa (1976), exact for points on a circle.
    """
    centred = points - points.mean(axis=0)
    scale = float(np.abs(centred).max())
    x, y = (centred / scale).T
    a, b, c = np.linalg.lstsq(np.column_stack([x, y, np.ones_like(x)]), x * x + y * y, rcond=None)[
        0
    ]
    return float(1.0 / (scale * np.sqrt(c + 0.25 * (a * a + b * b))))


def benchmark_table(name: str, reference: Path | None = None) -> dict[str, Any]:
    """A table of the published shell benchmarks, which are not part of sheetmorph.

    Args:
        name: of the table, such as "sze_cantilever_endshear".
        reference: folder of reference data; found as for designs when None.

    Raises:
        InputError: there is no such folder or file.
    """
    file = (reference_folder(None) if reference is None else reference) / TABLES
    try:
        tables = json.loads(file.read_text("utf-8"))
        return dict(tables[name])
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"holds no table {name} ({error})", file=file) from None
