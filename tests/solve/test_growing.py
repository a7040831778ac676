"""A pattern that grows: the same answers as dense algebra, whatever has come and gone."""

from __future__ import annotations

import numpy as np
import pytest

from sheetmorph.core.sparse import Growth, SymmetricPattern, symmetric_matrix
from sheetmorph.solve.constraints import HeldDofs
from sheetmorph.solve.linear import available, make_solver
from sheetmorph.solve.system import System

NODES = 5
N = 3 * NODES


def diagonal() -> SymmetricPattern:
    return SymmetricPattern(N, np.arange(N + 1, dtype=np.int32), np.arange(N, dtype=np.int32))


def grown(growth: Growth, pairs: list[tuple[int, int]], seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Entries with random blocks at pairs, and the dense matrix that they stand for."""
    rng = np.random.default_rng(seed)
    slots = growth.add(np.array(pairs, dtype=np.int64).reshape(-1, 2))
    data = np.concatenate([np.full(N, 9.0), np.zeros(growth.count)])
    dense = 9.0 * np.eye(N)
    for slot, (p, q) in zip(slots, pairs, strict=True):
        block = rng.standard_normal((3, 3))
        block = np.triu(block) if p == q else block
        data[N + 9 * slot : N + 9 * slot + 9] = block.ravel()
        whole = block + block.T - np.diag(np.diag(block)) if p == q else block
        dense[3 * p : 3 * p + 3, 3 * q : 3 * q + 3] += whole
        if p != q:
            dense[3 * q : 3 * q + 3, 3 * p : 3 * p + 3] += block.T
    return data, dense


@pytest.mark.parametrize("name", available())
def test_solutions_and_inertia_as_the_pattern_grows(name: str) -> None:
    growth = Growth()
    solver = make_solver(diagonal(), name, growth=growth)
    rhs = np.random.default_rng(0).standard_normal(N)
    for seed, pairs in enumerate(
        ([], [(0, 3)], [(0, 3), (1, 1), (1, 4)], [(0, 3)], [(2, 3), (2, 4)])
    ):
        if seed == 4:
            growth.begin()
        data, dense = grown(growth, pairs, seed)
        np.testing.assert_array_equal(symmetric_matrix(diagonal(), growth, data).toarray(), dense)
        assert solver.factorise(data)
        np.testing.assert_allclose(solver.solve(rhs), np.linalg.solve(dense, rhs), rtol=1e-10)
        data[:N] -= 8.5
        negative = int((np.linalg.eigvalsh(dense - 8.5 * np.eye(N)) < 0).sum())
        assert solver.factorise_indefinite(data) == negative
    assert len(growth.pairs) == 2


def test_entries_from_before_a_new_beginning_are_refused() -> None:
    growth = Growth()
    solver = make_solver(diagonal(), growth=growth)
    data, _ = grown(growth, [(0, 1), (1, 2)], 0)
    growth.begin()
    with pytest.raises(ValueError, match="began anew"):
        solver.factorise(data)


def test_held_degrees_of_freedom_are_free_of_what_has_grown() -> None:
    growth = Growth()
    held = np.zeros(N, dtype=bool)
    held[[0, 10]] = True

    class Grown:
        pattern = diagonal()

        def evaluate(self, x, order):  # type: ignore[no-untyped-def]
            return 0.0, np.ones(N), grown(growth, [(0, 3), (0, 0), (1, 2)], 3)[0]

    system = System(Grown(), HeldDofs.of(diagonal(), held), make_solver(diagonal(), growth=growth))
    _, _, data = system.hessian(np.zeros(N))
    full = symmetric_matrix(diagonal(), growth, data).toarray()
    expected = grown(growth, [(0, 3), (0, 0), (1, 2)], 3)[1]
    expected[held] = 0.0
    expected[:, held] = 0.0
    expected[held, held] = 9.0
    np.testing.assert_allclose(full, expected)
