"""Cantilever tests: closed forms, the elastica, statistics, readings that are refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ellipk, ellipkinc

from sheetmorph.core.errors import InputError
from sheetmorph.measure.cantilever import (
    GRAVITY,
    evaluate_cantilever,
    parse_cantilever,
    read_cantilever,
)
from sheetmorph.measure.elastica import load_exponent, load_number

EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "materials"
WEIGHT = "length [mm], width [mm], thickness [mm], density [g/cm^3], deflection [mm]\n"
FORCE = "length [mm], width [mm], thickness [mm], force [N], deflection [mm]\n"
ROW = "50, 20, 1, 1.05, 1\n"


def spread(mean: float, deviation: float, count: int = 5) -> np.ndarray:
    """Numbers of exactly this mean and standard deviation (n − 1)."""
    z = np.sin(np.arange(count) * 1.7)
    return mean + deviation * (z - z.mean()) / z.std(ddof=1)


def table(heading: str, *columns: np.ndarray) -> str:
    rows = np.column_stack(np.broadcast_arrays(*columns)).tolist()
    return heading + "".join(", ".join(repr(cell) for cell in row) + "\n" for row in rows)


# Closed forms


def test_self_weight_gives_back_modulus_and_stiffness():
    modulus, length, height = spread(2.60e9, 0.32e9), 0.16, 0.3e-3
    sag = 1050 * GRAVITY * 12 * length**4 / (8 * modulus * height**2)
    text = table(WEIGHT, 1e3 * length, 20.6, 1e3 * height, 1.05, 1e3 * sag)
    result = evaluate_cantilever(parse_cantilever(text))
    assert result.young_modulus == pytest.approx(modulus, rel=1e-12)
    assert result.modulus.mean == pytest.approx(2.60e9, rel=1e-12)
    assert result.modulus.deviation == pytest.approx(0.32e9, rel=1e-10)
    second_moment = 0.0206 * height**3 / 12
    assert result.second_moment.mean == pytest.approx(second_moment, rel=1e-12)
    assert result.stiffness == pytest.approx(8 * modulus * second_moment / length**3, rel=1e-12)


def test_end_load_gives_back_modulus_and_stiffness():
    modulus, length, height, width = spread(2.65e9, 1.58e9), 0.073, 1.8e-3, 0.0143
    second_moment = width * height**3 / 12
    sag = 0.4 * length**3 / (3 * modulus * second_moment)
    text = table(FORCE, 1e3 * length, 1e3 * width, 1e3 * height, 0.4, 1e3 * sag)
    result = evaluate_cantilever(parse_cantilever(text))
    assert result.young_modulus == pytest.approx(modulus, rel=1e-12)
    assert result.modulus.deviation == pytest.approx(1.58e9, rel=1e-10)
    assert result.stiffness == pytest.approx(3 * modulus * second_moment / length**3, rel=1e-12)


def test_the_synthetic_examples_have_the_numbers_that_the_paper_prints():
    before = evaluate_cantilever(read_cantilever(EXAMPLES / "synthetic_self_weight.csv"))
    after = evaluate_cantilever(read_cantilever(EXAMPLES / "synthetic_end_load.csv"))
    for result, modulus, deviation, stiffness, its in (
        (before, 2.60e9, 0.32e9, 0.2357, 0.0016),
        (after, 2.65e9, 1.58e9, 142.0, 52.0),
    ):
        assert result.modulus.mean == pytest.approx(modulus, rel=1e-3)
        assert result.modulus.deviation == pytest.approx(deviation, rel=2e-3)
        assert result.nominal_stiffness.mean == pytest.approx(stiffness, rel=1e-3)
        assert result.nominal_stiffness.deviation == pytest.approx(its, rel=5e-3)
        assert result.modulus.count == 5


def test_what_the_printed_numbers_imply():
    """The paper prints E, K, L and h; I = K L³/(8E) or K L³/(3E) follows, and a width."""
    before = 0.2357 * 0.16**3 / (8 * 2.60e9)
    after = 142 * 0.073**3 / (3 * 2.65e9)
    assert before == pytest.approx(4.64e-14, rel=2e-3)  # printed: ~1e-14
    assert after == pytest.approx(6.95e-12, rel=2e-3)  # printed: ~1e-12
    assert 12 * before / 0.3e-3**3 == pytest.approx(20.6e-3, rel=2e-3)
    assert 12 * after / 1.8e-3**3 == pytest.approx(14.3e-3, rel=2e-3)


# Large deflections


def test_heavy_elastica_of_the_reference(reference):
    table = json.loads((reference / "shell_benchmarks.json").read_text("utf-8"))["heavy_elastica"]
    for number, drop, _reach in table["rows"]:
        if drop < 0.9:
            # The table has six decimals: its first row is known to 4e-5 only.
            rounding = 5.1e-7 / drop * float(load_exponent(drop, "self_weight"))
            wanted = pytest.approx(number, rel=rounding)
            assert float(load_number(drop, "self_weight")) == wanted


def test_end_shear_of_the_reference(reference):
    """Sze's cantilever shears a little (h/L = 0.01), and is printed to four digits."""
    case = json.loads((reference / "shell_benchmarks.json").read_text("utf-8"))[
        "sze_cantilever_endshear"
    ]
    stiffness = case["E"] * case["b"] * case["h"] ** 3 / 12
    drop = np.array(case["W"]) / case["L"]
    number = np.array(case["P"]) * case["Pmax"] * case["L"] ** 2 / stiffness
    assert load_number(drop, "end_load") == pytest.approx(number, rel=1.1e-3)


@pytest.mark.parametrize("slope", [0.05, 0.4, 0.9, 1.25])
def test_end_load_by_elliptic_integrals(slope):
    """√Γ = K(m) − F(φ, m), m = (1 + sin α)/2, sin²φ = 1/(2m) for a tip slope α."""
    m = (1 + np.sin(slope)) / 2
    root = ellipk(m) - ellipkinc(np.arcsin(1 / np.sqrt(2 * m)), m)
    # Energy: θ′²/2 = Γ (sin α − sin θ), so that with E the second kind δ/L is known too; by
    # quadrature of sin θ dθ/θ′ here, after θ = α − t² takes the root away at the tip.
    t, weights = np.polynomial.legendre.leggauss(80)
    t, weights = np.sqrt(slope) * (t + 1) / 2, np.sqrt(slope) * weights / 2
    angle = slope - t**2
    drop = weights @ (np.sin(angle) * 2 * t / np.sqrt(2 * (np.sin(slope) - np.sin(angle)))) / root
    assert float(load_number(drop, "end_load")) == pytest.approx(root**2, rel=1e-6)


@pytest.mark.parametrize(("loading", "factor"), [("self_weight", 8.0), ("end_load", 3.0)])
def test_small_deflections_are_the_limit(loading, factor):
    ratio = np.array([1e-4, 1e-3, 1e-2, 2e-2])
    excess = load_number(ratio, loading) / (factor * ratio) - 1
    assert excess[0] < 1e-7
    slope = np.polyfit(np.log(ratio[1:]), np.log(excess[1:]), 1)[0]
    assert slope == pytest.approx(2.0, abs=0.01)
    numeric = np.log(load_number(0.4001, loading) / load_number(0.3999, loading))
    numeric /= np.log(0.4001 / 0.3999)
    assert float(load_exponent(0.4, loading)) == pytest.approx(float(numeric), rel=1e-6)


def test_the_paper_s_strip_sags_by_more_than_a_quarter():
    """E = 2.60 GPa by the small-deflection formula is 2.45 GPa by the elastica."""
    sag = 1050 * GRAVITY * 12 * 0.16**4 / (8 * 2.60e9 * 0.3e-3**2)
    assert sag == pytest.approx(43.3e-3, abs=1e-4)
    text = table(WEIGHT, np.array([160.0, 160.0]), 20.6, 0.3, 1.05, 1e3 * sag)
    rows = parse_cantilever(text)
    small, exact = (evaluate_cantilever(rows, large_deflection=way) for way in (False, True))
    assert small.modulus.mean == pytest.approx(2.60e9, rel=1e-12)
    assert exact.modulus.mean == pytest.approx(2.446e9, rel=1e-3)
    assert small.overestimate == pytest.approx(0.0630, abs=2e-4)
    assert small.modulus.mean / exact.modulus.mean - 1 == pytest.approx(small.overestimate[0])
    assert "too large by up to 6.3 %" in small.warnings[0]
    assert exact.warnings == ()
    assert exact.nominal_stiffness == small.nominal_stiffness


def test_strips_made_by_the_elastica_give_back_their_modulus():
    drop = np.array([0.05, 0.2, 0.4, 0.7])
    length, width, height, modulus = 0.1, 0.02, 0.4e-3, 3e9
    stiffness = modulus * width * height**3 / 12
    force = load_number(drop, "end_load") * stiffness / length**2
    text = table(FORCE, 1e3 * length, 1e3 * width, 1e3 * height, force, 1e3 * length * drop)
    result = evaluate_cantilever(parse_cantilever(text), large_deflection=True)
    assert result.young_modulus == pytest.approx(np.full(4, modulus), rel=1e-12)


# Uncertainty


@pytest.mark.parametrize("large", [False, True])
@pytest.mark.parametrize(("heading", "load"), [(WEIGHT, "density"), (FORCE, "force")])
def test_uncertainties_are_those_of_finite_differences(heading, load, large):
    units = {"length": "mm", "width": "mm", "thickness": "mm", "deflection": "mm"}
    units[load] = "g/cm^3" if load == "density" else "N"
    values = {"length": 100.0, "width": 20.0, "thickness": 0.5, load: 1.1, "deflection": 30.0}
    errors = {"length": 0.5, "width": 0.2, "thickness": 0.01, load: 0.02, "deflection": 0.4}

    def modulus(changed: dict[str, float]) -> float:
        text = table(heading, *(np.array([changed[key]] * 2) for key in values))
        rows = parse_cantilever(text)
        return float(evaluate_cantilever(rows, large_deflection=large).young_modulus[0])

    squares = 0.0
    for key, error in errors.items():
        step = 1e-4 * values[key]
        up, down = ({**values, key: values[key] + way * step} for way in (1, -1))
        squares += ((modulus(up) - modulus(down)) / (2 * step) * error) ** 2
    more = "".join(f", ± {key} [{units[key]}]" for key in values)
    cells = [np.array([number] * 2) for number in (*values.values(), *errors.values())]
    result = evaluate_cantilever(
        parse_cantilever(table(heading.strip() + more + "\n", *cells)), large_deflection=large
    )
    assert result.modulus_uncertainty == pytest.approx(np.sqrt(squares) * np.ones(2), rel=1e-5)


def test_without_uncertainties_there_is_none():
    assert evaluate_cantilever(parse_cantilever(WEIGHT + 2 * ROW)).modulus_uncertainty is None


# Titles and broken files


def test_other_titles_and_units():
    text = (
        "Sample, Length [cm], width [in], thickness [um], Density [kg/m^3], tip deflection [mm], "
        "+- tip deflection [mm]\na, 5, 0.5, 1000, 1050, 1, 0.1\nb, 5, 0.5, 1000, 1050, 2, 0\n"
    )
    rows = parse_cantilever(text)
    assert rows.samples == ("a", "b")
    assert rows.readings["width"] == pytest.approx([0.0127, 0.0127])
    assert rows.uncertainties["deflection"] == pytest.approx([1e-4, 0.0])


def test_a_thick_strip_is_warned_of():
    result = evaluate_cantilever(parse_cantilever(WEIGHT + 2 * "50, 20, 9, 1.05, 1\n"))
    assert any("shear and the clamp" in warning for warning in result.warnings)


@pytest.mark.parametrize(
    ("text", "fragment"),
    [
        ("", "no line of titles"),
        (WEIGHT, "no rows below"),
        (WEIGHT + ROW, "has one row; a standard deviation needs at least two"),
        (WEIGHT.replace("width [mm], ", "") + 2 * "50, 1, 1.05, 1\n", "there is no column width"),
        (WEIGHT.replace("density [g/cm^3], ", "") + 2 * "5, 2, 1, 1\n", "no column density .* or"),
        (WEIGHT.strip() + ", force [N]\n" + 2 * "50, 20, 1, 1.05, 1, 1\n", "exclude each other"),
        (WEIGHT.replace("[mm]", "", 1) + 2 * ROW, "line 1, column length: write the unit in br"),
        (WEIGHT.replace("[mm]", "[MPa]", 1) + 2 * ROW, "line 1, column length: .*not a unit of l"),
        (WEIGHT.replace("width", "widht") + 2 * ROW, "column widht is not known; did you mean wid"),
        (WEIGHT + ROW + "50, 20, nan, 1.05, 1\n", "line 3, column thickness: write a finite"),
        (WEIGHT + ROW + "50, 20, 1e999, 1.05, 1\n", "line 3, column thickness: is out of range"),
        (WEIGHT + ROW + "50, , 1, 1.05, 1\n", "line 3, column width: the cell is empty"),
        (WEIGHT + ROW + "50, 20, 1, -1.05, 1\n", "line 3, column density: is out of range"),
        (WEIGHT + ROW + "50, 20, 1, 1.05, 0\n", "line 3, column deflection: is out of range"),
        (WEIGHT + ROW + "50, 20, 1, 1.05\n", "line 3: has 4 cells under 5 titles"),
        (WEIGHT + ROW + "50, 20, 1, 1.05, 49\n", "line 3, column deflection: .*the strip hangs"),
        (WEIGHT + ROW * 10_001, "too many rows"),
        (WEIGHT.strip() + ", ± width [mm]\n" + 2 * "5, 2, 1, 1, 1, -1\n", "line 2, column ± width"),
        ("x," * 60 + "\n1\n", "line 1: has too many columns|is no title"),
    ],
)
def test_readings_that_are_refused(text, fragment):
    with pytest.raises(InputError, match=fragment) as caught:
        parse_cantilever(text)
    assert "\n" not in str(caught.value)


def test_files_that_cannot_be_read(tmp_path):
    for name, data, fragment in (
        ("absent.csv", None, "there is no such file"),
        ("bytes.csv", b"\xff\xfe\x00", "UTF-8"),
        ("huge.csv", b"#" * 5_000_001, "too large"),
    ):
        file = tmp_path / name
        if data is not None:
            file.write_bytes(data)
        with pytest.raises(InputError, match=fragment) as caught:
            read_cantilever(file)
        assert name in str(caught.value)
    with pytest.raises(InputError, match="is a folder"):
        read_cantilever(tmp_path)
