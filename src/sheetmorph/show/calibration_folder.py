"""A fit from design to folder: search, and write its numbers, its design and its pictures."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from sheetmorph.calibrate.curves import Curve
from sheetmorph.calibrate.evaluations import JOURNAL
from sheetmorph.calibrate.fit import CalibrateOptions, calibrate
from sheetmorph.calibrate.parameters import Parameter
from sheetmorph.calibrate.result import Calibration
from sheetmorph.core.errors import InputError
from sheetmorph.core.events import Listener, Progress, silent
from sheetmorph.core.files import resumable, write_bytes, write_text, writing
from sheetmorph.core.locks import sole_user
from sheetmorph.design.spec import Design
from sheetmorph.show.calibration import PICTURES, write_pictures

if TYPE_CHECKING:
    from sheetmorph.calibrate.targets import MeasuredScan

NUMBERS = "calibration.json"


def fitted_name(design: Design) -> str:
    """Name of the file of the fitted design."""
    return f"{design.name}-calibrated.toml"


def check_folder(folder: Path, design: Design, *, resume: bool, force: bool) -> None:
    """Refuse to overwrite a fit, or to throw away an unfinished one.

    Raises:
        InputError: the folder holds a fit, and neither `resume` nor `force` is set.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError("this is a file; choose another folder with -o", file=folder)
    if resume and force:
        raise InputError("--resume and --force exclude each other; keep one of them")
    if resume or force:
        return
    if (folder / NUMBERS).exists():
        raise InputError(
            "this folder holds a fit; add --force to replace it, or choose another with -o",
            file=folder,
        )
    if (folder / JOURNAL).exists():
        raise InputError(
            "this folder holds an unfinished fit; add --resume to go on, or --force to start anew",
            file=folder,
        )
    if (folder / fitted_name(design)).exists():
        raise InputError(
            "this file is in the way; add --force to replace it, or choose another folder with -o",
            file=folder / fitted_name(design),
        )


def calibrate_into(
    folder: str | Path,
    design: Design,
    parameters: Sequence[Parameter],
    *,
    scans: Sequence[MeasuredScan] = (),
    curves: Sequence[Curve] = (),
    options: CalibrateOptions | None = None,
    resume: bool = False,
    force: bool = False,
    pictures: bool = True,
    on_event: Listener = silent,
) -> Calibration:
    """Fit parameters, and write calibration.json, the fitted design, and pictures.

    Every evaluation is kept in evaluations.jsonl as it is made.

    Args:
        folder: where to write.
        design, parameters, scans, curves, options: as for `calibrate`.
        resume: go on with a fit that was cut off in the folder.
        force: replace the fit that is in the folder.
        pictures: whether to draw.
        on_event: told of the progress.

    Raises:
        InputError: as for `calibrate` and `check_folder`; or another job is at work there.
        ComputationError: no candidate could be simulated.
        OutputError: something could not be written; what is there is whole.
    """
    place = Path(folder)
    check_folder(place, design, resume=True, force=False)
    with sole_user(place):
        check_folder(place, design, resume=resume, force=force)
        if force:
            with writing(place):
                for name in (NUMBERS, JOURNAL, fitted_name(design), *PICTURES):
                    (place / name).unlink(missing_ok=True)
        fit = calibrate(
            design,
            parameters,
            scans=scans,
            curves=curves,
            options=options,
            journal=place / JOURNAL,
            resume=resume,
            on_event=on_event,
        )
        with resumable():
            _write(fit, place, pictures, on_event)
    return fit


def _write(fit: Calibration, place: Path, pictures: bool, on_event: Listener) -> None:
    design = fit.design
    on_event(Progress(0.98, "writing"))
    write_text(place / fitted_name(design), fit.fitted_toml())
    for key, name in _named_files(design):
        source = design.resolve_file(name, key)
        if source.resolve() != (place / name).resolve():
            write_bytes(place / name, source.read_bytes())
    if pictures:
        write_pictures(fit, place)
    numbers = json.dumps(fit.to_json(), indent=2, ensure_ascii=False, allow_nan=False)
    write_text(place / NUMBERS, numbers + "\n")
    on_event(Progress(1.0, "done"))


def _named_files(design: Design) -> list[tuple[str, str]]:
    """Files beside the design that its fitted copy needs, too: key and name."""
    files = []
    if design.spec.mesh.file is not None:
        files.append(("mesh.file", design.spec.mesh.file))
    if design.actuation.temperature is not None and design.actuation.shrink_curve != "polystyrene":
        files.append(("actuation.shrink_curve", design.actuation.shrink_curve))
    if design.actuation.radial_profile is not None:
        files.append(("actuation.radial_profile", design.actuation.radial_profile))
    if design.actuation.field is not None:
        files.append(("actuation.field", design.actuation.field))
    return files
