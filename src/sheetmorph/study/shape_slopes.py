"""Derivatives by the corners of the shapes of a pattern, each by itself, and by their numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from sheetmorph.design.boundary import Boundary
from sheetmorph.design.spec import Design
from sheetmorph.design.tracing import trace
from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from shapely import Polygon
    from shapely.geometry.base import BaseGeometry

    from sheetmorph.design.piece import Piece

JUMP = 1e-3
"""Corners that move farther than this for a small step, in widths of the sheet, are others."""


@dataclass(frozen=True, eq=False)
class ShapeSlopes:
    """Derivatives by the corners of the shapes that a pattern is drawn from.

    Attributes:
        sheet: the outline, which shapes that fill it need.
        regions: of the shapes.
        corners: of each, its rings closed [m], shape (M, 2).
        by_corner: derivatives by them, shape (M, 2).
        unclear: indices of shapes whose corners do not account for all that they do.
        jump: farther than this no corner moves [m].
    """

    sheet: Polygon
    regions: Sequence[BaseGeometry]
    corners: Sequence[Floats]
    by_corner: Sequence[Floats]
    unclear: frozenset[int]
    jump: float

    @classmethod
    def of(
        cls,
        design: Design,
        boundaries: Mapping[str, Boundary],
        by_corner: Mapping[str, Floats],
        members: Mapping[str, Sequence[int]],
    ) -> ShapeSlopes:
        """Carry derivatives by the corners of parts on to the corners of their shapes.

        Args:
            design: the design.
            boundaries: of the parts.
            by_corner: derivatives by their corners, shape (M, 2).
            members: indices of the shapes that make each part.
        """
        sheet = design.outline_polygon()
        regions = [piece.region(sheet) for piece in design.pattern]
        shapes = [Boundary.of(region) for region in regions]
        found = [np.zeros_like(shape.corners) for shape in shapes]
        unclear: frozenset[int] = frozenset()
        for name, boundary in boundaries.items():
            traced = trace(boundary, shapes, members[name])
            traced.onto_shapes(boundary, by_corner[name], shapes, found)
            unclear |= traced.unclear
        jump = JUMP * float(np.ptp(np.array(sheet.bounds).reshape(2, 2), axis=0).max())
        return cls(sheet, regions, [shape.corners for shape in shapes], found, unclear, jump)

    def by_number(self, shape: int, ahead: Piece, behind: Piece, step: float) -> float | None:
        """Derivative by a number of one shape, from what it does to the shape's own corners.

        A central difference; one to a side where corners come or go on the other.

        Args:
            shape: index of the shape.
            ahead: the same with the number larger by the step.
            behind: smaller by it.
            step: in the unit of the number.

        Returns:
            None where the corners of the shape do not tell.
        """
        if shape in self.unclear:
            return None
        near = self.corners[shape]
        ends = [self._corners(piece, near) for piece in (ahead, behind)]
        known = [end for end in ends if end is not None]
        if not known:
            return None
        first = near if ends[0] is None else ends[0]
        last = near if ends[1] is None else ends[1]
        return float((self.by_corner[shape] * (first - last)).sum()) / (len(known) * step)

    def _corners(self, piece: Piece, near: Floats) -> Floats | None:
        import shapely

        return followed(near, shapely.get_coordinates(piece.region(self.sheet)), self.jump)


def followed(near: Floats, far: Floats, jump: float) -> Floats | None:
    """Where corners have gone, by the corners of a boundary that differs a little, shape (M, 2).

    Args:
        near: corners, ring by ring, each closed by its first corner again [m], shape (M, 2).
        far: those of the other, whose rings may begin elsewhere.
        jump: farther than this no corner moves [m].

    Returns:
        None where a corner has come or gone.
    """
    if far.shape == near.shape and np.abs(far - near).max() < jump:
        return far
    one, back = np.unique(near, axis=0, return_inverse=True)
    other = np.unique(far, axis=0)
    if len(one) != len(other):
        return None
    away, nearest = cKDTree(other).query(one)
    if away.max() > jump or len(np.unique(nearest)) < len(one):
        return None
    return np.asarray(other[nearest][back.ravel()])
