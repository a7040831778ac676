"""A motion on disk: tables, pictures, film, and the command that writes them."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from PIL import Image

import sheetmorph as sm
from sheetmorph.cli.run import run
from sheetmorph.core.errors import InputError
from sheetmorph.show.motion import time_text
from sheetmorph.show.outputs import run_design
from sheetmorph.study.motion_record import COLUMNS

DESIGN = """
name = "flap"
model = "laminate"
[outline]
kind = "rectangle"
width = "20 mm"
height = "10 mm"
[[layers]]
name = "lower"
role = "active"
thickness = "0.2 mm"
young_modulus = "1 GPa"
density = "1100 kg/m^3"
[[layers]]
name = "upper"
role = "inert"
thickness = "0.2 mm"
young_modulus = "1 GPa"
density = "1100 kg/m^3"
[actuation]
eps_pre = -0.02
profile = "uniform"
[mesh]
size = "4 mm"
[solver]
kind = "dynamic"
[solver.dynamic]
time_step = "1 ms"
damping = "200 1/s"
[solver.dynamic.course]
times = ["0 s", "20 ms", "25 ms"]
actuation = [0, 1, 1]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("motion")
    (place / "flap.toml").write_text(DESIGN, encoding="utf-8")
    called = CliRunner().invoke(run, [str(place / "flap.toml"), "-o", str(place / "out")])
    assert called.exit_code == 0, called.output
    assert re.search(
        r"motion +at rest after 0\.0\d+ s, \d+ steps \(implicit euler\)", called.output
    )
    assert "by the actuation" in called.output
    return place / "out"


def test_the_table_has_a_row_for_every_step(folder: Path) -> None:
    with (folder / "motion.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    told = json.loads((folder / "summary.json").read_text("utf-8"))["motion"]
    assert list(rows[0]) == list(COLUMNS) and len(rows) == told["steps"] + 1
    last = {name: float(value) for name, value in rows[-1].items()}
    works = last["actuation_work_J"] + last["load_work_J"]
    taken = last["damped_J"] + last["numerical_J"]
    assert last["kinetic_J"] + last["elastic_J"] == pytest.approx(works - taken, rel=1e-6)


def test_pictures_and_film_tell_the_time(folder: Path) -> None:
    with Image.open(folder / "pictures" / "energies.png") as picture:
        assert picture.width == 1000 and len(set(picture.convert("L").tobytes())) > 50
    with Image.open(folder / "animation.gif") as film:
        assert film.n_frames >= 40
    page = (folder / "report.html").read_text("utf-8")
    assert "Where the energy of the motion comes from" in page and "Taken by damping" in page
    index = (folder / "series" / "shape.pvd").read_text("utf-8")
    times = [float(text) for text in re.findall(r'timestep="([^"]+)"', index)]
    told = json.loads((folder / "summary.json").read_text("utf-8"))["motion"]
    assert times == sorted(times) and times[0] == 0.0
    assert times[-1] == pytest.approx(told["time_s"])
    assert not (folder / "states").exists()


def test_times_are_told_in_their_unit() -> None:
    told = [time_text(value) for value in (0.0, 2e-6, 3.5e-3, 1.25)]
    assert told == ["t = 0", "t = 2 µs", "t = 3.5 ms", "t = 1.25 s"]


def test_modes_are_those_of_equilibria(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="follows equilibria"):
        run_design(sm.Design.from_toml(DESIGN), tmp_path / "out", modes=2)
