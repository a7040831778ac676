"""Copies of the mesh of a sector, welded to the mesh of a sheet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.sectors import Sector, UnfitError, sector_angle
from sheetmorph.geometry.symmetry import cosine_sine
from sheetmorph.geometry.triangulate import Indices

# In edge lengths:
ON_RAY = 1e-5  # nodes closer than this to a ray are on it
MISMATCH = 0.05  # nodes of two rays that a rotation joins are no farther apart


def welded(
    nodes: Floats, triangles: Indices, sector: Sector, size: float
) -> tuple[Floats, Indices]:
    """All copies of the mesh of a sector as one mesh.

    Copies share what lies on a ray by construction: the second ray of copy k is the first of
    copy k + 1, or a mirror line. Every node is the image of one of its orbit under one
    element of the group, so the symmetry is exact but for one rounding.

    Args:
        nodes: positions in the sector, shape (N, 2).
        triangles: corner indices, counter-clockwise, shape (T, 3).
        size: wanted edge length [m].

    Returns:
        Nodes in the drawing [m], shape (V, 2), and triangles, shape (G T + …, 3).

    Raises:
        UnfitError: the rays of the sector have nodes that do not match.
    """
    group, order = sector.group, sector.group.order
    if group.mirror is not None:
        # Its first reflection must be the one that keeps the first ray.
        group = replace(group, mirror=sector.direction)
    nodes, first, second, tip = _on_rays(nodes, sector_angle(group), size)
    nodes = np.concatenate([nodes, np.zeros((1, 2))])
    centre = len(nodes) - 1
    copies = np.arange(order)[:, None]
    # Which node of the sector each node stands for, and in which copy, shape (copies, N).
    owner = np.tile(np.arange(len(nodes)), (order, 1))
    copy = np.tile(copies, len(nodes))
    if group.mirror is None:
        nodes, first, second = _matched(nodes, first, second, size)
        owner[:, second] = first
        copy[:, second] = (copies + 1) % order
    else:
        mirrored = copy + order
        mirrored[:, first] = copies
        mirrored[:, second] = (copies - 1) % order
        owner, copy = np.tile(owner, (2, 1)), np.concatenate([copy, mirrored])
    owner[:, [*tip, centre]] = centre
    copy[:, [*tip, centre]] = 0
    labels = copy * len(nodes) + owner
    faces = labels[:, triangles]
    faces[order:] = faces[order:, :, ::-1]
    faces = faces.reshape(-1, 3)
    if sector.cap is not None:
        faces = np.concatenate([faces, _cap(labels[:order], nodes, first, second, centre)])
    used, index = np.unique(faces, return_inverse=True)
    copy, owner = np.divmod(used, len(nodes))
    c, s = cosine_sine(np.array(sector.direction))
    upright = nodes @ np.array([[c, s], [-s, c]])
    moved = np.einsum("nij,nj->ni", group.matrices()[copy], upright[owner])
    return np.array(group.centre) + moved, index.reshape(-1, 3)


def _on_rays(nodes: Floats, angle: float, size: float) -> tuple[Floats, Indices, Indices, Indices]:
    """Nodes with those near a ray put on it, those on each ray outward, and those at the tip."""
    nodes = nodes.copy()
    near = ON_RAY * size
    tip = np.flatnonzero(np.linalg.norm(nodes, axis=1) < near)
    found = []
    for direction in (0.0, angle):
        c, s = cosine_sine(np.array(direction))
        along, beside = nodes @ np.array([c, s]), nodes @ np.array([-s, c])
        on = np.flatnonzero((np.abs(beside) < near) & (along >= near))
        on = on[np.argsort(along[on])]
        nodes[on] = along[on, None] * np.array([c, s])
        found.append(on)
    return nodes, found[0], found[1], tip


def _matched(
    nodes: Floats, first: Indices, second: Indices, size: float
) -> tuple[Floats, Indices, Indices]:
    """Nodes whose positions on the first ray are the means of those on both."""
    if len(first) != len(second):
        raise UnfitError("the two rays of a sector have different numbers of nodes")
    inner, outer = nodes[first, 0], np.linalg.norm(nodes[second], axis=1)
    if len(first) and np.abs(inner - outer).max() > MISMATCH * size:
        raise UnfitError("the nodes on the two rays of a sector do not match")
    nodes[first, 0] = 0.5 * (inner + outer)
    return nodes, first, second


def _cap(labels: Indices, nodes: Floats, first: Indices, second: Indices, centre: int) -> Indices:
    """Triangles around the centre, and those between them and the sectors, shape (2 n, 3)."""
    corner, apex = labels[:, first[0]], labels[:, second[0]]
    following = np.roll(corner, -1)
    middle = np.full_like(corner, centre)
    return np.concatenate(
        [
            np.stack([middle, corner, following], -1),
            np.stack([corner, apex, following], -1),
        ]
    )
