"""Which nodes and edges of a mesh the tables of supports and loads choose."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import SheetMesh

Bools = NDArray[np.bool_]

TOLERANCE = 1e-9
"""Width of the faces of a box, as a fraction of the size of the sheet."""
PLANE = 1e-6
"""Width of a plane: files may keep coordinates in single precision."""


def in_box(mesh: SheetMesh, *intervals: tuple[float, float] | None) -> Bools:
    """Nodes in a box, its faces included, shape (V,).

    Args:
        mesh: the reference mesh.
        intervals: along x, y and z [m]; None for all.
    """
    width = TOLERANCE * mesh.size
    chosen = np.ones(len(mesh.nodes), dtype=np.bool_)
    for axis, interval in enumerate(intervals):
        if interval is not None:
            along = mesh.nodes[:, axis]
            chosen &= (along >= interval[0] - width) & (along <= interval[1] + width)
    return chosen


def on_plane(mesh: SheetMesh, axis: int, value: float) -> Bools:
    """Nodes whose coordinate along an axis has a value [m], shape (V,)."""
    return np.asarray(np.abs(mesh.nodes[:, axis] - value) <= PLANE * mesh.size)


def of_indices(mesh: SheetMesh, nodes: Sequence[int], key: str) -> Bools:
    """Nodes by their indices, shape (V,).

    Raises:
        InputError: an index that no node has; names the key.
    """
    count = len(mesh.nodes)
    beyond = [node for node in nodes if node >= count]
    if beyond:
        raise InputError(
            "there is no such node in the mesh",
            key=key,
            value=beyond[0],
            allowed=f"0 to {count - 1}",
        )
    chosen = np.zeros(count, dtype=np.bool_)
    chosen[list(nodes)] = True
    return chosen


def rim_between(mesh: SheetMesh, chosen: Bools) -> NDArray[np.intp]:
    """Positions in `mesh.rim_edges` of the edges whose two nodes are chosen, shape (K,)."""
    return np.flatnonzero(chosen[mesh.edges[mesh.rim_edges]].all(axis=1))
