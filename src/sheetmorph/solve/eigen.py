"""The softest modes of an equilibrium: smallest eigenvalues of the Hessian and their vectors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import ComputationError
from sheetmorph.solve.system import System

Floats = NDArray[np.float64]

SMALL = 30
"""Degrees of freedom up to which all eigenvalues are computed at once."""

FIRST_SHIFT = 1e-10
"""Of a matrix that is not positive definite, as a fraction of its largest diagonal entry."""

MARGIN = 3
"""Eigenvalues found beyond those asked for, among which a gap is looked for."""


@dataclass(frozen=True, eq=False)
class Modes:
    """The smallest eigenvalues of a Hessian, increasing.

    Attributes:
        eigenvalues: λ of H v = λ W v, shape (k,).
        vectors: v with vᵀ W v = 1, zero at held degrees of freedom, shape (k, n).
        checked: True where the number of negative pivots of H − μ W has shown that none below
            the last of them was missed.
    """

    eigenvalues: Floats
    vectors: Floats
    checked: bool

    @property
    def negative(self) -> int:
        """How many of them are below zero."""
        return int(np.count_nonzero(self.eigenvalues < 0.0))


def smallest_modes(
    system: System,
    x: Floats,
    count: int,
    *,
    weights: Floats | None = None,
    rigid: Floats | None = None,
) -> Modes:
    """The smallest eigenvalues of the Hessian at x, by size and sign, and their vectors.

    The Hessian is shifted until it is positive definite, and the largest eigenvalues of its
    inverse are found by Lanczos' method with implicit restarts (ARPACK), each step of which is a
    solution with the factor. Multiple eigenvalues, of which Lanczos' method may find some alone,
    are counted by Sylvester's law.

    Args:
        system: the problem.
        x: the state, shape (n,).
        count: how many, at most the number of degrees of freedom that are neither held nor
            rigid nor without weight.
        weights: the diagonal of W, not negative, shape (n,); ones when None. The eigenvalues
            tell of displacements where it is not zero; the rest follows them in equilibrium.
        rigid: motions without energy that are to be left out, one a row, shape (m, n).

    Returns:
        The modes; fewer than `count` where there are no more.

    Raises:
        ComputationError: the Hessian stays indefinite, or eigenvalues are missed again and again.
    """
    weight = np.ones(len(x)) if weights is None else weights.copy()
    weight[system.held.held] = 0.0
    _, _, data = system.hessian(x)
    motions = _orthonormal(rigid, np.sqrt(weight))
    pencil = _Pencil(system, data, weight, motions)
    pencil.make_definite()
    moving = int(np.count_nonzero(weight)) - len(motions)
    wanted = min(count, moving)
    for attempt in range(4):
        sought = min(moving, (wanted + MARGIN) * (attempt + 1))
        values, vectors = _largest(pencil.inverse, len(x), sought, attempt, weight)
        values = 1.0 / values - pencil.shift
        order = np.argsort(values)
        values, vectors = values[order], vectors[:, order]
        checked = pencil.none_missed(values, wanted)
        pencil.factorise()  # the count has taken the place of the factor
        if checked is not False:
            shapes = pencil.unscaled(vectors[:, :wanted])
            return Modes(values[:wanted], shapes, bool(checked))
    raise ComputationError("eigenvalues of the Hessian are so close that some are missed")


class _Pencil:
    """H and W, and solutions with H + shift W between the square roots of W."""

    def __init__(self, system: System, data: Floats, weight: Floats, motions: Floats) -> None:
        self._system, self._data, self._motions = system, data, motions
        self._weight, self._root = weight, np.sqrt(weight)
        self._held = system.held.held
        self.shift = 0.0

    def _shifted(self, shift: float) -> Floats:
        data = self._data.copy()
        data[self._system.held.diagonal] += shift * self._weight
        return data

    def factorise(self) -> bool:
        """Factorise H + shift W; True when it is positive definite."""
        return self._system.factorise(self._shifted(self.shift))

    def make_definite(self) -> None:
        """Find the first shift of a series that makes H positive definite."""
        diagonal = np.abs(self._data[self._system.held.diagonal])
        has = self._weight > 0.0
        scale = float((diagonal[has] / self._weight[has]).max(initial=0.0)) or 1.0
        shifts = [FIRST_SHIFT * scale * 30.0**power for power in range(9)]
        # Rigid motions make H singular, so that none is not tried.
        for shift in shifts if len(self._motions) else [0.0, *shifts]:
            self.shift = shift
            if self.factorise():
                return
        raise ComputationError("no shift makes the Hessian positive definite")

    def inverse(self, y: Floats) -> Floats:
        """W^½ (H + shift W)⁻¹ W^½ y without the rigid motions."""
        y = y - self._motions.T @ (self._motions @ y)
        solved = self._root * self._system.solve(self._root * y)
        return np.asarray(solved - self._motions.T @ (self._motions @ solved))

    def unscaled(self, vectors: Floats) -> Floats:
        """The modes themselves, one a row, also where they have no weight."""
        rows = []
        for y in vectors.T:
            v = self._system.solve(self._root * y)
            v[self._held] = 0.0
            w = v * self._root
            if len(self._motions):
                v = v - self._rigid_part(self._motions @ w)
            rows.append(v / np.linalg.norm(v * self._root))
        return np.array(rows).reshape(len(rows), len(self._root))

    def _rigid_part(self, along: Floats) -> Floats:
        has = self._weight > 0.0
        part = np.zeros(len(self._root))
        part[has] = (along @ self._motions)[has] / self._root[has]
        return part

    def none_missed(self, values: Floats, wanted: int) -> bool | None:
        """Whether as many eigenvalues lie below a gap behind those wanted as were found.

        None where no factor exists that could tell.
        """
        if len(values) <= wanted:
            return True  # all there are
        gaps = np.diff(values[wanted - 1 :])
        widest = wanted - 1 + int(gaps.argmax())
        for part in (0.5, 0.4, 0.6):
            middle = values[widest] + part * (values[widest + 1] - values[widest])
            count = self._system.factorise_indefinite(self._shifted(-middle))
            if count is not None:
                rigid = len(self._motions) if middle > 0.0 else 0
                return count - rigid == widest + 1
        return None


def _largest(
    inverse: Callable[[Floats], Floats], n: int, count: int, seed: int, weight: Floats
) -> tuple[Floats, Floats]:
    """The largest eigenvalues of a symmetric operator, with vectors in columns."""
    if n <= SMALL or count >= n - 1:
        full = np.column_stack([inverse(row) for row in np.eye(n)])
        values, vectors = np.linalg.eigh(0.5 * (full + full.T))
        return values[-count:], vectors[:, -count:]
    from scipy.sparse.linalg import LinearOperator, eigsh

    start = np.random.default_rng(seed).standard_normal(n) * (weight > 0.0)
    operator = LinearOperator((n, n), matvec=inverse, dtype=np.float64)
    basis = min(n, max(2 * count + 1, 20))
    values, vectors = eigsh(operator, count, which="LA", v0=start, ncv=basis)
    return values, vectors


def _orthonormal(rigid: Floats | None, root: Floats) -> Floats:
    """Motions times W^½ as orthonormal rows."""
    if rigid is None or not len(rigid):
        return np.zeros((0, len(root)))
    q, _ = np.linalg.qr((rigid * root).T)
    return np.asarray(q.T)
