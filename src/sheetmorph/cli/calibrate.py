"""The command `calibrate`."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sheetmorph.cli.shared import (
    ProgressBar,
    by_their_options,
    design_file,
    load_design,
    naming,
    output_folder,
    set_values,
)
from sheetmorph.core.errors import InputError

if TYPE_CHECKING:
    from sheetmorph.calibrate.result import Calibration
    from sheetmorph.calibrate.targets import MeasuredScan

# As in compare.faces, which --help must not import.
FACES = ("auto", "outer", "inner", "both")
MOST_WORKERS = 8


@click.command()
@design_file
@click.option(
    "--fit",
    "fits",
    multiple=True,
    metavar="NAME=LOW:HIGH",
    help="A parameter and its bounds. May be repeated.",
)
@click.option(
    "--scan",
    "scans",
    multiple=True,
    metavar="SCAN",
    type=click.Path(path_type=Path),
    help="A measured shape: STL, OBJ, PLY, or a run. May be repeated.",
)
@click.option(
    "--curve",
    "curves",
    multiple=True,
    metavar="CSV",
    type=click.Path(path_type=Path),
    help="Measured h/d against actuation, eps_pre or time. May be repeated.",
)
@output_folder("Folder for the fit. Default: calibrate/NAME.", "calibrate/petals")
@set_values
@click.option("--unit", metavar="UNIT", help="Unit of the scans, such as mm; else it is fitted.")
@click.option(
    "--face",
    type=click.Choice(FACES),
    default=FACES[0],
    show_default=True,
    help="Which face of a scan that has the thickness of the sheet.",
)
@click.option("--mirror", is_flag=True, help="Mirror the scans: sheets bent to the other side.")
@click.option("--curve-weight", type=float, default=1.0, show_default=True,
              help="Weight of a curve; a scan has 1.")  # fmt: skip
@click.option("--starts", type=int, help="Starting points. Default: 4, and 4 per parameter.")
@click.option("--samples", type=int, default=100_000, show_default=True,
              help="Points that stand for a scan at most.")  # fmt: skip
@click.option("--confidence", type=float, default=0.95, show_default=True, help="Of the intervals.")
@click.option("--no-intervals", is_flag=True, help="Find the optimum only, several times faster.")
@click.option(
    "--workers", type=int, help=f"Processes. Default: the processors, at most {MOST_WORKERS}."
)
@click.option("--seed", type=int, default=0, show_default=True, help="Of the starting points.")
@click.option("--resume", is_flag=True, help="Go on with a fit that was cut off in this folder.")
@click.option("--force", is_flag=True, help="Replace the fit that is in the folder.")
@click.option("--no-pictures", is_flag=True, help="Write numbers and the design only.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
@click.option("--json", "as_json", is_flag=True, help="Print calibration.json, nothing else.")
def calibrate(
    file: Path,
    fits: tuple[str, ...],
    scans: tuple[Path, ...],
    curves: tuple[Path, ...],
    output: Path | None,
    overrides: tuple[str, ...],
    unit: str | None,
    face: str,
    mirror: bool,
    curve_weight: float,
    starts: int | None,
    samples: int,
    confidence: float,
    no_intervals: bool,
    workers: int | None,
    seed: int,
    resume: bool,
    force: bool,
    no_pictures: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Fit parameters of the design FILE to scans, and to curves of h/d.

    Parameters: eps_pre, gamma, moduli_ratio, stretch_factor, coupling; or a key of the design
    that holds a number, with its unit in the bounds. The folder receives calibration.json
    (values with intervals), the fitted design, pictures of the misfit, and evaluations.jsonl.

    \b
    Examples:
      sheetmorph calibrate petals.toml --scan scan.stl --fit eps_pre=-0.8:-0.2
      sheetmorph calibrate petals.toml --scan scan.stl --unit mm --fit eps_pre --fit moduli_ratio
      sheetmorph calibrate bowl.toml --curve film.csv --fit "layers.1.thickness=0.4 mm:1 mm"
    """
    from sheetmorph.calibrate.curves import read_curve
    from sheetmorph.calibrate.fit import CalibrateOptions
    from sheetmorph.calibrate.parameter_texts import read_parameters
    from sheetmorph.show.calibration_folder import NUMBERS, calibrate_into, check_folder

    design = load_design(file, overrides)
    folder = output or Path("calibrate") / file.stem
    with by_their_options(_OPTIONS):
        options = CalibrateOptions(
            starts=starts,
            samples=samples,
            confidence=confidence,
            profile=not no_intervals,
            curve_weight=curve_weight,
            workers=min(os.cpu_count() or 1, MOST_WORKERS) if workers is None else workers,
            seed=seed,
        )
    parameters = read_parameters(fits, design)
    if not scans and not curves:
        raise InputError("nothing to fit to; give --scan or --curve")
    check_folder(folder, design, resume=resume, force=force)
    measured = _read_scans(scans, unit, face, mirror)
    read = [read_curve(path) for path in curves]
    with ProgressBar(quiet or as_json) as listener, naming(file):
        try:
            fit = calibrate_into(
                folder,
                design,
                parameters,
                scans=measured,
                curves=read,
                options=options,
                resume=resume,
                force=force,
                pictures=not no_pictures,
                on_event=listener,
            )
        except KeyboardInterrupt:
            raise click.exceptions.Abort("interrupted; add --resume to go on") from None
    if as_json:
        click.echo((folder / NUMBERS).read_text(encoding="utf-8").rstrip())
    elif not quiet:
        _tell(fit, folder)


def _read_scans(
    paths: tuple[Path, ...], unit: str | None, face: str, mirror: bool
) -> list[MeasuredScan]:
    from sheetmorph.calibrate.targets import MeasuredScan
    from sheetmorph.cli.surfaces import is_run, read_scan
    from sheetmorph.compare.comparison import CompareOptions
    from sheetmorph.core.units import scale_of

    if unit is not None:
        try:
            scale_of(unit.strip(), "length")
        except InputError as error:
            raise InputError(
                error.message, key="--unit", value=unit, allowed="mm, cm, m, in, ft, …"
            ) from None
    measured = []
    for path in paths:
        if not path.exists():
            raise InputError("there is no such file or folder", file=path)
        chosen = CompareOptions(
            unit=None if unit is None or is_run(path) else unit.strip(),
            face=face,  # type: ignore[arg-type]  # click allows no other
            mirror=mirror,
        )
        measured.append(MeasuredScan(read_scan(path), chosen))
    return measured


def _tell(fit: Calibration, folder: Path) -> None:
    """The fit in a few lines."""
    for note in fit.notes:
        click.echo(f"note: {note}", err=True)
    failed = f", {fit.failed} did not reach their end" if fit.failed else ""
    lines = fit.summary().replace("\n", "\n  ")
    click.echo(
        f"{fit.design.name}: fitted to {', '.join(fit.targets)}\n"
        f"  {lines}\n"
        f"  {len(fit.evaluations)} designs{failed}, {fit.seconds:.1f} s\n"
        f"fit in {str(folder).rstrip('/')}/ (misfit.png, {fit.design.name}-calibrated.toml)"
    )


_OPTIONS = {
    "starts": "--starts",
    "samples": "--samples",
    "confidence": "--confidence",
    "curve_weight": "--curve-weight",
    "workers": "--workers",
    "seed": "--seed",
}
"""Fields of `CalibrateOptions`, as they are called on the command line."""
