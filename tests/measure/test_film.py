"""h/d of rendered films against the shapes they were rendered from, within 3 %."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

import sheetmorph as sm
from rendered_films import Oven, film_of, write_series, write_video
from sheetmorph.core.errors import InputError
from sheetmorph.design.presets import preset_text
from sheetmorph.measure.camera import Shapes, caps, shapes_of
from sheetmorph.measure.film import FilmOptions, read_film
from sheetmorph.measure.film_history import read_table
from sheetmorph.measure.frames import open_film
from sheetmorph.measure.side_view import Reference
from sheetmorph.measure.silhouette import MaskOptions

SMALL = (400, 300)
REAL = {"noise": 10.0, "blur": 2.0, "uneven": 40.0}
LIGHT = {"noise": 10.0, "blur": 2.0, "uneven": -25.0, "backdrop": (215, 220, 225), "ink": "dark"}
TWO_TONE = {**REAL, "ink": "light"}
OTHER = {"actuation.eps_pre": -0.5}
NAMES = ("bowl", "canoe", "petals")


@lru_cache
def result_of(name: str):
    return sm.simulate(sm.Design.from_toml(preset_text(name)))


@lru_cache
def changed_bowl():
    """The same drawing, shrunk less: it ends far from where the film does."""
    text = preset_text("bowl")
    return sm.simulate(sm.Design.from_toml(text).with_values(OTHER))


def measured(result, oven: Oven, path, frames: int, **options):
    filmed = film_of(result, oven, frames)
    film = write_video(path / "film.mp4", filmed.images)
    return filmed, read_film(open_film(film), FilmOptions(**options))


def with_shapes(result, oven: Oven, shapes: Shapes | None = None) -> dict:
    """Options for a camera whose distance is known, and its tilt not if it has one."""
    own = shapes_of(result.positions, result.mesh.triangles)
    return {
        "elevation": None if oven.elevation else 0.0,
        "distance": oven.distance * own.flat_width,
        "shapes": own if shapes is None else Shapes(shapes.positions, own.outline),
        "thickness": oven.thickness,
    }


def assert_within_3_percent(filmed, film, pixels: float = 1.0) -> None:
    """3 % of h/d from h/d 0.05 on, or some pixels of h where that is more."""
    risen = filmed.ratio > 0.05
    pixel = filmed.metre_per_pixel / filmed.width
    assert film.good[risen].all()
    error = (film.ratio - filmed.ratio)[risen]
    tolerance = np.maximum(0.03 * filmed.ratio, pixels * pixel)[risen]
    assert (abs(error) < tolerance).all(), (
        100 * error / filmed.ratio[risen],
        error / pixel[risen],
    )


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
    filmed, film = measured(result, oven, tmp_path, 5, **with_shapes(result, oven))
    assert_within_3_percent(filmed, film)
    assert np.degrees(film.elevation) == pytest.approx(5.0, abs=0.4)
    assert np.degrees(film.roll) == pytest.approx(-4.0, abs=0.2)
    assert (film.seen[1:] > 1.05 * filmed.ratio[1:]).any()  # there was something to correct


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    "oven",
    [Oven(**REAL), Oven(roll=2.0, elevation=3.0, **REAL), Oven(distance=6.0, **REAL)],
    ids=["level", "3°", "near"],
)
def test_a_pale_sheet_before_a_dark_backdrop(name, oven, tmp_path):
    """Its rim is hardly lighter than the backdrop: 2 px of h are left to it."""
    result = result_of(name)
    filmed, film = measured(result, oven, tmp_path, 5, **with_shapes(result, oven))
    assert_within_3_percent(filmed, film, 2.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    "oven",
    [
        *(Oven(roll=5.0, **LIGHT), Oven(roll=-5.0, elevation=5.0, **LIGHT)),
        *(Oven(roll=5.0, elevation=10.0, **LIGHT), Oven(distance=6.0, **LIGHT)),
        Oven(roll=-5.0, elevation=5.0, distance=6.0, **LIGHT),
    ],
    ids=["rolled", "5°", "10°", "near", "5°, near"],
)
def test_two_tones_with_a_dark_line_before_a_light_backdrop(name, oven, tmp_path):
    result = result_of(name)
    filmed, film = measured(result, oven, tmp_path, 5, **with_shapes(result, oven))
    assert_within_3_percent(filmed, film)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "oven"),
    [
        ("bowl", Oven(roll=5.0, elevation=10.0, **TWO_TONE)),
        ("canoe", Oven(roll=2.0, elevation=3.0, **TWO_TONE)),
        ("petals", Oven(roll=5.0, elevation=10.0, distance=6.0, **TWO_TONE)),
    ],
)
def test_two_tones_with_a_light_line_before_a_dark_backdrop(name, oven, tmp_path):
    result = result_of(name)
    filmed, film = measured(result, oven, tmp_path, 5, **with_shapes(result, oven))
    assert_within_3_percent(filmed, film)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "oven"),
    [
        ("canoe", Oven(roll=5.0, elevation=10.0, **REAL)),
        ("bowl", Oven(roll=-5.0, elevation=5.0, **TWO_TONE)),
    ],
)
def test_what_hardly_differs_from_the_backdrop_is_measured_worse(name, oven, tmp_path):
    """Tips with a rim as dark as the backdrop, a stripe of its colour along the lowest edge."""
    result = result_of(name)
    filmed, film = measured(result, oven, tmp_path, 5, **with_shapes(result, oven))
    error = film.ratio[1:] / filmed.ratio[1:] - 1.0
    assert (abs(error) < 0.07).all(), error


@pytest.mark.slow
def test_other_shapes_correct_a_film_as_well_and_pull_it_nowhere(tmp_path):
    """A sheet that closes to h/d 0.46, corrected by one that ends at h/d 0.7, and by caps.

    By other shapes the correction is wrong; by a run of the same drawing with other layers that
    is hardly so, though its h/d at the same load is another.
    """
    bowl = result_of("bowl")
    other = changed_bowl()
    oven = Oven(roll=-5.0, elevation=5.0, distance=6.0, **LIGHT)
    options = with_shapes(bowl, oven)
    filmed, own = measured(bowl, oven, tmp_path, 5, **options)
    film = open_film(tmp_path / "film.mp4")
    true = filmed.ratio[1:]
    assert abs(other.aspect_ratio[-1] / bowl.aspect_ratio[-1] - 1.0) > 0.15
    shapes = shapes_of(other.positions, other.mesh.triangles)
    alike = read_film(film, FilmOptions(**{**options, "shapes": shapes}))
    assert_within_3_percent(filmed, alike, 2.0)
    flat = options["shapes"]
    stretched = caps(flat.flat_width, flat.flat_depth)
    capped = read_film(film, FilmOptions(**with_shapes(bowl, oven, stretched)))
    assert (abs(capped.ratio[1:] / true - 1.0) < 0.06).all(), capped.ratio[1:] / true
    # Not corrected at all: what is at stake.
    assert (own.seen[1:] / true > 1.07).all()


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
