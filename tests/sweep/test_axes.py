"""Lists, ranges and samples of one key."""

from __future__ import annotations

import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.core.units import KINDS, SI_UNITS, Kind
from sheetmorph.sweep.axes import read_axis, sampled_axis


def test_lists_are_converted_to_si() -> None:
    axis = read_axis("layers.0.thickness", ["0.3 mm", "400 um", "0.05 cm"])
    assert axis.values == (0.0003, 0.0004, 0.0005)
    assert axis.unit == "m"
    assert axis.written(axis.values[1]) == "0.0004 m"
    assert read_axis("actuation.temperature", ["150 degC"]).values == (423.15,)
    assert read_axis("actuation.eps_pre", [-0.1, "-20 %"]).values == (-0.1, -0.2)


@pytest.mark.parametrize("kind", KINDS)
def test_quantities_of_every_kind_vary(kind: Kind) -> None:
    axis = read_axis("some.key", [f"{value} {SI_UNITS[kind]}" for value in (1.0, 2.0)])
    assert axis.values == (1.0, 2.0)
    assert axis.unit == SI_UNITS[kind]


def test_what_is_no_number_stays_as_it_is() -> None:
    for values in (["spokes", "outline"], [True, False], [[1, 2], [3, 4]]):
        axis = read_axis("pattern.0.style", values)
        assert list(axis.values) == values
        assert axis.unit == ""
        assert axis.written(values[0]) is values[0]


@pytest.mark.parametrize(
    ("entry", "values"),
    [
        ({"from": 0, "to": 10, "count": 6}, (0, 2, 4, 6, 8, 10)),
        ({"from": 0, "to": 1, "count": 3}, (0.0, 0.5, 1.0)),
        ({"from": -0.1, "to": -0.4, "count": 4}, (-0.1, -0.2, -0.3, -0.4)),
        ({"from": 1, "to": 8, "count": 4, "spacing": "log"}, (1, 2, 4, 8)),
        ({"from": -1, "to": -100, "count": 3, "spacing": "log"}, (-1, -10, -100)),
        ({"from": 3, "to": 0, "step": -1}, (3, 2, 1, 0)),
        ({"from": 0.1, "to": 0.5, "step": 0.1}, (0.1, 0.2, 0.3, 0.4, 0.5)),
        ({"from": "1 mm", "to": "2 mm", "step": "0.5 mm"}, (0.001, 0.0015, 0.002)),
        ({"from": "1 mm", "to": "1 cm", "count": 2}, (0.001, 0.01)),
    ],
)
def test_ranges(entry: dict[str, object], values: tuple[float, ...]) -> None:
    found = read_axis("key", entry).values
    assert found == values
    assert [type(value) for value in found] == [type(value) for value in values]


def test_samples_lie_where_the_shares_say() -> None:
    shares = (0.0, 0.25, 0.999999)
    assert sampled_axis("k", {"from": 1.0, "to": 3.0}, shares).values == (1.0, 1.5, 2.999998)
    ratios = sampled_axis("k", {"from": "1 mm", "to": "16 mm", "spacing": "log"}, (0.25, 0.5))
    assert ratios.values == (0.002, 0.004)
    whole = sampled_axis("k", {"from": 2, "to": 5, "whole": True}, shares)
    assert whole.values == (2, 3, 5)
    assert all(isinstance(value, int) for value in whole.values)


@pytest.mark.parametrize(
    ("entry", "word"),
    [
        ("-0.1", "list of values"),
        ([], "0 values"),
        ({"from": 0, "to": 1}, "count or step"),
        ({"from": 0, "to": 1, "count": 3, "step": 1}, "count or step"),
        ({"from": 0, "to": 1, "count": 1}, "2 to"),
        ({"from": 0, "to": 1, "count": 2_000_000}, "1000000"),
        ({"from": 0, "to": 1, "step": 1e-9}, "values"),
        ({"from": 0, "to": 1, "step": -1}, "away"),
        ({"from": 0, "to": 1, "step": 0}, "away"),
        ({"from": 0, "to": 1, "counts": 3}, "did you mean count"),
        ({"from": "1 mm", "to": "1 MPa", "count": 3}, "one kind"),
        ({"from": float("nan"), "to": 1, "count": 3}, "one kind"),
        ({"to": 1, "count": 3}, "from and to"),
        ({"from": 0, "to": 1, "count": 3, "spacing": "log"}, "one side of zero"),
        ({"from": 1, "to": 2, "count": 3, "spacing": "cubic"}, "linear, log"),
        ({"from": "20 degC", "to": "50 degC", "step": "10 K"}, "count"),
    ],
)
def test_ranges_that_are_refused(entry: object, word: str) -> None:
    with pytest.raises(InputError, match=word):
        read_axis("key", entry)


@pytest.mark.parametrize(
    "entry",
    [
        {"from": 1, "to": 1},
        {"from": 2, "to": 1},
        {"from": 0.5, "to": 3, "whole": True},
        {"from": "1 mm", "to": "3 mm", "whole": True},
        {"from": 1, "to": 3, "whole": 1},
        [1, 2],
    ],
)
def test_bounds_that_are_refused(entry: object) -> None:
    with pytest.raises(InputError):
        sampled_axis("key", entry, (0.5,))
