"""The film of a result: from flat to final as an animated GIF, which opens everywhere."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sheetmorph.core.files import write_bytes
from sheetmorph.geometry.mesh import Floats
from sheetmorph.show import fields, scene, style
from sheetmorph.show.flat import actuation_text
from sheetmorph.show.motion import time_text
from sheetmorph.show.scene import Image, Job, View
from sheetmorph.show.stills import SHAPE_COLOURS, base_job, white

if TYPE_CHECKING:
    from sheetmorph.study.result import Result

NAME = "animation.gif"
SIZE = (640, 480)
_HEAD, _BAR = 66, 5
_SCENE = (SIZE[0], SIZE[1] - _HEAD - _BAR)
FRAMES = 40
MOST_FRAMES = 120
"""Of a motion, which has a frame for each state that was kept."""
FRAME_TIME = 70
HOLD_FIRST, HOLD_LAST = 500, 2200
"""Milliseconds for which a frame, the first and the last one stay."""
MAX_BYTES = 3_000_000


def film_job(
    result: Result, base: Job | None = None, frames: int | None = None
) -> tuple[Job, Floats]:
    """The frames to draw, and the actuation of each, or the time of a motion, shape (frames,).

    The textures are those of `base`, when it is given.
    """
    ramp, load = fields.clock_of(result)
    told = result.actuation if result.motion is None else result.motion.time
    if frames is None:
        frames = FRAMES if result.motion is None else min(max(FRAMES, len(told)), MOST_FRAMES)
    moved, told = fields.motion(result.positions, ramp, load, told, frames)
    camera = scene.perspective().fitted(moved.reshape(-1, 3), _SCENE, 0.03)
    plain = white(moved.shape[1])
    views = tuple(View(points, plain, SHAPE_COLOURS, camera, _SCENE) for points in moved)
    return replace(base or base_job(result), views=views), told


def save_film(result: Result, folder: Path, images: Iterator[Image], told: Floats) -> Path:
    """Write `<folder>/animation.gif`, given the frames that the renderer has begun to draw.

    Raises:
        OutputError: the file cannot be written; no half-written file is left.
    """
    pen = _Pen(result)
    frames = [pen.labelled(image, float(value)) for image, value in zip(images, told, strict=True)]
    data = encode(frames)
    while len(data) > MAX_BYTES and frames[0].width > SIZE[0] // 3:
        frames = [frame.resize((frame.width * 4 // 5, frame.height * 4 // 5)) for frame in frames]
        data = encode(frames)
    path = folder / NAME
    write_bytes(path, data)
    return path


def encode(frames: list[Any]) -> bytes:
    """Pictures of Pillow as an animated GIF with one palette that suits them all."""
    from PIL import Image as Pillow

    samples = [
        frames[k] for k in sorted({0, len(frames) // 3, 2 * len(frames) // 3, -1 % len(frames)})
    ]
    strip = Pillow.new("RGB", (samples[0].width // 2, samples[0].height // 2 * len(samples)))
    for k, sample in enumerate(samples):
        strip.paste(sample.reduce(2), (0, k * (sample.height // 2)))
    palette = strip.quantize(255, method=Pillow.Quantize.MEDIANCUT)
    colours = np.array(palette.getpalette(), dtype=np.int64).reshape(-1, 3)
    colours[colours.min(axis=1) > 246] = 255  # the paper stays white
    palette.putpalette(colours.ravel().tolist())
    flat = [frame.quantize(palette=palette, dither=Pillow.Dither.NONE) for frame in frames]
    times = [FRAME_TIME] * len(flat)
    times[0], times[-1] = HOLD_FIRST, HOLD_LAST
    stream = io.BytesIO()
    flat[0].save(
        stream,
        format="GIF",
        save_all=True,
        append_images=flat[1:],
        duration=times,
        loop=0,
        optimize=False,
        disposal=1,
    )
    return stream.getvalue()


class _Pen:
    """Writes the name, the actuation and how far it has come onto a frame."""

    def __init__(self, result: Result) -> None:
        import matplotlib
        from PIL import ImageFont

        fonts = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
        self._large = ImageFont.truetype(str(fonts / "DejaVuSans.ttf"), 22)
        self._small = ImageFont.truetype(str(fonts / "DejaVuSans.ttf"), 15)
        self._name = style.shortened(result.design.name, 60)
        self._text = actuation_text if result.motion is None else time_text
        motion = result.motion
        self._full = float(result.summary["eps_pre"] if motion is None else motion.time[-1])

    def labelled(self, image: Image, told: float) -> Any:
        from PIL import Image as Pillow
        from PIL import ImageDraw

        frame = Pillow.new("RGB", SIZE, "white")
        frame.paste(Pillow.fromarray(image), (0, _HEAD))
        pen = ImageDraw.Draw(frame)
        pen.text((18, 14), self._text(told), fill=style.INK, font=self._large)
        pen.text((18, 44), self._name, fill=style.MUTED, font=self._small)
        share = min(max(told / self._full, 0.0), 1.0) if self._full else 1.0
        top = frame.height - _BAR
        pen.rectangle((0, top, frame.width, frame.height), fill="#e6eaee")
        pen.rectangle(
            (0, top, round(share * frame.width), frame.height), fill=style.colour(style.BILAYER)
        )
        return frame
