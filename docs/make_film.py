"""Draw docs/pictures/morphing.webp: bowl, canoe and petals from flat to full actuation.

Run it in the project's environment: .venv/bin/python docs/make_film.py
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont

import sheetmorph as sm
from sheetmorph.core.files import write_bytes
from sheetmorph.design.presets import preset_text
from sheetmorph.show import film, scene, style
from sheetmorph.show.render import RenderWorker

PRESETS = ("bowl", "canoe", "petals")
SIZE = (300, 260)
"""Width and height of the picture of a preset [px]."""
LABEL, BAR = 46, 4
FRAMES = 48
FRAME_TIME, HOLD_FIRST, HOLD_LAST = 60, 700, 1800
"""Milliseconds for which a frame, the first and the last one stay."""
QUALITY = 70


def main(path: Path) -> None:
    """Simulate, draw and write the film."""
    results = [sm.simulate(sm.Design.from_toml(preset_text(name))) for name in PRESETS]
    frames = list(drawn(results))
    times = [HOLD_FIRST, *[FRAME_TIME] * (len(frames) - 2), HOLD_LAST]
    stream = io.BytesIO()
    frames[0].save(
        stream,
        format="WEBP",
        save_all=True,
        append_images=frames[1:],
        duration=times,
        loop=0,
        quality=QUALITY,
        method=6,
    )
    write_bytes(path, stream.getvalue())
    print(f"{path.name}: {len(frames)} frames, {path.stat().st_size / 1e6:.2f} MB")


def drawn(results: list[sm.Result]) -> Iterator[Any]:
    """The frames: the sheets side by side at the same share of their actuation."""
    jobs = [film.film_job(result, frames=FRAMES) for result in results]
    with RenderWorker.start() as painter:
        columns = [list(painter.draw(resized(job))) for job, _ in jobs]
    fonts = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
    font = ImageFont.truetype(str(fonts / "DejaVuSans.ttf"), 15)
    for k in range(FRAMES):
        frame = Image.new("RGB", (SIZE[0] * len(results), SIZE[1] + LABEL + BAR), "white")
        pen = ImageDraw.Draw(frame)
        for column, (result, (_, actuation)) in enumerate(zip(results, jobs, strict=True)):
            left = column * SIZE[0]
            frame.paste(Image.fromarray(columns[column][k]), (left, LABEL))
            text = f"{result.design.name}, free strain {style.signed(float(actuation[k]), 2)}"
            width = pen.textlength(text, font=font)
            pen.text((left + (SIZE[0] - width) / 2, 16), text, fill=style.INK, font=font)
        share = k / (FRAMES - 1)
        bottom = frame.height - BAR
        pen.rectangle((0, bottom, frame.width, frame.height), fill="#e6eaee")
        pen.rectangle(
            (0, bottom, round(share * frame.width), frame.height), fill=style.colour(style.BILAYER)
        )
        yield frame


def resized(job: scene.Job) -> scene.Job:
    """The same frames, seen by a camera that has the whole motion in a picture of `SIZE`."""
    points = np.concatenate([view.points for view in job.views])
    camera = scene.perspective().fitted(points, SIZE, 0.03)
    views = tuple(replace(view, camera=camera, size=SIZE) for view in job.views)
    return replace(job, views=views)


if __name__ == "__main__":
    main(Path(__file__).resolve().parent / "pictures" / "morphing.webp")
