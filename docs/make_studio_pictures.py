"""Draws the pictures of the presets that the studio's gallery shows.

    .venv/bin/python docs/make_studio_pictures.py

They lie in src/sheetmorph/studio/page, as the page needs them.
"""

from __future__ import annotations

import io
from pathlib import Path

from PIL import Image

import sheetmorph as sm
from sheetmorph.core.files import replacing
from sheetmorph.design.presets import PRESETS, preset_text
from sheetmorph.show.pictures import shape_png

PAGE = Path(__file__).resolve().parents[1] / "src" / "sheetmorph" / "studio" / "page"
WIDTH, HEIGHT = 432, 270


def main() -> None:
    """Solve every preset and draw its shape."""
    for name in PRESETS:
        result = sm.simulate(sm.Design.from_toml(preset_text(name)))
        picture = Image.open(io.BytesIO(shape_png(result))).convert("RGB")
        picture = fitted(picture)
        with replacing(PAGE / f"preset-{name}.png") as partial:
            picture.quantize(128).save(partial, optimize=True)


def fitted(picture: Image.Image) -> Image.Image:
    """A picture within the size of the gallery, on white."""
    shown = picture.copy()
    shown.thumbnail((WIDTH, HEIGHT), Image.Resampling.LANCZOS)
    sheet = Image.new("RGB", (WIDTH, HEIGHT), "white")
    sheet.paste(shown, ((WIDTH - shown.width) // 2, (HEIGHT - shown.height) // 2))
    return sheet


if __name__ == "__main__":
    main()
