"""Small energies with known minima, on the interface that the solver expects."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sheetmorph.core.sparse import SymmetricPattern
from sheetmorph.solve.constraints import HeldDofs
from sheetmorph.solve.linear import make_solver
from sheetmorph.solve.system import System


def dense_pattern(n: int) -> SymmetricPattern:
    """The whole upper triangle."""
    rows, cols = np.triu_indices(n)
    indptr = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=n))])
    return SymmetricPattern(n, indptr.astype(np.int32), cols.astype(np.int32))


@dataclass(frozen=True)
class Toy:
    """Base: two degrees of freedom x, y; subclasses give energy, gradient, Hessian."""

    ramp: float = 0.0
    load: float = 0.0

    pattern = dense_pattern(2)

    def at(self, ramp: float, load: float) -> Toy:
        return replace(self, ramp=ramp, load=load)

    def evaluate(self, x, order):  # type: ignore[no-untyped-def]
        energy, gradient, hessian = self.derivatives(x[0], x[1])
        if order == 3:
            values, vectors = np.linalg.eigh(np.array([hessian[:2], hessian[1:]]))
            full = (vectors * np.abs(values)) @ vectors.T
            hessian = (full[0, 0], full[0, 1], full[1, 1])
        return (
            float(energy),
            np.array(gradient, dtype=float) if order >= 1 else None,
            np.array(hessian, dtype=float) if order >= 2 else None,
        )


class Pitchfork(Toy):
    """A strut: x⁴/4 − (t − 0.3) x²/2 − 10⁻³ load x + y²/2; buckles at t = 0.3."""

    def derivatives(self, x, y):  # type: ignore[no-untyped-def]
        a = self.ramp - 0.3
        push = 1e-3 * self.load
        return (
            x**4 / 4 - a * x**2 / 2 - push * x + y**2 / 2,
            (x**3 - a * x - push, y),
            (3 * x**2 - a, 0.0, 1.0),
        )


class Fold(Toy):
    """x³/3 − (1/2 − t) x: the minimum disappears at t = 1/2."""

    def derivatives(self, x, y):  # type: ignore[no-untyped-def]
        a = 0.5 - self.ramp
        x = max(x, -1e50)  # down it goes for ever
        return x**3 / 3 - a * x + y**2 / 2, (x**2 - a, y), (2 * x, 0.0, 1.0)


class Broken(Toy):
    """Not a number beyond t = 0.4."""

    def derivatives(self, x, y):  # type: ignore[no-untyped-def]
        bad = np.nan if self.ramp > 0.4 else 0.0
        return x**2 / 2 - self.ramp * x + y**2 / 2 + bad, (x - self.ramp + bad, y), (1.0, 0.0, 1.0)


class Rosenbrock(Toy):
    """The curved valley; minimum at (1, 1)."""

    def derivatives(self, x, y):  # type: ignore[no-untyped-def]
        u = y - x * x
        return (
            100 * u**2 + (1 - x) ** 2,
            (-400 * x * u - 2 * (1 - x), 200 * u),
            (1200 * x * x - 400 * y + 2, -400 * x, 200.0),
        )


class Stiff(Toy):
    """10¹² (x² − 2)²/4 + 10¹² (y² − 3)²/4: no number has a gradient near zero."""

    def derivatives(self, x, y):  # type: ignore[no-untyped-def]
        a, b = x * x - 2.0, y * y - 3.0
        return (
            1e12 * (a * a + b * b) / 4.0,
            (1e12 * x * a, 1e12 * y * b),
            (1e12 * (3 * x * x - 2), 0.0, 1e12 * (3 * y * y - 3)),
        )


def system_of(energy: Toy, solver: str = "scipy") -> System:
    """A system without held degrees of freedom."""
    held = HeldDofs.of(energy.pattern, np.zeros(2, dtype=bool))
    return System(energy, held, make_solver(energy.pattern, solver))
