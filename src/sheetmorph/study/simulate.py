"""Design in, result out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sheetmorph import __version__
from sheetmorph.core.events import Event, Listener, Notice, Progress, Started, StateReached, silent
from sheetmorph.core.machine import surroundings
from sheetmorph.design.spec import Design
from sheetmorph.geometry import surface
from sheetmorph.geometry.crossings import crossing_pairs
from sheetmorph.geometry.mesh import SheetMesh
from sheetmorph.solve.constraints import HeldDofs, align_to_reference
from sheetmorph.solve.linear import make_solver
from sheetmorph.solve.minimise import NewtonOptions
from sheetmorph.solve.path import (
    Path,
    PathOptions,
    PathState,
    Status,
    Waypoint,
    follow,
    start_of_path,
)
from sheetmorph.solve.system import System, Work
from sheetmorph.study.journal import Journal
from sheetmorph.study.model import Problem, build_problem
from sheetmorph.study.result import Result

WAYPOINTS = (Waypoint(0.0, 1.0), Waypoint(1.0, 1.0), Waypoint(1.0, 0.0))
"""Actuate under the perturbation load, then remove the load."""

LAID_DOWN = (Waypoint(0.0, 0.0), *WAYPOINTS)
"""With gravity: weight and perturbation load come on first."""


def simulate(
    design: Design,
    *,
    on_event: Listener = silent,
    journal: Journal | None = None,
    resume: bool = False,
    stops: Sequence[float] = (),
    mesh: SheetMesh | None = None,
) -> Result:
    """Predict the shape into which a sheet morphs, from flat to full actuation.

    Args:
        design: what to simulate.
        on_event: told of the progress, see `sheetmorph.core.events`.
        journal: where to keep every state as it is reached; nowhere by default.
        resume: go on from the last state in the journal.
        stops: fractions of the actuation at which there shall be a state, increasing.
        mesh: reference mesh to take in the place of the design's own.

    Returns:
        The result with every state that was reached. A computation that did not reach the
        end is a `status` in its summary, with a remedy, not an exception.

    Raises:
        InputError: the design and its mesh do not fit together.
        OutputError: a state could not be kept.
    """
    if design.solver.kind == "dynamic":
        from sheetmorph.study.motion import simulate_motion

        if stops:
            design.must_be_still("a run with stops")
        return simulate_motion(design, on_event=on_event, journal=journal, resume=resume, mesh=mesh)
    began = perf_counter()
    on_event(Started(design.name))
    problem = build_problem(design, mesh)
    legs = WAYPOINTS if design.gravity is None else LAID_DOWN
    actuation = len(legs) - len(WAYPOINTS)
    options = replace(path_options(problem), stops=tuple(stops), stops_leg=actuation)
    x0 = problem.start
    known = [start_of_path(x0, legs, options)]
    if resume and journal is not None:
        known = journal.read(design.hash, x0.size)
    elif journal is not None:
        journal.begin(design.hash)
        journal.write(0, known[0])
    problem.total.at(0.0, 1.0).evaluate(x0, 2)  # compiles, or loads the compiled kernels

    aside = _Aside(on_event, journal)
    start = perf_counter()
    linear = make_solver(
        problem.total.pattern,
        design.solver.linear_solver,
        max(1, design.solver.threads),
        problem.total.growth,
    )
    system = System(problem.total, HeldDofs.of(problem.total.pattern, problem.held_dofs), linear)
    path = follow(
        system,
        legs,
        known,
        options,
        equal_steps={actuation + 1: design.perturbation.ramp_down_steps},
        on_event=aside.tell,
        on_state=aside.keep,
    )
    solved = perf_counter() - start - aside.seconds
    result = result_of(problem, path, system, linear.name)
    if path.status is Status.STEP_TOO_SMALL:
        explain(result)
    elif path.status is Status.COMPLETED:
        _tell_of_guard(result)
    result.summary["seconds"] = seconds_of(system.work, solved, perf_counter() - began)
    if path.status is not Status.COMPLETED:
        on_event(Notice(f"{path.status}: {result.summary['remedy']}"))
    if crossing := result.summary["crossing_pairs"]:
        on_event(Notice(f"{_passes(crossing)}; {WITH_CONTACT} keeps its parts apart"))
    return result


class _Aside:
    """Listeners and journal, and the time they take, which is not the solver's."""

    def __init__(self, on_event: Listener, journal: Journal | None) -> None:
        self._on_event, self._journal = on_event, journal
        self.seconds = 0.0

    def tell(self, event: Event) -> None:
        start = perf_counter()
        self._on_event(event)
        if isinstance(event, StateReached):
            ramp = 100 * event.ramp
            text = f"{ramp:.0f} % actuated" if event.load == 1.0 else "removing the load"
            if event.ramp == 0.0:
                self._on_event(Progress(0.0, "laying the sheet down"))
            else:
                self._on_event(Progress(0.95 * event.ramp + 0.05 * (1.0 - event.load), text))
        self.seconds += perf_counter() - start

    def keep(self, index: int, state: PathState) -> None:
        start = perf_counter()
        if self._journal is not None:
            self._journal.write(index, state)
        self.seconds += perf_counter() - start


def path_options(problem: Problem) -> PathOptions:
    """Steps and limits that the design of a problem asks for."""
    chosen = problem.design.solver
    return PathOptions(
        newton=NewtonOptions(
            residual_tolerance=problem.residual_tolerance, max_iterations=chosen.max_iterations
        ),
        initial_step=problem.design.initial_step,
        max_step=chosen.max_step,
        min_step=chosen.min_step,
        max_steps=chosen.max_steps,
        time_limit=float("inf") if chosen.time_limit is None else chosen.time_limit,
    )


def result_of(
    problem: Problem, path: Path, system: System, solver: str, *, aligned: bool = True
) -> Result:
    """What is told of the states of a path, without the times it took.

    Args:
        problem: the problem.
        path: its states, and how it ended.
        system: the account of the work.
        solver: name of the linear solver.
        aligned: lay the states of a sheet that nothing holds over the flat one.
    """
    positions = np.array([problem.positions(state.x) for state in path.states])
    if aligned and problem.floats:
        positions = align_to_reference(positions, problem.mesh.nodes)
    final = path.states[-1]
    energies = problem.total.at(final.ramp, final.load).energies(final.x)
    extent = np.ptp(positions[-1], axis=0)
    nodes, edges, triangles = problem.mesh.counts
    summary: dict[str, Any] = {
        "name": problem.design.name,
        "model": problem.design.model,
        "status": str(path.status),
        "detail": path.detail,
        "remedy": path.status.remedy,
        "stable": final.negative_pivots == 0,
        "negative_pivots": final.negative_pivots,
        "residual_max_N": final.residual,
        "residual_tolerance_N": problem.residual_tolerance,
        "eps_pre": problem.design.eps_pre,
        "actuation_reached": final.ramp,
        "states": len(path.states),
        "newton_iterations": system.work.iterations,
        "factorisations": system.work.factorisations,
        "back_substitutions": system.work.solves,
        "evaluations": system.work.evaluations,
        "solver": solver,
        "nodes": nodes,
        "edges": edges,
        "triangles": triangles,
        "height_m": float(extent[2]),
        "bbox_m": [float(value) for value in extent],
        "aspect_ratio": float(surface.aspect_ratio(positions[-1])),
        "crossing_pairs": len(crossing_pairs(positions[-1], problem.mesh.triangles)),
        **problem.surroundings.numbers(problem.positions(final.x)),
        "energy_J": {**energies, "total": sum(energies.values())},
        "version": __version__,
        "design_hash": problem.design.hash,
        "computed_with": surroundings(max(1, problem.design.solver.threads)),
    }
    found = Result(
        design=problem.design,
        mesh=problem.mesh,
        positions=positions,
        ramp=np.array([state.ramp for state in path.states]),
        load_fraction=np.array([state.load for state in path.states]),
        residual=np.array([state.residual for state in path.states]),
        thermal_strain_full=problem.thermal_strain,
        edge_in_pattern=problem.regions.edge_in_pattern,
        triangle_in_pattern=problem.regions.triangle_in_pattern,
        stretch_stiffness=problem.model.stretch_stiffness,
        bending_stiffness=problem.model.bending_stiffness,
        coupling=problem.model.coupling,
        held_nodes=problem.held_nodes,
        scalars=np.array([state.x[problem.mesh.nodes.size :] for state in path.states]),
        summary=summary,
    )
    vars(found)["regions"] = problem.regions  # which else are looked up anew when asked for
    return found


WITH_CONTACT = "contact.self_contact = true"


def _passes(crossing: int) -> str:
    pairs = (
        "1 pair of triangles crosses" if crossing == 1 else f"{crossing} pairs of triangles cross"
    )
    return f"the sheet passes through itself ({pairs})"


FOLDED_FLAT = 2.9
"""Size of a dihedral angle [rad] beyond which two triangles all but touch."""

COLLAPSED = np.deg2rad(8.0)
"""Smallest angle of a deformed triangle below which it counts as collapsed."""


def explain(result: Result) -> None:
    """Say so when the path ended because the sheet left the reach of the model."""
    state, mesh = result.positions[-1], result.mesh
    angles = np.abs(result.dihedral[-1])
    corners = surface.smallest_angles(state, mesh.triangles)
    advice = "try a smaller actuation.eps_pre, another mesh.size or a wider pattern"
    if angles.max(initial=0.0) > FOLDED_FLAT:
        place = mesh.edge_midpoints[mesh.hinge_edges[int(angles.argmax()), 0]]
        result.summary["detail"] = f"the sheet has folded flat on itself at {_at(place)}"
        on = result.design.contact.self_contact
        result.summary["remedy"] = advice if on else f"{advice}, or {WITH_CONTACT}"
    elif corners.min() < COLLAPSED:
        place = mesh.triangle_centroids[int(corners.argmin())]
        result.summary["detail"] = (
            f"a triangle at {_at(place)} has collapsed to a smallest angle of "
            f"{np.rad2deg(corners.min()):.0f}°"
        )
        result.summary["remedy"] = (
            f"the eigenstrains of its edges fit no triangle; {advice}, or a smoother profile"
        )


def _tell_of_guard(result: Result) -> None:
    """Say so where triangles of a shape are held open by nothing but the guards."""
    state, mesh, energy = result.positions[-1], result.mesh, result.summary["energy_J"]
    found = []
    if energy["guard"] > 0.0:
        flattest = int(surface.smallest_angles(state, mesh.triangles).argmin())
        found.append(
            "triangles are squeezed to slivers and held open by the guard, the flattest at "
            f"{_at(mesh.triangle_centroids[flattest])}"
        )
    if energy["fold"] > 0.0:
        angles = np.abs(result.dihedral[-1])
        folded = mesh.hinge_edges[int(angles.argmax()), 0]
        found.append(
            f"the sheet is folded to {np.rad2deg(angles.max()):.0f}° along edges of the mesh and "
            f"held open by the guard, farthest at {_at(mesh.edge_midpoints[folded])}"
        )
    if found:
        result.summary["detail"] = (
            f"{'; '.join(found)}; another mesh.size or a smaller actuation avoids that"
        )


def _at(place: NDArray[np.float64]) -> str:
    """A place on the flat sheet, for people."""
    x, y = 1e3 * place
    return f"({x:.1f}, {y:.1f}) mm"


def seconds_of(work: Work, solved: float, wall: float) -> dict[str, float]:
    """Where the time went [s]: the parts of the solver, and all in all."""
    parts = {
        "assembly": work.assembly_seconds,
        "factorise": work.factorise_seconds,
        "solve": work.solve_seconds,
    }
    return {**parts, "other": solved - sum(parts.values()), "total": solved, "wall": wall}
