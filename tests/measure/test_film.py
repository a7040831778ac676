"""h/d of rendered films against the shapes they were rendered from, within 3 %."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

import sheetmorph as sm
from rendered_films import Oven, film_of, write_series, write_video
from sheetmorph.core.errors import InputError
from sheetmorph.design.presets import preset_text
from sheetmorph.measure.film import FilmOptions, read_film
from sheetmorph.measure.film_history import read_table
from sheetmorph.measure.frames import open_film
from sheetmorph.measure.side_view import Reference, tilt_shape
from sheetmorph.measure.silhouette import MaskOptions

SMALL = (400, 300)
REAL = {"noise": 10.0, "blur": 2.0, "uneven": 40.0}
LIGHT = {
    "noise": 10.0,
    "blur": 2.0,
    "uneven": -25.0,
    "backdrop": (215, 220, 225),
    "thickness": 0.8e-3,
}


@lru_cache
def result_of(name: str):
    return sm.simulate(sm.Design.from_toml(preset_text(name)))


def measured(result, oven: Oven, path, frames: int, **options):
    filmed = film_of(result, oven, frames)
    film = write_video(path / "film.mp4", filmed.images)
    return filmed, read_film(open_film(film), FilmOptions(**options))


def with_run(result, oven: Oven) -> dict:
    """Options for a camera that looks down by an angle that nobody knows."""
    return {
        "elevation": None,
        "shape": lambda angle: tilt_shape(result.positions, angle),
        "depth": tilt_shape(result.positions, 0.0).depth,
        "thickness": oven.thickness,
        "flat_width": float(np.ptp(result.positions[0, :, 0])),
    }


def assert_within_3_percent(filmed, film) -> None:
    """3 % of h/d, or a pixel at each of the two edges where that is more.

    Below h/d 0.05 5 px: what a blur of 2 px makes of the edge of a flat sheet of 2 to 4 px.
    """
    risen = filmed.ratio > 0.05
    pixel = filmed.metre_per_pixel / filmed.width
    tolerance = np.where(risen, np.maximum(0.03 * filmed.ratio, 2 * pixel), 5 * pixel)
    assert film.good[risen].all()
    error = abs(film.ratio - filmed.ratio)[film.good]
    assert (error < tolerance[film.good]).all(), 100 * (film.ratio / filmed.ratio - 1)


def test_a_level_camera(tmp_path):
    result = result_of("bowl")
    oven = Oven(roll=5.0, **REAL)
    filmed = film_of(result, oven, 5)
    folder = write_series(tmp_path / "oven", filmed.images)
    x = 100 + 0.05 / filmed.metre_per_pixel
    film = read_film(
        open_film(folder, 0.5), FilmOptions(interval=2.0, reference=Reference(0.05, (100, 9, x, 9)))
    )
    assert_within_3_percent(filmed, film)
    assert np.degrees(film.roll) == pytest.approx(5.0, abs=0.4)
    assert film.time.tolist() == [0, 2, 4, 6, 8]
    scale = film.metre_per_pixel
    np.testing.assert_allclose(scale * film.width[2:], filmed.width[2:], rtol=0.02)
    np.testing.assert_allclose(scale * film.height[2:], filmed.height[2:], rtol=0.03, atol=5e-4)
    assert film.notes == ()
    # The table comes back as it was written.
    (tmp_path / "film.csv").write_text(film.to_csv())
    again = read_table(tmp_path / "film.csv")
    np.testing.assert_allclose(again.ratio, film.ratio, atol=1e-5)
    np.testing.assert_array_equal(again.good, film.good)
    assert again.metre_per_pixel == pytest.approx(scale, rel=1e-3)


def test_a_tilted_camera(tmp_path):
    result = result_of("petals")
    oven = Oven(roll=-4.0, elevation=5.0, **REAL)
    filmed, film = measured(result, oven, tmp_path, 5, **with_run(result, oven))
    assert_within_3_percent(filmed, film)
    assert np.degrees(film.elevation) == pytest.approx(5.0, abs=0.4)
    assert np.degrees(film.roll) == pytest.approx(-4.0, abs=0.2)
    assert (film.seen[1:] > 1.05 * filmed.ratio[1:]).any()  # there was something to correct


@pytest.mark.slow
@pytest.mark.parametrize("name", ["bowl", "canoe", "petals"])
@pytest.mark.parametrize(
    "oven",
    [
        *(Oven(**REAL), Oven(roll=-5.0, **LIGHT), Oven(roll=2.0, elevation=3.0, **REAL)),
        *(Oven(roll=5.0, elevation=5.0, **REAL), Oven(roll=-5.0, elevation=5.0, **LIGHT)),
    ],
    ids=["level", "rolled, light", "3°", "5°", "5°, light"],
)
def test_presets(name, oven, tmp_path):
    result = result_of(name)
    options = with_run(result, oven) if oven.elevation else {}
    filmed, film = measured(result, oven, tmp_path, 5, **options)
    assert_within_3_percent(filmed, film)


@pytest.mark.slow
def test_a_dark_line_along_the_rim_widens_the_sheet_by_the_blur(tmp_path):
    """An edge is put at half of the contrast beside it; beside a blurred line that is outside."""
    filmed, film = measured(result_of("bowl"), Oven(roll=-5.0, ink=True, **LIGHT), tmp_path, 5)
    excess = film.height - filmed.height / filmed.metre_per_pixel
    assert (excess[1:] > 1.5).all() and (excess[1:] < 3.0).all(), excess


@pytest.mark.slow
def test_a_camera_that_is_said_to_be_level_but_is_not(tmp_path):
    result = result_of("bowl")
    filmed, film = measured(result, Oven(elevation=6.0), tmp_path, 3)
    assert film.ratio[-1] > 1.08 * filmed.ratio[-1]
    assert "add --tilt auto" in film.notes[0] and "looks down by 6" in film.notes[0]
    capped = read_film(open_film(tmp_path / "film.mp4"), FilmOptions(elevation=np.radians(6.0)))
    assert capped.ratio[-1] == pytest.approx(filmed.ratio[-1], rel=0.03)


def test_a_hand_and_an_empty_frame_are_flagged(tmp_path):
    filmed = film_of(
        result_of("bowl"), Oven(roll=2.0, elevation=4.0, noise=5.0, blur=1.0), 8, SMALL
    )
    filmed.images[4][40:190, 190:350] = (150, 170, 200)
    filmed.images[6][:] = 60
    film = read_film(open_film(write_series(tmp_path / "s", filmed.images)), FilmOptions())
    assert "jump" in film.flags[4]
    assert film.flags[6] == ("nothing found",)
    assert np.isnan(film.ratio[6])
    assert film.good.tolist() == [k not in (4, 6) for k in range(8)]
    rows = film.to_csv().splitlines()
    assert rows[7].startswith("6,6,,,,,,,") and rows[7].endswith("nothing found")
    assert len(film.shots) == 8 and film.shots[6].outline.shape == (0, 2)


def test_a_film_without_a_sheet_is_refused(tmp_path):
    rng = np.random.default_rng(0)
    noise = [rng.normal(90, 8, (120, 160, 3)).astype(np.uint8) for _ in range(3)]
    folder = write_series(tmp_path / "s", noise)
    with pytest.raises(InputError, match="found in no frame"):
        read_film(open_film(folder), FilmOptions())
    with pytest.raises(InputError, match="--region"):
        read_film(open_film(folder), FilmOptions(mask=MaskOptions(region=(0, 0, 500, 20))))


def test_a_sheet_that_is_not_flat_at_first(tmp_path):
    filmed = film_of(result_of("bowl"), Oven(noise=5.0, blur=1.0), 5, SMALL)
    folder = write_series(tmp_path / "s", filmed.images[3:])
    assert "give --roll" in read_film(open_film(folder), FilmOptions()).notes[0]
    with pytest.raises(InputError, match="--tilt"):
        read_film(open_film(folder), FilmOptions(elevation=None))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a,b\n1,2\n", "columns time_s and h_over_d"),
        ("", "columns time_s and h_over_d"),
        ("time_s,h_over_d\n1,high\n", "line 2, h_over_d: this is no number"),
        ("time_s,h_over_d\n,0.2\n", "a time is missing"),
    ],
)
def test_bad_tables(tmp_path, text, words):
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(InputError, match=words):
        read_table(tmp_path / "t.csv")


def test_a_table_typed_by_hand(tmp_path):
    (tmp_path / "t.csv").write_text("time_s,h_over_d\n0,0.0\n1,0.2\n2,\n3,0.5\n")
    table = read_table(tmp_path / "t.csv")
    assert table.good.tolist() == [True, True, False, True]
    assert table.metre_per_pixel is None and table.name == "t"
