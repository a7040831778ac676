"""Shared by all tests: reference data, small meshes."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import numpy as np
import pytest
from small import SMALL

import sheetmorph as sm
from sheetmorph.geometry.mesh import SheetMesh
from sheetmorph.geometry.topology import build_mesh

# A shell that starts the tests in the background has them, and their programs, ignore Ctrl-C.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

ROOT = Path(__file__).resolve().parents[1]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files with slow tests come first, so that no process is left alone with one at the end."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.fixture(scope="session")
def reference() -> Path:
    """The folder of reference data; the test is skipped where it is absent."""
    folder = Path(os.environ.get("SHEETMORPH_REFERENCE_DATA", ROOT.parent / "shared" / "reference"))
    if not folder.is_dir():
        pytest.skip(f"no reference data in {folder} (set SHEETMORPH_REFERENCE_DATA)")
    return folder


def grid_mesh(
    nx: int, ny: int, dx: float = 1.0, dy: float | None = None, seed: int | None = None
) -> SheetMesh:
    """A rectangle of nx × ny cells cut along alternating diagonals; interior jittered by a seed."""
    dy = dx if dy is None else dy
    x, y = np.meshgrid(np.arange(nx + 1) * dx, np.arange(ny + 1) * dy)
    nodes = np.column_stack([x.ravel(), y.ravel()])
    if seed is not None:
        rng = np.random.default_rng(seed)
        inside = (
            (nodes[:, 0] > 0)
            & (nodes[:, 0] < nx * dx)
            & (nodes[:, 1] > 0)
            & (nodes[:, 1] < ny * dy)
        )
        nodes[inside] += rng.uniform(-0.2, 0.2, (int(inside.sum()), 2)) * [dx, dy]
    i, j = np.meshgrid(np.arange(nx), np.arange(ny))
    a = (j * (nx + 1) + i).ravel()
    b, c, d = a + 1, a + nx + 2, a + nx + 1
    even = ((i + j) % 2 == 0).ravel()[:, None]
    first = np.where(even, np.column_stack([a, b, c]), np.column_stack([a, b, d]))
    second = np.where(even, np.column_stack([a, c, d]), np.column_stack([b, c, d]))
    return build_mesh(nodes, np.concatenate([first, second]))


@pytest.fixture(scope="session")
def small_mesh() -> SheetMesh:
    """42 irregular nodes, about 1 cm apart."""
    return grid_mesh(6, 5, 0.01, seed=3)


@pytest.fixture(scope="session")
def small_design() -> sm.Design:
    """A design that is solved in a tenth of a second."""
    return sm.Design.from_toml(SMALL)


@pytest.fixture(scope="session")
def small_result(small_design: sm.Design) -> sm.Result:
    """Its shape."""
    return sm.simulate(small_design)
