"""Draws the pictures of sweeps.md: computes examples/sweeps/stars.toml (a minute) and plots it.

.venv/bin/python docs/make_sweep_pictures.py
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from sheetmorph.cli import main

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "pictures"


def draw() -> None:
    """Compute the sweep and write the pictures."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "stars"
        plots = folder / "plots"
        commands = (
            ["sweep", str(ROOT / "examples" / "sweeps" / "stars.toml"), "-o", str(folder)],
            ["plot", str(folder), "layers.print.thickness", "aspect_ratio", "actuation.eps_pre"],
            ["plot", str(folder), "--by", "aspect_ratio", "--shapes", "18"],
        )
        for command in commands:
            if main(command) != 0:
                raise SystemExit(f"sheetmorph {' '.join(command)} failed")
        (scatter,) = plots.glob("aspect_ratio-*.png")
        shutil.copyfile(scatter, PICTURES / "sweep-scatter.png")
        shutil.copyfile(plots / "shapes.png", PICTURES / "sweep-shapes.png")


if __name__ == "__main__":
    draw()
