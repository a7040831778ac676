"""The command `fabricate`."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sheetmorph.cli.shared import (
    at_work,
    design_file,
    load_design,
    naming,
    output_folder,
    read_length,
    set_values,
)
from sheetmorph.core.errors import ComputationError, InputError, SheetmorphError

if TYPE_CHECKING:
    from sheetmorph.core.events import Listener
    from sheetmorph.design.spec import Design
    from sheetmorph.fabricate.options import Prediction
    from sheetmorph.study.result import Result

# As in fabricate.printer and fabricate.options, which --help must not import.
PRINTERS = ("generic-0.4", "bambu-p1s", "prusa-mk4")
PAPERS = ("a4", "letter")


@click.command()
@design_file
@output_folder("Folder for the files. Default: fabricate/NAME.", "parts")
@set_values
@click.option(
    "--printer",
    type=click.Choice(PRINTERS),
    default=PRINTERS[0],
    show_default=True,
    help="Profile of the 3D printer.",
)
@click.option("--nozzle", metavar="LENGTH", help='Width of its nozzle, such as "0.6 mm".')
@click.option("--bed", metavar="W,D", help='Width and depth of its bed, such as "180 mm, 180 mm".')
@click.option("--layer-height", metavar="LENGTH", help="Height of its layers.")
@click.option("--minimum-feature", metavar="LENGTH", help="Narrowest rib that it prints well.")
@click.option("--kerf", metavar="LENGTH", help='Width of the cut, such as "0.15 mm". Default: 0.')
@click.option("--copies", type=int, default=1, show_default=True, help="Sheets to nest on stock.")
@click.option("--stock", metavar="W,H", help='Size of the stock, such as "300 mm, 200 mm".')
@click.option("--spacing", metavar="LENGTH", help="Between nested sheets. Default: 2 mm.")
@click.option(
    "--paper", "papers", type=click.Choice(PAPERS), multiple=True, help="Of the template [both]."
)
@click.option("--result", "result_folder", metavar="DIR", help="Take the shape from this run.")
@click.option("--no-prediction", is_flag=True, help="Do not compute the shape.")
@click.option("--force", is_flag=True, help="Replace the files that are in the folder.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
@click.option("--json", "as_json", is_flag=True, help="Print what was written as JSON.")
def fabricate(
    file: Path,
    output: Path | None,
    overrides: tuple[str, ...],
    printer: str,
    nozzle: str | None,
    bed: str | None,
    layer_height: str | None,
    minimum_feature: str | None,
    kerf: str | None,
    copies: int,
    stock: str | None,
    spacing: str | None,
    papers: tuple[str, ...],
    result_folder: str | None,
    no_prediction: bool,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Write the files that make the design FILE: to print, to cut, to glue, to bake.

    The folder receives parts/ (3MF and STL of the inert parts), cut/ (DXF and SVG of sheet and
    pattern), a 1:1 template as PDF, and assembly.html and .pdf with the steps.

    \b
    Examples:
      sheetmorph fabricate bowl.toml -o parts
      sheetmorph fabricate bowl.toml --printer prusa-mk4 --kerf "0.15 mm"
      sheetmorph fabricate bowl.toml --copies 4 --stock "300 mm, 200 mm"
    """
    from sheetmorph.fabricate.options import FabricationOptions
    from sheetmorph.fabricate.package import check_folder, fabricate_design
    from sheetmorph.fabricate.printer import find_profile
    from sheetmorph.fabricate.stack import levels_of

    if no_prediction and result_folder is not None:
        raise InputError("--result and --no-prediction exclude each other; keep one of them")
    design = load_design(file, overrides)
    folder = output or Path("fabricate") / file.stem
    bed_width, bed_depth = _pair(bed, "--bed")
    stock_width, stock_height = _pair(stock, "--stock")
    with _by_their_options():
        options = FabricationOptions(
            printer=find_profile(
                printer,
                nozzle_width=read_length(nozzle, "--nozzle"),
                bed_width=bed_width,
                bed_depth=bed_depth,
                minimum_feature=read_length(minimum_feature, "--minimum-feature"),
                layer_height=read_length(layer_height, "--layer-height"),
            ),
            kerf=read_length(kerf, "--kerf") or 0.0,
            copies=copies,
            stock_width=stock_width,
            stock_height=stock_height,
            **({} if spacing is None else {"spacing": read_length(spacing, "--spacing") or 0.0}),
            papers=papers or PAPERS,
        )
    with naming(file):
        levels_of(design)  # what cannot be made is refused before it is computed
    working = at_work(folder, quiet or as_json, lambda: check_folder(folder, force))
    with working as listener, naming(file), _by_their_options():
        prediction = None if no_prediction else _predicted(design, result_folder, listener)
        package = fabricate_design(
            design, folder, options=options, prediction=prediction, force=force, on_event=listener
        )
    if as_json:
        told = {
            "folder": str(package.folder),
            "files": [str(path.relative_to(package.folder)) for path in package.files],
            "warnings": list(package.warnings),
        }
        click.echo(json.dumps(told, indent=2, ensure_ascii=False))
    elif not quiet:
        for warning in (*design.notes, *package.warnings):
            click.echo(f"warning: {warning}", err=True)
        click.echo(
            f"{design.name}: {len(package.files)} files in {package.folder} (open assembly.html)"
        )
    if prediction is not None and prediction.status != "completed":
        raise SheetmorphError(f"{file}: the files are written, but no shape: {prediction.note}")


_OPTIONS = {
    "nozzle_width": "--nozzle",
    "bed_width": "--bed",
    "bed_depth": "--bed",
    "layer_height": "--layer-height",
    "minimum_feature": "--minimum-feature",
    "kerf": "--kerf",
    "copies": "--copies",
    "spacing": "--spacing",
    "stock_width": "--stock",
    "stock_height": "--stock",
    "papers": "--paper",
}
"""Fields of `FabricationOptions` and `PrinterProfile`, as they are called on the command line."""


@contextmanager
def _by_their_options() -> Iterator[None]:
    """Errors about the fields of the options name the options of the command line."""
    try:
        yield
    except InputError as error:
        if error.key not in _OPTIONS or error.file is not None:
            raise
        allowed = error.allowed
        if error.key.startswith("stock") and (allowed or "").startswith("stock_width"):
            allowed = '--stock "300 mm, 200 mm"'
        raise InputError(
            error.message, key=_OPTIONS[error.key], value=error.value, allowed=allowed
        ) from None


def _predicted(design: Design, folder: str | None, listener: Listener) -> Prediction:
    """The shape that the design takes: computed, or from a run of the same design."""
    from sheetmorph.fabricate.options import Prediction

    try:
        result = _result_of(design, folder, listener)
    except ComputationError as error:
        return Prediction(0.0, 0.0, 0.0, 0.0, "failed", False, None, str(error))
    if result.status == "interrupted":
        raise click.exceptions.Abort("interrupted; nothing was written")
    return prediction_of(result)


def prediction_of(result: Result) -> Prediction:
    """The shape of a run, as the assembly sheet shows it."""
    from sheetmorph.fabricate.options import Prediction
    from sheetmorph.show.pictures import shape_png

    summary = result.summary
    width, depth, height = summary["bbox_m"]
    done = result.status == "completed"
    reached = 100 * summary["actuation_reached"]
    return Prediction(
        width=width if done else 0.0,
        depth=depth if done else 0.0,
        height=height if done else 0.0,
        aspect_ratio=summary["aspect_ratio"] if done else 0.0,
        status=result.status,
        stable=bool(summary["stable"]),
        picture_png=shape_png(result) if done else None,
        note=(
            ""
            if done
            else f"The computation ended at {reached:.0f} % of the actuation "
            f"({summary['detail'] or result.status.replace('_', ' ')}): {summary['remedy']}."
        ),
    )


def _result_of(design: Design, folder: str | None, listener: Listener) -> Result:
    if folder is None:
        from sheetmorph.study.simulate import simulate

        return simulate(design, on_event=listener)
    from sheetmorph.study.result import Result

    result = Result.load(folder)
    if result.summary["design_hash"] != design.hash:
        raise InputError(
            "this run is of another design; run the design again, or leave out --result",
            file=folder,
        )
    return result


def _pair(text: str | None, option: str) -> tuple[float | None, float | None]:
    if text is None:
        return None, None
    parts = text.split(",")
    if len(parts) != 2:
        raise InputError(
            "wants two lengths", key=option, value=text, allowed='as in "300 mm, 200 mm"'
        )
    return read_length(parts[0], option), read_length(parts[1], option)
