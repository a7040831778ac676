"""Trays whose rims are letters: strokes on a grid, made wide, with walls that rise to the rim."""

from __future__ import annotations

import numpy as np

from sheetmorph.compare.surface import Surface
from sheetmorph.geometry.generate import generate_mesh
from sheetmorph.geometry.surface import in_plane_width

STROKES: dict[str, tuple[tuple[tuple[float, float], ...], ...]] = {
    "C": (((2, 3), (0.6, 3), (0, 2.4), (0, 0.6), (0.6, 0), (2, 0)),),
    "H": (((0, 0), (0, 3)), ((2, 0), (2, 3)), ((0, 1.5), (2, 1.5))),
    "I": (((0, 0), (0, 3)),),
    "J": (((2, 3), (2, 0.6), (1.4, 0), (0.6, 0), (0, 0.6)),),
    "L": (((0, 3), (0, 0), (2, 0)),),
    "S": (((2, 3), (0.5, 3), (0, 2.5), (0, 2), (2, 1), (2, 0.5), (1.5, 0), (0, 0)),),
    "T": (((0, 3), (2.4, 3)), ((1.2, 3), (1.2, 0))),
    "U": (((0, 3), (0, 0.6), (0.6, 0), (1.4, 0), (2, 0.6), (2, 3)),),
    "V": (((0, 3), (1.2, 0), (2.4, 3)),),
    "X": (((0, 0), (2.2, 3)), ((0, 3), (2.2, 0))),
    "Y": (((0, 3), (1.2, 1.5), (2.4, 3)), ((1.2, 1.5), (1.2, 0))),
    "Z": (((0, 3), (2.2, 3), (0, 0), (2.2, 0)),),
}
"""Middle lines; a stroke is 0.9 wide."""

_HALF = 0.45
_PER_WIDTH = 5.0


def letter(name: str, depth: float) -> Surface:
    """A channel along the strokes of a letter, whose rim draws it.

    Args:
        name: one of `STROKES`.
        depth: height of the rim over the width of a stroke.

    Returns:
        A surface whose largest extent in the plan is 1.
    """
    import shapely

    shape = shapely.union_all(
        [shapely.LineString(line).buffer(_HALF, quad_segs=12) for line in STROKES[name]]
    )
    shape = shape.buffer(0.2).buffer(-0.4).buffer(0.2).simplify(0.004)
    mesh = generate_mesh(shape, shapely.Polygon(), 2.0 * _HALF / _PER_WIDTH)
    points = mesh.nodes.copy()
    inward = shapely.distance(shape.exterior, shapely.points(points[:, :2])) / _HALF
    points[:, 2] = 2.0 * _HALF * depth * np.clip(1.0 - inward, 0.0, 1.0) ** 2
    points -= points.mean(axis=0)
    return Surface(points / float(in_plane_width(points)), mesh.triangles.astype(np.int64))
