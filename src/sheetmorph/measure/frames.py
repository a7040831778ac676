"""Frames of a film: a video file, or a folder of pictures, one at a time and bounded."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError

Image = NDArray[np.uint8]

PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")
MAX_SIDE = 8192
"""Pixels along a side of a frame."""
MAX_PIXELS = 1 << 26
MAX_PICTURES = 100_000
MAX_BYTES = 200_000_000
"""Bytes of one picture file."""
MAX_VIDEO_FRAMES = 2_000_000

_CONTAINERS = (
    (4, b"ftyp"),  # MP4, MOV
    (4, b"moov"),
    (4, b"mdat"),
    (8, b"AVI "),
    (0, b"\x1a\x45\xdf\xa3"),  # Matroska, WebM
    (0, b"\x00\x00\x01\xba"),  # MPEG
    (0, b"\x00\x00\x01\xb3"),
    (0, b"OggS"),
)
"""How videos begin. A playlist, which could lead FFmpeg to other files, does not."""


@dataclass(frozen=True, eq=False)
class Frame:
    """One picture of a film.

    Attributes:
        index: its number in the film, from 0.
        time: since the first frame [s].
        image: blue, green, red, shape (rows, columns, 3).
    """

    index: int
    time: float
    image: Image


@dataclass(frozen=True)
class Film:
    """Where the frames are, before any is read.

    Attributes:
        path: the video file, or the folder of pictures.
        pictures: the files of the series in their order; empty for a video.
        rate: frames per second.
        count: frames there are; what the header says for a video, 0 where it does not.
    """

    path: Path
    pictures: tuple[Path, ...]
    rate: float
    count: int

    @property
    def name(self) -> str:
        """The name of the file or folder without its ending."""
        return self.path.resolve().name if self.pictures else self.path.stem


def open_film(path: str | Path, rate: float | None = None) -> Film:
    """Look at a film.

    Args:
        path: a video that FFmpeg reads (MP4, MOV, AVI, MKV, WebM), or a folder of pictures
            (PNG, JPEG, TIFF, BMP), taken in natural order: 2.png before 10.png.
        rate: frames per second; overrules what a video says; 1 for pictures by default.

    Raises:
        InputError: there is none, it is no film, or OpenCV is not installed.
    """
    place = Path(path)
    if rate is not None and not (0.0 < rate < 1e5 and np.isfinite(rate)):
        raise InputError(
            "wants frames per second", key="--rate", value=rate, allowed="above 0, below 1e5"
        )
    if place.is_dir():
        names = [p for p in place.iterdir() if p.suffix.lower() in PICTURES and p.is_file()]
        if not names:
            raise InputError(
                "this folder holds no pictures", file=place, allowed=" ".join(PICTURES)
            )
        if len(names) > MAX_PICTURES:
            raise InputError(
                "too many pictures", file=place, value=len(names), allowed=f"up to {MAX_PICTURES}"
            )
        opencv()
        return Film(place, tuple(sorted(names, key=_natural)), rate or 1.0, len(names))
    if not place.is_file():
        raise InputError("there is no such film: a video, or a folder of pictures", file=place)
    video = _open_video(place)
    cv2 = opencv()
    stated = float(video.get(cv2.CAP_PROP_FPS))
    count = float(video.get(cv2.CAP_PROP_FRAME_COUNT))
    video.release()
    if rate is None and not (0.0 < stated < 1e5):
        raise InputError("the video does not say its frames per second; add --rate", file=place)
    return Film(place, (), rate or stated, int(count) if 0 < count < MAX_VIDEO_FRAMES else 0)


def read_frames(
    film: Film, interval: float, start: float = 0.0, end: float | None = None
) -> Iterator[Frame]:
    """The frames nearest to start, start + interval, … up to the end, one at a time.

    Args:
        film: what `open_film` found.
        interval: between frames [s]; every frame when it is shorter than one lasts.
        start, end: part of the film [s].

    Raises:
        InputError: a frame cannot be decoded, or is too large, or differs in size from the
            first one; or there is none in this part of the film.
    """
    size: tuple[int, ...] | None = None
    for frame in (
        _pictures(film, interval, start, end)
        if film.pictures
        else _video(film, interval, start, end)
    ):
        if size is not None and frame.image.shape[:2] != size:
            raise InputError(
                f"the picture at {frame.time:g} s has another size than the first one "
                f"({_by(size)})",
                file=film.pictures[frame.index] if film.pictures else film.path,
                value=_by(frame.image.shape[:2]),
            )
        size = frame.image.shape[:2]
        yield frame
    if size is None:
        raise InputError(
            "no frame could be read from this part of the film",
            file=film.path,
            value=f"from {start:g} s" + ("" if end is None else f" to {end:g} s"),
            allowed=f"{film.count} frames at {film.rate:g} per second" if film.count else None,
        )


def opencv() -> Any:
    """The module cv2, with its own messages turned off and its own limits set.

    Raises:
        InputError: it is not installed.
    """
    os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(MAX_PIXELS))
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")
    try:
        import cv2
    except ImportError:
        raise InputError(
            'films are read with OpenCV, which is not installed: pip install "sheetmorph[video]"'
        ) from None
    return cv2


def _wanted(film: Film, interval: float, start: float, end: float | None) -> Iterator[int]:
    """Numbers of the frames to read, rising."""
    if not (interval > 0.0 and np.isfinite(interval)):
        raise InputError(
            "must be above zero", key="--interval", value=interval, allowed='such as "1 s"'
        )
    last = -1
    limit = film.count if film.pictures else MAX_VIDEO_FRAMES
    for k in range(limit):
        time = start + k * interval
        number = round(time * film.rate)
        if (end is not None and time > end + 1e-9) or number >= limit:
            return
        if number > last:
            last = number
            yield number
        elif interval * film.rate < 0.5:  # every frame, without counting to each many times
            yield from range(last + 1, limit if end is None else int(end * film.rate) + 1)
            return


def _pictures(film: Film, interval: float, start: float, end: float | None) -> Iterator[Frame]:
    cv2 = opencv()
    for number in _wanted(film, interval, start, end):
        file = film.pictures[number]
        if file.stat().st_size > MAX_BYTES:
            raise InputError("too large for a picture", file=file, allowed="up to 200 MB")
        try:
            image = cv2.imdecode(np.fromfile(file, dtype=np.uint8), cv2.IMREAD_COLOR)
        except (cv2.error, OSError) as error:
            raise InputError("this picture cannot be read", file=file) from error
        yield Frame(number, number / film.rate, _checked(image, file))


def _video(film: Film, interval: float, start: float, end: float | None) -> Iterator[Frame]:
    video = _open_video(film.path)
    try:
        position = 0
        for number in _wanted(film, interval, start, end):
            while position < number:
                if not video.grab():
                    return
                position += 1
            good, image = video.read()
            if not good:
                return
            position += 1
            yield Frame(number, number / film.rate, _checked(image, film.path))
    finally:
        video.release()


def _open_video(path: Path) -> Any:
    with path.open("rb") as stream:
        head = stream.read(16)
    if not any(head[at : at + len(mark)] == mark for at, mark in _CONTAINERS):
        raise InputError(
            "this file is no video",
            file=path,
            allowed="MP4, MOV, AVI, MKV, WebM, or a folder of pictures",
        )
    cv2 = opencv()
    # FFmpeg alone: other readers of OpenCV take names for patterns, addresses or cameras.
    try:
        video = cv2.VideoCapture(str(path.resolve()), cv2.CAP_FFMPEG)
    except cv2.error as error:
        raise InputError("this video cannot be read", file=path) from error
    width, height = (
        video.get(side) for side in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT)
    )
    if not video.isOpened() or width < 1:
        raise InputError("this video cannot be read; it is damaged or cut off", file=path)
    if max(width, height) > MAX_SIDE:
        video.release()
        raise InputError(
            "the frames are too large",
            file=path,
            value=_by((int(height), int(width))),
            allowed=f"up to {MAX_SIDE} px a side",
        )
    return video


def _checked(image: Any, file: Path) -> Image:
    if image is None or image.ndim != 3 or image.dtype != np.uint8:
        raise InputError("this picture cannot be read; it is damaged or cut off", file=file)
    if max(image.shape) > MAX_SIDE or min(image.shape[:2]) < 8:
        raise InputError(
            "a picture of this size cannot be measured",
            file=file,
            value=_by(image.shape[:2]),
            allowed=f"8 to {MAX_SIDE} px a side",
        )
    return np.asarray(image)


def _by(shape: tuple[int, ...]) -> str:
    return f"{shape[1]} × {shape[0]} px"


def _natural(path: Path) -> list[tuple[int, int, str]]:
    """Numbers in a name count as numbers."""
    parts = re.split(r"([0-9]+)", path.name.lower())
    return [(1, int(part), "") if part.isdigit() else (0, 0, part) for part in parts]
