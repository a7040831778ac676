"""Files to take away: all that `sheetmorph run` and `sheetmorph fabricate` write, and a zip."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.core.events import Event, Progress
from sheetmorph.core.files import replacing, write_text
from sheetmorph.core.locks import FILE as LOCK

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design
    from sheetmorph.fabricate.options import Prediction
    from sheetmorph.studio.worker import Desk
    from sheetmorph.study.result import Result

RUN, PARTS = "run", "parts"


def export(job: dict[str, Any], desk: Desk, memory: Any) -> None:
    """Write the wanted files into a folder of the tab and tell their names.

    The job has `into`, an empty folder; `what`: "run", "parts" or both; `printer` and `kerf` [m].
    """
    from sheetmorph.show.outputs import run_design
    from sheetmorph.studio.tasks import designed

    design, place = designed(job), Path(job["into"])
    what = [name for name in (RUN, PARTS) if name in job["what"]]
    if not what:
        raise InputError("choose what to export", allowed=f"{RUN}, {PARTS}")
    write_text(place / f"{_plain(design.name)}.toml", design.to_portable_toml())
    notes: list[str] = []
    result = None
    share = 1.0 / len(what)
    if RUN in what:
        asked = {f"outputs.{key}": True for key in ("pictures", "animation", "report", "series")}
        result, told = run_design(
            design.with_values(asked), place / RUN, on_event=_part(desk, 0.0, share)
        )
        notes += told
    if PARTS in what:
        notes += _parts(design, result, place / PARTS, job, _part(desk, 1.0 - share, share))
    files = {
        path.relative_to(place).as_posix(): path
        for path in sorted(place.rglob("*"))
        if path.is_file() and path.name != LOCK
    }
    name = _plain(design.name)
    archive = f"{name}.zip"
    files[archive] = zipped(files, place / archive, name)
    desk.answer(
        "exported",
        {
            "name": place.name,
            "zip": archive,
            "files": [{"name": key, "bytes": path.stat().st_size} for key, path in files.items()],
            "places": {key: str(path) for key, path in files.items()},
            "notes": notes,
        },
    )


def zipped(files: dict[str, Path], target: Path, folder: str) -> Path:
    """Write a zip of files, under a folder of its own.

    Raises:
        OutputError: it cannot be written.
    """
    with replacing(target) as partial, zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED) as into:
        for name, path in files.items():
            into.write(path, f"{folder}/{name}")
    return target


def _parts(
    design: Design, result: Result | None, folder: Path, job: dict[str, Any], listener: Any
) -> list[str]:
    from sheetmorph.fabricate.options import FabricationOptions
    from sheetmorph.fabricate.package import fabricate_design
    from sheetmorph.fabricate.printer import find_profile
    from sheetmorph.study.simulate import simulate

    options = FabricationOptions(
        printer=find_profile(job.get("printer") or "generic-0.4"), kerf=job.get("kerf") or 0.0
    )
    package = fabricate_design(
        design,
        folder,
        options=options,
        prediction=_prediction(simulate(design) if result is None else result),
        on_event=listener,
    )
    return list(package.warnings)


def _prediction(result: Result) -> Prediction:
    """The shape as the assembly sheet shows it."""
    from sheetmorph.fabricate.options import Prediction
    from sheetmorph.show.pictures import shape_png

    summary = result.summary
    if result.status != "completed":
        note = f"The computation ended early ({result.status}): {summary['remedy']}."
        return Prediction(0.0, 0.0, 0.0, 0.0, result.status, False, None, note)
    try:
        picture = shape_png(result)
    except ComputationError:
        picture = None
    width, depth, height = summary["bbox_m"]
    return Prediction(
        width, depth, height, summary["aspect_ratio"], result.status, summary["stable"], picture
    )


def _part(desk: Desk, start: float, share: float) -> Any:
    """A listener that shows progress as a part of the whole."""

    def listen(event: Event) -> None:
        if isinstance(event, Progress):
            desk.listen(Progress(start + share * event.fraction, event.text))
        else:
            desk.listen(event)

    return listen


def _plain(name: str) -> str:
    """A design's name as that of a file: letters, digits, - and _ alone."""
    plain = "".join(letter if letter.isalnum() or letter in "-_" else "-" for letter in name)
    return plain.strip("-")[:60] or "design"
