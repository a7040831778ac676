"""Draws the pictures of dynamics.md: computes examples/dynamic/snap.toml (half a minute).

.venv/bin/python docs/make_motion_pictures.py
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from PIL import Image, ImageSequence

from sheetmorph.cli import main

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "pictures"
TIMES = (0.0, 0.3, 0.61, 0.64, 0.65, 0.66, 0.67, 1.1)
"""Of the frames in the strip [s]."""
COLUMNS = 4


def draw() -> None:
    """Compute the motion, and write its energies and frames of its film."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "snap"
        command = ["run", str(ROOT / "examples" / "dynamic" / "snap.toml"), "-o", str(folder)]
        if main([*command, "--quiet"]) != 0:
            raise SystemExit("sheetmorph run failed")
        strip(folder, PICTURES / "snap-film.png")
        shutil.copyfile(folder / "pictures" / "energies.png", PICTURES / "snap-energies.png")


def strip(folder: Path, target: Path) -> None:
    """Frames of the film of a run, in the order of their times."""
    import sheetmorph as sm

    motion = sm.Result.load(folder).motion
    if motion is None:
        raise SystemExit("this run has no motion")
    with Image.open(folder / "animation.gif") as film:
        frames = [frame.convert("RGB") for frame in ImageSequence.Iterator(film)]
    last = len(frames) - 1
    chosen = [frames[min(last, round(last * time / motion.time[-1]))] for time in TIMES]
    small = [frame.crop((0, 0, frame.width, int(0.97 * frame.height))) for frame in chosen]
    small = [frame.resize((360, 360 * frame.height // frame.width)) for frame in small]
    wide, high = small[0].size
    rows = -(-len(small) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * wide, rows * high), "white")
    for k, frame in enumerate(small):
        sheet.paste(frame, (k % COLUMNS * wide, k // COLUMNS * high))
    sheet.quantize(128).save(target, optimize=True)


if __name__ == "__main__":
    draw()
