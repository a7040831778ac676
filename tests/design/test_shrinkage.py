"""Shrink curves: the built-in one, a user's CSV, and curves that are refused."""

from __future__ import annotations

import numpy as np
import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.design.shrinkage import built_in_curve, parse_curve
from sheetmorph.design.spec import Design

TG = 366.5


def test_polystyrene_is_flat_then_falls_to_a_plateau():
    curve = built_in_curve("polystyrene")
    assert curve.eps_pre(300.0) == 0
    assert curve.eps_pre(TG) == 0
    assert curve.eps_pre(1.2 * TG) == pytest.approx(-0.6, abs=1e-12)
    assert curve.eps_pre(1.15 * TG) == pytest.approx(-0.6, abs=0.02)
    ratios = [curve.length_ratio(t) for t in np.linspace(0.76, 1.39, 500) * TG]
    assert (np.diff(ratios) <= 1e-15).all()
    assert min(ratios) >= 0.4 - 1e-12
    assert max(ratios) <= 1 + 1e-12


def test_a_design_by_temperature(design):
    design = design.with_values({"actuation.temperature": "300 degF"})
    assert design.actuation.eps_pre is None
    assert design.eps_pre == pytest.approx(-0.595, abs=0.01)


def test_beyond_the_curve(design):
    design = design.with_values({"actuation.temperature": "500 degC"})
    with pytest.raises(InputError) as caught:
        _ = design.eps_pre
    message = str(caught.value)
    assert "actuation.temperature" in message
    assert "does not reach 500 degC; allowed: 1.725 degC to 239.95 degC" in message


def test_a_curve_of_ones_own(design, tmp_path):
    (tmp_path / "mine.csv").write_text(
        "# measured\ntemperature [degC], L/L0\n20, 1\n100,0.9\n150,0.5\n"
    )
    text = design.with_values({"actuation.temperature": "100 degC"}).to_toml()
    text = text.replace("[actuation]", '[actuation]\nshrink_curve = "mine.csv"')
    design = Design.from_toml(text, tmp_path)
    assert design.eps_pre == pytest.approx(-0.1, abs=1e-12)
    before = design.hash
    (tmp_path / "mine.csv").write_text("temperature [degC], L/L0\n20, 1\n100,0.8\n150,0.5\n")
    again = Design.from_toml(text, tmp_path)
    assert again.eps_pre == pytest.approx(-0.2, abs=1e-12)
    assert again.hash != before


def test_swelling_curves_work():
    curve = parse_curve("temperature [K], L/L0\n300, 1.0\n400, 1.5\n", "swell")
    assert curve.eps_pre(350.0) == pytest.approx(0.25)


@pytest.mark.parametrize(
    ("text", "fragment"),
    [
        ("", "no header line"),
        ("# only a comment\n", "no header line"),
        ("a, b\n1, 2\n", "line 1: the header is not known"),
        ("temperature [mm], L/L0\n1, 1\n2, 1\n", "line 1: .*not a unit of temperature"),
        ("T/Tg, L/L0\n1, 1\n2, 1\n", 'needs a line "# Tg = 366.5 K"'),
        ("# Tg = hot\nT/Tg, L/L0\n1, 1\n2, 1\n", "write a temperature"),
        ("temperature [K], L/L0\n300, 1\n", "at least two points"),
        ("temperature [K], L/L0\n300, 1\n# x\n300, 0.9\n", "line 4: the temperature must increase"),
        ("temperature [K], L/L0\n300, 1\n310, nan\n", "line 3: not a finite number"),
        ("temperature [K], L/L0\n300, 1\n310, one\n", "line 3: write two numbers"),
        ("temperature [K], L/L0\n300, 1\n310, 1, 2\n", "line 3: write two numbers"),
        ("temperature [K], L/L0\n300, 1\n310, 0.01\n", "line 3: L/L0 is out of range"),
        ("temperature [K], L/L0\n-5, 1\n310, 1\n", "line 2: .*below absolute zero"),
    ],
)
def test_curves_that_are_refused(text, fragment):
    with pytest.raises(InputError, match=fragment) as caught:
        parse_curve(text, "mine")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["../mine.csv", "/etc/passwd.csv", "nylon", "absent.csv"])
def test_curve_names_that_are_refused(design, tmp_path, name):
    text = design.with_values({"actuation.temperature": "100 degC"}).to_toml()
    text = text.replace("[actuation]", f'[actuation]\nshrink_curve = "{name}"')
    with pytest.raises(InputError, match=r"actuation\.shrink_curve"):
        _ = Design.from_toml(text, tmp_path).eps_pre
