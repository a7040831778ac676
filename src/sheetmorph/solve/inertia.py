"""Masses, damping, and the energy whose minimum is the end of a step through time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from sheetmorph.core.sparse import SymmetricPattern
from sheetmorph.solve.system import Energy, System

Floats = NDArray[np.float64]


class Integrator(StrEnum):
    """How velocity and position are carried through a step.

    Implicit Euler is of first order and takes energy out of all that moves faster than the step
    can follow. The trapezoidal rule (Newmark's method with β = 1/4, γ = 1/2) is of second order
    and takes none out of a linear system.
    """

    IMPLICIT_EULER = "implicit_euler"
    TRAPEZOIDAL = "trapezoidal"

    @property
    def order(self) -> int:
        """Order of accuracy in the step."""
        return 1 if self is Integrator.IMPLICIT_EULER else 2


@dataclass(frozen=True, eq=False)
class Inertia:
    """What resists a change of position and of velocity; n degrees of freedom.

    Attributes:
        mass: of each degree of freedom, shape (n,); [kg] for coordinates. Those without mass are
            in equilibrium at the end of every step.
        drag: force per velocity on each, shape (n,) [N·s/m].
        retardation: β [s]: with K the convex part of the Hessian at the beginning of a step, the
            forces β K v resist strain rates.
    """

    mass: Floats
    drag: Floats
    retardation: float = 0.0

    def kinetic(self, velocity: Floats) -> float:
        """½ vᵀ M v [J]."""
        return 0.5 * float(velocity @ (self.mass * velocity))


@dataclass(frozen=True, eq=False)
class Moment:
    """The state of motion at a time, and all that the next step needs to know.

    Attributes:
        index: number of the step that ended here; 0 at the start.
        time: [s].
        x: degrees of freedom [m], shape (n,).
        velocity: [m/s], shape (n,).
        acceleration: [m/s²], shape (n,); 0 without mass.
        step: length of the next step, if nothing shortens it [s].
        residual: largest imbalance of the forces [N].
        dissipated: energy that the damping took in the step that ended here [J].
    """

    index: int
    time: float
    x: Floats
    velocity: Floats
    acceleration: Floats
    step: float
    residual: float = 0.0
    dissipated: float = 0.0


@dataclass(frozen=True, eq=False)
class Pull:
    """Forces of inertia and damping at the end of a step, linear in the displacement u in it.

    With masses M and damping C = drag + β K they are (α M + γ C) u − b. Implicit Euler:
    v = u/h and M (v − v0)/h + C v, so α = 1/h², γ = 1/h, b = M v0/h. Trapezoidal rule:
    v = 2 u/h − v0 and a = 4 (u − h v0)/h² − a0, so α = 4/h², γ = 2/h,
    b = M (4 v0/h + a0) + C v0.

    Attributes:
        start: the moment at the beginning.
        size: h [s].
        integrator: see `Integrator`.
        inertia: M and C.
        viscous: β K, shape (n, n), and its entries in the pattern; None without retardation.
        diagonal: of α M + γ drag, shape (n,).
        rate: γ [1/s].
        push: b, shape (n,).
    """

    start: Moment
    size: float
    integrator: Integrator
    inertia: Inertia
    viscous: tuple[csr_array, Floats] | None
    diagonal: Floats
    rate: float
    push: Floats

    @classmethod
    def of(
        cls, system: System, inertia: Inertia, start: Moment, size: float, integrator: Integrator
    ) -> Pull:
        """The forces of a step; with retardation the convex part is evaluated at its start."""
        viscous = None
        if inertia.retardation > 0.0:
            _, _, entries = system.energy.evaluate(start.x, 3)
            assert entries is not None  # noqa: S101
            entries = inertia.retardation * entries
            viscous = system.energy.pattern.full(entries), entries
        mass, drag, v0 = inertia.mass, inertia.drag, start.velocity
        if integrator is Integrator.IMPLICIT_EULER:
            rate = 1.0 / size
            diagonal, push = mass * rate**2 + drag * rate, mass * v0 * rate
        else:
            rate = 2.0 / size
            diagonal = mass * rate**2 + drag * rate
            push = mass * (2.0 * rate * v0 + start.acceleration) + drag * v0
            if viscous is not None:
                push = push + viscous[0] @ v0
        return cls(start, size, integrator, inertia, viscous, diagonal, rate, push)

    def damping(self, velocity: Floats) -> Floats:
        """C v [N], shape (n,)."""
        forces = self.inertia.drag * velocity
        return forces if self.viscous is None else forces + self.viscous[0] @ velocity

    def energy(self, x: Floats) -> tuple[float, Floats]:
        """The potential of these forces at x, zero at u = 0, and the forces, shape (n,)."""
        u = x - self.start.x
        forces = self.diagonal * u
        if self.viscous is not None:
            forces = forces + self.rate * (self.viscous[0] @ u)
        return float(u @ (0.5 * forces - self.push)), forces - self.push

    def guess(self) -> Floats:
        """Where the sheet would be without a change of its forces."""
        start = self.start
        return start.x + self.size * (start.velocity + 0.5 * self.size * start.acceleration)

    def arrival(self, x: Floats, residual: float, time: float) -> tuple[Moment, float]:
        """The moment at the end of the step, and the estimated error of its position [m].

        The error is that of the step alone: the difference from a Taylor series of the same
        order, h² a for implicit Euler and h² (a − a0)/4 for the trapezoidal rule, of which it is
        half and a third.
        """
        start, h = self.start, self.size
        u = x - start.x
        heavy = self.inertia.mass > 0.0
        if self.integrator is Integrator.IMPLICIT_EULER:
            velocity = u / h
            acceleration = np.where(heavy, (velocity - start.velocity) / h, 0.0)
            errors = h * h * acceleration / 2.0
        else:
            velocity = 2.0 * u / h - start.velocity
            acceleration = 4.0 * (u / h - start.velocity) / h - start.acceleration
            acceleration = np.where(heavy, acceleration, 0.0)
            errors = h * h * (acceleration - start.acceleration) / 12.0
        dissipated = float(u @ self.damping(u)) / h
        moment = Moment(start.index + 1, time, x, velocity, acceleration, h, residual, dissipated)
        return moment, float(np.abs(errors).max(initial=0.0))


@dataclass(frozen=True, eq=False)
class Moving:
    """An energy with the potential of inertia and damping: its minimum ends the step.

    Attributes:
        static: the energy at the end of the step.
        pull: forces of inertia and damping.
    """

    static: Energy
    pull: Pull

    @property
    def pattern(self) -> SymmetricPattern:
        """Pattern of the Hessian."""
        return self.static.pattern

    def at(self, ramp: float, load: float) -> Self:
        """The same step at another point of the path."""
        return replace(self, static=self.static.at(ramp, load))

    def reach(self, x: Floats, step: Floats) -> float:
        """The part of a step that the energy allows; see `Energy`."""
        limit = getattr(self.static, "reach", None)
        return 1.0 if limit is None else float(limit(x, step))

    def evaluate(self, x: Floats, order: int) -> tuple[float, Floats | None, Floats | None]:
        """See `Energy.evaluate`."""
        energy, gradient, data = self.static.evaluate(x, order)
        potential, forces = self.pull.energy(x)
        if gradient is not None:
            gradient = gradient + forces
        if data is not None:
            data = data.copy()
            data[self.pattern.indptr[:-1]] += self.pull.diagonal
            if self.pull.viscous is not None:
                data += self.pull.rate * self.pull.viscous[1]
        return energy + potential, gradient, data
