"""Draw the pictures of comparing.md, history.md and calibration.md, of a scan made here.

Run it in the project's environment: .venv/bin/python docs/make_comparison_pictures.py [FOLDER]
FOLDER keeps the files of the examples: the design, its run, the scan, the film, and what the
commands made of them.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import sheetmorph as sm
from sheetmorph.cli import main as sheetmorph
from sheetmorph.core.errors import SheetmorphError
from sheetmorph.design.presets import preset_text

DOCS = Path(__file__).resolve().parent
MADE = {"actuation.eps_pre": -0.46, "layers.1.young_modulus": "3.2 MPa"}
"""In what the sheet that was "scanned" and "filmed" differs from the design of the examples."""

NOISE = 0.2e-3
"""Standard deviation of the points of the scan along their normals [m]."""

UNIT = 25.4e-3
"""The scan is in inches [m]."""

FRAMES = 8
COLOURS = 256
FILM, WIDTH = "history-film.png", 720
PICTURES = {
    "comparison/pictures/overlay.png": "compare-overlay.png",
    "comparison/pictures/distance.png": "compare-distance.png",
    "comparison/pictures/ssim.png": "compare-ssim.png",
    "history/history.png": "history.png",
    "history/films/oven.png": FILM,
    "fit/misfit.png": "calibrate-misfit.png",
}


def main(folder: Path) -> None:
    """Make the scan and the film, run the commands of the pages, keep their pictures."""
    from make_pictures import shrink

    folder.mkdir(parents=True, exist_ok=True)
    (folder / "petals.toml").write_text(preset_text("petals"), encoding="utf-8")
    design = sm.Design.load(folder / "petals.toml")
    sm.simulate(design).save(folder / "petals")
    made = sm.simulate(design.with_values(MADE))
    write_scan(made, folder / "scan.stl")
    write_film(made, folder / "oven.mp4")
    call("compare", "petals", "scan.stl", "-o", "comparison", folder=folder)
    call(
        *("history", "petals", "--film", "oven.mp4", "-o", "history"),
        *("--tilt", "auto", "--thickness", "0.4 mm"),
        folder=folder,
    )
    call(
        *("calibrate", "petals.toml", "--scan", "scan.stl", "--unit", "in", "-o", "fit"),
        *("--fit", "eps_pre=-0.6:-0.3", "--fit", "moduli_ratio=1:10"),
        folder=folder,
    )
    for source, name in PICTURES.items():
        shutil.copyfile(folder / source, DOCS / "pictures" / name)
        if name == FILM:
            narrow(DOCS / "pictures" / name)
        shrink(DOCS / "pictures" / name, COLOURS)


def narrow(path: Path) -> None:
    """Write the picture again with fewer pixels: noise takes room."""
    from PIL import Image

    with Image.open(path) as picture:
        small = picture.convert("RGB").resize(
            (WIDTH, round(WIDTH * picture.height / picture.width)), Image.Resampling.LANCZOS
        )
    small.save(path)


def call(*arguments: str, folder: Path) -> None:
    """A command of the program, whose files lie in the folder."""
    files = ("petals", "petals.toml", "scan.stl", "oven.mp4", "comparison", "history", "fit")
    given = [str(folder / a) if a in files else a for a in arguments[1:]]
    if sheetmorph([arguments[0], *given, "--force"]):
        raise SheetmorphError(f"{arguments[0]} failed")


def write_scan(result: sm.Result, path: Path) -> None:
    """The shape as a scanner shows it: many small triangles, rough, in any pose, in inches."""
    import trimesh
    from scipy.spatial.transform import Rotation

    from sheetmorph.geometry.surface import vertex_normals
    from sheetmorph.geometry.writers import write_stl

    points, triangles = result.positions[-1], result.mesh.triangles
    for _ in range(2):
        points, triangles = trimesh.remesh.subdivide(points, triangles)
    random = np.random.default_rng(1)
    shift = random.normal(0.0, NOISE, (len(points), 1))
    points = points + shift * vertex_normals(points, triangles)
    turn = Rotation.from_quat(random.normal(size=4)).as_matrix()
    write_stl(path, triangles, (points @ turn.T + random.normal(0.0, 0.1, 3)) / UNIT)


def write_film(result: sm.Result, path: Path) -> None:
    """The sheet as a camera sees it that looks down a little: noisy, blurred, not level."""
    sys.path.insert(0, str(DOCS.parent / "tests"))
    import rendered_films

    oven = rendered_films.Oven(roll=2.0, elevation=4.0, noise=8.0, blur=1.5, uneven=30.0)
    rendered_films.write_video(path, rendered_films.film_of(result, oven, FRAMES).images)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(Path(sys.argv[1]))
    else:
        with TemporaryDirectory() as place:
            main(Path(place))
