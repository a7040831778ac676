"""Nested copies: apart, on the stock, not fewer than asked."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from sheetmorph.core.errors import InputError
from sheetmorph.fabricate.nest import Placement, apart, nest

DISC = shapely.Point(0.3, -0.2).buffer(0.05, quad_segs=60)
RECTANGLE = shapely.box(-0.07765, -0.05, 0.07765, 0.05)
TRIANGLE = shapely.Polygon([(0, 0), (0.1, 0), (0.05, 0.0866)])
ELL = shapely.Polygon([(0, 0), (0.1, 0), (0.1, 0.02), (0.02, 0.02), (0.02, 0.1), (0, 0.1)])
STAR = shapely.Polygon(
    [
        (r * math.cos(k * math.pi / 6), r * math.sin(k * math.pi / 6))
        for k, r in enumerate([0.05, 0.02] * 6)
    ]
)
SHAPES = {"disc": DISC, "rectangle": RECTANGLE, "triangle": TRIANGLE, "ell": ELL, "star": STAR}
STOCK = (0.4, 0.3)


@pytest.mark.parametrize("spacing", [0.0, 2e-3, 8e-3])
@pytest.mark.parametrize("name", SHAPES)
def test_copies_are_apart_and_on_the_stock(name: str, spacing: float) -> None:
    shape = SHAPES[name]
    sheets = nest(shape, 25, STOCK, spacing)
    assert sum(map(len, sheets)) == 25
    assert all(len(sheet) == len(sheets[0]) for sheet in sheets[:-1])
    for places in sheets:
        placed = [place.apply(shape) for place in places]
        # Pair by pair, without the tree of `apart`.
        gaps = [a.distance(b) for i, a in enumerate(placed) for b in placed[:i]]
        assert min(gaps, default=1.0) >= spacing - 1e-9
        overlaps = [a.intersection(b).area for i, a in enumerate(placed) for b in placed[:i]]
        assert max(overlaps, default=0.0) < 1e-12
        low = np.min([copy.bounds[:2] for copy in placed], axis=0)
        high = np.max([copy.bounds[2:] for copy in placed], axis=0)
        assert (low >= spacing - 2e-8).all()
        assert (high <= np.array(STOCK) - spacing + 2e-8).all()
        for copy in placed:
            assert copy.area == pytest.approx(shape.area, rel=1e-12)


def test_rows_interlock_where_boxes_would_not() -> None:
    """Boxes alone hold 2 × 2 discs, or 3 × 2 triangles."""
    stock = (0.21, 0.302)
    assert len(nest(DISC, 99, (0.3, 0.291), 2e-3)[0]) > 4
    assert len(nest(TRIANGLE, 99, stock, 2e-3)[0]) > 6


def test_a_turned_rectangle_is_laid_straight() -> None:
    turned = shapely.affinity.rotate(RECTANGLE, 17)
    assert len(nest(turned, 9, (0.32, 0.21), 1e-3)[0]) == 4


def test_the_same_is_nested_the_same_way() -> None:
    assert nest(STAR, 7, STOCK, 2e-3) == nest(STAR, 7, STOCK, 2e-3)


def test_stock_too_small_is_refused() -> None:
    with pytest.raises(InputError, match=r"100\.0 × 100\.0 mm does not fit a stock of 90 × 300"):
        nest(DISC, 2, (0.09, 0.3), 0.0)
    assert len(nest(DISC, 1, (0.1, 0.1), 0.0)[0]) == 1
    with pytest.raises(InputError):
        nest(DISC, 1, (0.1, 0.1), 1e-3)


def test_overlap_is_noticed() -> None:
    places = [Placement(0.0, 0.0, 0.0), Placement(0.0, 0.1005, 0.0)]
    assert apart(DISC, places, 0.4e-3)
    assert not apart(DISC, places, 0.6e-3)
    assert not apart(DISC, [places[0], Placement(0.0, 0.09, 0.0)], 0.0)
