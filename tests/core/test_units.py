"""Quantities from the outside: exact conversion, and text that is refused at once."""

from __future__ import annotations

import subprocess
import sys
import time

import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.core.units import KINDS, format_si, scale_of, to_si


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("0.3 mm", "length", 3e-4),
        ("5.9mm", "length", 0.0059),
        ("  12 um ", "length", 1.2e-5),
        ("12 µm", "length", 1.2e-5),
        ("1e-3 m", "length", 1e-3),
        ("1 in", "length", 0.0254),
        ("-2.5 cm", "length", -0.025),
        ("−2.5 cm", "length", -0.025),
        ("0.9 MPa", "pressure", 9e5),
        ("2.6 GPa", "pressure", 2.6e9),
        ("1 N/mm^2", "pressure", 1e6),
        ("1 N/mm²", "pressure", 1e6),
        ("1050 kg/m^3", "density", 1050.0),
        ("1.05 g/cm³", "density", 1050.0),
        ("9.81e-7 N", "force", 9.81e-7),
        ("1 kg*m/s**2", "force", 1.0),
        ("1 mN", "force", 1e-3),
        ("150 degC", "temperature", 423.15),
        ("150 °C", "temperature", 423.15),
        ("32 degF", "temperature", 273.15),
        ("366.5 K", "temperature", 366.5),
        ("180 deg", "angle", 3.141592653589793),
        ("60°", "angle", 1.0471975511965979),
        ("5 min", "time", 300.0),
        ("0.33", "dimensionless", 0.33),
        (0.33, "dimensionless", 0.33),
        (2, "dimensionless", 2.0),
        ("-30 %", "dimensionless", -0.3),
    ],
)
def test_converts_exactly(text, kind, value):
    assert to_si(text, kind) == value


def test_fahrenheit():
    # (300 + 459.67) * 5/9 = 422.0388...
    assert to_si("300 degF", "temperature") == pytest.approx(759.67 * 5 / 9, rel=1e-15)


def test_the_same_quantity_in_two_units_is_the_same_float():
    for millimetres in range(1, 2000, 7):
        written = millimetres / 100
        assert to_si(f"{written} mm", "length") == to_si(f"{written * 1000:.0f} um", "length")


@pytest.mark.parametrize(
    ("text", "kind", "fragment"),
    [
        (0.3, "length", 'write a length with its unit, such as "0.3 mm"'),
        ("0.3", "length", 'write a length with its unit, such as "0.3 mm"'),
        ("45", "angle", 'write an angle with its unit, such as "45 deg"'),
        (True, "dimensionless", "write a number without unit"),
        (None, "length", "write a length"),
        (["1 mm"], "length", "write a length"),
        ("", "length", "write a length"),
        ("mm", "length", "write a length"),
        ("0.3 MPa", "length", '"MPa" is not a unit of length'),
        ("0.3 mm^2", "length", '"mm^2" is not a unit of length'),
        ("45 deg", "dimensionless", '"deg" is not a unit of a pure number'),
        ("3 furlong", "length", 'the unit "furlong" is not known'),
        ("3 Mm Mm", "length", "write a length"),
        ("nan mm", "length", "write a length"),
        ("inf mm", "length", "write a length"),
        ("1e999 mm", "length", "must be a finite number"),
        ("1e9999999999 mm", "length", "write a length"),
        (float("nan"), "dimensionless", "must be a finite number"),
        (float("inf"), "dimensionless", "must be a finite number"),
        ("9**9**9 mm", "length", "write a length"),
        ("1 mm**9**9**9", "length", "write a length"),
        ("1 __import__('os')", "length", "write a length"),
        ("1 mm; 2 mm", "length", "write a length"),
        ("1 m/0", "length", "write a length"),
        ("1 lambda", "length", "not known"),
        ("٣ mm\n", "length", "write a length"),
        ("1" * 100_000 + " mm", "length", "too long for a quantity"),
        ("1 " + "m" * 60, "length", "not known"),
        ("1 degC^2", "temperature", "is not a unit of temperature"),
    ],
)
def test_refuses_with_a_remedy_and_fast(text, kind, fragment):
    to_si("1 mm", "length")
    start = time.perf_counter()
    with pytest.raises(InputError) as caught:
        to_si(text, kind)
    assert time.perf_counter() - start < 0.2
    message = str(caught.value)
    assert fragment in message
    assert "\n" not in message
    assert len(message) < 300


def test_every_kind_accepts_its_own_example():
    for kind in KINDS:
        with pytest.raises(InputError) as caught:
            to_si("?", kind)
        assert to_si(str(caught.value).split('"')[1], kind) is not None


def test_scale_of_units():
    assert scale_of("mm", "length") == 1e-3
    for unit in ("MPa", "", "2 mm", 3, "x" * 200, "m\n*"):
        with pytest.raises(InputError):
            scale_of(unit, "length")
    with pytest.raises(InputError, match="offset"):
        scale_of("degC", "temperature")


def test_formats_back():
    assert format_si(3e-4, "length", "mm") == "0.3 mm"
    assert format_si(423.15, "temperature", "degC") == "150 degC"
    assert format_si(0.25, "dimensionless", "") == "0.25"


def test_pint_is_imported_on_first_use_only():
    code = "import sys, sheetmorph.core.units; assert 'pint' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
