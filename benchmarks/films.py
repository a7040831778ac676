"""How far h/d read off films is from the truth: designs, sheets and backdrops, cameras.

    .venv/bin/python benchmarks/films.py [--only TEXT]

Draws 72 films from computed shapes (`tests/rendered_films.py`: noise of 10 grey levels, blur of
2 px, uneven light), reads them as `sheetmorph history FILM` does and prints every film whose h/d
is farther than 3 % and 1 px of h from the truth anywhere from h/d 0.05 on, then how many these
are. The camera's distance is stated, its tilt is found from the film (`--tilt auto`).
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

import sheetmorph as sm
from sheetmorph.design.presets import preset_text
from sheetmorph.measure.camera import shapes_of
from sheetmorph.measure.film import FilmOptions, read_film
from sheetmorph.measure.frames import open_film

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from rendered_films import Oven, film_of, write_video

DESIGNS = ("bowl", "canoe", "petals")
SPOILT = {"noise": 10.0, "blur": 2.0}
LOOKS = {
    "two tones, dark line, light backdrop": {
        "uneven": -25.0,
        "backdrop": (215, 220, 225),
        "ink": "dark",
    },
    "two tones, light line, dark backdrop": {"uneven": 40.0, "ink": "light"},
    "pale, faint line, dark backdrop": {"uneven": 40.0},
}
CAMERAS = (
    (0, 0, 0),
    (5, 0, 0),
    (2, 3, 0),
    (-5, 5, 0),
    (5, 10, 0),
    (0, 0, 6),
    (-5, 5, 6),
    (5, 10, 6),
)
"""Roll and elevation in degrees, distance in widths of the sheet (0: far away)."""
FRAMES = 5


def main() -> None:
    """Draw, read, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", help="films whose name holds this text")
    only = parser.parse_args().only
    results = {n: sm.simulate(sm.Design.from_toml(preset_text(n))) for n in DESIGNS}
    counts: dict[str, list[bool]] = {look: [] for look in LOOKS}
    percents, pixels = [], []
    with tempfile.TemporaryDirectory() as folder:
        for name, result in results.items():
            for look, kind in LOOKS.items():
                for roll, elevation, distance in CAMERAS:
                    film = f"{name}, {look}, roll {roll}°, tilt {elevation}°, {distance} widths"
                    if only not in film:
                        continue
                    oven = Oven(roll=roll, elevation=elevation, distance=distance, **SPOILT, **kind)
                    percent, pixel, fine = errors(result, oven, Path(folder) / "film.mp4")
                    counts[look].append(fine)
                    percents.append(percent)
                    pixels.append(pixel)
                    if not fine or only:
                        print(f"{film}: {np.round(percent, 1)} %, {np.round(pixel, 1)} px of h")
    for look, fine in counts.items():
        print(f"{look}: {sum(fine)} of {len(fine)} within 3 % or 1 px of h")
    worst = [float(np.abs(np.concatenate(rows)).max()) for rows in (percents, pixels)]
    print(f"largest errors of all: {worst[0]:.1f} %, {worst[1]:.1f} px of h")


def errors(result: sm.Result, oven: Oven, path: Path) -> tuple[np.ndarray, np.ndarray, bool]:
    """Errors of h/d in % and in pixels of h from h/d 0.05 on, and whether they are small."""
    filmed = film_of(result, oven, FRAMES)
    write_video(path, filmed.images)
    own = shapes_of(result.positions, result.mesh.triangles)
    options = FilmOptions(
        elevation=None if oven.elevation else 0.0,
        distance=oven.distance * own.flat_width,
        shapes=own,
        thickness=oven.thickness,
    )
    read = read_film(open_film(path), options)
    risen = filmed.ratio > 0.05
    away = (read.ratio - filmed.ratio)[risen]
    percent = 100.0 * away / filmed.ratio[risen]
    pixel = away * (filmed.width / filmed.metre_per_pixel)[risen]
    fine = bool(((np.abs(percent) < 3.0) | (np.abs(pixel) < 1.0)).all())
    return percent, pixel, fine


if __name__ == "__main__":
    main()
