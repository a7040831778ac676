"""Reading films: what is taken, and what is refused in one sentence."""

from __future__ import annotations

import builtins
from pathlib import Path

import cv2
import numpy as np
import pytest

from rendered_films import write_series, write_video
from sheetmorph.core.errors import InputError
from sheetmorph.measure.frames import open_film, read_frames


def greys(count: int, size: tuple[int, int] = (64, 48)) -> list[np.ndarray]:
    return [np.full((size[1], size[0], 3), 10 + 8 * k, dtype=np.uint8) for k in range(count)]


def levels(path: Path, interval: float = 1.0, rate: float | None = None, **part: float) -> list:
    frames = read_frames(open_film(path, rate), interval, **part)
    return [(frame.index, frame.time, round((frame.image.mean() - 10) / 8)) for frame in frames]


def test_pictures_come_in_natural_order(tmp_path):
    folder = write_series(tmp_path / "oven", greys(12))
    (folder / "notes.txt").write_text("no picture")
    assert levels(folder) == [(k, float(k), k) for k in range(12)]
    assert open_film(folder).name == "oven"


@pytest.mark.parametrize("ending", [".jpg", ".tif"])
def test_other_pictures(tmp_path, ending):
    assert [level for *_, level in levels(write_series(tmp_path / "s", greys(3), ending))] == [
        *(0, 1, 2)
    ]


@pytest.mark.parametrize("name", ["film.mp4", "film.avi"])
def test_videos_are_read_at_an_interval(tmp_path, name):
    film = write_video(tmp_path / name, greys(21), rate=4.0)
    assert open_film(film).rate == pytest.approx(4.0)
    assert levels(film) == [(4 * k, float(k), 4 * k) for k in range(6)]
    assert levels(film, start=1.5, end=2.6) == [(6, 1.5, 6), (10, 2.5, 10)]
    assert len(levels(film, interval=1e-3)) == 21
    assert levels(film, rate=2.0)[1] == (2, 1.0, 2)


def refused(path: Path, words: str, **part: float) -> None:
    with pytest.raises(InputError, match=words) as error:
        list(read_frames(open_film(path), part.pop("interval", 1.0), **part))
    assert "\n" not in str(error.value)


def test_what_is_no_film_is_refused(tmp_path):
    refused(tmp_path / "none.mp4", "no such film")
    (tmp_path / "text.mp4").write_text("#EXTM3U\nhttp://example.org/film.ts\n" * 9)
    refused(tmp_path / "text.mp4", "no video")
    (tmp_path / "empty.avi").write_bytes(b"")
    refused(tmp_path / "empty.avi", "no video")
    (tmp_path / "folder").mkdir()
    refused(tmp_path / "folder", "holds no pictures")
    whole = write_video(tmp_path / "whole.mp4", greys(30, (320, 240))).read_bytes()
    (tmp_path / "cut.mp4").write_bytes(whole[: len(whole) // 2])
    refused(tmp_path / "cut.mp4", "damaged or cut off")
    (tmp_path / "head.avi").write_bytes(b"RIFF\0\0\0\0AVI " + bytes(range(200)))
    refused(tmp_path / "head.avi", "damaged or cut off")


def test_a_cut_avi_gives_what_is_left(tmp_path):
    rng = np.random.default_rng(1)
    noisy = [rng.integers(0, 255, (48, 64, 3), dtype=np.uint8) for _ in range(30)]
    whole = write_video(tmp_path / "whole.avi", noisy).read_bytes()
    (tmp_path / "cut.avi").write_bytes(whole[: len(whole) // 2])
    assert 5 < len(levels(tmp_path / "cut.avi")) < 20


def test_damaged_pictures_are_named(tmp_path):
    folder = write_series(tmp_path / "s", greys(3))
    (folder / "oven 1.png").write_bytes(b"no png")
    refused(folder, "oven 1.png: .*cannot be read")
    cv2.imwrite(str(folder / "oven 1.png"), greys(1, (32, 48))[0])
    refused(folder, "oven 1.png: .*another size .*32 × 48 px")
    cv2.imwrite(str(folder / "oven 0.png"), greys(1, (4, 4))[0])
    refused(folder, "oven 0.png: .*cannot be measured")


def test_a_picture_that_unpacks_to_gigabytes_is_refused(tmp_path):
    import struct
    import zlib

    def chunk(name: bytes, data: bytes) -> bytes:
        code = zlib.crc32(name + data)
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", code)

    head = struct.pack(">IIBBBBB", 30000, 30000, 8, 2, 0, 0, 0)
    data = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"0" * 99))
    (tmp_path / "s").mkdir()
    (tmp_path / "s" / "bomb.png").write_bytes(data + chunk(b"IEND", b""))
    refused(tmp_path / "s", "bomb.png")


def test_bad_options(tmp_path):
    folder = write_series(tmp_path / "s", greys(3))
    refused(folder, "no frame could be read", start=50.0)
    refused(folder, "--interval", interval=0.0)
    for rate in (0.0, -1.0, float("nan")):
        with pytest.raises(InputError, match="--rate"):
            open_film(folder, rate)


def test_without_opencv(tmp_path, monkeypatch):
    folder = write_series(tmp_path / "s", greys(1))
    real = builtins.__import__

    def missing(name, *rest):
        if name == "cv2":
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", missing)
    with pytest.raises(InputError, match=r"sheetmorph\[video\]"):
        open_film(folder)
