"""Compute the designs of examples/gallery; write docs/gallery.md, its pictures and its numbers.

    .venv/bin/python docs/make_gallery.py              all (a minute)
    .venv/bin/python docs/make_gallery.py lotus helix  the pictures of these alone

The numbers, examples/gallery/numbers.json, are those that tests/gallery holds the designs to.
"""

from __future__ import annotations

import io
import json
import sys
from dataclasses import replace
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import sheetmorph as sm
from sheetmorph.core.files import write_bytes
from sheetmorph.show import scene, stills, style
from sheetmorph.show.render import RenderWorker

ROOT = Path(__file__).resolve().parents[1]
DESIGNS = ROOT / "examples" / "gallery"
NUMBERS = DESIGNS / "numbers.json"
PICTURES = ROOT / "docs" / "pictures" / "gallery"
PAGE = ROOT / "docs" / "gallery.md"

FLAT, SHAPE = (300, 240), (420, 320)
"""Width and height of the two pictures of a design [px]."""
COLOURS = 96

HEAD = """# Gallery

Designs to look at, to run and to change. Each has its file, its picture and its numbers;
`tests/gallery` computes all of them anew and holds them to these numbers. Page, pictures and
numbers are made by `.venv/bin/python docs/make_gallery.py`.

```sh
sheetmorph run examples/gallery/lotus.toml -o lotus
```

Left the flat sheet (blue: inert parts on the film), right the final shape. h/d is height over
width; angle the largest between two neighbouring triangles; U the elastic energy.

"""


def main(names: list[str]) -> None:
    """Draw the designs with these names, or all, and then write page and numbers too."""
    files = [path for path in sorted(DESIGNS.glob("*.toml")) if not names or path.stem in names]
    numbers = {}
    PICTURES.mkdir(parents=True, exist_ok=True)
    with RenderWorker.start() as painter, style.style():
        for path in files:
            result = sm.simulate(sm.Design.load(path))
            numbers[path.stem] = measured(result)
            draw(result, PICTURES / f"{path.stem}.png", painter)
            print(path.stem, numbers[path.stem], flush=True)
    if not names:
        write_bytes(NUMBERS, (json.dumps(numbers, indent=1) + "\n").encode())
        write_bytes(PAGE, page(files, numbers).encode())


def measured(result: sm.Result) -> dict[str, Any]:
    """The numbers of a result that the page shows and the tests pin."""
    summary = result.summary
    return {
        "model": summary["model"],
        "status": summary["status"],
        "stable": summary["stable"],
        "nodes": summary["nodes"],
        "eps_pre": summary["eps_pre"],
        "aspect_ratio": summary["aspect_ratio"],
        "height_mm": 1e3 * summary["height_m"],
        "energy_mJ": 1e3 * summary["energy_J"]["total"],
        "largest_angle_deg": float(np.degrees(np.abs(result.dihedral[-1]).max())),
    }


def draw(result: sm.Result, path: Path, painter: RenderWorker) -> None:
    """Flat sheet and final shape side by side."""
    flat, final = result.positions[0], result.positions[-1]
    white = stills.white(len(flat))
    camera = scene.perspective()
    views = tuple(
        scene.View(points, white, stills.SHAPE_COLOURS, camera.fitted(points, size, 0.05), size)
        for points, size in ((flat, FLAT), (final, SHAPE))
    )
    first, second = painter.draw(replace(stills.base_job(result), views=views))
    sheet = style.Sheet(FLAT[0] + SHAPE[0], SHAPE[1])
    sheet.image(first, 0, (SHAPE[1] - FLAT[1]) // 2)
    sheet.image(second, FLAT[0], 0)
    sheet.save(path)
    shrink(path)


def shrink(path: Path) -> None:
    """Write the picture again with a palette, which takes a quarter of the room."""
    with Image.open(path) as picture:
        small = picture.convert("RGB").quantize(COLOURS, method=Image.Quantize.MEDIANCUT)
    stream = io.BytesIO()
    small.save(stream, format="PNG", optimize=True)
    write_bytes(path, stream.getvalue())


def page(files: list[Path], numbers: dict[str, dict[str, Any]]) -> str:
    """The page: a section for each design, published model first."""
    parts = [HEAD]
    for model, title in (("published", "Published model"), ("laminate", "Laminate model")):
        parts.append(f"## {title}\n\n")
        parts += [
            section(path, numbers[path.stem])
            for path in files
            if numbers[path.stem]["model"] == model
        ]
    return "".join(parts).rstrip() + "\n"


def section(path: Path, found: dict[str, Any]) -> str:
    """One design: its first comment, its picture, its numbers."""
    lines = path.read_text("utf-8").splitlines()
    comment = " ".join(line[2:] for line in takewhile(lambda line: line.startswith("# "), lines))
    name = path.stem.replace("_", " ")
    return (
        f"### {name.capitalize()}\n\n{comment}\n\n"
        f"![{name}, flat and morphed](pictures/gallery/{path.stem}.png)\n\n"
        f"[{path.name}](../examples/gallery/{path.name}) · free strain "
        f"{style.signed(found['eps_pre'], 3)} · {found['nodes']} nodes · "
        f"h/d {found['aspect_ratio']:.3f} · height {found['height_mm']:.1f} mm · "
        f"angle {found['largest_angle_deg']:.0f}° · U {found['energy_mJ']:.3g} mJ\n\n"
    )


if __name__ == "__main__":
    main(sys.argv[1:])
