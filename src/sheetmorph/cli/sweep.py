"""The command `sweep`."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sheetmorph.cli.shared import (
    ProgressBar,
    notices_above,
    output_folder,
    read_values,
    set_values,
)
from sheetmorph.core.errors import InputError

if TYPE_CHECKING:
    from sheetmorph.sweep.run import Tally


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@output_folder("Folder for the results. Default: sweeps/NAME.", "sweeps/stars")
@set_values
@click.option("--workers", type=int, help="Processes, one thread each. Default: the processors.")
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="A Dask scheduler that is there, such as tcp://10.0.0.1:8786, in the place of processes.",
)
@click.option("--resume", is_flag=True, help="Go on with a sweep that was cut off in this folder.")
@click.option("--force", is_flag=True, help="Replace the sweep that is in the folder.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
@click.option("--json", "as_json", is_flag=True, help="Print how it went as JSON, nothing else.")
def sweep(
    file: Path,
    output: Path | None,
    overrides: tuple[str, ...],
    workers: int | None,
    scheduler: str | None,
    resume: bool,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Compute the many designs of the sweep FILE, by all processors or a Dask cluster.

    The folder receives results.parquet, a row for each design with inputs, numbers and
    status, and states.h5 with the shapes. Cut off at any moment, it goes on with --resume.

    \b
    Examples:
      sheetmorph sweep stars.toml -o sweeps/stars
      sheetmorph sweep stars.toml -o sweeps/stars --resume
      sheetmorph sweep stars.toml --scheduler tcp://10.0.0.1:8786
      sheetmorph plot sweeps/stars actuation.eps_pre aspect_ratio
    """
    from sheetmorph.sweep.plan import Plan
    from sheetmorph.sweep.run import run_sweep

    if scheduler is not None and workers is not None:
        raise InputError("--workers and --scheduler exclude each other")
    plan = Plan.load(file, read_values(overrides))
    folder = output or Path("sweeps") / file.stem
    silent = quiet or as_json
    with ProgressBar(silent) as listener:
        tally = run_sweep(
            plan,
            folder,
            workers=workers,
            scheduler=scheduler,
            resume=resume,
            force=force,
            on_event=listener if silent else notices_above(listener),
        )
    if tally.interrupted:
        raise click.exceptions.Abort(
            f"interrupted with {tally.present} of {tally.designs} designs; add --resume to go on"
        )
    if as_json:
        click.echo(json.dumps(asdict(tally), indent=2))
    elif not quiet:
        _tell(plan.name, tally, folder)


def _tell(name: str, tally: Tally, folder: Path) -> None:
    before = tally.designs - tally.computed
    known = f", {before} were there" if before else ""
    failed = f", {tally.failed} did not complete (see status and reason)" if tally.failed else ""
    click.echo(
        f"{name}: {tally.designs} designs{known}{failed}\n"
        f"  everything {tally.seconds:.1f} s\n"
        f"results in {str(folder).rstrip('/')}/ (results.parquet)"
    )
