"""The film: its frames, its times, its size."""

from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from sheetmorph.core.errors import OutputError
from sheetmorph.show import drawn, film


@pytest.fixture(autouse=True)
def without_vtk(monkeypatch):
    monkeypatch.setenv("SHEETMORPH_RENDERER", "drawn")


def filmed(result, folder, frames=None):
    job, actuation = film.film_job(result, frames=frames)
    return film.save_film(result, folder, (drawn.draw(job, view) for view in job.views), actuation)


def test_film(dome_result, tmp_path):
    path = filmed(dome_result, tmp_path)
    assert path == tmp_path / "animation.gif"
    assert path.stat().st_size < film.MAX_BYTES
    with Image.open(path) as image:
        assert image.size == film.SIZE
        assert image.n_frames == film.FRAMES
        assert image.info["loop"] == 0
        times, frames = [], []
        for k in range(image.n_frames):
            image.seek(k)
            times.append(image.info["duration"])
            frames.append(np.asarray(image.convert("RGB"), dtype=float))
    assert times[0] == film.HOLD_FIRST
    assert times[-1] == film.HOLD_LAST
    assert set(times[1:-1]) == {film.FRAME_TIME}
    assert np.all(frames[5][2, :5] == 255)  # the paper is white
    steps = [np.abs(a - b).mean() for a, b in pairwise(frames)]
    assert min(steps) > 0.02
    assert max(steps) < 12


def test_one_state_gives_a_still(small, build, tmp_path):
    mesh, positions, ramp, pattern = small
    result = build(mesh, positions[:1], ramp[:1], np.zeros(1), pattern)
    with Image.open(filmed(result, tmp_path)) as image:
        assert image.n_frames == 1


def test_a_film_that_is_too_large_is_made_smaller(dome_result, tmp_path, monkeypatch):
    size = filmed(dome_result, tmp_path, 4).stat().st_size
    monkeypatch.setattr(film, "MAX_BYTES", size - 1)
    with Image.open(filmed(dome_result, tmp_path, 4)) as image:
        assert image.width < film.SIZE[0]
        assert image.n_frames == 4


def test_a_failure_leaves_the_old_film(dome_result, tmp_path, monkeypatch):
    def disk_full(_):
        raise OSError(28, "No space left on device")

    (tmp_path / "animation.gif").write_bytes(b"old")
    monkeypatch.setattr("os.fsync", disk_full)
    with pytest.raises(OutputError, match=r"animation\.gif"):
        filmed(dome_result, tmp_path, 4)
    assert [path.name for path in tmp_path.iterdir()] == ["animation.gif"]
    assert (tmp_path / "animation.gif").read_bytes() == b"old"
