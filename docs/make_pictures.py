"""Draw docs/pictures/shapes.png: the three presets, flat and morphed, computed by the package.

Run it in the project's environment: .venv/bin/python docs/make_pictures.py
"""

from __future__ import annotations

import io
from pathlib import Path

import sheetmorph as sm
from sheetmorph.core.files import write_bytes
from sheetmorph.design.presets import preset_text
from sheetmorph.show import scene, stills, style
from sheetmorph.show.render import RenderWorker

PRESETS = ("bowl", "canoe", "petals")
FLAT, SHAPE = (360, 200), (360, 300)
"""Width and height of the two pictures of a preset [px]."""
GAP, HEAD, FOOT = 30, 64, 74
COLOURS = 128


def main(path: Path) -> None:
    """Simulate, draw and write the picture."""
    with RenderWorker.start() as painter, style.style():
        results = [sm.simulate(sm.Design.from_toml(preset_text(name))) for name in PRESETS]
        width = len(PRESETS) * (SHAPE[0] + GAP) + GAP
        sheet = style.Sheet(width, HEAD + FLAT[1] + SHAPE[1] + FOOT)
        for column, result in enumerate(results):
            draw(sheet, GAP + column * (SHAPE[0] + GAP), result, painter)
        sheet.save(path)
    shrink(path)


def draw(sheet: style.Sheet, x: int, result: sm.Result, painter: RenderWorker) -> None:
    """One preset in a column that begins at x [px]: name, flat sheet, shape, numbers."""
    flat, final = result.positions[0], result.positions[-1]
    white = stills.white(len(flat))
    camera = scene.perspective()
    job = stills.base_job(
        result,
        tuple(
            scene.View(points, white, stills.SHAPE_COLOURS, camera.fitted(points, size, 0.04), size)
            for points, size in ((flat, FLAT), (final, SHAPE))
        ),
    )
    first, second = painter.draw(job)
    sheet.image(first, x, FOOT + SHAPE[1])
    sheet.image(second, x, FOOT)
    middle = x + SHAPE[0] / 2
    sheet.text(
        middle, sheet.height - 34, result.design.name, fontsize=19, fontweight="bold", ha="center"
    )
    a, b, c = (1e3 * extent for extent in result.summary["bbox_m"])
    strain = style.signed(result.design.eps_pre)
    sheet.text(middle, 50, f"free strain {strain}", ha="center", va="center")
    sheet.text(
        middle, 24, f"{a:.1f} × {b:.1f} × {c:.1f} mm", ha="center", va="center", color=style.MUTED
    )


def shrink(path: Path, colours: int = COLOURS) -> None:
    """Write the picture again with a palette, which takes a quarter of the room."""
    from PIL import Image

    with Image.open(path) as picture:
        small = picture.quantize(colours, method=Image.Quantize.MEDIANCUT)
    stream = io.BytesIO()
    small.save(stream, format="PNG", optimize=True)
    write_bytes(path, stream.getvalue())


if __name__ == "__main__":
    main(Path(__file__).resolve().parent / "pictures" / "shapes.png")
