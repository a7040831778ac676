"""Draws the pictures of the presets that the studio's gallery shows, and one of the studio.

    .venv/bin/python docs/make_studio_pictures.py

The former lie in src/sheetmorph/studio/page, as the page needs them. The latter,
docs/pictures/studio.png, wants Chromium (its path in SHEETMORPH_CHROMIUM) and Playwright.
"""

from __future__ import annotations

import io
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from PIL import Image
from playwright.sync_api import expect, sync_playwright

import sheetmorph as sm
from sheetmorph.core.files import replacing
from sheetmorph.design.presets import PRESETS, preset_text
from sheetmorph.show.pictures import shape_png

PAGE = Path(__file__).resolve().parents[1] / "src" / "sheetmorph" / "studio" / "page"
SCREEN = Path(__file__).resolve().parent / "pictures" / "studio.png"
CHROMIUM = os.environ.get("SHEETMORPH_CHROMIUM") or shutil.which("chromium") or "chromium"
FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--use-gl=angle"),
    *("--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
)
WIDTH, HEIGHT = 432, 270


def main() -> None:
    """Draw everything."""
    presets()
    studio()


def studio() -> None:
    """Take a picture of the studio with the bowl and its fold angles."""
    command = [sys.executable, "-m", "sheetmorph", "studio", "--no-browser", "--port", "0"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)  # noqa: S603
    try:
        found = re.search(r"http://\S+", server.stdout.readline() if server.stdout else "")
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
            page = browser.new_page(viewport={"width": 1360, "height": 800})
            page.goto(found[0] if found else "")
            expect(page.locator("#state")).to_have_text("solved", timeout=60_000)
            page.locator("#field").select_option("angle")
            page.locator("#layout").select_option("over")
            page.click("#sizes")
            page.locator('.handle[data-key="pattern.0.half_width"]').focus()
            page.wait_for_timeout(500)
            with replacing(SCREEN) as partial:
                shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
                shot.save(partial, optimize=True)
            browser.close()
    finally:
        server.terminate()
        server.wait()


def presets() -> None:
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
