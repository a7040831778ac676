"""The softest modes, against dense eigenvalues of the same matrices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
import scipy.linalg
from toys import Pitchfork, dense_pattern, system_of

from sheetmorph.core.errors import ComputationError
from sheetmorph.solve.constraints import HeldDofs
from sheetmorph.solve.eigen import smallest_modes
from sheetmorph.solve.linear import available, make_solver
from sheetmorph.solve.system import System


@dataclass(frozen=True, eq=False)
class Quadratic:
    """xᵀ H x / 2."""

    matrix: np.ndarray

    @property
    def pattern(self):  # type: ignore[no-untyped-def]
        return dense_pattern(len(self.matrix))

    def at(self, ramp: float, load: float) -> Quadratic:
        return self

    def evaluate(self, x, order):  # type: ignore[no-untyped-def]
        upper = self.matrix[np.triu_indices(len(x))]
        return float(x @ self.matrix @ x) / 2, self.matrix @ x, upper if order >= 2 else None


def with_eigenvalues(values: list[float] | np.ndarray, seed: int = 0) -> np.ndarray:
    q, _ = np.linalg.qr(np.random.default_rng(seed).standard_normal((len(values),) * 2))
    return (q * np.asarray(values)) @ q.T


def system_for(matrix: np.ndarray, held: list[int] | None = None, solver: str = "auto") -> System:
    energy = Quadratic(matrix)
    mask = np.zeros(len(matrix), dtype=bool)
    mask[held or []] = True
    return System(energy, HeldDofs.of(energy.pattern, mask), make_solver(energy.pattern, solver))


@pytest.mark.parametrize("solver", available())
@pytest.mark.parametrize("n", [12, 80])
def test_negative_and_positive_ones(n: int, solver: str) -> None:
    values = np.concatenate([[-7.0, -0.2, 1e-3, 0.5], np.linspace(1.0, 100.0, n - 4)])
    matrix = with_eigenvalues(values)
    found = smallest_modes(system_for(matrix, solver=solver), np.zeros(n), 4)
    np.testing.assert_allclose(found.eigenvalues, values[:4], rtol=1e-7, atol=1e-10)
    assert found.negative == 2
    for value, v in zip(found.eigenvalues, found.vectors, strict=True):
        np.testing.assert_allclose(matrix @ v, value * v, atol=1e-6)
        assert np.linalg.norm(v) == pytest.approx(1.0, abs=1e-12)


def test_multiple_ones_are_all_found() -> None:
    values = np.concatenate([[1.0, 1.0, 1.0, 2.0, 2.0], np.linspace(5.0, 100.0, 75)])
    found = smallest_modes(system_for(with_eigenvalues(values)), np.zeros(80), 5)
    np.testing.assert_allclose(found.eigenvalues, [1, 1, 1, 2, 2], rtol=1e-9)
    assert found.checked
    np.testing.assert_allclose(found.vectors @ found.vectors.T, np.eye(5), atol=1e-7)


@pytest.mark.parametrize("n", [12, 80])
def test_weights_zero_weights_and_held(n: int) -> None:
    """What has no weight follows in equilibrium: the Schur complement is what is left."""
    rng = np.random.default_rng(3)
    matrix = with_eigenvalues(np.geomspace(0.1, 10.0, n))
    weights = rng.uniform(0.5, 2.0, n)
    weights[[1, 5]] = 0.0
    held = [0, 7]
    found = smallest_modes(system_for(matrix, held), np.zeros(n), 3, weights=weights)
    heavy = [k for k in range(n) if k not in (0, 7, 1, 5)]
    light = [1, 5]
    schur = matrix[np.ix_(heavy, heavy)] - matrix[np.ix_(heavy, light)] @ np.linalg.solve(
        matrix[np.ix_(light, light)], matrix[np.ix_(light, heavy)]
    )
    known = scipy.linalg.eigh(schur, np.diag(weights[heavy]), eigvals_only=True)[:3]
    np.testing.assert_allclose(found.eigenvalues, known, rtol=1e-8)
    assert not found.vectors[:, held].any()
    np.testing.assert_allclose(found.vectors**2 @ weights, 1.0, rtol=1e-10)


@pytest.mark.parametrize("second", [-0.5, 0.5])
def test_motions_without_energy_are_left_out(second: float) -> None:
    values = np.concatenate([[0.0, 0.0, second, 1.0], np.linspace(2.0, 50.0, 56)])
    q, _ = np.linalg.qr(np.random.default_rng(1).standard_normal((60, 60)))
    matrix = (q * values) @ q.T
    rigid = q[:, :2].T @ np.eye(60)
    mixed = np.array([rigid[0] + rigid[1], rigid[0] - 2 * rigid[1]])
    found = smallest_modes(system_for(matrix), np.zeros(60), 3, rigid=mixed)
    np.testing.assert_allclose(found.eigenvalues, [second, 1.0, 2.0], rtol=1e-6)
    np.testing.assert_allclose(found.vectors @ mixed.T, 0.0, atol=1e-8)
    assert found.checked


def test_a_strut_before_and_beyond_its_buckling() -> None:
    for ramp, value in ((0.1, 0.2), (0.7, -0.4)):
        found = smallest_modes(system_of(Pitchfork().at(ramp, 0.0)), np.zeros(2), 5)
        np.testing.assert_allclose(found.eigenvalues, [value, 1.0], rtol=1e-9)


def test_a_hessian_that_no_shift_mends() -> None:
    """A negative entry where there is no weight."""
    with pytest.raises(ComputationError, match="no shift"):
        smallest_modes(
            system_for(np.diag([1.0, -1.0, 2.0])), np.zeros(3), 1, weights=np.array([1.0, 0.0, 1.0])
        )
