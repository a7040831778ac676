"""Curves fitted to raw rows: monotone, with scatter, used by designs; tables that are refused."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.design.check import describe, format_description
from sheetmorph.design.shrink_fit import fit_shrinkage
from sheetmorph.design.shrink_rows import parse_shrinkage, read_shrinkage
from sheetmorph.design.shrinkage import built_in_curve, curve_text, holds_raw_rows, parse_curve
from sheetmorph.design.spec import Design

TG = 366.5
SYNTHETIC = Path(__file__).resolve().parents[2] / "examples/materials/synthetic_shrinkage.csv"


@cache
def truth() -> dict[float, float]:
    """L/L0 of the built-in curve at 21 T/Tg."""
    curve = built_in_curve("polystyrene")
    return {float(share): curve.length_ratio(share * TG) for share in np.linspace(0.8, 1.3, 21)}


def rows_of(shift: float = 0.0, deviation: float = 0.01, repeats: int = 6, seed: int = 1) -> str:
    """Rows scattered about the built-in curve, those along y `shift` longer."""
    rng = np.random.default_rng(seed)
    lines = ["# Tg = 366.5 K", "T/Tg, direction, L/L0"]
    for share, ratio in truth().items():
        for way, extra in (("x", 0.0), ("y", shift)):
            lengths = ratio + extra + deviation * rng.standard_normal(repeats)
            lines += [f"{share:.6f}, {way}, {length:.6f}" for length in lengths]
    return "\n".join(lines)


def european(text: str) -> str:
    """The text as a spreadsheet writes it where the comma is the decimal sign."""
    return text.replace(",", ";").replace(".", ",").replace("366,5", "366.5")


def test_tables_with_semicolons_and_decimal_commas() -> None:
    text = rows_of()
    assert holds_raw_rows(european(text))
    curves = [fit_shrinkage(parse_shrinkage(one, "a")).curve for one in (text, european(text))]
    assert "0,95" in european(text)
    assert curve_text(curves[0]) == curve_text(curves[1])
    written = curve_text(curves[0])
    assert not holds_raw_rows(european(written))
    np.testing.assert_array_equal(
        parse_curve(european(written), "a").length_ratios, parse_curve(written, "a").length_ratios
    )
    with pytest.raises(InputError, match="line 3: write two numbers with a semicolon"):
        parse_curve("temperature [degC];L/L0\n20;1,0\n30,5\n", "a")


def test_the_fit_is_monotone_and_close_to_the_truth():
    fit = fit_shrinkage(parse_shrinkage(rows_of(), "rows"))
    assert fit.trend == "falls"
    assert (np.diff(fit.fitted) <= 0).all()
    # Twelve rows at each temperature: their mean is off by 0.01/√12, three times that at most.
    assert np.abs(fit.fitted - list(truth().values())).max() < 3.2 * 0.01 / np.sqrt(12)
    assert fit.pooled_deviation == pytest.approx(0.01, rel=0.15)
    assert fit.residual_rms == pytest.approx(0.01, rel=0.15)
    assert fit.onset / TG == pytest.approx(1.0, abs=0.026)
    assert fit.plateau is not None
    assert fit.plateau / TG == pytest.approx(1.15, abs=0.026)
    fine = [fit.curve.length_ratio(t) for t in np.linspace(0.81, 1.29, 400) * TG]
    assert (np.diff(fine) <= 1e-15).all()


def test_isotonic_means_are_pooled_by_their_number_of_rows():
    """Closed form: two means out of order become their mean, weighted by the rows."""
    text = "temperature [degC], L/L0\n20, 1\n50, 0.7\n50, 0.7\n50, 0.7\n80, 0.8\n110, 0.5\n"
    fit = fit_shrinkage(parse_shrinkage(text, "rows"))
    assert fit.fitted == pytest.approx([1.0, 0.725, 0.725, 0.5])
    assert fit.together.counts.tolist() == [1, 3, 1, 1]


def test_scatter_is_that_of_the_rows_or_pooled():
    text = "temperature [K], L/L0\n300, 1\n400, 0.5\n400, 0.7\n500, 0.4\n500, 0.4\n500, 0.4\n"
    fit = fit_shrinkage(parse_shrinkage(text, "rows"))
    two = np.std([0.5, 0.7], ddof=1)
    pooled = np.sqrt((1 * two**2 + 2 * 0.0) / 3)
    assert fit.scatter == pytest.approx([pooled, two, 0.0])
    assert fit.curve.eps_pre_scatter(400.0) == pytest.approx(two)
    assert fit.curve.eps_pre_scatter(450.0) == pytest.approx(two / 2)
    assert fit.residual_rms == pytest.approx(np.sqrt(2 * 0.1**2 / 6))


def test_a_sheet_that_swells_rises():
    text = "temperature [K], L/L0\n300, 1\n310, 1.2\n320, 1.1\n330, 1.4\n330, 1.5\n"
    fit = fit_shrinkage(parse_shrinkage(text, "rows"))
    assert fit.trend == "rises"
    assert fit.fitted == pytest.approx([1.0, 1.15, 1.15, 1.45])
    assert fit.plateau is None


@pytest.mark.parametrize(("shift", "significant"), [(0.0, False), (0.012, True)])
def test_directions_are_compared(shift, significant):
    fit = fit_shrinkage(parse_shrinkage(rows_of(shift), "rows"))
    found = fit.anisotropy
    assert found is not None
    # 21 temperatures, two means of six rows each: 0.01 √(2/6) / √21.
    assert found.standard_error == pytest.approx(0.01 * np.sqrt(2 / 6 / 21), rel=0.15)
    assert found.difference == pytest.approx(-shift, abs=3.5 * found.standard_error)
    assert found.significant is significant
    assert ("within the scatter" in fit.anisotropy_text) is not significant
    assert set(fit.by_direction) == {"x", "y"}


def test_equal_directions_are_rarely_called_different():
    """At 5 % significance about one in twenty random tables is called anisotropic."""
    calls = [
        fit_shrinkage(parse_shrinkage(rows_of(repeats=2, seed=seed), "rows")).anisotropy
        for seed in range(60)
    ]
    assert 0 < sum(bool(call and call.significant) for call in calls) < 9


def test_directions_without_repeats_are_not_judged():
    text = "temperature [K], direction, L/L0\n300,x,1\n300,y,1\n400,x,0.5\n400,y,0.52\n"
    fit = fit_shrinkage(parse_shrinkage(text, "rows"))
    assert fit.anisotropy is not None
    assert fit.anisotropy.significant is None
    assert fit.anisotropy.largest == pytest.approx(-0.02)
    assert "1 % of L0" in fit.anisotropy_text
    assert "without repeats" in fit.anisotropy_text


def test_lengths_and_units_and_any_order():
    ratio = "temperature [degC], L/L0\n20, 1\n150, 0.5\n150, 0.4\n"
    lengths = (
        "L0 [cm], sample, L [mm], temperature [K], note\n"
        "4, a, 20, 423.15, first\n5, b, 20, 423.15, \n4, c, 40, 293.15, cold\n"
    )
    percent = "temperature [degF], L/L0 [%]\n68, 100\n302, 50\n302, 40\n"
    fits = [fit_shrinkage(parse_shrinkage(text, "rows")) for text in (ratio, lengths, percent)]
    for fit in fits[1:]:
        assert fit.temperatures == pytest.approx(fits[0].temperatures, rel=1e-12)
        assert fit.fitted == pytest.approx(fits[0].fitted, rel=1e-12)


def test_readings_half_a_kelvin_apart_are_repeats():
    text = "temperature [degC], L/L0\n99.8, 0.9\n100.2, 0.8\n20, 1\n"
    fit = fit_shrinkage(parse_shrinkage(text, "rows"))
    assert fit.temperatures == pytest.approx([293.15, 373.15])
    assert fit.together.counts.tolist() == [1, 2]


def test_a_curve_file_reads_back_the_same_curve():
    curve = fit_shrinkage(parse_shrinkage(rows_of(), "rows")).curve
    text = curve_text(curve, ("Tg = 366.5 K",))
    assert not holds_raw_rows(text)
    again = parse_curve(text, "curve")
    assert np.array_equal(again.temperatures, curve.temperatures)
    assert np.array_equal(again.length_ratios, curve.length_ratios)
    assert curve.scatter is not None
    assert np.array_equal(again.scatter, curve.scatter)


def by_temperature(base: str, folder: Path, heat: str, text: str) -> Design:
    (folder / "raw.csv").write_text(text)
    base = base.replace(
        "eps_pre = -0.3 # free shrinkage", f'temperature = "{heat}"\nshrink_curve = "raw.csv"'
    )
    return Design.from_toml(base, folder)


def test_a_design_names_raw_rows(base, tmp_path):
    text = SYNTHETIC.read_text("utf-8")
    fit = fit_shrinkage(read_shrinkage(SYNTHETIC))
    design = by_temperature(base, tmp_path, "149 degC", text)
    assert design.eps_pre == fit.curve.eps_pre(149 + 273.15)
    assert design.eps_pre == pytest.approx(-0.595, abs=0.005)
    report = describe(design)
    assert report["actuation"]["eps_pre_scatter"] == pytest.approx(0.0026, abs=0.0003)
    assert "eps_pre -0.5953 ± 0.0026 at 149 °C" in format_description(report)
    other = by_temperature(base, tmp_path, "149 degC", text + "149, x, S4, 50, 20.5\n")
    assert other.hash != design.hash
    # What material shrink writes gives the same design.
    curve = by_temperature(base, tmp_path, "149 degC", curve_text(fit.curve))
    assert curve.eps_pre == design.eps_pre
    assert curve.eps_pre_scatter == design.eps_pre_scatter


def test_beyond_the_rows_is_an_error(base, tmp_path):
    """Below the lowest temperature nothing is assumed, not even that the length stays."""
    design = by_temperature(base, tmp_path, "20 degC", SYNTHETIC.read_text("utf-8"))
    with pytest.raises(InputError, match="does not reach 20 degC; allowed: 25 degC to 175 degC"):
        _ = design.eps_pre


def test_a_broken_raw_file_is_named_in_a_design(base, tmp_path):
    text = "temperature [degC], direction, L/L0\n20, x, 1\n30, z, 0.9\n"
    design = by_temperature(base, tmp_path, "25 degC", text)
    with pytest.raises(InputError, match=r"raw\.csv: line 3, column direction: is no direction"):
        _ = design.eps_pre


HEAD = "temperature [degC], sample, L/L0\n"


@pytest.mark.parametrize(
    ("text", "fragment"),
    [
        ("", "no line of titles"),
        (HEAD, "no rows below the titles in line 1"),
        ("sample, L/L0\na, 1\n", "line 1: there is no column temperature"),
        ("temperature [degC], sample\n20, a\n", "line 1: there is no column L/L0"),
        ("temperature [degC], L [mm], note\n20, 5, a\n", "line 1: there is no column L0"),
        ("temperature, L/L0, note\n20, 1, a\n", "line 1, column temperature: write the unit"),
        ("temperature [mm], L/L0, note\n20, 1, a\n", "line 1, column temperature: .*not a unit"),
        ("temperature [degC], lenght, L/L0\n20, 1, 1\n", "line 1: the column lenght is not known"),
        ("temperature [degC], L/L0, L/L0\n20, 1, 1\n", "line 1: .* is there twice"),
        ("temperature [degC]; L/L0; x\n20; 1; 1\n", "line 1: the column x is not known"),
        ("T/Tg, sample, L/L0\n1, a, 1\n", 'needs a line "# Tg = 366.5 K"'),
        ("# Tg = hot\n" + HEAD + "20, a, 1\n", "the comment # Tg = …: write a temperature"),
        (HEAD + "20, a, 1\n\n# x\n30, a, nan\n", "line 5, column L/L0: write a finite number"),
        (HEAD + "20, a, 1\n30, a, inf\n", "line 3, column L/L0: write a finite number"),
        (HEAD + "20, a, 1\n30, a,\n", "line 3, column L/L0: the cell is empty"),
        (HEAD + "20, a, 1\n30, a\n", "line 3: has 2 cells under 3 titles"),
        (HEAD + "20, a, 1\n30, a, -0.9\n", "line 3, column L/L0: is out of range"),
        (HEAD + "-300, a, 1\n30, a, 1\n", "line 2, column temperature: is out of range"),
        (HEAD + "20, a, 1\n", "at least two temperatures"),
        (HEAD + "20, a, 1\n20.1, a, 1\n", "at least two temperatures"),
        ("temperature [K], L [mm], L0 [mm]\n300, 5, 1\n", "line 2, columns L and L0: .*range"),
        (HEAD + "20, a, 1\n" * 100_001, "too many rows"),
    ],
)
def test_rows_that_are_refused(text, fragment):
    with pytest.raises(InputError, match=fragment) as caught:
        fit_shrinkage(parse_shrinkage(text, "rows"))
    assert "\n" not in str(caught.value)


def test_many_rows_are_fitted_in_a_moment():
    rng = np.random.default_rng(0)
    heat = rng.uniform(20, 180, 50_000)
    text = "temperature [degC], L/L0\n" + "\n".join(f"{t:.2f}, {1 - t / 400:.4f}" for t in heat)
    fit = fit_shrinkage(parse_shrinkage(text, "rows"))
    assert len(fit.temperatures) < 330
    assert fit.fitted == pytest.approx(1 - (fit.temperatures - 273.15) / 400, abs=1e-3)
