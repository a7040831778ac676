"""The plot of h/d and the frames with their outlines."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from sheetmorph.measure.film_history import FilmHistory, Shot
from sheetmorph.show.film_frames import write_frames
from sheetmorph.show.history import write_history
from sheetmorph.study.history import RunHistory, history_of, mean_csv, mean_of, runs_csv


def film(
    name: str = "oven", speed: float = 0.1, count: int = 8, flag: int | None = 5
) -> FilmHistory:
    time = np.arange(count, dtype=float)
    flags = tuple(("jump",) if k == flag else () for k in range(count))
    ratio = speed * time
    grey = np.full((90, 120, 3), 90, dtype=np.uint8)
    turn = np.linspace(0, 2 * np.pi, 60)
    ring = np.stack([60 + 40 * np.cos(turn), 45 + 20 * np.sin(turn)], axis=1)
    shots = tuple(Shot(k, grey, ring if k else np.empty((0, 2))) for k in range(count))
    width = np.full(count, 300.0)
    return FilmHistory(
        name, np.arange(count), time, ratio, ratio, ratio * width, width, width, flags, shots=shots
    )


@pytest.fixture
def run(dome_result) -> RunHistory:
    return history_of(dome_result, "dome")


def test_history_of_a_run(dome_result, run):
    x = dome_result.positions
    np.testing.assert_allclose(run.ratio("x"), np.ptp(x[..., 2], 1) / np.ptp(x[..., 0], 1))
    np.testing.assert_allclose(run.widths["side"], run.widths["x"])
    assert (run.widths["feret_min"] <= run.widths["y"] * (1 + 1e-9)).all()
    assert (run.widths["feret_max"] >= run.widths["x"] * (1 - 1e-9)).all()
    turned = history_of(dome_result, "dome", azimuth=np.pi / 2)
    np.testing.assert_allclose(turned.widths["side"], run.widths["y"])
    lines = runs_csv([run, turned]).splitlines()
    assert len(lines) == 1 + 2 * len(x)
    head = lines[0].split(",")
    last = dict(zip(head, lines[len(x)].split(","), strict=True))
    assert float(last["h_over_d_feret_max"]) == pytest.approx(run.ratio("feret_max")[-1], abs=1e-5)
    assert float(last["actuation"]) == pytest.approx(-0.3)
    assert lines[1].split(",")[2] == "0"


def test_mean_of_films():
    mean = mean_of([film(speed=0.1), film(speed=0.2, count=5, flag=None)], 1.0)
    assert mean.count.tolist() == [2, 2, 2, 2, 2, 1, 1, 1]
    np.testing.assert_allclose(mean.mean[:5], 0.15 * np.arange(5))
    np.testing.assert_allclose(mean.mean[5:], 0.1 * np.arange(5, 8))  # across the flagged frame
    np.testing.assert_allclose(mean.deviation[:5], 0.1 * np.arange(5) / np.sqrt(2))
    assert np.isnan(mean.deviation[5:]).all()
    assert mean_csv(mean).splitlines()[-1] == "7,0.70000,,1"


@pytest.mark.parametrize("films", [0, 1, 3])
@pytest.mark.parametrize("runs", [0, 1, 2])
def test_every_mixture_is_drawn(run, tmp_path, runs, films):
    if not runs + films:
        pytest.skip("nothing to draw")
    filmed = [film(f"film {k}", 0.08 + 0.01 * k) for k in range(films)]
    computed = [replace(run, name=f"run {k}") for k in range(runs)]
    mean = mean_of(filmed, 1.0) if films else None
    path = write_history(tmp_path / "h.png", computed, filmed, mean, "side")
    with Image.open(path) as picture:
        assert picture.size == (1200, 700)
        left = np.asarray(picture)[130:560, 110:600]
        right = np.asarray(picture)[130:560, 660:1160]
    assert (left < 100).any() or (left.std() > 5)
    assert right.std() > 5


def test_a_film_without_a_good_frame_and_a_flat_run_are_drawn(run, tmp_path):
    lost = film(flag=None)
    lost = replace(lost, flags=(("nothing found",),) * 8, ratio=np.full(8, np.nan))
    flat = replace(run, height=0.0 * run.height)
    write_history(tmp_path / "h.png", [flat], [lost], None, "x")


def test_frames_show_their_outline(tmp_path):
    path = write_frames(film(), tmp_path / "f.png")
    with Image.open(path) as picture:
        pixels = np.asarray(picture).astype(int)
    pink = (abs(pixels - [255, 46, 166]).sum(axis=2) < 40).sum()
    red = (abs(pixels - [200, 16, 46]).sum(axis=2) < 40).sum()
    assert pink > 7 * 100
    assert red > 10  # the flag


def test_a_long_film_shows_twelve_frames(tmp_path):
    with Image.open(write_frames(film(count=40), tmp_path / "f.png")) as picture:
        long = picture.size
    with Image.open(write_frames(film(count=12), tmp_path / "g.png")) as picture:
        assert picture.size == long
