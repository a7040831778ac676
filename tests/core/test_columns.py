"""Tables as spreadsheets write them: separators, decimal signs, and what is ambiguous."""

from __future__ import annotations

import pytest

from sheetmorph.core.columns import parse_table
from sheetmorph.core.errors import InputError

PLAIN = "length [mm], force [N], sample\n12.5, -0.25, a\n1e2, .5, b\n"


def _numbers(text: str) -> list[list[float]]:
    table = parse_table(text)
    return [table.numbers("length", "length").tolist(), table.numbers("force", "force").tolist()]


@pytest.mark.parametrize(
    "text",
    [
        PLAIN,
        "length [mm];force [N];sample\n12.5;-0.25;a\n1e2;.5;b\n",
        "length [mm];force [N];sample\r\n12,5;-0,25;a\r\n1e2;,5;b\r\n",
        "length [mm];force [N];sample\n12,5;−0,25;a\n1,0e2;0,5;b\n",
        "length [mm]\tforce [N]\tsample\n12,5\t-0,25\ta\n100\t0,5\tb\n",
        '"length [mm]";"force [N]";"sample"\n"12,5";"-0,25";"a; c"\n100;0,5;b\n',
    ],
)  # fmt: skip
def test_the_separator_is_that_of_the_titles(text: str) -> None:
    assert _numbers(text) == [[0.0125, 0.1], [-0.25, 0.5]]


def test_words_keep_their_commas() -> None:
    table = parse_table("length [mm];sample\n1,5;a,b\n2,5;c\n")
    assert table.words("sample") == ("a,b", "c")
    assert table.comma == "yes"
    assert parse_table(PLAIN).comma == "no"


def test_a_comma_that_may_part_thousands_is_refused() -> None:
    table = parse_table("length [mm];force [N]\n1,234;0.5\n")
    with pytest.raises(InputError, match=r"line 2, column length: .*commas and decimal points"):
        table.numbers("length", "length")
    assert table.numbers("force", "force").tolist() == [0.5]


@pytest.mark.parametrize(
    ("text", "fragment"),
    [
        ("length [mm], force [N]\n12,5; 1\n", "line 2, column force: write a finite number"),
        ("length [mm], force [N]\n12,5, 1\n", "line 2: has 3 cells under 2 titles"),
        ("length [mm];force [N]\n12,5;1\n3,5\n", "line 3: has 1 cells under 2 titles"),
        ("length [mm];force [N]\n1.234,5;1\n", "line 2, column length: write a finite number"),
        ("length [mm];force [N]\n1,2,3;1\n", "line 2, column length: write a finite number"),
        ("length [mm];force [N]\n,;1\n", "line 2, column length: write a finite number"),
        ("length [mm];force [N]\n1 234,5;1\n", "line 2, column length: write a finite number"),
    ],
)
def test_what_stays_refused(text: str, fragment: str) -> None:
    with pytest.raises(InputError, match=fragment):
        _numbers(text)
