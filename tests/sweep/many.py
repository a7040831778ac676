"""Sweep files of small designs, and what two sweeps have in common."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pyarrow.parquet as pq
from small import SMALL

STARS = """
design = "small.toml"
[grid]
actuation.eps_pre = [-0.1, -0.2]
layers.print.thickness = ["0.5 mm", "0.9 mm"]
mesh.size = ["5 mm"]
"""


def written(folder: Path, text: str = STARS) -> Path:
    """A sweep file with its design beside it."""
    (folder / "small.toml").write_text(SMALL)
    file = folder / "stars.toml"
    file.write_text(text)
    return file


def differences(one: Path, other: Path) -> list[str]:
    """Columns and arrays in which two sweeps differ, but for the seconds."""
    a, b = (pq.read_table(place / "results.parquet") for place in (one, other))
    if a.column_names != b.column_names:
        return [f"{a.column_names} {b.column_names}"]
    names = [name for name in a.column_names if name.split(".")[0] != "seconds"]
    found = [name for name in names if not a[name].equals(b[name])]
    with h5py.File(one / "states.h5") as f, h5py.File(other / "states.h5") as g:
        assert set(f) == set(g)
        return found + [name for name in f if not np.array_equal(f[name][()], g[name][()])]
