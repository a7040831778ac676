"""Forces in time, and the account of where the energy of a motion goes."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from sheetmorph.design.motion_table import Course
from sheetmorph.energy.total import Total
from sheetmorph.geometry.mesh import Floats
from sheetmorph.solve.inertia import Inertia, Moment
from sheetmorph.study.motion_record import COLUMNS

LOADS = ("load", "applied", "weight")
"""Names of the energy terms that are potentials of dead loads."""

_ENERGIES, _SUMS = slice(5, 7), slice(7, 11)
"""Places of both energies, and of the sums, in a row of the history."""
_NONE = np.zeros(4)

Factors = tuple[float, float, float]
"""Of actuation, loads and perturbation load."""


@dataclass(eq=False)
class Acting:
    """The energy of a sheet under what acts at a time; weight always acts.

    Attributes:
        total: the energy, at any point of its path.
        course: what acts when.
        kept: the last two energies, for what acts is often the same.
    """

    total: Total
    course: Course
    kept: dict[Factors, Total] = field(default_factory=dict)

    def at(self, time: float) -> Total:
        """The energy at a time [s]."""
        return self.under(self.course.at(time))

    def under(self, factors: Factors) -> Total:
        """The energy under given factors."""
        found = self.kept.get(factors)
        if found is None:
            found = acting(self.total, factors)
            self.kept = {**dict(list(self.kept.items())[-1:]), factors: found}
        return found


def acting(total: Total, factors: Factors) -> Total:
    """The energy under factors of actuation, loads and perturbation load."""
    actuation, loads, perturbation = factors
    ramps = {"applied": loads, "weight": 1.0}
    return replace(
        total,
        terms=tuple(t.at(ramps.get(t.name, actuation), perturbation) for t in total.terms),
    )


@dataclass(eq=False)
class Ledger:
    """The history of a motion, a row per step; see `COLUMNS`.

    The work of the actuation in a step is what its change does to the elastic energy at fixed
    positions, the mean of both ends; that of the loads is the mean of their forces at both ends
    times the displacement. What is left of the balance is what the step took.

    Attributes:
        acting: the forces.
        inertia: masses and damping.
        nodes: number of coordinates, the first degrees of freedom.
        rows: the history.
        largest: largest kinetic and elastic energy so far [J].
    """

    acting: Acting
    inertia: Inertia
    nodes: int
    rows: list[Floats] = field(default_factory=list)
    largest: float = 0.0
    _weighed: tuple[Moment, float, Floats] | None = None

    def begin(self, moment: Moment) -> None:
        """The first row."""
        elastic, _ = _split(self.acting.at(moment.time), moment.x)
        self._add(moment, 0.0, elastic, _NONE)

    def take(self, rows: Floats) -> None:
        """Rows of a run that is to go on, shape (N, columns)."""
        self.rows += list(rows)
        energies = rows[:, _ENERGIES].sum(axis=1)
        self.largest = max(self.largest, float(energies.max(initial=0.0)))

    def weigh(self, before: Moment, after: Moment) -> tuple[float, float]:
        """Energy that a step makes out of nothing, and that after it [J]."""
        elastic, flows = self._flows(before, after)
        self._weighed = after, elastic, flows
        return -float(flows[3]), elastic + self.inertia.kinetic(after.velocity)

    def enter(self, before: Moment, after: Moment) -> None:
        """The row of a step."""
        moment, elastic, flows = self._weighed or (before, 0.0, _NONE)
        if moment is not after:
            elastic, flows = self._flows(before, after)
        self._add(after, after.time - before.time, elastic, self.rows[-1][_SUMS] + flows)

    @property
    def made(self) -> float:
        """Energy that the steps have made out of nothing so far, less what they took [J]."""
        return -float(self.rows[-1][_SUMS][3])

    def _flows(self, before: Moment, after: Moment) -> tuple[float, Floats]:
        """Elastic energy after a step, and what came and went in it, as in the history [J]."""
        old, new = self.acting.at(before.time), self.acting.at(after.time)
        elastic, load = _split(new, after.x)
        if old is new:
            work, pushed = 0.0, _split(new, before.x)[1] - load
        else:
            (e01, l01), (e00, l00) = _split(new, before.x), _split(old, before.x)
            e10, l10 = _split(old, after.x)
            work = 0.5 * ((e01 - e00) + (elastic - e10))
            pushed = 0.5 * ((l01 - load) + (l00 - l10))
        kinetic = self.inertia.kinetic(after.velocity)
        gained = kinetic + elastic - float(self.rows[-1][_ENERGIES].sum())
        taken = work + pushed - after.dissipated - gained
        return elastic, np.array([work, pushed, after.dissipated, taken])

    def _add(self, moment: Moment, step: float, elastic: float, sums: Floats) -> None:
        speeds = np.linalg.norm(moment.velocity[: self.nodes].reshape(-1, 3), axis=1)
        kinetic = self.inertia.kinetic(moment.velocity)
        height = float(np.ptp(moment.x[2 : self.nodes : 3]))
        factors = self.acting.course.at(moment.time)
        row = (moment.time, step, *factors, kinetic, elastic, *sums, speeds.max(), height)
        self.rows.append(np.array(row))
        self.largest = max(self.largest, kinetic + elastic)

    @property
    def history(self) -> dict[str, Floats]:
        """The columns, shape (N + 1,) each."""
        return dict(zip(COLUMNS, np.array(self.rows).T, strict=True))


def _split(total: Total, x: Floats) -> tuple[float, float]:
    """Elastic energy and potential of the loads [J]."""
    energies = total.energies(x)
    load = sum(value for name, value in energies.items() if name in LOADS)
    return sum(energies.values()) - load, load
