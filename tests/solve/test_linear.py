"""The solvers agree with dense algebra and with one another."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_array, diags_array, triu

from sheetmorph.core.errors import InputError
from sheetmorph.core.sparse import SymmetricPattern
from sheetmorph.solve import linear
from sheetmorph.solve.linear import SOLVERS, SingularMatrixError, available, make_solver

N = 14 * 14


def laplacian(shift: float = 0.0) -> tuple[SymmetricPattern, np.ndarray, np.ndarray]:
    """A 2D grid Laplacian minus a shift: pattern, entries, dense matrix."""
    main = diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(14, 14))
    eye = diags_array([1.0], offsets=[0], shape=(14, 14))
    from scipy.sparse import kron

    full = csr_array(kron(main, eye) + kron(eye, main)) - shift * diags_array(
        [1.0], offsets=[0], shape=(N, N)
    )
    upper = csr_array(triu(full, format="csr"))
    upper.sort_indices()
    pattern = SymmetricPattern(N, upper.indptr.astype(np.int32), upper.indices.astype(np.int32))
    return pattern, upper.data, full.toarray()


needs = [
    pytest.param(n, marks=pytest.mark.skipif(n not in available(), reason=f"{n} is not installed"))
    for n in SOLVERS
]


@pytest.mark.parametrize("name", needs)
def test_definite(name: str) -> None:
    pattern, data, dense = laplacian()
    solver = make_solver(pattern, name)
    assert solver.factorise(data)
    rhs = np.random.default_rng(0).standard_normal(N)
    np.testing.assert_allclose(solver.solve(rhs), np.linalg.solve(dense, rhs), rtol=1e-10)
    assert solver.factorise_indefinite(data) == 0
    np.testing.assert_allclose(solver.solve(rhs), np.linalg.solve(dense, rhs), rtol=1e-10)


@pytest.mark.parametrize("name", needs)
@pytest.mark.parametrize("shift", [0.5, 1.3, 4.1, 9.0])
def test_inertia_and_solution_when_indefinite(name: str, shift: float) -> None:
    pattern, data, dense = laplacian(shift)
    solver = make_solver(pattern, name)
    negative = int((np.linalg.eigvalsh(dense) < 0).sum())
    assert negative > 0
    assert not solver.factorise(data)
    assert solver.factorise_indefinite(data) == negative
    rhs = np.random.default_rng(1).standard_normal(N)
    np.testing.assert_allclose(solver.solve(rhs), np.linalg.solve(dense, rhs), rtol=1e-8)


@pytest.mark.parametrize("name", needs)
def test_works_again_after_an_indefinite_matrix(name: str) -> None:
    pattern, data, dense = laplacian()
    solver = make_solver(pattern, name)
    _, bad, _ = laplacian(4.1)
    rhs = np.ones(N)
    for _ in range(3):
        assert not solver.factorise(bad)
        assert solver.factorise(data)
        np.testing.assert_allclose(solver.solve(rhs), np.linalg.solve(dense, rhs), rtol=1e-10)


@pytest.mark.parametrize("name", needs)
def test_singular_and_not_finite(name: str) -> None:
    pattern, data, _ = laplacian()
    solver = make_solver(pattern, name)
    assert not solver.factorise(np.zeros_like(data))
    for bad in (np.nan, np.inf):
        spoilt = data.copy()
        spoilt[7] = bad
        with pytest.raises(SingularMatrixError, match="finite"):
            solver.factorise(spoilt)


def test_auto_takes_the_fastest_that_is_there(monkeypatch: pytest.MonkeyPatch) -> None:
    pattern, _, _ = laplacian()
    assert make_solver(pattern).name.split()[0].split("-")[0] == available()[0].split("-")[0]
    real = linear.find_spec
    monkeypatch.setattr(
        linear, "find_spec", lambda m: None if m in ("pymklpardiso", "rslab") else real(m)
    )
    assert available() == ["scipy"]
    assert make_solver(pattern).name.startswith("scipy-superlu")
    with pytest.raises(InputError, match=r"solver\.linear_solver: .*not installed.*allowed: auto"):
        make_solver(pattern, "mkl")
    with pytest.raises(InputError, match="unknown linear solver"):
        make_solver(pattern, "umfpack")


def test_symmetric_product() -> None:
    pattern, data, dense = laplacian(0.3)
    x = np.random.default_rng(2).standard_normal(N)
    product = linear.symmetric_product(pattern.indptr, pattern.indices, data, x)
    np.testing.assert_allclose(product, dense @ x, atol=1e-13)
    np.testing.assert_array_equal(pattern.full(data).toarray(), dense)
