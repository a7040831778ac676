"""Edges, hinges and the checks that make a list of triangles a sheet."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats, Ints, SheetMesh

MAX_NODES = 2_000_000
_NO_AREA = 1e-9  # twice the area of a triangle over its longest side squared
MAX_COORDINATE = 1e9  # [m]; squares and products of coordinates must not overflow


def build_mesh(
    nodes: ArrayLike,
    triangles: ArrayLike,
    edges: ArrayLike | None = None,
    *,
    curved: bool = False,
) -> SheetMesh:
    """Check a triangle mesh and derive its edges and hinges.

    Args:
        nodes: positions [m], shape (V, 2) or (V, 3) with one common z (removed).
        triangles: node indices from 0, shape (T, 3), counter-clockwise seen from +z.
        edges: the edges in the order and orientation to keep, shape (E, 2); derived
            from the triangles (lower node first, sorted) when absent.
        curved: True for a sheet that need not be flat: it keeps its z, and no triangle may
            face down; vertical ones may be there.

    Returns:
        The mesh. Hinges follow the order of the edges and run the way the edges run.

    Raises:
        InputError: the arrays are no flat, connected, manifold, counter-clockwise
            sheet; the message names the first node, triangle or edge at fault.
    """
    points = _checked_nodes(nodes, curved)
    faces = _checked_triangles(triangles, points)
    halves = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    opposite = np.concatenate([faces[:, 2], faces[:, 0], faces[:, 1]])
    unique, inverse = _unique_edges(halves, len(points))
    given = unique if edges is None else _checked_edges(edges, unique, len(points))
    hinges, hinge_edges = _hinges(given, halves, opposite, inverse, unique, len(points))
    _check_connected(faces, len(points))
    return SheetMesh(points, faces, given, hinges, hinge_edges)


def _checked_nodes(nodes: ArrayLike, curved: bool) -> Floats:
    points = np.array(nodes, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] not in (2, 3) or len(points) < 3:
        raise InputError(
            "the mesh needs at least 3 nodes with 2 or 3 coordinates each", value=points.shape
        )
    if len(points) > MAX_NODES:
        raise InputError("the mesh has too many nodes", value=len(points), allowed=f"≤ {MAX_NODES}")
    bad = ~np.isfinite(points).all(axis=1)
    if bad.any():
        raise InputError(f"node {int(np.argmax(bad))} has a coordinate that is not a finite number")
    far = (np.abs(points) > MAX_COORDINATE).any(axis=1)
    if far.any():
        raise InputError(
            f"node {int(np.argmax(far))} has a coordinate that is far too large",
            allowed=f"within ±{MAX_COORDINATE:.0e} m",
        )
    if points.shape[1] == 2:
        return np.column_stack([points, np.zeros(len(points))])
    if curved:
        return points
    spread, extent = float(np.ptp(points[:, 2])), float(np.ptp(points[:, :2], axis=0).max())
    if spread > 1e-9 * max(extent, 1e-300):
        worst = int(np.argmax(np.abs(points[:, 2] - np.median(points[:, 2]))))
        raise InputError(
            f"the sheet is not flat: node {worst} is {spread:.3g} m off the plane z = constant"
        )
    points[:, 2] = 0.0
    return points


def _checked_triangles(triangles: ArrayLike, points: Floats) -> Ints:
    raw = np.asarray(triangles)
    if raw.ndim != 2 or raw.shape[1] != 3 or len(raw) < 1:
        raise InputError("the mesh needs at least one triangle of 3 nodes", value=raw.shape)
    if not np.issubdtype(raw.dtype, np.integer):
        raise InputError("triangle corners must be whole numbers")
    outside = ((raw < 0) | (raw >= len(points))).any(axis=1)
    if outside.any():
        index = int(np.argmax(outside))
        raise InputError(
            f"triangle {index} refers to a node that does not exist",
            value=raw[index].tolist(),
            allowed=f"0 to {len(points) - 1}",
        )
    faces = np.ascontiguousarray(raw, dtype=np.int32)
    a, b, c = (points[faces[:, k]] for k in range(3))
    u, v, w = b - a, c - a, c - b
    doubled = np.cross(u, v)
    longest2 = np.maximum.reduce([(u * u).sum(1), (v * v).sum(1), (w * w).sum(1)])
    degenerate = np.linalg.norm(doubled, axis=1) <= _NO_AREA * longest2
    if degenerate.any():
        index = int(np.argmax(degenerate))
        raise InputError(f"triangle {index} is degenerate (no area)", value=faces[index].tolist())
    # Flat triangles have all their area in the plan; vertical ones have none.
    flipped = doubled[:, 2] < -_NO_AREA * longest2
    if flipped.any():
        index = int(np.argmax(flipped))
        raise InputError(
            f"triangle {index} is flipped: its nodes run clockwise seen from +z "
            f"({int(flipped.sum())} of {len(faces)} triangles do)",
            value=faces[index].tolist(),
        )
    unused = np.setdiff1d(np.arange(len(points)), faces)
    if len(unused):
        raise InputError(f"node {int(unused[0])} belongs to no triangle ({len(unused)} such nodes)")
    return faces


def _unique_edges(halves: Ints, node_count: int) -> tuple[Ints, NDArray[np.intp]]:
    keys, inverse = np.unique(_edge_keys(halves, node_count), return_inverse=True)
    edges = np.column_stack([keys // node_count, keys % node_count]).astype(np.int32)
    return edges, inverse


def _edge_keys(pairs: Ints, node_count: int) -> NDArray[np.int64]:
    low = pairs.min(axis=1).astype(np.int64)
    high = pairs.max(axis=1).astype(np.int64)
    return np.asarray(low * node_count + high)


def _checked_edges(edges: ArrayLike, unique: Ints, node_count: int) -> Ints:
    raw = np.asarray(edges)
    if raw.ndim != 2 or raw.shape[1] != 2 or not np.issubdtype(raw.dtype, np.integer):
        raise InputError("edges must be pairs of node numbers", value=raw.shape)
    if ((raw < 0) | (raw >= node_count)).any():
        index = int(np.argmax(((raw < 0) | (raw >= node_count)).any(axis=1)))
        raise InputError(
            f"edge {index} refers to a node that does not exist", value=raw[index].tolist()
        )
    given = np.ascontiguousarray(raw, dtype=np.int32)
    keys, counts = np.unique(_edge_keys(given, node_count), return_counts=True)
    if (counts > 1).any():
        key = int(keys[np.argmax(counts > 1)])
        raise InputError(f"edge {key // node_count}–{key % node_count} is listed more than once")
    wanted = _edge_keys(unique, node_count)
    missing, extra = np.setdiff1d(wanted, keys), np.setdiff1d(keys, wanted)
    for difference, text in (
        (missing, "is missing from the list of edges"),
        (extra, "is listed but is no side of a triangle"),
    ):
        if len(difference):
            key = int(difference[0])
            raise InputError(
                f"edge {key // node_count}–{key % node_count} {text} ({len(difference)} such edges)"
            )
    return given


def _hinges(
    edges: Ints,
    halves: Ints,
    opposite: Ints,
    inverse: NDArray[np.intp],
    unique: Ints,
    node_count: int,
) -> tuple[Ints, Ints]:
    shared = np.bincount(inverse, minlength=len(unique))
    if (shared > 2).any():
        a, b = unique[int(np.argmax(shared > 2))].tolist()
        raise InputError(
            f"edge {a}–{b} is not manifold: {int(shared.max())} triangles share it",
            allowed="at most 2 triangles per edge",
        )
    # One column per direction: the node opposite the half-edge that runs low→high, high→low.
    sides = np.full((len(unique), 2), -1, dtype=np.int32)
    direction = (halves[:, 0] > halves[:, 1]).astype(np.intp)
    order = np.argsort(inverse * 2 + direction, kind="stable")
    slots = (inverse * 2 + direction)[order]
    repeated = np.flatnonzero(np.diff(slots) == 0)
    if len(repeated):
        a, b = unique[slots[repeated[0]] // 2].tolist()
        raise InputError(f"edge {a}–{b} lies on the same side of two triangles that overlap")
    sides[inverse, direction] = opposite
    sorted_keys = _edge_keys(unique, node_count)
    position = np.searchsorted(sorted_keys, _edge_keys(edges, node_count))
    forward = edges[:, 0] < edges[:, 1]
    left = np.where(forward, sides[position, 0], sides[position, 1])
    right = np.where(forward, sides[position, 1], sides[position, 0])
    interior = np.flatnonzero((left >= 0) & (right >= 0))
    hinges = np.column_stack([edges[interior], left[interior], right[interior]]).astype(np.int32)
    given_at = np.empty(len(edges), dtype=np.int32)
    given_at[position] = np.arange(len(edges), dtype=np.int32)
    around = [interior.astype(np.int32)]
    for pair in ((0, 2), (0, 3), (1, 2), (1, 3)):
        keys = _edge_keys(hinges[:, list(pair)], node_count)
        around.append(given_at[np.searchsorted(sorted_keys, keys)])
    return hinges, np.column_stack(around).astype(np.int32)


def _check_connected(faces: Ints, node_count: int) -> None:
    rows, cols = faces[:, [0, 1]].ravel(), faces[:, [1, 2]].ravel()
    graph = coo_array((np.ones(len(rows)), (rows, cols)), shape=(node_count, node_count))
    parts, labels = connected_components(graph, directed=False)
    if parts > 1:
        sizes = np.bincount(labels)
        raise InputError(
            f"the sheet is in {parts} pieces (of {', '.join(map(str, sizes[:5]))} nodes)",
            allowed="one connected sheet",
        )
