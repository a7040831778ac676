"""Units, by properties: text to SI and back, whatever the numbers."""

from __future__ import annotations

from decimal import Decimal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sheetmorph.core.errors import InputError
from sheetmorph.core.units import to_si

often = settings(deadline=None, max_examples=60, derandomize=True)

POWERS = {"um": -6, "mm": -3, "cm": -2, "m": 0}
NUMBERS = st.decimals(-10_000, 10_000, places=6)


@often
@given(NUMBERS, st.sampled_from(sorted(POWERS)), st.sampled_from(sorted(POWERS)))
def test_the_same_length_in_another_unit_is_the_same_number(
    number: Decimal, unit: str, other: str
) -> None:
    written = number.scaleb(POWERS[unit] - POWERS[other])
    assert to_si(f"{number:f} {unit}", "length") == to_si(f"{written:f} {other}", "length")
    assert to_si(f"{number:f} {unit}", "length") == float(number.scaleb(POWERS[unit]))


@often
@given(st.text(max_size=30))
def test_any_text_is_a_length_or_one_line_that_says_what_is_wrong(text: str) -> None:
    try:
        value = to_si(text, "length")
    except InputError as error:
        assert "\n" not in str(error)
    else:
        assert isinstance(value, float)
        assert any(letter.isdigit() for letter in text)


@often
@given(NUMBERS, st.sampled_from(["N", "Pa", "K", "kg"]))
def test_another_dimension_is_refused(number: Decimal, unit: str) -> None:
    with pytest.raises(InputError):
        to_si(f"{number:f} {unit}", "length")
