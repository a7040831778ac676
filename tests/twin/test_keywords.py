"""The checker finds what is wrong with a deck."""

from __future__ import annotations

import pytest

from sheetmorph.twin.keywords import check_deck

GOOD = """*HEADING
a plate
*NODE, NSET=ALL
1, 0., 0., 0.
2, 1., 0., 0.
3, 0., 1., 0.
*ELEMENT, TYPE=S3R, ELSET=E
1, 1, 2, 3
*MATERIAL, NAME=M
*DENSITY
1000.
*HYPERELASTIC, MOONEY-RIVLIN
1., 1., 1.
*SHELL SECTION, ELSET=E, MATERIAL=M
0.1, 5
*AMPLITUDE, NAME=A, DEFINITION=SMOOTH STEP
0., 0., 1., 1.
*BOUNDARY
1, 1, 3
*STEP, NLGEOM=YES
*DYNAMIC, EXPLICIT
, 1.
*TEMPERATURE, AMPLITUDE=A
1, 5.
*END STEP
"""


def test_a_good_deck_has_no_faults() -> None:
    assert check_deck(GOOD.splitlines()) == []


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("*DENSITY", "*DENSTY", "line 10: unknown keyword *DENSTY"),
        (", TYPE=S3R", "", "line 7: *ELEMENT: wants TYPE"),
        ("NLGEOM=YES", "NLGEM=YES", "line 20: *STEP: does not know NLGEM"),
        ("NAME=M\n*D", "NAME=\n*D", "line 9: *MATERIAL: NAME wants a value"),
        ("NAME=M\n*D", "NAME=3M\n*D", "line 9: *MATERIAL: 3M is no name"),
        (", EXPLICIT", ", EXPLICIT=1", "line 21: *DYNAMIC: EXPLICIT takes no value"),
        ("1, 1, 2, 3", "1, 1, 2, 4", "line 8: *ELEMENT: there is no node 4"),
        ("3, 0., 1., 0.", "2, 0., 1., 0.", "line 6: *NODE: node 2 is there twice"),
        ("1000.", "1000 kg", "line 11: *DENSITY: 1000 kg is no number"),
        ("1., 1., 1.\n", "1., 1.\n", "line 13: *HYPERELASTIC: 2 entries, not 3 to 4"),
        ("*MATERIAL, NAME=M", "*MATERIAL, NAME=N", "line 14: there is no material M"),
        ("ELSET=E, M", "ELSET=F, M", "line 14: there is no element set F"),
        ("AMPLITUDE=A", "AMPLITUDE=B", "line 23: there is no amplitude B"),
        ("1, 5.", "9, 5.", "line 24: *TEMPERATURE: there is no node 9"),
        ("*END STEP\n", "", "the last step has no *END STEP"),
        ("*END STEP", "*END STEP\n*CLOAD\n1, 1, 1.", "line 26: *CLOAD: stands outside of a step"),
        ("*TEMPERATURE", "*DENSITY\n1.\n*TEMPERATURE", "line 23: *DENSITY: stands within a step"),
        ("*END STEP", "*END STEP\n1.", "line 26: *END STEP: takes no data"),
        ("a plate", "a " * 200, "line 2: longer than 256 characters"),
    ],
)
def test_a_fault_is_told_with_its_line(old: str, new: str, fault: str) -> None:
    assert old in GOOD
    assert fault in check_deck(GOOD.replace(old, new).splitlines())


def test_a_deck_without_a_step_is_none() -> None:
    assert "there is no step" in check_deck(GOOD[: GOOD.index("*STEP")].splitlines())
