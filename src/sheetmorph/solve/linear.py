"""Sparse symmetric factorisation behind one small interface, several libraries behind it."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.compiled import kernel
from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.core.sparse import Growth, SymmetricPattern

Floats = NDArray[np.float64]


class SingularMatrixError(ComputationError):
    """The matrix has no usable factorisation (a zero pivot, or entries that are not finite)."""


class LinearSolver(Protocol):
    """Factorise matrices of one pattern and solve with the last factor.

    The analysis of the pattern is made once. Newton's method only needs to know whether a
    matrix is positive definite, which libraries find out faster than the whole inertia.

    Attributes:
        name: library and version, for the record.
    """

    name: str

    def factorise(self, data: Floats) -> bool:
        """Factorise the matrix with these upper-triangle entries.

        Args:
            data: entries in the order of the pattern, shape (nnz,).

        Returns:
            True when the matrix is positive definite to working accuracy. Only then may
            `solve` be called.

        Raises:
            SingularMatrixError: an entry is not finite, or the library failed.
        """
        ...

    def factorise_indefinite(self, data: Floats) -> int:
        """Factorise a matrix of any inertia.

        Returns:
            Number of negative pivots: by Sylvester's law that of negative eigenvalues.

        Raises:
            SingularMatrixError: no factor exists, or the inertia cannot be trusted.
        """
        ...

    def solve(self, rhs: Floats) -> Floats:
        """Solve with the last factor; shape (n,)."""
        ...


class MklPardiso:
    """Intel oneMKL PARDISO through `py-mkl-pardiso`: Cholesky, and LDLᵀ where inertia counts.

    Reference: Schenk, Gärtner, On fast factorization pivoting methods for sparse symmetric
    indefinite systems, ETNA 23 (2006).
    """

    SMALL = 10_000
    """Unknowns below which a minimum-degree ordering leads to the faster factorisation."""

    def __init__(self, pattern: SymmetricPattern, threads: int = 1) -> None:
        del threads  # the wheels of py-mkl-pardiso link the sequential library
        import pymklpardiso

        self._pattern = pattern
        self._definite: Any = self._handle(pymklpardiso.MTYPE_REAL_SYM_POSDEF)
        self._indefinite: Any = None
        self._last: Any = None
        self._analysed: set[int] = set()
        self.name = f"mkl-pardiso {_version('py-mkl-pardiso')}"

    def _handle(self, kind: int) -> Any:
        # The public class checks the triangle row by row in Python, so the one below it.
        from pymklpardiso._mkl_pardiso import PardisoSolver

        handle = PardisoSolver(kind, 0)
        handle.set_iparm(1, 0 if self._pattern.size < self.SMALL else 2)
        handle.set_iparm(9, 13)  # perturb only pivots below 1e-13 of the norm
        handle.set_iparm(20, 1)  # 1×1 and 2×2 Bunch–Kaufman pivots where indefinite
        handle.set_pattern(
            self._pattern.indptr.astype(np.int64),
            self._pattern.indices.astype(np.int64),
            self._pattern.size,
        )
        return handle

    def _factorise(self, handle: Any, data: Floats) -> None:
        if id(handle) in self._analysed:
            handle.refactor_values(data)
        else:
            handle.factor(data)
            self._analysed.add(id(handle))
        self._last = handle

    def factorise(self, data: Floats) -> bool:
        """See `LinearSolver.factorise`."""
        _check_finite(data)
        try:
            self._factorise(self._definite, data)
        except RuntimeError:
            return False
        return True

    def factorise_indefinite(self, data: Floats) -> int:
        """See `LinearSolver.factorise_indefinite`."""
        import pymklpardiso

        _check_finite(data)
        if self._indefinite is None:
            self._indefinite = self._handle(pymklpardiso.MTYPE_REAL_SYM_INDEF)
        try:
            self._factorise(self._indefinite, data)
        except RuntimeError as error:
            raise SingularMatrixError(f"PARDISO could not factorise the Hessian: {error}") from None
        perturbed = self._indefinite.get_iparm_value(13)
        if perturbed:
            raise SingularMatrixError(f"PARDISO had to perturb {perturbed} vanishing pivots")
        return int(self._indefinite.get_iparm_value(22))

    def solve(self, rhs: Floats) -> Floats:
        """See `LinearSolver.solve`."""
        return np.asarray(self._last.solve(rhs))


class Rslab:
    """The supernodal LDLᵀ of `rslab` (Bunch–Kaufman). Young, so each solve is checked."""

    RESIDUAL_LIMIT = 1e-8

    def __init__(self, pattern: SymmetricPattern, threads: int = 1) -> None:
        import rslab
        from scipy.sparse import csc_array

        self._pattern = pattern
        lower = csc_array(
            (np.ones(pattern.nnz), pattern.indices, pattern.indptr),
            shape=(pattern.size, pattern.size),
        )
        self._symbolic: Any = rslab.analyze(lower, path="ldlt", threads=threads)
        self._factor: Any = None
        self._data: Floats = np.zeros(0)
        self.name = f"rslab {_version('rslab')}"

    def factorise(self, data: Floats) -> bool:
        """See `LinearSolver.factorise`."""
        return _positive(self, data)

    def factorise_indefinite(self, data: Floats) -> int:
        """See `LinearSolver.factorise_indefinite`."""
        _check_finite(data)
        self._factor = None  # free the old factor before the new one is made
        try:
            self._factor = self._symbolic.factor(data)
        except RuntimeError as error:
            raise SingularMatrixError(f"rslab could not factorise the Hessian: {error}") from None
        self._data = data
        _, negative, zero = self._factor.inertia
        if zero:
            raise SingularMatrixError(f"the Hessian has {zero} vanishing pivots")
        return int(negative)

    def solve(self, rhs: Floats) -> Floats:
        """See `LinearSolver.solve`; raises SingularMatrixError when the residual is large."""
        x: Floats = np.asarray(self._factor.solve(rhs))
        p = self._pattern
        for _ in range(2):
            residual = rhs - symmetric_product(p.indptr, p.indices, self._data, x)
            scale = np.abs(rhs).max(initial=0.0)
            if not np.abs(residual).max(initial=0.0) > self.RESIDUAL_LIMIT * scale:
                return x
            x = x + np.asarray(self._factor.solve(residual))
        raise SingularMatrixError("rslab returned a solution with a large residual")


class ScipySuperLU:
    """SciPy's SuperLU in symmetric mode: the portable last resort.

    Without row exchanges LU is LDLᵀ with U = D Lᵀ, so the signs of the diagonal of U give
    the inertia. Where an exchange was needed, a small symmetric shift is the caller's remedy.
    """

    def __init__(self, pattern: SymmetricPattern, threads: int = 1) -> None:
        import scipy

        del threads
        from scipy.sparse import csr_array

        self._pattern = pattern
        numbered = csr_array(
            (np.arange(1.0, pattern.nnz + 1.0), pattern.indices, pattern.indptr),
            shape=(pattern.size, pattern.size),
        )
        strict = numbered - csr_array(
            (numbered.diagonal(), (np.arange(pattern.size),) * 2), shape=numbered.shape
        )
        strict.eliminate_zeros()
        full = (numbered + strict.T).tocsc()
        full.sort_indices()
        self._gather = np.rint(full.data).astype(np.int64) - 1
        self._full: Any = full
        self._lu: Any = None
        self.name = f"scipy-superlu {scipy.__version__}"

    def factorise(self, data: Floats) -> bool:
        """See `LinearSolver.factorise`."""
        return _positive(self, data)

    def factorise_indefinite(self, data: Floats) -> int:
        """See `LinearSolver.factorise_indefinite`."""
        from scipy.sparse.linalg import splu

        _check_finite(data)
        self._full.data = data[self._gather]
        self._lu = None
        try:
            self._lu = splu(
                self._full,
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            raise SingularMatrixError(f"SuperLU could not factorise the Hessian: {error}") from None
        if not np.array_equal(self._lu.perm_r, self._lu.perm_c):
            raise SingularMatrixError("SuperLU had to exchange rows, which hides the inertia")
        return int(np.count_nonzero(self._lu.U.diagonal() < 0))

    def solve(self, rhs: Floats) -> Floats:
        """See `LinearSolver.solve`."""
        return np.asarray(self._lu.solve(rhs))


class Growing:
    """Any of the solvers for matrices whose pattern grows, as where parts of the sheet touch.

    The pattern is analysed anew whenever what is beyond the fixed one has changed.

    Attributes:
        growth: what matrices have beyond the fixed pattern.
    """

    def __init__(
        self, pattern: SymmetricPattern, growth: Growth, choice: str = "auto", threads: int = 1
    ) -> None:
        self.growth = growth
        self._pattern, self._choice, self._threads = pattern, choice, threads
        self._version = -1
        self._renew()
        self.name = self._inner.name

    def _renew(self) -> None:
        if self._version == self.growth.version:
            return
        whole, self._fixed, self._beyond = self.growth.joined(self._pattern)
        self._inner = make_solver(whole, self._choice, self._threads)
        self._size, self._version = whole.nnz, self.growth.version

    def _joined(self, data: Floats) -> Floats:
        self._renew()
        count = self._pattern.nnz
        if len(data) != count + len(self._beyond):
            raise ValueError("these entries were made before the pattern began anew")
        joined = np.zeros(self._size)
        joined[self._fixed] = data[:count]
        np.add.at(joined, self._beyond, data[count:])
        return joined

    def factorise(self, data: Floats) -> bool:
        """See `LinearSolver.factorise`."""
        joined = self._joined(data)  # first: it may take another solver
        return self._inner.factorise(joined)

    def factorise_indefinite(self, data: Floats) -> int:
        """See `LinearSolver.factorise_indefinite`."""
        joined = self._joined(data)
        return self._inner.factorise_indefinite(joined)

    def solve(self, rhs: Floats) -> Floats:
        """See `LinearSolver.solve`."""
        return self._inner.solve(rhs)


SOLVERS: dict[str, tuple[str, type[MklPardiso] | type[Rslab] | type[ScipySuperLU]]] = {
    "mkl": ("pymklpardiso", MklPardiso),
    "rslab": ("rslab", Rslab),
    "scipy": ("scipy", ScipySuperLU),
}
"""Name in the design file → (module it needs, class), fastest first."""


def make_solver(
    pattern: SymmetricPattern,
    choice: str = "auto",
    threads: int = 1,
    growth: Growth | None = None,
) -> LinearSolver:
    """The chosen solver, or with "auto" the fastest that is installed and loads.

    Args:
        pattern: of the matrices.
        choice: name of the library.
        threads: of the library, where it has any.
        growth: what matrices have beyond the pattern; see `Growing`.

    Raises:
        InputError: the name is unknown, or the library is not installed here.
    """
    if choice != "auto" and choice not in SOLVERS:
        raise InputError(
            "unknown linear solver",
            key="solver.linear_solver",
            value=choice,
            allowed=", ".join(["auto", *SOLVERS]),
        )
    if growth is not None:
        return Growing(pattern, growth, choice, threads)
    names = list(SOLVERS) if choice == "auto" else [choice]
    for name in names:
        module, factory = SOLVERS[name]
        if find_spec(module) is None:
            continue
        try:
            return factory(pattern, threads)
        except ImportError:
            continue
    raise InputError(
        f"the linear solver {choice!r} is not installed on this machine",
        key="solver.linear_solver",
        value=choice,
        allowed=", ".join(["auto", *available()]),
    )


def available() -> list[str]:
    """Names of the solvers whose library is installed, fastest first."""
    return [name for name, (module, _) in SOLVERS.items() if find_spec(module) is not None]


@kernel
def symmetric_product(indptr, indices, data, x):  # type: ignore[no-untyped-def]
    """A x for a symmetric matrix given by its upper triangle in rows, diagonal first."""
    y = np.zeros_like(x)
    for i in range(len(indptr) - 1):
        start = indptr[i]
        total = data[start] * x[i]
        for k in range(start + 1, indptr[i + 1]):
            j = indices[k]
            total += data[k] * x[j]
            y[j] += data[k] * x[i]
        y[i] += total
    return y


def _positive(solver: LinearSolver, data: Floats) -> bool:
    """Positive definiteness for libraries without a Cholesky factorisation of their own."""
    _check_finite(data)
    try:
        return solver.factorise_indefinite(data) == 0
    except SingularMatrixError:
        return False


def _check_finite(data: Floats) -> None:
    # One reduction: any NaN or infinity survives a sum.
    if not np.isfinite(data.sum()):
        raise SingularMatrixError("the Hessian has entries that are not finite numbers")


def _version(package: str) -> str:
    from importlib.metadata import version

    return version(package)
