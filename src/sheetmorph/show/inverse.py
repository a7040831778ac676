"""A search for a design from target to folder: live picture, numbers, design, run and page."""

from __future__ import annotations

import json
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

from sheetmorph.core.errors import InputError
from sheetmorph.core.events import Listener, Progress, silent
from sheetmorph.core.files import resumable, write_bytes, write_text, writing
from sheetmorph.core.locks import sole_user
from sheetmorph.geometry.writers import write_stl
from sheetmorph.inverse.find import SearchOptions, find_design
from sheetmorph.inverse.free import GRADED
from sheetmorph.inverse.graded import FIELD
from sheetmorph.inverse.journal import JOURNAL
from sheetmorph.inverse.misfit import Evaluation, pose_of, shape_of
from sheetmorph.inverse.result import Found, Step
from sheetmorph.inverse.targets import Target
from sheetmorph.show import guard
from sheetmorph.show.guard import Written
from sheetmorph.show.inverse_pictures import Pair, write_best, write_course, write_found
from sheetmorph.show.render import RenderWorker
from sheetmorph.study.simulate import simulate

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design

DATA, DESIGN, PAGE = "inverse.json", "design.toml", "inverse.html"
SHAPE, WANTED = "shape.stl", "target.stl"
PICTURE, BEST, COURSE = "found.png", "best.png", "search.png"
RUN = ("result.h5", "summary.json")
OUTPUTS = (
    *(DATA, DESIGN, PAGE, SHAPE, WANTED, PICTURE, BEST, COURSE, *RUN),
    *(f"{GRADED}/{name}" for name in (DESIGN, FIELD, SHAPE, PICTURE, *RUN)),
)
"""What a search writes into its folder, and what the next one there replaces."""

PAUSE = 8.0
"""Seconds between two live pictures at least."""


def check_folder(folder: str | Path, *, resume: bool, force: bool) -> None:
    """Refuse to overwrite a search, or to throw away an unfinished one.

    Raises:
        InputError: the folder holds a search, and neither `resume` nor `force` is set; or files
            of these names that no search wrote.
        OutputError: nothing can be written there.
    """
    place = Path(folder)
    if resume and force:
        raise InputError("--resume and --force exclude each other; keep one of them")
    unfinished = (place / JOURNAL).exists()
    if unfinished and not (place / DATA).exists() and not (resume or force):
        raise InputError(
            "this folder holds an unfinished search; add --resume to go on, or --force to start "
            "anew",
            file=place,
        )
    guard.check_folder(
        place,
        OUTPUTS,
        "search for a design",
        ours=lambda _file: unfinished,
        force=force or resume,
    )


def design_into(
    folder: str | Path,
    target: Target,
    options: SearchOptions,
    *,
    resume: bool = False,
    force: bool = False,
    processes: int = 1,
    scheduler: str | None = None,
    pictures: bool = True,
    on_event: Listener = silent,
) -> tuple[Found, Written]:
    """Find a design, and write it with its run, numbers, pictures and a page.

    Every design is kept in evaluations.jsonl as it is measured, and best.png shows the best so
    far while the search goes on.

    Args:
        folder: where to write.
        target, options, processes, scheduler: as for `find_design`.
        resume: go on with a search that was cut off in the folder.
        force: replace the search that is in the folder.
        pictures: whether to draw.
        on_event: told of the progress.

    Raises:
        InputError: as for `find_design` and `check_folder`; or another job is at work there.
        ComputationError: no design reached its end.
        OutputError: something could not be written; what is there is whole.
        KeyboardInterrupt: interrupted; the journal holds what was measured.
    """
    place = Path(folder)
    with sole_user(place):
        check_folder(place, resume=resume, force=force)
        if force:
            with writing(place):
                for name in (*OUTPUTS, JOURNAL):
                    (place / name).unlink(missing_ok=True)
        painter = RenderWorker.start() if pictures else None
        try:
            found = find_design(
                target,
                options,
                journal=place / JOURNAL,
                resume=resume,
                processes=processes,
                scheduler=scheduler,
                on_event=on_event,
                on_better=_Live(target, place / BEST, painter),
            )
            on_event(Progress(0.96, "writing"))
            with resumable():
                written = write_found_folder(found, place, painter)
        finally:
            if painter is not None:
                painter.close()
    on_event(Progress(1.0, "done"))
    return found, written


def write_found_folder(found: Found, place: Path, painter: RenderWorker | None) -> Written:
    """Write what a search found; the numbers last, for they say that it is finished.

    Raises:
        OutputError: a file cannot be written; no half-written file is left.
    """
    from sheetmorph.show.inverse_page import write_page

    files = [place / name for name in (DESIGN, *found.files)]
    write_text(place / DESIGN, design_text(found))
    for name, data in found.files.items():
        write_bytes(place / name, data)
    found.result.save(place)
    write_stl(place / SHAPE, found.shape.triangles, found.shape.points)
    wanted = found.laid.target
    write_stl(place / WANTED, wanted.triangles, wanted.points)
    files += [place / SHAPE, place / WANTED]
    notes: tuple[str, ...] = ()
    drawn: list[Path] = []
    if painter is not None:
        pair = Pair(wanted, found.result, found.distance)
        title = f"{found.target.text}: {found.family}"
        drawn.append(write_found(pair, place / PICTURE, title, told(found), painter))
        drawn.append(write_course(found.steps, place / COURSE, found.target.text))
        write_best(pair, place / BEST, title, found.steps, painter)
        notes = (painter.note,) if painter.note else ()
    for name, other in found.others.items():
        files += write_other(other, place / name, painter)
    page = write_page(found, place / PAGE, drawn, notes)
    numbers = json.dumps(found.to_json(), indent=2, ensure_ascii=False, allow_nan=False)
    write_text(place / DATA, numbers + "\n")
    return Written((place / DATA, *files, *drawn, page), notes)


def write_other(found: Found, place: Path, painter: RenderWorker | None) -> list[Path]:
    """Write another design that was found on the way: its files, run, shape and picture."""
    files = [place / name for name in (DESIGN, *found.files)]
    write_text(place / DESIGN, design_text(found))
    for name, data in found.files.items():
        write_bytes(place / name, data)
    found.result.save(place)
    write_stl(place / SHAPE, found.shape.triangles, found.shape.points)
    files.append(place / SHAPE)
    if painter is not None:
        pair = Pair(found.laid.target, found.result, found.distance)
        title = f"{found.target.text}: {found.family}"
        files.append(write_found(pair, place / PICTURE, title, told(found), painter))
    return files


def design_text(found: Found) -> str:
    """The design file, with a comment on what it was found for."""
    values = ", ".join(f"{key} {value:.5g}" for key, value in found.values.items())
    head = (
        f"# Found for the target {found.target.text}: distance {100 * found.distance:.2f} % of its "
        f"size.\n# Family {found.family}: {values}\n"
    )
    return head + found.design.to_toml()


def told(found: Found) -> str:
    """The result in a line."""
    scaled = "" if abs(found.scale - 1.0) < 1e-6 else f", target scaled by {found.scale:.3g}"
    return (
        f"distance {100 * found.distance:.2f} % of the size, {1e3 * found.distance_m:.2f} mm"
        f"{scaled}"
    )


class _Live:
    """Draws the best so far, now and then."""

    def __init__(self, target: Target, path: Path, painter: RenderWorker | None) -> None:
        self._target, self._path, self._painter = target, path, painter
        self._drawn = -1e9

    def __call__(self, design: Design, found: Evaluation, steps: tuple[Step, ...]) -> None:
        if self._painter is None or monotonic() - self._drawn < PAUSE:
            return
        result = simulate(design)
        if result.status == "interrupted":
            raise KeyboardInterrupt
        if result.status != "completed":
            return
        target = self._target.surface
        laid = target.moved(pose_of(found.pose)) if found.pose else shape_of(result)
        pair = Pair(laid, result, found.distance)
        write_best(pair, self._path, self._target.text, steps, self._painter)
        self._drawn = monotonic()
