"""The pattern of a sparse symmetric matrix, shared by assembly and factorisation."""

from __future__ import annotations

from dataclasses import dataclass

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
