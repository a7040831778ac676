"""A run from design to folder: simulate, and write all that the design asks for."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter

from sheetmorph.core.errors import InputError
from sheetmorph.core.events import Listener, Progress, silent
from sheetmorph.core.files import resumable, write_text
from sheetmorph.core.locks import sole_user
from sheetmorph.design.spec import Design
from sheetmorph.geometry.writers import write_stl, write_vtu_series
from sheetmorph.show import fields
from sheetmorph.show.folder import write_folder
from sheetmorph.show.pictures import MOTION_NAMES, NAMES
from sheetmorph.show.render import RenderWorker
from sheetmorph.study.journal import Journal
from sheetmorph.study.result import Result
from sheetmorph.study.simulate import simulate
from sheetmorph.study.stability import stability_of, write_modes

OUTPUTS = (
    *("result.h5", "summary.json", "shape.stl", "animation.gif", "report.html", "modes.h5"),
    *("motion.csv", "series/shape.pvd", "series/shape_[0-9]*.vtu"),
    *(f"pictures/{name}" for name in (*NAMES, *MOTION_NAMES)),
)
"""What a run writes into its folder, and what the next one there replaces: nothing else."""

RESUMABLE = ("interrupted", "time_limit", "too_many_steps")
"""Statuses after which the states are kept for `--resume`."""


def run_design(
    design: Design,
    folder: str | Path,
    *,
    resume: bool = False,
    force: bool = False,
    modes: int = 0,
    on_event: Listener = silent,
    started: float | None = None,
) -> tuple[Result, list[str]]:
    """Simulate a design and write its results folder.

    Args:
        design: what to simulate.
        folder: where to write: result.h5, summary.json, shape.stl, of a motion
            motion.csv, and as the design's `outputs` ask: series/ for ParaView, pictures/,
            animation.gif, report.html.
        resume: go on from the states that an unfinished run left in the folder.
        force: replace the results that are in the folder.
        modes: how many of the softest modes of every state to compute and write as modes.h5.
        on_event: told of the progress.
        started: `time.perf_counter()` at the beginning of the job; now by default.

    Returns:
        The result, and notes for the user (such as what to install for better pictures).

    Raises:
        InputError: bad design, or the folder holds results and `force` is not set, or another
            job is at work there.
        OutputError: something could not be written; what is there is whole.
    """
    began = perf_counter() if started is None else started
    place = Path(folder)
    if modes:
        design.must_be_still("--modes")
    if place.exists() and not place.is_dir():
        raise InputError("this is a file; choose another folder with -o", file=place)
    with sole_user(place):
        return _run(design, place, resume, force, modes, on_event, began)


def _run(
    design: Design,
    place: Path,
    resume: bool,
    force: bool,
    modes: int,
    on_event: Listener,
    began: float,
) -> tuple[Result, list[str]]:
    journal = Journal.of_run(place, _outdated(place) if force else ())
    _guard(place, journal, resume, force)
    wanted = design.outputs
    draws = wanted.pictures or wanted.animation
    worker = RenderWorker.start() if draws else None
    notes: list[str] = []
    try:
        result = simulate(design, on_event=on_event, journal=journal, resume=resume)
        if result.status == "interrupted":
            return result, notes
        with resumable():
            notes += _write(result, place, worker, modes, on_event, began)
            result.summary["seconds"]["wall"] = perf_counter() - began
            result.save_summary(place)
    finally:
        if worker is not None:
            worker.close()
    if result.status not in RESUMABLE:
        journal.remove()
    on_event(Progress(1.0, "done"))
    return result, notes


def _write(
    result: Result,
    place: Path,
    worker: RenderWorker | None,
    modes: int,
    on_event: Listener,
    began: float,
) -> list[str]:
    """Write all that the design asks for; returns notes for the user."""
    wanted, notes = result.design.outputs, list[str]()
    on_event(Progress(0.95, "writing"))
    if modes:
        on_event(Progress(0.95, "computing modes"))
        found, result.summary["stability"] = stability_of(result, modes)
        write_modes(found, place / "modes.h5")
    result.save(place)
    if result.motion is not None:
        write_text(place / "motion.csv", result.motion.to_csv())
    write_stl(place / "shape.stl", result.mesh.triangles, result.positions[-1])
    if wanted.series:
        write_series(result, place)
    on_event(Progress(0.97, "drawing"))
    result.summary["seconds"]["wall"] = perf_counter() - began
    if wanted.pictures or wanted.animation or wanted.report:
        shown = write_folder(
            result,
            place,
            worker,
            pictures=wanted.pictures,
            animation=wanted.animation,
            report=wanted.report,
        )
        notes += shown.notes
    return notes


def write_series(result: Result, folder: str | Path) -> Path:
    """Write `series/shape.pvd`, every state with its fields, for ParaView.

    Edge and hinge fields are averaged onto the triangles and nodes they touch.

    Raises:
        OutputError: a file cannot be written.
    """
    mesh = result.mesh
    return write_vtu_series(
        Path(folder) / "series",
        "shape",
        mesh.triangles,
        result.positions,
        result.ramp,
        clock=None if result.motion is None else result.motion.time,
        point_fields={
            "height_m": result.height,
            "mean_curvature_per_m": result.mean_curvature,
            "gaussian_curvature_per_m2": result.gaussian_curvature,
            "dihedral_angle_size_rad": [
                fields.hinges_to_nodes(mesh, abs(angles)) for angles in result.dihedral
            ],
        },
        cell_fields={
            "strain": fields.edges_to_triangles(mesh, result.strain),
            "thermal_strain": fields.edges_to_triangles(mesh, result.thermal_strain),
            "in_pattern": [result.triangle_in_pattern.astype(float)] * len(result.ramp),
        },
    )


def _outdated(place: Path) -> list[Path]:
    """Files of an earlier run, where there was one: a folder without results is the user's."""
    if not (place / "result.h5").is_file():
        return []
    return [path for pattern in OUTPUTS for path in place.glob(pattern) if path.is_file()]


def _guard(place: Path, journal: Journal, resume: bool, force: bool) -> None:
    """Refuse to overwrite results, or to throw away the states of an unfinished run."""
    if resume or force:
        return
    if (place / "result.h5").exists():
        raise InputError(
            "this folder holds results; add --force to replace them, or choose another with -o",
            file=place,
        )
    if journal.exists:
        raise InputError(
            "this folder holds an unfinished run; add --resume to go on, or --force to start anew",
            file=place,
        )
