"""Where the corners of a part come from: its shapes, and the crossings of their sides."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely.affinity import rotate, translate

from sheetmorph.design.boundary import Boundary
from sheetmorph.design.tracing import trace


def joined(parts: list[shapely.Polygon]) -> shapely.Polygon:
    """Two bars across each other, a hole cut out of them, and a pad by itself."""
    return ((parts[0] | parts[1]) - parts[2]) | parts[3]


@pytest.fixture(scope="module")
def shapes() -> list[shapely.Polygon]:
    bar = shapely.box(-5, -1, 5, 1)
    return [bar, rotate(bar, 70), shapely.box(0.3, -3, 2.2, 0.4), shapely.box(6, 3, 8, 4.5)]


def test_a_motion_of_the_shapes_moves_the_corners_of_the_part(
    shapes: list[shapely.Polygon],
) -> None:
    """Against the part that is drawn anew from shapes whose corners have all moved a little."""
    boundary, edges = Boundary.of(joined(shapes)), [Boundary.of(shape) for shape in shapes]
    found = trace(boundary, edges, range(4))
    assert not found.unclear
    assert len(found.crossing) == 5  # three of the bars, one has been cut away, and two of the hole
    rng, h = np.random.default_rng(2), 1e-6
    by_corner = rng.standard_normal(boundary.corners.shape)
    by_corner[-1] = 0.0  # the closing corner of a ring is its first
    pulled = [np.zeros_like(edge.corners) for edge in edges]
    found.onto_shapes(boundary, by_corner, edges, pulled)
    motions = [rng.standard_normal(edge.corners.shape) for edge in edges]
    for motion in motions:
        motion[-1] = motion[0]

    def corners(step: float) -> np.ndarray:
        moved = [
            shapely.Polygon(edge.corners + step * motion)
            for edge, motion in zip(edges, motions, strict=True)
        ]
        part = Boundary.of(joined(moved)).corners
        away = np.linalg.norm(boundary.corners[:, None] - part, axis=2)
        assert away.min(axis=1).max() < 100 * abs(step)
        return np.asarray(part[away.argmin(axis=1)])

    expected = (by_corner * (corners(h) - corners(-h))).sum() / (2.0 * h)
    total = sum((pull * motion).sum() for pull, motion in zip(pulled, motions, strict=True))
    assert total == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("move", "unclear"),
    [((2.0, 0.0), {0, 1}), ((2.0 + 1e-6, 0.0), set()), ((2.0, 2.0), {0, 1}), ((1.0, 0.5), set())],
    ids=["flush", "apart", "corner on corner", "across"],
)
def test_shapes_that_touch_are_told(move: tuple[float, float], unclear: set[int]) -> None:
    """A small motion of these makes corners or takes them away."""
    square = shapely.box(0, 0, 2, 2)
    shapes = [square, translate(square, *move), shapely.box(9, 9, 10, 10)]
    edges = [Boundary.of(shape) for shape in shapes]
    found = trace(Boundary.of(shapely.union_all(shapes)), edges, range(3))
    assert set(found.unclear) == unclear


def test_shapes_of_other_parts_do_not_count(shapes: list[shapely.Polygon]) -> None:
    edges = [Boundary.of(shape) for shape in shapes]
    found = trace(edges[3], edges, [3])
    assert (found.shape == 3).all()
    assert found.corner.tolist() == [0, 1, 2, 3, 0]
    assert not len(found.crossing)
