"""From which shape of a pattern each corner of its boundary comes.

A corner of a part is a corner of one of its shapes, or lies where the sides of two of them cross.
So derivatives by the corners of the part are derivatives by those of the shapes, and a number of
one shape needs no look at the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.compiled import kernel
from sheetmorph.design.boundary import GROUP, Boundary
from sheetmorph.geometry.mesh import Floats

Ints = NDArray[np.intp]

NEAR = 1e-9
"""Corners within this distance of a side lie on it, as a fraction of the size of the pattern."""
PARALLEL = 1e-6
"""Sine of the angle below which two sides do not cross at a definite place."""


@dataclass(frozen=True, eq=False)
class Trace:
    """Where the M corners of a boundary come from, of which K lie at crossings.

    Attributes:
        shape: index of the shape whose corner it is, −1 at a crossing, shape (M,).
        corner: index among the corners of that shape, shape (M,).
        crossing: the corners at crossings, shape (K,).
        sides: of each the two sides, as index of the shape and of the side's first corner,
            shape (K, 2, 2).
        unclear: shapes with a corner that could not be told, or that touch another so that a
            small motion makes or removes corners.
    """

    shape: Ints
    corner: Ints
    crossing: Ints
    sides: Ints
    unclear: frozenset[int]

    def onto_shapes(
        self, boundary: Boundary, by_corner: Floats, shapes: Sequence[Boundary], found: list[Floats]
    ) -> None:
        """Add derivatives by the corners of the boundary to those by the corners of the shapes.

        A crossing x of two sides with the normals m and n follows the sides: m·dx = m·v and
        n·dx = n·w with the motions v and w of the sides at x.

        Args:
            boundary: that which was traced.
            by_corner: derivatives by its corners, shape (M, 2).
            shapes: the shapes.
            found: derivatives by the corners of each shape, to which is added.
        """
        for index, whole in enumerate(found):
            own = np.flatnonzero(self.shape == index)
            np.add.at(whole, self.corner[own], by_corner[own])
        at, pull = boundary.corners[self.crossing], by_corner[self.crossing]
        ends = np.array(
            [[shapes[s].corners[k : k + 2] for s, k in pair] for pair in self.sides.tolist()]
        ).reshape(-1, 2, 2, 2)
        along = ends[:, :, 1] - ends[:, :, 0]
        squares = (along**2).sum(axis=2)
        normals = np.stack([along[..., 1], -along[..., 0]], axis=-1)
        part = ((at[:, None] - ends[:, :, 0]) * along).sum(axis=2) / squares
        both = normals[:, 0, 0] * normals[:, 1, 1] - normals[:, 0, 1] * normals[:, 1, 0]
        # Weights of the two conditions: the transposed system [m n] weights = pull.
        first = (pull[:, 0] * normals[:, 1, 1] - pull[:, 1] * normals[:, 1, 0]) / both
        second = (normals[:, 0, 0] * pull[:, 1] - normals[:, 0, 1] * pull[:, 0]) / both
        for side, weight in enumerate((first, second)):
            force = weight[:, None] * normals[:, side]
            t = part[:, side, None]
            for (index, k), near, far in zip(
                self.sides[:, side].tolist(), (1.0 - t) * force, t * force, strict=True
            ):
                found[index][k] += near
                found[index][k + 1] += far


def trace(boundary: Boundary, shapes: Sequence[Boundary], members: Sequence[int]) -> Trace:
    """Tell where the corners of a boundary come from.

    Args:
        boundary: of the union, difference or intersection of some shapes.
        shapes: all shapes of the pattern, whole and in their places.
        members: indices of those that made the boundary.
    """
    pool = np.concatenate([shapes[m].corners for m in members])
    counts = [len(shapes[m].corners) for m in members]
    owner = np.repeat(np.arange(len(members)), counts)
    place = np.concatenate([np.arange(count) for count in counts])
    known, first, back = np.unique(_plain(pool), return_index=True, return_inverse=True)
    owners = np.zeros(len(known), dtype=np.intp)
    np.maximum.at(owners, back.ravel(), owner)
    shared = owners != owner[first]  # first has the least owner, for the sort is stable
    corners = _plain(boundary.corners)
    at = np.minimum(np.searchsorted(known, corners), len(known) - 1)
    own = known[at] == corners
    source = np.where(own, first[at], 0)
    holder = np.where(own, owner[source], -1)

    touching = _touched(boundary.corners, holder, [shapes[m] for m in members])
    count, pairs = touching
    numbers = np.asarray(members, dtype=np.intp)
    unclear = set(numbers[owner[source[own & shared[at]]]].tolist())
    unclear |= set(numbers[owners[at[own & shared[at]]]].tolist())
    for index in np.flatnonzero(own & (count > 0)).tolist():
        unclear |= {int(numbers[holder[index]]), int(numbers[pairs[index, 0, 0]])}
    crossing = np.flatnonzero(~own & (count == 2))
    sides = pairs[crossing]
    slanted = _slanted(sides, [shapes[m] for m in members])
    lost = np.concatenate([np.flatnonzero(~own & (count != 2)), crossing[~slanted]])
    for index in lost.tolist():
        touched = pairs[index, : min(int(count[index]), 2), 0]
        unclear |= set(numbers[touched].tolist()) if 0 < count[index] <= 2 else set(members)
    crossing, sides = crossing[slanted], sides[slanted]
    sides = sides.copy()
    sides[:, :, 0] = numbers[sides[:, :, 0]]
    return Trace(
        shape=np.where(own, numbers[holder], -1),
        corner=np.where(own, place[source], 0),
        crossing=crossing,
        sides=sides,
        unclear=frozenset(unclear),
    )


def _plain(corners: Floats) -> NDArray[np.complex128]:
    """Corners as numbers that can be sorted, −0 as 0."""
    return np.asarray((corners[:, 0] + 0.0) + 1j * (corners[:, 1] + 0.0))


def _slanted(sides: Ints, shapes: Sequence[Boundary]) -> NDArray[np.bool_]:
    """Whether two sides cross at a definite place, shape (K,)."""
    ends = np.array(
        [[shapes[s].corners[k : k + 2] for s, k in pair] for pair in sides.tolist()]
    ).reshape(-1, 2, 2, 2)
    along = ends[:, :, 1] - ends[:, :, 0]
    along /= np.linalg.norm(along, axis=2)[:, :, None]
    return np.asarray(
        np.abs(along[:, 0, 0] * along[:, 1, 1] - along[:, 0, 1] * along[:, 1, 0]) > PARALLEL
    )


def _touched(points: Floats, holders: Ints, shapes: Sequence[Boundary]) -> tuple[Ints, Ints]:
    """Sides of other shapes than the holder on which points lie.

    Args:
        points: [m], shape (M, 2).
        holders: index of the shape that does not count, −1 for none, shape (M,).
        shapes: the shapes.

    Returns:
        How many other shapes touch each point, counting sides where there is no holder, shape
        (M,), and the first two, as index of the shape and of the first corner, shape (M, 2, 2).
    """
    count = np.zeros(len(points), dtype=np.intp)
    pairs = np.zeros((len(points), 2, 2), dtype=np.intp)
    low = np.array([shape.boxes[:, :2].min(axis=0) for shape in shapes])
    high = np.array([shape.boxes[:, 2:].max(axis=0) for shape in shapes])
    reach = NEAR * float(np.ptp(np.concatenate([low, high]), axis=0).max())
    frames = np.column_stack([low - reach, high + reach])
    for index, shape in enumerate(shapes):
        _touch(
            points,
            holders,
            index,
            frames[index],
            shape.corners,
            shape.sides,
            shape.boxes,
            reach,
            count,
            pairs,
        )
    return count, pairs


@kernel
def _touch(points, holders, index, frame, corners, sides, boxes, reach, count, pairs):  # type: ignore[no-untyped-def]
    for i in range(len(points)):
        x, y = points[i, 0], points[i, 1]
        if x < frame[0] or x > frame[2] or y < frame[1] or y > frame[3] or holders[i] == index:
            continue
        for box in range(len(boxes)):
            if (
                x < boxes[box, 0] - reach
                or x > boxes[box, 2] + reach
                or y < boxes[box, 1] - reach
                or y > boxes[box, 3] + reach
            ):
                continue
            for k in range(box * GROUP, min((box + 1) * GROUP, len(sides))):
                j = sides[k]
                ax, ay = x - corners[j, 0], y - corners[j, 1]
                ex, ey = corners[j + 1, 0] - corners[j, 0], corners[j + 1, 1] - corners[j, 1]
                squared = ex * ex + ey * ey
                if squared == 0.0:
                    continue
                t = min(max((ax * ex + ay * ey) / squared, 0.0), 1.0)
                ax, ay = ax - t * ex, ay - t * ey
                if ax * ax + ay * ay <= reach * reach:
                    if count[i] < 2:
                        pairs[i, count[i], 0] = index
                        pairs[i, count[i], 1] = j
                    count[i] += 1
