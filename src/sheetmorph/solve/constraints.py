"""Held degrees of freedom as identity rows, so that the pattern never changes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.sparse import SymmetricPattern

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class HeldDofs:
    """Degrees of freedom that keep their value.

    Attributes:
        held: True for held degrees of freedom, shape (n,).
        diagonal: places of all diagonal entries in the data of the pattern, shape (n,).
        coupling: places of the off-diagonal entries in a held row or column.
    """

    held: NDArray[np.bool_]
    diagonal: NDArray[np.int32]
    coupling: NDArray[np.intp]

    @classmethod
    def of(cls, pattern: SymmetricPattern, held: NDArray[np.bool_]) -> HeldDofs:
        """Find the entries that belong to the held degrees of freedom."""
        rows = np.repeat(np.arange(pattern.size, dtype=np.int32), np.diff(pattern.indptr))
        touched = (held[rows] | held[pattern.indices]) & (rows != pattern.indices)
        return cls(held, pattern.indptr[:-1].copy(), np.flatnonzero(touched))

    def hold(self, gradient: Floats) -> Floats:
        """Zero the gradient at the held degrees of freedom, in place."""
        gradient[self.held] = 0.0
        return gradient

    def reduce(self, data: Floats) -> Floats:
        """Turn the held rows and columns into a multiple of the identity, in place.

        The multiple is the mean size of the diagonal, so that these rows add one positive
        pivot each and do not harm the conditioning.
        """
        data[self.coupling] = 0.0
        places = self.diagonal[self.held]
        data[places] = np.abs(data[self.diagonal]).mean()
        return data


def rigid_motion_pins(nodes: Floats) -> NDArray[np.bool_]:
    """The six degrees of freedom that stop the rigid motions of a free sheet.

    Node A near the middle keeps x, y, z; node B, far from A along x, keeps y and z; node C,
    far from A along y, keeps z. Every shape can be turned into this position, so the pins
    carry no force, except for the net moment that a dead load has on the deformed sheet.

    Args:
        nodes: flat reference positions [m], shape (V, 3).

    Returns:
        True at the pinned degrees of freedom, shape (3 V,).
    """
    centred = nodes - nodes.mean(axis=0)
    a = int(np.argmin((centred**2).sum(axis=1)))
    offset = nodes - nodes[a]
    b = int(np.argmax(offset[:, 0] - np.abs(offset[:, 1])))
    c = int(np.argmax(offset[:, 1] - np.abs(offset[:, 0])))
    held = np.zeros((len(nodes), 3), dtype=bool)
    held[a] = True
    held[b, 1:] = True
    held[c, 2] = True
    return held.ravel()


def level_motion_pins(nodes: Floats) -> NDArray[np.bool_]:
    """The three degrees of freedom that stop what a level table without friction does not.

    Node A near the middle keeps x and y; node B, far from A along x, keeps y.

    Args:
        nodes: flat reference positions [m], shape (V, 3).

    Returns:
        True at the pinned degrees of freedom, shape (3 V,).
    """
    held = rigid_motion_pins(nodes).reshape(-1, 3)
    held[:, 2] = False
    return held.ravel()


def align_to_reference(positions: Floats, reference: Floats) -> Floats:
    """Move each state rigidly to lie closest to the reference (least squares, no mirror).

    Args:
        positions: states [m], shape (S, V, 3).
        reference: positions to match [m], shape (V, 3).

    Returns:
        The moved states, shape (S, V, 3). Method: Kabsch 1976.
    """
    centre = reference.mean(axis=0)
    flat = reference - centre
    moved = np.empty_like(positions)
    for k, state in enumerate(positions):
        own = state - state.mean(axis=0)
        u, _, vt = np.linalg.svd(own.T @ flat)
        sign = np.sign(np.linalg.det(u @ vt))
        rotation = u @ np.diag([1.0, 1.0, sign]) @ vt
        moved[k] = own @ rotation + centre
    return moved
