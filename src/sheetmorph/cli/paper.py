"""The command `paper`."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter

import click

from sheetmorph.cli.shared import at_work, output_folder

STARTED = perf_counter()


@click.command()
@output_folder("Folder for the report.", "paper-report", default="paper-report")
@click.option(
    "--only",
    multiple=True,
    metavar="SECTION",
    help="Redo this section alone, such as shapes or mesh. May be repeated.",
)
@click.option("--reference", metavar="DIR", help="Folder with the paper's meshes.")
@click.option("--scan", metavar="FILE", help="Scan of the petals, as STL, OBJ or PLY.")
@click.option("--workers", type=click.IntRange(1, 64), help="Processes. Default: one a core, to 8.")
@click.option("--force", is_flag=True, help="Replace the report that is in the folder.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
def paper(
    output: Path,
    only: tuple[str, ...],
    reference: str | None,
    scan: str | None,
    workers: int | None,
    force: bool,
    quiet: bool,
) -> None:
    """Redo the results of the paper, side by side with what it states.

    The folder receives paper.html, a page with all pictures, and paper.json, all numbers. The
    paper's meshes and a scan are not part of sheetmorph: --reference or the variable
    SHEETMORPH_REFERENCE_DATA names their folder. Without them meshes are made here.

    \b
    Examples:
      sheetmorph paper
      sheetmorph paper --reference shared/reference -o report
      sheetmorph paper --only shapes --only mesh --force
    """
    from sheetmorph.paper.redo import chosen_sections, find_setting, redo_paper
    from sheetmorph.show.paper import check_paper_folder, write_paper
    from sheetmorph.show.render import RenderWorker

    chosen_sections(only)
    setting = find_setting(reference, scan)
    working = at_work(output, quiet, lambda: check_paper_folder(output, force))
    with working as listener, RenderWorker.start() as worker:
        try:
            done = redo_paper(setting, only=only, workers=workers, on_event=listener)
        except KeyboardInterrupt:
            raise click.exceptions.Abort("interrupted; nothing was written") from None
        page, notes = write_paper(done, output, worker, on_event=listener, started=STARTED)
    if quiet:
        return
    for note in notes:
        click.echo(f"note: {note}", err=True)
    meshes = "the paper's meshes" if setting.reference else "meshes made here (see --reference)"
    click.echo(f"{len(done.outcomes)} simulations on {meshes}, {done.seconds:.0f} s")
    for verdict, count in done.counts.items():
        click.echo(f"  {count:3d}  {verdict}")
    click.echo(f"{Path(page)}")
