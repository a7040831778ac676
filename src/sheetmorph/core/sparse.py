"""The pattern of a sparse symmetric matrix, shared by assembly and factorisation; how it grows."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array


@dataclass(frozen=True, eq=False)
class SymmetricPattern:
    """Upper triangle of a symmetric matrix by rows; equally its lower triangle by columns.

    Attributes:
        size: number of rows n.
        indptr: start of each row in `indices`, shape (n + 1,).
        indices: column of each entry, sorted in each row, diagonal first, shape (nnz,).
    """

    size: int
    indptr: NDArray[np.int32]
    indices: NDArray[np.int32]

    @property
    def nnz(self) -> int:
        """Number of stored entries."""
        return len(self.indices)

    def full(self, data: NDArray[np.float64]) -> csr_array:
        """Both triangles of the matrix with the given entries, as a SciPy CSR array."""
        upper = csr_array((data, self.indices, self.indptr), shape=(self.size, self.size))
        diagonal = data[self.indptr[:-1]]
        full = csr_array(upper + upper.T)
        full.setdiag(diagonal)
        return full


def _none() -> NDArray[np.int64]:
    return np.zeros((0, 2), dtype=np.int64)


@dataclass
class Growth:
    """Blocks of a symmetric matrix beside its fixed pattern, which come and go.

    The entries of such a matrix are those of the fixed pattern, then nine for each pair of nodes
    in `pairs`, row by row. Pairs are added at the end, so that entries made before stay where
    they are; now and then `begin` starts anew.

    Attributes:
        pairs: nodes (p, q), p ≤ q, shape (k, 2); of a pair (p, p) the lower triangle is zero.
        version: a number that changes with the pairs.
    """

    pairs: NDArray[np.int64] = field(default_factory=_none)
    version: int = 0

    def begin(self) -> None:
        """Forget all pairs."""
        self.pairs = _none()
        self.version += 1

    def add(self, pairs: NDArray[np.int64]) -> NDArray[np.intp]:
        """Make sure that pairs are there.

        Args:
            pairs: distinct ones, p ≤ q, shape (m, 2).

        Returns:
            Their places in `pairs`, shape (m,).
        """
        width = int(max(self.pairs.max(initial=0), pairs.max(initial=0))) + 1
        known, asked = (rows[:, 0] * width + rows[:, 1] for rows in (self.pairs, pairs))
        new = ~np.isin(asked, known)
        if new.any():
            self.pairs = np.concatenate([self.pairs, pairs[new]])
            self.version += 1
            known = self.pairs[:, 0] * width + self.pairs[:, 1]
        order = np.argsort(known, kind="stable")
        return np.asarray(order[np.searchsorted(known[order], asked)])

    @property
    def count(self) -> int:
        """Number of entries beyond the fixed pattern."""
        return 9 * len(self.pairs)

    def places(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Rows and columns of the entries beyond the fixed pattern, shape (count,) each."""
        row, column = np.divmod(np.arange(9), 3)
        rows = (3 * self.pairs[:, :1] + row).ravel()
        columns = (3 * self.pairs[:, 1:] + column).ravel()
        return np.minimum(rows, columns), np.maximum(rows, columns)

    def joined(
        self, pattern: SymmetricPattern
    ) -> tuple[SymmetricPattern, NDArray[np.intp], NDArray[np.intp]]:
        """A pattern with both, and where the entries of each are in it.

        Returns:
            The pattern; places of the entries of the fixed one, shape (nnz,), and of those
            beyond it, shape (count,).
        """
        n = pattern.size
        rows = np.repeat(np.arange(n, dtype=np.int64), np.diff(pattern.indptr))
        fixed = rows * n + pattern.indices
        beyond_rows, beyond_columns = self.places()
        beyond = beyond_rows * n + beyond_columns
        keys = np.union1d(fixed, beyond)
        counts = np.bincount(keys // n, minlength=n)
        indptr = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
        whole = SymmetricPattern(n, indptr, (keys % n).astype(np.int32))
        return whole, np.searchsorted(keys, fixed), np.searchsorted(keys, beyond)


def symmetric_matrix(
    pattern: SymmetricPattern, growth: Growth | None, data: NDArray[np.float64]
) -> csr_array:
    """Both triangles of a matrix whose pattern may have grown, as a SciPy CSR array.

    Args:
        pattern: the fixed pattern.
        growth: what is beyond it; None for nothing.
        data: entries of both, shape (nnz + count,).
    """
    if growth is None:
        return pattern.full(data)
    whole, fixed, beyond = growth.joined(pattern)
    joined = np.zeros(whole.nnz)
    joined[fixed] = data[: pattern.nnz]
    np.add.at(joined, beyond, data[pattern.nnz :])
    return whole.full(joined)
