"""An energy with held degrees of freedom and a linear solver, and an account of the work."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.sparse import SymmetricPattern
from sheetmorph.solve.constraints import HeldDofs
from sheetmorph.solve.linear import LinearSolver, SingularMatrixError

Floats = NDArray[np.float64]


class Energy(Protocol):
    """A function of all degrees of freedom with derivatives, along a loading path.

    An energy whose gradient at fixed x is not linear in ramp and load has an attribute
    `linear_in_ramp` that is False. One that is infinite somewhere, as at contact, has a method
    `reach(x, step)`: the part of a step, at most 1, that does not lead there or past it.
    """

    @property
    def pattern(self) -> SymmetricPattern:
        """Pattern of the Hessian."""
        ...

    def at(self, ramp: float, load: float) -> Self:
        """The energy at a fraction of the actuation and of the load."""
        ...

    def evaluate(self, x: Floats, order: int) -> tuple[float, Floats | None, Floats | None]:
        """Energy, gradient from order 1, Hessian entries at order 2, those of a positive
        semidefinite part of it at order 3."""
        ...


def allowed(energy: Energy, x: Floats, step: Floats) -> float:
    """The part of a step, at most 1, that an energy allows; see `Energy`."""
    limit = getattr(energy, "reach", None)
    return 1.0 if limit is None else float(limit(x, step))


@dataclass
class Work:
    """What a computation has cost so far."""

    factorisations: int = 0
    solves: int = 0
    evaluations: int = 0
    iterations: int = 0
    assembly_seconds: float = 0.0
    factorise_seconds: float = 0.0
    solve_seconds: float = 0.0


@dataclass(frozen=True, eq=False)
class System:
    """The free problem that Newton's method works on.

    Attributes:
        energy: the energy at the current point of the path.
        held: the held degrees of freedom.
        linear: the linear solver, bound to the pattern of the energy.
        work: the account, shared by all copies.
    """

    energy: Energy
    held: HeldDofs
    linear: LinearSolver
    work: Work = field(default_factory=Work)

    def at(self, ramp: float, load: float) -> System:
        """The same system at another point of the path."""
        return replace(self, energy=self.energy.at(ramp, load))

    @property
    def linear_in_ramp(self) -> bool:
        """True when the forces at fixed positions are linear along the path; see `Energy`."""
        return bool(getattr(self.energy, "linear_in_ramp", True))

    def reach(self, x: Floats, step: Floats) -> float:
        """The part of a step, at most 1, that the energy allows; see `Energy`."""
        return allowed(self.energy, x, step)

    def toward(self, x: Floats, goal: Floats) -> Floats:
        """The goal, or the last place on the way to it from x that the energy allows."""
        part = self.reach(x, goal - x)
        return goal if part >= 1.0 else x + part * (goal - x)

    def value(self, x: Floats) -> float:
        """Energy alone."""
        start = perf_counter()
        energy, _, _ = self.energy.evaluate(x, 0)
        self._account_evaluation(start)
        return energy

    def gradient(self, x: Floats) -> tuple[float, Floats]:
        """Energy and gradient, zero at the held degrees of freedom."""
        start = perf_counter()
        energy, gradient, _ = self.energy.evaluate(x, 1)
        assert gradient is not None  # noqa: S101
        self.held.hold(gradient)
        self._account_evaluation(start)
        return energy, gradient

    def hessian(self, x: Floats, convex: bool = False) -> tuple[float, Floats, Floats]:
        """Energy, gradient and Hessian entries with the held rows reduced.

        With `convex`, the positive semidefinite part of the Hessian in its place.
        """
        start = perf_counter()
        energy, gradient, data = self.energy.evaluate(x, 3 if convex else 2)
        assert gradient is not None and data is not None  # noqa: S101
        self.held.hold(gradient)
        self.held.reduce(data)
        growth = getattr(self.linear, "growth", None)
        if growth is not None:
            rows, columns = growth.places()
            data[self.energy.pattern.nnz :][self.held.held[rows] | self.held.held[columns]] = 0.0
        self._account_evaluation(start)
        return energy, gradient, data

    def factorise(self, data: Floats, shift: float = 0.0) -> bool:
        """Factorise the Hessian plus a multiple of the identity; True when positive definite."""
        if shift:
            data = data.copy()
            data[self.held.diagonal] += shift
        start = perf_counter()
        try:
            return self.linear.factorise(data)
        finally:
            self.work.factorisations += 1
            self.work.factorise_seconds += perf_counter() - start

    def factorise_indefinite(self, data: Floats, shift: float = 0.0) -> int | None:
        """Factorise a Hessian of any inertia, plus a multiple of the identity.

        Returns:
            Number of negative pivots; None when the matrix is singular to working accuracy.
        """
        if shift:
            data = data.copy()
            data[self.held.diagonal] += shift
        start = perf_counter()
        try:
            return self.linear.factorise_indefinite(data)
        except SingularMatrixError:
            if not np.isfinite(data).all():
                raise
            return None
        finally:
            self.work.factorisations += 1
            self.work.factorise_seconds += perf_counter() - start

    def solve(self, rhs: Floats) -> Floats:
        """Solve with the last factor."""
        start = perf_counter()
        try:
            return self.linear.solve(rhs)
        finally:
            self.work.solves += 1
            self.work.solve_seconds += perf_counter() - start

    def _account_evaluation(self, start: float) -> None:
        self.work.evaluations += 1
        self.work.assembly_seconds += perf_counter() - start
