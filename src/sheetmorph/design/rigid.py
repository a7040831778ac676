"""Which rigid motions supports leave a sheet, and how to say so."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sheetmorph.geometry.mesh import Floats

AXES = "xyz"
TOLERANCE = 1e-6
"""Motions that move no held place by more than this, of a motion of 1, are free."""


def free_motions(
    nodes: Floats, held: NDArray[np.bool_], turns: Floats, size: float
) -> tuple[Floats, Floats]:
    """The rigid motions u + ω × (x − c) that move nothing that is held; k of them.

    Args:
        nodes: reference positions [m], shape (V, 3); c is their mean.
        held: held components of the nodes, shape (V, 3).
        turns: unit axes about which the sheet cannot turn, shape (K, 3).
        size: of the sheet [m].

    Returns:
        u/size and ω, shape (k, 3) each, the six numbers of a motion of length 1.
    """
    arms = (nodes - nodes.mean(axis=0)) / size
    rows = []
    for axis in range(3):
        chosen = arms[held[:, axis]]
        unit = np.zeros((len(chosen), 3))
        unit[:, axis] = 1.0
        rows.append(np.hstack([unit, np.cross(chosen, unit)]))
    rows.append(np.hstack([np.zeros_like(turns), turns]))
    # Six rows of zeros: there are six singular values however little is held.
    matrix = np.concatenate([*rows, np.zeros((6, 6))])
    _, singular, motions = np.linalg.svd(matrix, full_matrices=False)
    free = motions[singular < TOLERANCE]
    return free[:, :3], free[:, 3:]


def told(shifts: Floats, spins: Floats, centre: Floats, size: float) -> str:
    """Free motions in words: "move along x, and turn about the line along y through …".

    Args:
        shifts: u/size of `free_motions`, shape (k, 3).
        spins: ω of `free_motions`, shape (k, 3).
        centre: c [m], shape (3,).
        size: of the sheet [m].
    """
    left, values, axes = np.linalg.svd(spins)
    turning = int((values > TOLERANCE).sum())
    sliding = (left.T @ shifts)[turning:]
    said = []
    if len(sliding):
        said.append(f"move along {_directions(sliding)}")
    if turning:
        text = f"turn about {_directions(axes[:turning])}"
        if turning == 1 and not len(sliding):
            shift, spin = (left.T @ shifts)[0] * size, (left.T @ spins)[0]
            at = centre + np.cross(spin, shift) / (spin @ spin)
            where = ", ".join(f"{1e3 * part + 0.0:.4g}" for part in np.round(at, 9))
            text = f"turn about the line along {_directions(axes[:1])} through ({where}) mm"
        said.append(text)
    return ", and ".join(said)


def _directions(vectors: ArrayLike) -> str:
    """Names of the directions that some vectors span: axes where they span axes."""
    basis = np.linalg.svd(np.atleast_2d(vectors), full_matrices=False)[2]
    inside = np.linalg.norm(basis, axis=0) > 1.0 - TOLERANCE
    if inside.sum() == len(basis):
        names = [name for name, there in zip(AXES, inside, strict=True) if there]
    else:
        basis *= np.sign(np.take_along_axis(basis, np.abs(basis).argmax(axis=1)[:, None], axis=1))
        names = ["(" + ", ".join(f"{part + 0.0:.2f}" for part in row) + ")" for row in basis]
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + f" and {names[-1]}"
