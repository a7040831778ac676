"""The search for the shapes of a sheet at full actuation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from sheetmorph.branches import seeds, walk
from sheetmorph.branches.result import Attempt, Branch, Branches
from sheetmorph.branches.sameness import MIRROR, Sameness, turned_over
from sheetmorph.branches.seeds import Seed
from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.core.events import Listener, Progress, silent
from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.solve.constraints import align_to_reference
from sheetmorph.solve.linear import SingularMatrixError
from sheetmorph.solve.minimise import NewtonOptions, Outcome, minimise
from sheetmorph.solve.path import Path, PathOptions, Status, Waypoint, follow, start_of_path
from sheetmorph.solve.stability import escape_saddle, negative_pivots
from sheetmorph.solve.system import System
from sheetmorph.study.model import Problem, build_problem
from sheetmorph.study.simulate import path_options, simulate
from sheetmorph.study.stability import modes_at, system_of

ESCAPES = 5
"""How often a saddle is left at full actuation before it counts as where a seed ends."""


@dataclass(frozen=True)
class SearchOptions:
    """What is tried.

    Attributes:
        modes: kicked at each bifurcation, and from the final shape of the run.
        sectors: invert sectors of the design's rotations in the final shape of the run.
        random: number of random loads.
        seed: of the first of them; the next ones count on.
        tolerance: shapes nearer than this are the same: root mean square distance over size.
    """

    modes: int = 3
    sectors: bool = True
    random: int = 4
    seed: int = 0
    tolerance: float = 0.01

    def __post_init__(self) -> None:
        for key, most in (("modes", 12), ("random", 1000)):
            value = getattr(self, key)
            if not 0 <= value <= most:
                raise InputError("is out of range", key=key, value=value, allowed=f"0 to {most}")
        if not 0.0 < self.tolerance < 1.0:
            raise InputError(
                "is out of range", key="tolerance", value=self.tolerance, allowed="0 to 1"
            )


def find_branches(
    design: Design,
    options: SearchOptions = SearchOptions(),
    *,
    mesh: SheetMesh | None = None,
    on_event: Listener = silent,
) -> Branches:
    """Find shapes of a sheet at full actuation, stable ones and the unperturbed one.

    The run of the design comes first; then the one with the opposite perturbation, kicks of both
    signs along the modes that lose their stability on the path without perturbation, wide
    kicks along the softest modes of the final shape, sectors of it inverted, random loads, and the
    shapes found so far turned over. Each is followed to full actuation without load.

    Args:
        design: the sheet.
        options: what is tried.
        mesh: reference mesh to take in the place of the design's own.
        on_event: told of the progress.

    Raises:
        InputError: the design and its mesh do not fit together, or it has weight or contact.
        ComputationError: not one seed leads to a shape at full actuation.
    """
    _check_alone(design)
    on_event(Progress(0.0, "the run of the design"))
    result = simulate(design, mesh=mesh)
    problem = build_problem(design, result.mesh)
    system = system_of(problem)
    search = _Search(problem, system, Sameness.of(problem, system), options)
    search.take_run(result.positions[-1], result.scalars[-1], result.status, result.ramp[-1])
    on_event(Progress(0.1, "the path without perturbation"))
    path = walk.unperturbed_path(problem, system)
    places = walk.bifurcations(problem, system, path)
    search.take_unperturbed(path[-1])
    on_event(Progress(0.3, "seeds"))
    planned = list(_seeds(problem, system, places, search, options))
    for k, seed in enumerate(planned):
        on_event(Progress(0.3 + 0.6 * k / len(planned), seed.name))
        search.take(seed)
    on_event(Progress(0.9, "turned over"))
    for seed in search.mirrored():
        search.take(seed)
    if not search.found:
        ends = sorted({one.status.replace("_", " ") for one in search.attempts})
        raise ComputationError(f"no seed led to a shape at full actuation: {', '.join(ends)}")
    branches, attempts = search.ranked()
    return Branches(
        result=result,
        branches=branches,
        attempts=attempts,
        bifurcations=tuple(
            (place.ramp, place.before, place.before + len(place.modes)) for place in places
        ),
        followed=path[-1].ramp,
        images=tuple(image.name for image in search.sameness.images[1:]),
    )


def _check_alone(design: Design) -> None:
    """Refuse paths that do not begin flat, and barriers that lead through the sheet."""
    design.must_be_still("the search for branches")
    if design.gravity is not None or design.contact.table or design.contact.self_contact:
        raise InputError(
            "branches are those of a sheet without weight and contact",
            key="contact" if design.gravity is None else "gravity",
            allowed="a design without these tables",
        )


def _seeds(
    problem: Problem,
    system: System,
    places: list[walk.Bifurcation],
    search: _Search,
    options: SearchOptions,
) -> Iterator[Seed]:
    yield seeds.opposite(problem, system)
    yield from seeds.at_bifurcations(problem, system, places, options.modes)
    if options.modes and search.found:
        first = search.found[0]
        modes = modes_at(problem, system.at(1.0, 0.0), first.x, options.modes).vectors
        size = problem.mesh.nodes.size
        modes = modes / np.abs(modes[:, :size]).max(axis=1, keepdims=True)
        yield from seeds.from_modes(problem, system, first.x, modes, "the run")
    if options.sectors and search.found:
        yield from seeds.with_sectors_inverted(problem, system, search.found[0].x)
    yield from seeds.random_loads(problem, system, options.random, options.seed)


class _Search:
    """Shapes found so far, and what became of the seeds."""

    def __init__(
        self, problem: Problem, system: System, sameness: Sameness, options: SearchOptions
    ) -> None:
        self.problem, self.system, self.sameness = problem, system, sameness
        self.options = options
        self.found: list[Branch] = []
        self.attempts: list[Attempt] = []
        self._guarded = False  # is the run itself one of shapes that lean on a guard?
        self._path_options: PathOptions = path_options(problem)

    def take_run(self, positions: Floats, scalars: Floats, status: str, reached: float) -> None:
        """The run of the design."""
        attempt = Attempt("the run", "perturbation", status, float(reached))
        self._enter(attempt, np.concatenate([positions.ravel(), scalars]))

    def take_unperturbed(self, last: walk.Station) -> None:
        """The end of the path without perturbation, where it is at full actuation."""
        arrived = last.ramp >= 1.0
        status = Status.STEP_TOO_SMALL if not arrived else Status.COMPLETED
        if arrived and last.negative:
            status = Status.UNSTABLE
        attempt = Attempt("without perturbation", "unperturbed", str(status), last.ramp)
        self._enter(attempt, last.x)

    def take(self, seed: Seed) -> None:
        """Follow a seed to full actuation."""
        first = seed.waypoints[0]
        x = seed.x
        if seed.kind in ("bifurcation", "mode", "sectors", "mirrored"):
            here = seed.system.at(first.ramp, first.load)
            settled = minimise(here, x, self._newton)
            if settled.outcome is not Outcome.CONVERGED:
                self._enter(Attempt(seed.name, seed.kind, str(settled.outcome), 0.0), None)
                return
            x = settled.x
        if len(seed.waypoints) == 1:
            self._enter(Attempt(seed.name, seed.kind, str(Status.COMPLETED), 1.0), x)
            return
        path = self._followed(seed, x)
        last = path.states[-1]
        self._enter(Attempt(seed.name, seed.kind, str(path.status), last.ramp), last.x)

    def mirrored(self) -> list[Seed]:
        """The stable shapes turned over, where that is not the same shape by itself."""
        if any(MIRROR in image.name for image in self.sameness.images):
            return []
        return [
            Seed(
                f"branch {k + 1} turned over",
                "mirrored",
                (Waypoint(1.0, 0.0),),
                turned_over(self.problem, one.x),
                self.system,
            )
            for k, one in enumerate(self.found)
            if one.stable
        ]

    def ranked(self) -> tuple[tuple[Branch, ...], tuple[Attempt, ...]]:
        """Branches by energy, and the attempts with their new numbers."""
        order = sorted(self.found, key=lambda one: one.energy)
        numbers = {one.number: k + 1 for k, one in enumerate(order)}
        attempts = [
            one if one.branch is None else replace(one, branch=numbers[one.branch])
            for one in self.attempts
        ]
        return tuple(replace(one, number=numbers[one.number]) for one in order), tuple(attempts)

    @property
    def _newton(self) -> NewtonOptions:
        return replace(self._path_options.newton, max_iterations=300)

    def _followed(self, seed: Seed, x: Floats) -> Path:
        start = start_of_path(x, seed.waypoints, self._path_options)
        last = len(seed.waypoints) - 2
        unload = {last: self.problem.design.perturbation.ramp_down_steps}
        steps = unload if seed.waypoints[-2].load else {}
        return follow(seed.system, seed.waypoints, [start], self._path_options, equal_steps=steps)

    def _enter(self, attempt: Attempt, x: Floats | None) -> None:
        """Note where a seed has ended: at a known shape, at a new one, or nowhere."""
        if x is None or attempt.reached < 1.0 - 1e-9:
            self.attempts.append(attempt)
            return
        keep = attempt.kind == "unperturbed"
        branch = self._branch(x, keep)
        if branch is None:
            self.attempts.append(replace(attempt, status="not an equilibrium"))
            return
        if attempt.kind == "perturbation":
            self._guarded = branch.guarded > 0
        if branch.guarded and not self._guarded:
            self.attempts.append(replace(attempt, status="leans on a guard"))
            return
        number, image = None, ""
        for known in self.found:
            apart, image = self.sameness.distance(known.positions, branch.positions)
            if apart <= self.options.tolerance and known.stable == branch.stable:
                number = known.number
                known.positions_found.setdefault(image, branch.x)
                break
        if number is None:
            number, image = len(self.found) + 1, ""
            self.found.append(replace(branch, number=number, positions_found={"": branch.x}))
        self.attempts.append(replace(attempt, branch=number, image=image))

    def _branch(self, x: Floats, keep: bool) -> Branch | None:
        """The state at full actuation without load; saddles are left unless they are to be kept."""
        here = self.system.at(1.0, 0.0)
        if not keep:
            for _ in range(ESCAPES):
                settled = minimise(here, x, self._newton)
                if settled.outcome is not Outcome.CONVERGED:
                    return None
                try:
                    negative, x, _ = negative_pivots(here, settled.x)
                    if negative == 0:
                        break
                    x = escape_saddle(here, x)
                except SingularMatrixError:
                    return None
        energy, gradient = here.gradient(x)
        residual = float(np.abs(gradient).max(initial=0.0))
        modes = modes_at(self.problem, here, x, 1)
        negative, _, _ = negative_pivots(here, x)
        positions = self.problem.positions(x)
        if not len(self.problem.held_nodes):
            positions = align_to_reference(positions[None], self.problem.mesh.nodes)[0]
        guarded = sum(self.problem.held_open(self.problem.positions(x)).values())
        value = float(modes.eigenvalues[0])
        return Branch(0, x, positions, energy, negative, value, residual, guarded)
