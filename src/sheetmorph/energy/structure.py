"""Where the local blocks of the energy terms go in the Hessian of the whole sheet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.sparse import SymmetricPattern
from sheetmorph.energy.term import Term, scalar_unknowns
from sheetmorph.geometry.mesh import Ints


@dataclass(frozen=True, eq=False)
class Slots:
    """Where the local blocks of one term go in the storage of the assembly.

    Attributes:
        pairs: the stored block of each pair of nodes, shape (n, m (m + 1)/2); −1 − block where
            the local block must be transposed.
        scalars: the term's scalar unknowns, as degrees of freedom, shape (n, 3) or (n, 0).
        mixed: the place in the flat storage of the 3 entries of each node (row) with each
            scalar (column), shape (n, 3 m) or (n, 0), nodes first.
        own: the places of the scalar pairs (0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2),
            shape (n, 6) or (n, 0).
    """

    pairs: Ints
    scalars: Ints
    mixed: Ints
    own: Ints


@dataclass(frozen=True, eq=False)
class Structure:
    """Where the local blocks of the terms go; computed once per mesh.

    Attributes:
        pattern: pattern of the Hessian on all degrees of freedom.
        gather: for each entry of the pattern its place in the flat storage.
        slots: of each term.
        storage: length of the flat storage: 3 × 3 blocks of node pairs, then 3 entries for
            each pair of a node and a scalar, then one for each pair of scalars.
    """

    pattern: SymmetricPattern
    gather: NDArray[np.int32]
    slots: tuple[Slots, ...]
    storage: int


def assembly_map(terms: Sequence[Term], node_count: int, scalar_count: int) -> Structure:
    """Number the pairs of nodes and scalars that occur, and map the pattern's entries to them.

    Args:
        terms: the terms of the energy.
        node_count: V.
        scalar_count: number of scalar unknowns, which follow the 3 V coordinates.
    """
    size = 3 * node_count + scalar_count
    pair_keys, flips, mixed_keys, own_keys = [], [], [], []
    for term in terms:
        stencil, scalars = np.asarray(term.stencil, dtype=np.int64), scalar_unknowns(term)
        p, q = np.triu_indices(stencil.shape[1])
        first, second = stencil[:, p], stencil[:, q]
        pair_keys.append(np.minimum(first, second) * node_count + np.maximum(first, second))
        flips.append(first > second)
        nodes, columns = np.broadcast_arrays(
            stencil[:, :, None], scalars[:, None, :].astype(np.int64)
        )
        mixed_keys.append((nodes * size + columns).reshape(len(stencil), -1))
        r, c = np.triu_indices(scalars.shape[1])
        low = np.minimum(scalars[:, r], scalars[:, c]).astype(np.int64)
        own_keys.append(low * size + np.maximum(scalars[:, r], scalars[:, c]))
    every_node = np.arange(node_count, dtype=np.int64) * (node_count + 1)
    every_scalar = np.arange(3 * node_count, size, dtype=np.int64) * (size + 1)
    blocks = np.unique(np.concatenate([every_node, *(key.ravel() for key in pair_keys)]))
    mixed = np.unique(np.concatenate([key.ravel() for key in mixed_keys]))
    own = np.unique(np.concatenate([every_scalar, *(key.ravel() for key in own_keys)]))
    after_blocks = 9 * len(blocks)
    after_mixed = after_blocks + 3 * len(mixed)
    slots = []
    for term, pair_key, flip, mixed_key, own_key in zip(
        terms, pair_keys, flips, mixed_keys, own_keys, strict=True
    ):
        slot = np.searchsorted(blocks, pair_key)
        slots.append(
            Slots(
                pairs=np.where(flip, -1 - slot, slot).astype(np.int32),
                scalars=scalar_unknowns(term),
                mixed=(after_blocks + 3 * np.searchsorted(mixed, mixed_key)).astype(np.int32),
                own=(after_mixed + np.searchsorted(own, own_key)).astype(np.int32),
            )
        )
    # Rows and columns of all stored entries, without the strict lower triangle.
    r, c = np.divmod(np.arange(9), 3)
    rows = np.concatenate(
        [
            (3 * (blocks // node_count)[:, None] + r).ravel(),
            (3 * (mixed // size)[:, None] + np.arange(3)).ravel(),
            own // size,
        ]
    ).astype(np.int32)
    columns = np.concatenate(
        [
            (3 * (blocks % node_count)[:, None] + c).ravel(),
            np.repeat(mixed % size, 3),
            own % size,
        ]
    ).astype(np.int32)
    upper = np.flatnonzero(columns >= rows)
    gather = upper[np.lexsort((columns[upper], rows[upper]))].astype(np.int32)
    counts = np.bincount(rows[gather], minlength=size)
    indptr = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
    pattern = SymmetricPattern(size, indptr, np.ascontiguousarray(columns[gather]))
    return Structure(pattern, gather, tuple(slots), len(rows))
