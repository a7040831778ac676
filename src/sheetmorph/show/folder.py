"""All that can be seen of a result, written into its folder in one go."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from sheetmorph.show.pictures import borrowed, compose
from sheetmorph.show.render import RenderWorker

if TYPE_CHECKING:
    from sheetmorph.study.result import Result


@dataclass(frozen=True)
class Shown:
    """What was written.

    Attributes:
        files: the files, the report last.
        notes: lines for the user, such as what to install for better pictures.
    """

    files: list[Path]
    notes: list[str]


def write_folder(
    result: Result,
    folder: str | Path,
    worker: RenderWorker | None = None,
    *,
    pictures: bool = True,
    animation: bool = True,
    report: bool = True,
) -> Shown:
    """Write pictures, film and report of a result.

    The renderer draws the frames of the film while the pictures are put together, which
    is why this is faster than writing one after the other.

    Args:
        result: what was computed.
        folder: the results folder; made when absent.
        worker: draws the shape; start it before the solver. One is started and ended
            here when absent.
        pictures: write `pictures/*.png`.
        animation: write `animation.gif`.
        report: write `report.html` with whatever of these lies in the folder.

    Raises:
        OutputError: a file cannot be written; no half-written file is left.
        ComputationError: SHEETMORPH_RENDERER=vtk, and VTK does not draw.
    """
    from sheetmorph.show.film import film_job, save_film
    from sheetmorph.show.report import write_report
    from sheetmorph.show.stills import plan

    place = Path(folder)
    written: list[Path] = []
    if not (pictures or animation):
        return Shown([write_report(result, place)] if report else [], [])
    with borrowed(worker) as painter:
        stills = plan(result) if pictures else None
        images = painter.draw(stills.job) if stills else None
        film, actuation = (
            film_job(result, stills.job if stills else None) if animation else (None, None)
        )
        frames = painter.draw(film) if film else None
        if stills and images:
            written += compose(result, place, stills, images)
        if frames and actuation is not None:
            written.append(save_film(result, place, frames, actuation))
        notes = [painter.note] if painter.note else []
        drawn_by = painter.renderer
    if report:
        written.append(write_report(result, place, notes=notes, renderer=drawn_by))
    return Shown(written, notes)
