"""The sum of all terms: gather positions, evaluate locally, scatter into a fixed pattern."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.compiled import kernel
from sheetmorph.core.sparse import SymmetricPattern
from sheetmorph.energy.term import Term
from sheetmorph.geometry.mesh import Floats

CHUNK = 1024
"""Elements evaluated at a time: enough to hide the calls, few enough to stay in cache."""


@dataclass(frozen=True, eq=False)
class Structure:
    """Where the local blocks of the terms go; computed once per mesh.

    Attributes:
        pattern: pattern of the Hessian on all 3 V degrees of freedom.
        gather: for each entry of the pattern its place in the flat block storage.
        slots: per term, the storage block of each local pair, shape (n, pairs); −1 − block
            where the local block must be transposed.
        blocks: number of stored 3 × 3 blocks.
    """

    pattern: SymmetricPattern
    gather: NDArray[np.int32]
    slots: tuple[NDArray[np.int32], ...]
    blocks: int


@dataclass(frozen=True, eq=False)
class Total:
    """The energy of the sheet as a function of all node positions.

    Attributes:
        terms: the terms, at the current actuation and load.
        structure: assembly map, shared by all copies.
        workspace: scratch arrays, shared by all copies (one evaluation at a time).
    """

    terms: tuple[Term, ...]
    structure: Structure
    workspace: Workspace

    @classmethod
    def of(cls, terms: Sequence[Term], node_count: int) -> Total:
        """Build the pattern of the Hessian and the scratch arrays for these terms."""
        structure = _structure([np.asarray(t.stencil) for t in terms], node_count)
        return cls(tuple(terms), structure, Workspace.of(terms, structure))

    def at(self, ramp: float, load: float) -> Total:
        """The same energy at a fraction of the actuation and of the perturbation load."""
        return replace(self, terms=tuple(t.at(ramp, load) for t in self.terms))

    @property
    def pattern(self) -> SymmetricPattern:
        """Pattern of the Hessian, shape (3 V, 3 V)."""
        return self.structure.pattern

    def evaluate(self, x: Floats, order: int) -> tuple[float, Floats | None, Floats | None]:
        """Energy, gradient and Hessian at the positions x.

        Args:
            x: positions [m], shape (3 V,) or (V, 3), C-contiguous.
            order: 0 energy only, 1 with the gradient, 2 with the Hessian, 3 with the positive
                semidefinite part of the Hessian instead (see `Term.local`).

        Returns:
            Energy [J]; gradient [N], shape (3 V,); entries of the Hessian [N/m] in the order
            of `pattern`. The latter two are None where `order` does not ask for them.
        """
        work = self.workspace
        nodes = x.reshape(-1, 3)
        gradient = np.zeros(nodes.shape) if order >= 1 else work.no_gradient
        if order >= 2:
            work.blocks[:] = 0.0
        energy = 0.0
        for term, slots in zip(self.terms, self.structure.slots, strict=True):
            energy += _sum_term(term, slots, nodes, order, gradient, work)
        hessian = np.take(work.blocks.reshape(-1), self.structure.gather) if order >= 2 else None
        return energy, gradient.reshape(-1) if order >= 1 else None, hessian

    def energies(self, x: Floats) -> dict[str, float]:
        """Energy of each term [J] by its name."""
        nodes, work = x.reshape(-1, 3), self.workspace
        return {
            term.name: _sum_term(term, slots, nodes, 0, work.no_gradient, work)
            for term, slots in zip(self.terms, self.structure.slots, strict=True)
        }


@dataclass(frozen=True, eq=False)
class Workspace:
    """Scratch arrays of one assembly; the local ones are as long as a chunk."""

    blocks: Floats
    energy: Floats
    gradients: dict[int, Floats]
    hessians: dict[int, Floats]
    no_gradient: Floats
    no_hessian: Floats

    @classmethod
    def of(cls, terms: Sequence[Term], structure: Structure) -> Workspace:
        """Allocate for the stencil widths that occur."""
        widths = {t.stencil.shape[1] for t in terms}
        return cls(
            blocks=np.zeros((structure.blocks, 3, 3)),
            energy=np.zeros(CHUNK),
            gradients={m: np.zeros((CHUNK, m, 3)) for m in widths},
            hessians={m: np.zeros((CHUNK, m * (m + 1) // 2, 3, 3)) for m in widths},
            no_gradient=np.zeros((0, 3)),
            no_hessian=np.zeros((0, 0, 3, 3)),
        )

    def local(self, term: Term) -> tuple[Floats, Floats]:
        """Scratch for the local gradients and Hessians of a term."""
        width = term.stencil.shape[1]
        return self.gradients[width], self.hessians[width]


def _chunks(count: int) -> list[tuple[int, int]]:
    return [(start, min(start + CHUNK, count)) for start in range(0, count, CHUNK)]


def _sum_term(
    term: Term,
    slots: NDArray[np.int32],
    nodes: Floats,
    order: int,
    gradient: Floats,
    work: Workspace,
) -> float:
    local_order = min(order, 1) if term.linear else order
    local_gradient, local_hessian = work.local(term)
    energy = 0.0
    for start, stop in _chunks(len(term.stencil)):
        term.local(nodes, start, stop, local_order, work.energy, local_gradient, local_hessian)
        energy += _scatter(
            term.stencil,
            slots,
            start,
            stop,
            local_order,
            work.energy,
            local_gradient,
            local_hessian,
            gradient,
            work.blocks,
        )
    return energy


@kernel
def _scatter(stencil, slots, start, stop, order, energy, grad, hess, gradient, blocks):  # type: ignore[no-untyped-def]
    total = 0.0
    width = stencil.shape[1]
    for i in range(start, stop):
        k = i - start
        total += energy[k]
        if order < 1:
            continue
        for p in range(width):
            node = stencil[i, p]
            for c in range(3):
                gradient[node, c] += grad[k, p, c]
        if order < 2:
            continue
        for pair in range(slots.shape[1]):
            slot = slots[i, pair]
            if slot >= 0:
                for r in range(3):
                    for c in range(3):
                        blocks[slot, r, c] += hess[k, pair, r, c]
            else:
                slot = -1 - slot
                for r in range(3):
                    for c in range(3):
                        blocks[slot, c, r] += hess[k, pair, r, c]
    return total


def _structure(stencils: Sequence[NDArray[np.int32]], node_count: int) -> Structure:
    """Number the node pairs that occur, and map scalar upper-triangle entries onto them."""
    keys, flips = [], []
    for stencil in stencils:
        p, q = np.triu_indices(stencil.shape[1])
        first, second = stencil[:, p].astype(np.int64), stencil[:, q].astype(np.int64)
        keys.append(np.minimum(first, second) * node_count + np.maximum(first, second))
        flips.append(first > second)
    diagonal = np.arange(node_count, dtype=np.int64) * (node_count + 1)
    unique = np.unique(np.concatenate([diagonal, *(k.ravel() for k in keys)]))
    slots = []
    for key, flip in zip(keys, flips, strict=True):
        slot = np.searchsorted(unique, key).astype(np.int32)
        slots.append(np.where(flip, -1 - slot, slot).astype(np.int32))
    rows, cols = (unique // node_count).astype(np.int32), (unique % node_count).astype(np.int32)
    # Scalar entries of every block, without the strict lower triangle of the diagonal blocks.
    r, c = np.divmod(np.arange(9, dtype=np.int32), 3)
    entry_row = (3 * rows[:, None] + r).ravel()
    entry_col = (3 * cols[:, None] + c).ravel()
    place = np.flatnonzero(entry_col >= entry_row)
    order = np.lexsort((entry_col[place], entry_row[place]))
    gather = place[order].astype(np.int32)
    size = 3 * node_count
    counts = np.bincount(entry_row[gather], minlength=size)
    indptr = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
    pattern = SymmetricPattern(size, indptr, np.ascontiguousarray(entry_col[gather]))
    return Structure(pattern, gather, tuple(slots), len(unique))
