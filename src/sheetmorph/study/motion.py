"""Design in, motion out: the equation of motion under the course of a design."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any, Self

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.core.events import (
    Event,
    Listener,
    MomentReached,
    Notice,
    Progress,
    Started,
    TimeStepRejected,
    silent,
)
from sheetmorph.core.sparse import SymmetricPattern
from sheetmorph.design.masses import node_masses
from sheetmorph.design.motion_table import DynamicOptions
from sheetmorph.design.spec import Design
from sheetmorph.energy.total import Total
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.solve.constraints import HeldDofs
from sheetmorph.solve.dynamic import REMEDIES, Motion, MotionOptions, move, start_of_motion
from sheetmorph.solve.inertia import Inertia, Integrator, Moment
from sheetmorph.solve.linear import LinearSolver, make_solver
from sheetmorph.solve.path import Path, PathState, Status, Waypoint, follow, start_of_path
from sheetmorph.solve.system import System, Work
from sheetmorph.study.journal import Journal
from sheetmorph.study.ledger import Acting, Ledger, acting
from sheetmorph.study.model import RESIDUAL_FLOOR, Problem, build_problem
from sheetmorph.study.motion_journal import MotionJournal
from sheetmorph.study.motion_record import MotionRecord
from sheetmorph.study.result import Result
from sheetmorph.study.simulate import path_options, result_of, seconds_of

MAX_STEPS = 100_000
"""Of time, where the design does not say."""

SHARPER = 1e-3
"""Imbalance of forces at the end of a step, over that at which a sheet counts as at rest: it
does work in every step, and the energy is balanced over many."""


def simulate_motion(
    design: Design,
    *,
    on_event: Listener = silent,
    journal: Journal | None = None,
    resume: bool = False,
    mesh: SheetMesh | None = None,
) -> Result:
    """Solve the equation of motion of a design whose solver is dynamic.

    Args:
        design: what to simulate.
        on_event: told of the progress, see `sheetmorph.core.events`.
        journal: where to keep moments as they are reached; nowhere by default.
        resume: go on from the last moment in the journal.
        mesh: reference mesh to take in the place of the design's own.

    Returns:
        The result, with `motion`. A motion that did not come to its end is a `status` in its
        summary, with a remedy, not an exception.

    Raises:
        InputError: the design is not dynamic, or does not fit its mesh.
        OutputError: a moment could not be kept.
    """
    table = design.solver.dynamic
    if table is None or design.solver.kind != "dynamic":
        raise InputError('this design has no solver.kind = "dynamic"', key="solver.kind")
    began = perf_counter()
    on_event(Started(design.name))
    sheet = MovingSheet.of(build_problem(design, mesh), table)
    record = MotionJournal(journal, design.hash)
    ledger = Ledger(sheet.acting, sheet.inertia, sheet.problem.mesh.nodes.size)
    if resume:
        moments = record.read(ledger, sheet.problem.start.size)
    else:
        record.begin()
        begun, failure = _first(sheet, on_event)
        moments = [begun]
        ledger.begin(begun)
        if failure is not None:
            return _result(sheet, ledger, moments, failure, began, 0.0, 0)
        record.write(begun, ledger)
    aside = _Aside(on_event, table)

    def on_moment(before: Moment, after: Moment) -> None:
        started = perf_counter()
        if _count(after.time, table.interval) > _count(before.time, table.interval):
            moments.append(after)
            record.write(after, ledger)
        aside.seconds += perf_counter() - started

    start = perf_counter()
    motion = move(
        sheet.at,
        sheet.static,
        sheet.inertia,
        moments[-1],
        sheet.options,
        account=ledger,
        on_event=aside.tell,
        on_moment=on_moment,
    )
    solved = perf_counter() - start - aside.seconds
    if motion.last.time > moments[-1].time:
        moments.append(motion.last)
    elif motion.at_rest:
        moments[-1] = motion.last
    if motion.status is not Status.COMPLETED:
        on_event(Notice(f"{motion.status}: {REMEDIES[motion.status]}"))
    return _result(sheet, ledger, moments, motion, began, solved, aside.rejected)


def _count(time: float, interval: float) -> int:
    """How many intervals have passed; a time that falls short by rounding counts."""
    return int(time / interval + 1e-6)


@dataclass(frozen=True, eq=False)
class MovingSheet:
    """A problem with its masses and its course.

    Attributes:
        problem: the problem.
        options: steps, integrator, ends.
        inertia: masses and damping.
        acting: the forces in time.
        free: the degrees of freedom that are held while the sheet moves: supports alone.
        pinned: those held for statics: a free sheet keeps its place.
        linear: the linear solver.
        work: the account.
    """

    problem: Problem
    options: MotionOptions
    inertia: Inertia
    acting: Acting
    free: HeldDofs
    pinned: HeldDofs
    linear: LinearSolver
    work: Work

    @classmethod
    def of(cls, problem: Problem, table: DynamicOptions) -> Self:
        """Lump the masses and set up the solver."""
        solver, pattern = problem.design.solver, problem.total.pattern
        coordinates = problem.mesh.nodes.size
        scalars = np.zeros(len(problem.model.held_scalars))
        mass = np.concatenate([np.repeat(node_masses(problem.mesh, problem.regions), 3), scalars])
        held = problem.held_dofs.copy()
        if not len(problem.held_nodes):
            held[:coordinates] = False
        limit = solver.max_steps if "max_steps" in solver.model_fields_set else MAX_STEPS
        floor = RESIDUAL_FLOOR * problem.model.stretch_force
        options = MotionOptions(
            newton=path_options(problem).newton,
            tolerance=max(SHARPER * solver.tolerance * problem.model.force_scale, floor),
            integrator=Integrator(table.integrator),
            time_step=table.time_step,
            step_error=float("inf") if table.step_error is None else table.step_error,
            corners=tuple(time for time in table.course.times if time > 0.0),
            end_time=float("inf") if table.end_time is None else table.end_time,
            rest=table.rest,
            max_steps=limit,
            time_limit=float("inf") if solver.time_limit is None else solver.time_limit,
        )
        return cls(
            problem,
            options,
            Inertia(mass, table.damping * mass, table.retardation),
            Acting(problem.total, table.course),
            HeldDofs.of(pattern, held),
            HeldDofs.of(pattern, problem.held_dofs),
            make_solver(pattern, solver.linear_solver, max(1, solver.threads)),
            Work(),
        )

    def at(self, time: float) -> System:
        """The problem at a time [s]."""
        return System(self.acting.at(time), self.free, self.linear, self.work)

    def static(self, time: float) -> System:
        """The same without rigid motions."""
        return System(self.acting.at(time), self.pinned, self.linear, self.work)


def _first(sheet: MovingSheet, on_event: Listener) -> tuple[Moment, Motion | None]:
    """The moment at time 0; with the motion that has failed where there is no equilibrium."""
    x, table = sheet.problem.start, sheet.problem.design.solver.dynamic
    sheet.acting.at(0.0).evaluate(x, 2)  # compiles, or loads the compiled kernels
    if table is None or table.start == "flat":
        return start_of_motion(sheet.at, sheet.inertia, x, sheet.options), None
    on_event(Progress(0.0, "equilibrium at the beginning"))
    actuation, loads, perturbation = table.course.at(0.0)
    beginning = _Beginning(sheet.problem.total, actuation, loads)
    legs = (Waypoint(0.0, 1.0), Waypoint(1.0, 1.0), Waypoint(1.0, perturbation))
    options = path_options(sheet.problem)
    system = replace(sheet.static(0.0), energy=beginning)
    path = follow(system, legs, [start_of_path(x, legs, options)], options)
    moment = start_of_motion(sheet.at, sheet.inertia, path.states[-1].x, sheet.options)
    if path.status is Status.COMPLETED:
        # At rest in an equilibrium nothing accelerates; the pins of a free sheet bear nothing.
        return replace(moment, acceleration=np.zeros_like(x)), None
    detail = f"no stable equilibrium at the beginning: {path.detail}"
    return moment, Motion(moment, path.status, detail)


@dataclass(frozen=True, eq=False)
class _Beginning:
    """The path from the flat sheet to the equilibrium with which a course begins."""

    total: Total
    actuation: float
    loads: float
    ramp: float = 0.0
    load: float = 1.0

    @property
    def pattern(self) -> SymmetricPattern:
        """Pattern of the Hessian."""
        return self.total.pattern

    @property
    def linear_in_ramp(self) -> bool:
        """As for the whole energy."""
        return self.total.linear_in_ramp

    def reach(self, x: Floats, step: Floats) -> float:
        """As for the whole energy."""
        return self._now().reach(x, step)

    def at(self, ramp: float, load: float) -> Self:
        """At a fraction of the way, and of the perturbation load."""
        return replace(self, ramp=ramp, load=load, total=self.total)

    def evaluate(self, x: Floats, order: int) -> tuple[float, Floats | None, Floats | None]:
        """See `Energy.evaluate`."""
        return self._now().evaluate(x, order)

    def _now(self) -> Total:
        return acting(self.total, (self.ramp * self.actuation, self.ramp * self.loads, self.load))


class _Aside:
    """Listeners, and the time they take, which is not the solver's."""

    def __init__(self, on_event: Listener, table: DynamicOptions) -> None:
        self._on_event, self._table = on_event, table
        self.seconds, self.rejected = 0.0, 0

    def tell(self, event: Event) -> None:
        start = perf_counter()
        self._on_event(event)
        if isinstance(event, TimeStepRejected):
            self.rejected += 1
        if isinstance(event, MomentReached):
            self._on_event(Progress(0.95 * self._share(event.time), f"t = {event.time:.4g} s"))
        self.seconds += perf_counter() - start

    def _share(self, time: float) -> float:
        """How far the motion has come; after the course nobody knows when it will rest."""
        if self._table.end_time is not None:
            return time / self._table.end_time
        course = self._table.course.duration
        if time < course:
            return 0.6 * time / course
        known = max(course, 10.0 * self._table.time_step)
        return 1.0 - 0.4 * min(1.0, known / time)


def _result(
    sheet: MovingSheet,
    ledger: Ledger,
    moments: Sequence[Moment],
    motion: Motion,
    began: float,
    solved: float,
    rejected: int,
) -> Result:
    problem, nodes = sheet.problem, sheet.problem.mesh.nodes
    factors = np.array([sheet.acting.course.at(moment.time) for moment in moments])
    states = tuple(
        PathState(
            x=moment.x,
            tangent=np.zeros(0),
            leg=0,
            s=0.0,
            step=moment.step,
            ramp=float(row[0]),
            load=float(row[2]),
            residual=moment.residual,
            negative_pivots=0,
        )
        for moment, row in zip(moments, factors, strict=True)
    )
    path = Path(states, motion.status, motion.detail)
    system = sheet.static(moments[-1].time)
    result = result_of(problem, path, system, sheet.linear.name, aligned=False)
    energies = system.energy.energies(moments[-1].x) if isinstance(system.energy, Total) else {}
    history = ledger.history
    record = MotionRecord(
        time=np.array([moment.time for moment in moments]),
        loads=factors[:, 1],
        velocity=np.array([m.velocity[: nodes.size].reshape(nodes.shape) for m in moments]),
        history=history,
    )
    result.summary.update(
        {
            "remedy": REMEDIES[motion.status],
            "stable": motion.at_rest and motion.negative_pivots == 0,
            "negative_pivots": motion.negative_pivots,
            "energy_J": {**energies, "total": sum(energies.values())},
            "motion": _numbers(sheet, record, motion, rejected),
            "seconds": seconds_of(system.work, solved, perf_counter() - began),
        }
    )
    return replace(result, motion=record)


def _numbers(
    sheet: MovingSheet, record: MotionRecord, motion: Motion, rejected: int
) -> dict[str, Any]:
    """The motion in numbers, for the summary."""
    last = {name: float(column[-1]) for name, column in record.history.items()}
    return {
        "integrator": str(sheet.options.integrator),
        "time_s": last["time_s"],
        "steps": motion.last.index,
        "rejected_steps": rejected,
        "at_rest": motion.at_rest,
        "settled_by_m": motion.settled_by,
        "mass_kg": float(sheet.inertia.mass.sum()) / 3.0,
        "kinetic_J": last["kinetic_J"],
        "kinetic_peak_J": record.kinetic_peak,
        "fastest_m_per_s": float(record.history["fastest_m_per_s"].max()),
        "actuation_work_J": last["actuation_work_J"],
        "load_work_J": last["load_work_J"],
        "damped_J": last["damped_J"],
        "numerical_J": last["numerical_J"],
    }
