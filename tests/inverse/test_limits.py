"""Limits of fabrication against patterns whose widths are known."""

from __future__ import annotations

import pytest
import shapely

from sheetmorph.core.errors import InputError
from sheetmorph.design.spec import Design
from sheetmorph.inverse.limits import Limits, measured, narrow_share

SHEET = """
name = "limits"
[outline]
kind = "disc"
radius = "50 mm"
{pattern}
[[layers]]
name = "film"
role = "active"
thickness = "0.3 mm"
young_modulus = "1 MPa"
[[layers]]
name = "ribs"
role = "inert"
thickness = "0.8 mm"
young_modulus = "3 MPa"
where = "pattern"
[actuation]
eps_pre = -0.2
[mesh]
size = "8 mm"
"""
STAR = """[[pattern]]
kind = "star"
arms = 5
arm_length = "40 mm"
half_width = "2 mm"
"""
PADS = """[[pattern]]
kind = "disc"
radius = "5 mm"
centre = ["30 mm", "0 mm"]
polar_array = {{ count = {count} }}
"""


def design(pattern: str) -> Design:
    return Design.from_toml(SHEET.format(pattern=pattern))


def test_a_star_is_as_narrow_as_its_arms() -> None:
    assert measured(design(STAR), Limits(minimum_width=3.9e-3)).narrow == 0.0
    assert measured(design(STAR), Limits(minimum_width=4.2e-3)).narrow > 0.5


def test_gaps_count_as_ribs_do() -> None:
    two = design(
        PADS.format(count=2).replace("30 mm", "6 mm")  # 2 mm apart, back to back
    )
    assert measured(two, Limits(minimum_width=1.5e-3)).narrow == 0.0
    assert 0.0 < measured(two, Limits(minimum_width=3e-3)).narrow < 0.01  # between them alone


def test_pieces_area_and_symmetry() -> None:
    pads = design(PADS.format(count=6))
    made = measured(pads, Limits(connected=True, most_inert=0.05, symmetry=3))
    assert (made.pieces, made.symmetry) == (6, 6)
    assert made.inert == pytest.approx(6 * 25 / 2500, rel=1e-6)
    assert [text.split()[0] for text in made.broken] == ["the", "it"]
    assert made.excess(Limits(connected=True, most_inert=0.05)) == pytest.approx(0.51, rel=1e-6)
    assert made.excess(Limits()) == 0.0
    uneven = measured(pads, Limits(symmetry=4))
    assert uneven.broken == ("no rotation of order 4 leaves it as it is",)
    assert uneven.excess(Limits(symmetry=4)) == pytest.approx(0.1)


def test_share_of_a_rectangle_with_a_narrow_tongue() -> None:
    region = shapely.box(0, 0, 10e-3, 10e-3).union(shapely.box(10e-3, 4e-3, 20e-3, 5e-3))
    assert narrow_share(region, 0.9e-3) == 0.0
    assert narrow_share(region, 2e-3) == pytest.approx(10 / 110, rel=0.02)


@pytest.mark.parametrize(
    ("key", "value"), [("minimum_width", 0.0), ("most_inert", 1.5), ("symmetry", 0)]
)
def test_limits_have_limits(key: str, value: float) -> None:
    with pytest.raises(InputError) as error:
        Limits(**{key: value})  # type: ignore[arg-type]
    assert key in str(error.value)
