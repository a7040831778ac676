"""Temperatures from shrink curves, and the weight on the glue."""

from __future__ import annotations

import numpy as np
import pytest

from sheetmorph.design.shrinkage import built_in_curve
from sheetmorph.fabricate.oven import (
    PAPER_TEMPERATURE,
    cure_mass,
    degrees,
    oven_setting,
    sentences_of,
)

CURVE = built_in_curve("polystyrene")


def test_the_inverse_undoes_the_curve(bare) -> None:
    def temperature(eps_pre: float) -> float | None:
        return oven_setting(bare.with_values({"actuation.eps_pre": eps_pre})).temperature

    # Up to 99 % of the plateau.
    for eps_pre in np.linspace(-0.5939, -0.001, 40).tolist():
        assert CURVE.eps_pre(temperature(eps_pre)) == pytest.approx(eps_pre, abs=1e-9)
    # At a node of the table: 366.5 K times T/Tg.
    assert temperature(0.705 - 1.0) == pytest.approx(1.075 * 366.5)
    assert temperature(-0.61) is None
    assert temperature(0.1) is None


def test_the_lowest_of_several_temperatures_is_taken(make, tmp_path) -> None:
    (tmp_path / "dip.csv").write_text(
        "temperature [degC], L/L0\n20, 1\n70, 0.8\n120, 0.6\n170, 0.8\n"
    )
    actuation = 'eps_pre = -0.2\nshrink_curve = "dip.csv"'
    setting = oven_setting(make("", actuation=actuation, folder=tmp_path))
    assert setting.temperature == pytest.approx(343.15)


def test_a_design_within_the_curve(make) -> None:
    setting = oven_setting(make("", actuation="eps_pre = -0.3"))
    assert setting.reach == "reached"
    assert CURVE.eps_pre(setting.temperature) == pytest.approx(-0.3)
    step = CURVE.eps_pre(setting.temperature - 0.1) - CURVE.eps_pre(setting.temperature + 0.1)
    assert setting.sensitivity == pytest.approx(step / 0.2, rel=1e-3)
    text = " ".join(sentences_of(setting))
    assert "reaches eps_pre = −0.3 at 121 °C (250 °F)" in text
    assert "steep" in text
    assert "smooth guess" in text


def test_a_design_beyond_the_plateau_is_told_both_numbers(bowl) -> None:
    setting = oven_setting(bowl)
    assert (setting.reach, setting.temperature) == ("beyond", None)
    assert setting.plateau == pytest.approx(-0.6)
    (text,) = sentences_of(setting)
    assert "eps_pre = −0.77" in text
    assert "levels off at −0.6, from 147 °C (297 °F)" in text


def test_designs_that_swell_or_rest_or_name_a_temperature(make, tmp_path) -> None:
    setting = oven_setting(make("", actuation="eps_pre = 0.2"))
    assert setting.reach == "swells"
    assert "swells (eps_pre = +0.2)" in sentences_of(setting)[0]
    assert oven_setting(make("", actuation="eps_pre = 0.0")).reach == "none"
    setting = oven_setting(make("", actuation='temperature = "120 degC"'))
    assert (setting.reach, setting.temperature) == ("given", pytest.approx(393.15))
    assert "names 120 °C (248 °F)" in sentences_of(setting)[0]
    (tmp_path / "gel.csv").write_text("temperature [degC], L/L0\n20, 1\n40, 1.1\n60, 1.5\n")
    actuation = 'eps_pre = 0.1\nshrink_curve = "gel.csv"'
    setting = oven_setting(make("", actuation=actuation, folder=tmp_path))
    assert (setting.reach, setting.temperature) == ("reached", pytest.approx(313.15))
    assert "guess" not in " ".join(sentences_of(setting))


def test_the_numbers_of_the_paper() -> None:
    assert degrees(PAPER_TEMPERATURE) == "149 °C (300 °F)"
    # 680 N/m² on 100 cm² are 6.8 N.
    assert cure_mass(1e-2) == pytest.approx(6.8 / 9.80665)


def test_on_the_plateau_the_oven_is_not_overheated(make) -> None:
    """The end of the built-in curve is no better than where it levels off."""
    almost = oven_setting(make("", actuation="eps_pre = -0.59"))
    full = oven_setting(make("", actuation="eps_pre = -0.6"))
    assert full.reach == "reached"
    assert full.temperature is not None
    assert almost.temperature is not None
    assert almost.temperature < full.temperature < almost.temperature + 3.0
