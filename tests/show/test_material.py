"""Pictures and folders of material data: there, whole, and nobody else's files touched."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from sheetmorph.core.errors import InputError
from sheetmorph.design.shrink_fit import fit_shrinkage
from sheetmorph.design.shrink_rows import parse_shrinkage, read_shrinkage
from sheetmorph.design.shrinkage import parse_curve
from sheetmorph.measure.cantilever import Summary, evaluate_cantilever, parse_cantilever
from sheetmorph.show.material import (
    spread,
    stiff_unit,
    write_cantilever_picture,
    write_shrink_picture,
)
from sheetmorph.show.material_files import (
    SHRINK_FILES,
    cantilever_numbers,
    cantilever_text,
    check_place,
    shrink_numbers,
    write_cantilever_files,
    write_shrink_files,
)

ROWS = Path(__file__).resolve().parents[2] / "examples/materials/synthetic_shrinkage.csv"
HEAD = "sample, length [mm], width [mm], thickness [mm], force [N], deflection [mm]\n"


def check(path: Path) -> None:
    with Image.open(path) as image:
        image.load()
        assert image.format == "PNG"
        assert image.width == 1000
        assert np.asarray(image).std() > 15
        assert image.getpixel((0, 0)) == (255, 255, 255)
        # Nothing runs into the edges.
        edges = np.asarray(image.convert("L"))
        assert edges[:, -6:].min() == 255
        assert edges[-6:].min() == 255


@pytest.mark.parametrize(
    "text",
    [
        "temperature [degC], L/L0\n20, 1\n20, 1\n100, 1.3\n100, 1.32\n",
        "temperature [degC], direction, L/L0\n20, x, 1\n100, y, 0.5\n",
        "# Tg = 366.5 K\ntemperature [degC], L/L0\n20, 1\n100, 1\n",
        "temperature [K], L/L0\n" + "".join(f"{300 + i % 90}, 0.9\n" for i in range(5000)),
    ],
    ids=["swells", "no repeats", "stays", "many"],
)
def test_shrink_pictures(text, tmp_path):
    check(write_shrink_picture(fit_shrinkage(parse_shrinkage(text, "x" * 200)), tmp_path / "a.png"))


@pytest.mark.parametrize(
    "rows",
    [
        ["a, 50, 20, 1, 1, 2", "b, 50, 20, 1, 1, 2"],
        ["W" * 80 + ", 50, 20, 1, 1, 30", "$x_{\\frac$, 50, 20, 1, 1, 20"],
        [f"{i}, 50, 20, 1, {1 + 0.001 * i}, 2" for i in range(400)],
    ],
    ids=["alike", "names", "many"],
)
def test_cantilever_pictures(rows, tmp_path):
    result = evaluate_cantilever(parse_cantilever(HEAD + "\n".join(rows)))
    check(write_cantilever_picture(result, tmp_path / "a.png"))


def test_the_files_of_a_curve(tmp_path):
    fit = fit_shrinkage(read_shrinkage(ROWS))
    paths = write_shrink_files(fit, tmp_path / "film")
    assert tuple(path.name for path in paths) == SHRINK_FILES
    told = json.loads(paths[0].read_text("utf-8"))
    assert told == json.loads(json.dumps(shrink_numbers(fit)))
    assert told["plateau"] == pytest.approx(1.152 * 366.5, rel=1e-3)
    assert told["plateau_eps_pre"] == pytest.approx(-0.6, abs=0.002)
    curve = parse_curve(paths[1].read_text("utf-8"), "curve")
    assert np.array_equal(curve.length_ratios, fit.fitted)
    check(paths[2])


def test_the_files_of_a_cantilever_test(tmp_path):
    rows = parse_cantilever(HEAD + "=1+1, 50, 20, 1, 1, 2\nb, 50, 20, 1, 1, 3\n")
    result = evaluate_cantilever(rows)
    paths = write_cantilever_files(result, tmp_path)
    told = json.loads(paths[0].read_text("utf-8"))
    assert told == json.loads(json.dumps(cantilever_numbers(result)))
    assert told["nominal_stiffness"]["mean"] == pytest.approx((1 / 2e-3 + 1 / 3e-3) / 2)
    lines = paths[1].read_text("utf-8").splitlines()
    assert len(lines) == 3
    assert lines[1].startswith("'=1+1,")
    assert float(lines[2].split(",")[1]) == pytest.approx(result.young_modulus[1], rel=1e-8)
    assert "± E" in cantilever_text(
        evaluate_cantilever(
            parse_cantilever(HEAD.strip() + ", ± force [N]\n" + 2 * "a, 50, 20, 1, 1, 2, 0.1\n")
        )
    )


def test_files_of_others_are_left_alone(tmp_path):
    fit = fit_shrinkage(read_shrinkage(ROWS))
    write_shrink_files(fit, tmp_path)
    (tmp_path / "mine.txt").write_text("mine")
    check_place(tmp_path, SHRINK_FILES, True, ROWS)
    with pytest.raises(InputError, match="--force"):
        check_place(tmp_path, SHRINK_FILES, False, ROWS)
    with pytest.raises(InputError, match="written over"):
        check_place(tmp_path, SHRINK_FILES, True, tmp_path / "curve.csv")
    (tmp_path / "shrink.json").write_text('{"format": "something else"}')
    with pytest.raises(InputError, match="no shrink curve wrote it"):
        check_place(tmp_path, SHRINK_FILES, True, ROWS)
    (tmp_path / "shrink.json").unlink()
    with pytest.raises(InputError, match=r"curve\.csv: .* no shrink curve wrote it"):
        check_place(tmp_path, SHRINK_FILES, True, ROWS)
    with pytest.raises(InputError, match="this is a file"):
        check_place(tmp_path / "mine.txt", SHRINK_FILES, True, ROWS)
    check_place(tmp_path / "new", SHRINK_FILES, False, ROWS)


def test_numbers_as_text():
    assert spread(Summary(2.65e9, 1.58e9, 5), 1e9) == "2.65 ± 1.58"
    assert spread(Summary(2.6e9, 0.32e9, 5), 1e9) == "2.60 ± 0.32"
    assert spread(Summary(0.2357, 0.0016, 5), 1.0) == "0.2357 ± 0.0016"
    assert spread(Summary(142.0, 52.0, 5), 1.0) == "142 ± 52"
    assert spread(Summary(142.0, 0.0, 5), 1.0) == "142 ± 0"
    assert stiff_unit(2.6e9) == (1e9, "GPa")
    assert stiff_unit(2.6e6) == (1e6, "MPa")
