"""Draws the pictures of contact.md: runs examples/contact (two minutes) and keeps their shapes.

.venv/bin/python docs/make_contact_pictures.py
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from sheetmorph.cli import main

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "pictures"
EXAMPLES = {"roll": "side", "cross": "shape", "rest": "shape", "drape": "shape"}
"""Examples, and the picture of each that is kept."""


def draw() -> None:
    """Run the examples and copy their pictures."""
    with tempfile.TemporaryDirectory() as name:
        for example, picture in EXAMPLES.items():
            folder = Path(name) / example
            design = ROOT / "examples" / "contact" / f"{example}.toml"
            command = ["run", str(design), "-o", str(folder), "--quiet"]
            command += ["--set", "outputs.animation=false", "--set", "outputs.series=false"]
            if main(command) != 0:
                raise SystemExit(f"sheetmorph {' '.join(command)} failed")
            shutil.copyfile(
                folder / "pictures" / f"{picture}.png", PICTURES / f"contact-{example}.png"
            )


if __name__ == "__main__":
    draw()
