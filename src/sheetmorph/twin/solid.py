"""The layers of a sheet as wedges of 15 nodes that share nodes where they touch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sheetmorph.geometry.mesh import Floats
from sheetmorph.twin.sheet import Sheet, Slab

Ids = NDArray[np.int64]

SAME = 1e-9
"""Heights that differ by less than this share of the thickness are one."""


@dataclass(frozen=True, eq=False)
class Solid:
    """Wedges: quadratic in the plane, one through each layer, quadratic through it.

    Attributes:
        nodes: [m], shape (N, 3).
        wedges: indices of nodes, shape (W, 15): corners of the lower face, of the upper face,
            middles of the edges of the lower face (12, 23, 31), of the upper, of the uprights.
        triangle: triangle of the plan below each wedge, shape (W,).
        layer: layer of the design that it is made of, shape (W,).
        column: node of the plan below each node, or V and the edge of the plan, shape (N,).
        surface: node of the reference plane at each node of the plan, shape (V,).
    """

    nodes: Floats
    wedges: Ids
    triangle: Ids
    layer: Ids
    column: Ids
    surface: Ids


def extrude(sheet: Sheet) -> Solid:
    """Stack the layers of a sheet on its triangles.

    Neighbours share the nodes of their common faces; where a layer ends at the rim of the
    pattern its side is free. A layer that the reference plane cuts elsewhere than in its
    middle becomes two.
    """
    mesh = sheet.mesh
    total = max(slabs[-1].top - slabs[0].bottom for slabs in sheet.slabs)
    levels = _Levels(SAME * total)
    count = len(mesh.nodes)
    keys, triangles, layers = [], [], []
    for cell, slabs in enumerate(sheet.slabs):
        here = np.flatnonzero(sheet.triangle_cell == cell)
        corners = mesh.triangles[here].astype(np.int64)
        edges = mesh.triangle_edges[here].astype(np.int64) + count
        for slab in _cut(slabs, SAME * total):
            low, high, between = levels.of(slab)
            parts = ((corners, low), (corners, high), (edges, low), (edges, high))
            columns = [*parts, (corners, between)]
            keys.append(np.concatenate([part * levels.LIMIT + at for part, at in columns], axis=1))
            triangles.append(here)
            layers.append(np.full(len(here), slab.layer))
    used, flat = np.unique(np.concatenate(keys), return_inverse=True)
    column, level = used // levels.LIMIT, used % levels.LIMIT
    plane = np.concatenate([mesh.nodes[:, :2], mesh.nodes[mesh.edges, :2].mean(axis=1)])
    nodes = np.column_stack([plane[column], levels.heights[level]])
    at_zero = np.flatnonzero((column < count) & (np.abs(nodes[:, 2]) <= SAME * total))
    surface = np.full(count, -1, dtype=np.int64)
    surface[column[at_zero]] = at_zero
    return Solid(
        nodes,
        flat.reshape(-1, 15).astype(np.int64),
        np.concatenate(triangles).astype(np.int64),
        np.concatenate(layers).astype(np.int64),
        column,
        surface,
    )


def _cut(slabs: tuple[Slab, ...], width: float) -> list[Slab]:
    """The same slabs, cut where z = 0 lies inside of one and not in its middle."""
    found: list[Slab] = []
    for slab in slabs:
        inside = slab.bottom < -width and slab.top > width
        if inside and abs(slab.middle) > width:
            found += [Slab(slab.layer, slab.bottom, 0.0), Slab(slab.layer, 0.0, slab.top)]
        else:
            found.append(slab)
    return found


class _Levels:
    """Heights of faces, and of the middles of layers, by number."""

    LIMIT = 1 << 20

    def __init__(self, width: float) -> None:
        self._width = width
        self._numbers: dict[tuple[int, ...], int] = {}
        self._heights: list[float] = []

    @property
    def heights(self) -> Floats:
        """Height of each level [m]."""
        return np.array(self._heights)

    def of(self, slab: Slab) -> tuple[int, int, int]:
        """Levels of the lower face, the upper face and the middle of a slab."""
        low, high = (round(height / self._width) for height in (slab.bottom, slab.top))
        return (
            self._number((low,), slab.bottom),
            self._number((high,), slab.top),
            self._number((low, high), slab.middle),
        )

    def _number(self, key: tuple[int, ...], height: float) -> int:
        if key not in self._numbers:
            self._numbers[key] = len(self._heights)
            self._heights.append(height)
        return self._numbers[key]
