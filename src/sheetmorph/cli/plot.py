"""The command `plot`."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sheetmorph.cli.shared import output_folder
from sheetmorph.core.errors import InputError

if TYPE_CHECKING:
    from sheetmorph.sweep.dataset import Sweep

SHAPES, PARALLEL = "shapes.png", "parallel.html"
FOLDER = "plots"


@click.command()
@click.argument("sweep", type=click.Path(path_type=Path))
@click.argument("x", required=False)
@click.argument("y", required=False)
@click.argument("colour", required=False)
@output_folder("Folder to write. Default: SWEEP/plots.", "sweeps/stars/plots")
@click.option(
    "--shapes", type=int, default=24, show_default=True, help="Shapes on the contact sheet."
)
@click.option("--by", metavar="COLUMN", help="Order of the shapes. Default: the designs' own.")
@click.option(
    "--column",
    "columns",
    multiple=True,
    metavar="COLUMN",
    help="An axis of the parallel coordinates. May be repeated. Default: inputs and shape.",
)
@click.option("--columns", "only_list", is_flag=True, help="Print the columns and write nothing.")
@click.option("--force", is_flag=True, help="Replace plots of the same name.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
def plot(
    sweep: Path,
    x: str | None,
    y: str | None,
    colour: str | None,
    output: Path | None,
    shapes: int,
    by: str | None,
    columns: tuple[str, ...],
    only_list: bool,
    force: bool,
    quiet: bool,
) -> None:
    """Draw the folder SWEEP: column Y over column X, coloured by a third.

    Without columns: shapes.png, a contact sheet of shapes, and parallel.html, a page of
    parallel coordinates on which ranges can be picked.

    \b
    Examples:
      sheetmorph plot sweeps/stars
      sheetmorph plot sweeps/stars actuation.eps_pre aspect_ratio
      sheetmorph plot sweeps/stars actuation.eps_pre aspect_ratio layers.print.thickness
      sheetmorph plot sweeps/stars --by aspect_ratio --shapes 48
    """
    from sheetmorph.show.guard import check_folder
    from sheetmorph.sweep.dataset import Sweep

    found = Sweep.load(sweep)
    if only_list:
        for name in found.table.column_names:
            unit = found.units.get(name)
            click.echo(f"{name} [{unit}]" if unit else name)
        return
    if x is not None and y is None:
        raise InputError("name two columns, for x and for y; --columns lists them", value=x)
    place = output or sweep / FOLDER
    if x is not None and y is not None:
        names = [_scatter_name(x, y, colour)]
    else:
        names = [SHAPES, PARALLEL] if found.rows_with_shape() else [PARALLEL]
    check_folder(place, names, "plot", ours=lambda file: True, force=force)
    if x is not None and y is not None:
        from sheetmorph.show.sweep_scatter import draw_scatter

        draw_scatter(found, x, y, colour, place / names[0])
    else:
        _overview(found, place, names, shapes, by, columns)
    if not quiet:
        click.echo(f"plots in {place}: {', '.join(names)}")


def _overview(
    found: Sweep,
    place: Path,
    names: list[str],
    shapes: int,
    by: str | None,
    columns: tuple[str, ...],
) -> None:
    from sheetmorph.show.render import RenderWorker
    from sheetmorph.show.sweep_parallel import write_parallel
    from sheetmorph.show.sweep_shapes import draw_shapes

    write_parallel(found, columns, place / PARALLEL)
    if SHAPES not in names:
        click.echo("note: no states were kept of this sweep, so there are no shapes", err=True)
        return
    with RenderWorker.start() as worker:
        draw_shapes(found, shapes, by, worker, place / SHAPES)
        if worker.note:
            click.echo(f"note: {worker.note}", err=True)


def _scatter_name(x: str, y: str, colour: str | None) -> str:
    """Name of the picture; columns have dots, and no file may lead elsewhere."""
    parts = [re.sub(r"[^A-Za-z0-9_.]+", "_", part).strip(".") for part in (y, x, colour) if part]
    return f"{'-'.join(parts)[:150]}.png"
