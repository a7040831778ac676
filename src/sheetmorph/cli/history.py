"""The command `history`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sheetmorph.cli.film_options import film_options, quantity
from sheetmorph.cli.shared import at_work, output_folder
from sheetmorph.core.errors import InputError

if TYPE_CHECKING:
    from sheetmorph.core.events import Listener
    from sheetmorph.measure.film_history import FilmHistory
    from sheetmorph.study.history import MeanHistory, RunHistory
    from sheetmorph.study.result import Result

# As geometry.surface.Width and measure.silhouette.Background, which --help must not import.
WIDTHS = ("feret_max", "feret_min", "x", "y", "side")
BACKGROUNDS = ("auto", "light", "dark")
PLOT, RUNS, MEANS = "history.png", "history.csv", "films.csv"


@click.command()
@click.argument("runs", nargs=-1, type=click.Path(path_type=Path), metavar="[RUN]...")
@click.option(
    "--film",
    "films",
    multiple=True,
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="A video, a folder of pictures, or a table that this command wrote. May be repeated.",
)
@output_folder("Folder to write.", "history", default="history")
@click.option(
    "--width",
    type=click.Choice(WIDTHS),
    help="Width d of the runs in the plot. Default: side with films, else feret_max.",
)
@click.option(
    "--azimuth",
    metavar="ANGLE",
    default="0 deg",
    show_default=True,
    help="Direction of the camera for --width side; at 0 it looks along +y.",
)
@click.option(
    "--reference",
    metavar="LENGTH=X0,Y0,X1,Y1",
    help='A known length and its ends in the picture [px], as in "50 mm=10,200,310,205".',
)
@click.option("--region", metavar="X0,Y0,X1,Y1", help="Part of the picture to look at [px].")
@click.option(
    "--background",
    type=click.Choice(BACKGROUNDS),
    default="auto",
    show_default=True,
    help="The sheet is darker than a light background, or lighter than a dark one.",
)
@click.option(
    "--threshold",
    metavar="auto|0..255",
    default="auto",
    show_default=True,
    help="Difference from the background from which on a pixel is the sheet.",
)
@click.option(
    "--interval", metavar="TIME", default="1 s", show_default=True, help="Between the frames."
)
@click.option("--rate", type=float, help="Frames per second. Default: the video's; 1 for pictures.")
@click.option("--start", metavar="TIME", default="0 s", help="Where in the film to begin.")
@click.option("--end", metavar="TIME", help="Where in the film to stop.")
@click.option(
    "--roll",
    metavar="auto|ANGLE|X0,Y0,X1,Y1",
    default="auto",
    show_default=True,
    help="What is level: from the flat sheet of the first frame, an angle (positive: level lines "
    "fall to the right), or a level line [px].",
)
@click.option(
    "--tilt",
    metavar="auto|ANGLE",
    default="0 deg",
    show_default=True,
    help="By how much the camera looks down; auto: from the flat sheet of the first frame.",
)
@click.option(
    "--thickness",
    metavar="LENGTH",
    help="Of the flat sheet, for --tilt auto; needs a RUN or --reference.",
)
@click.option(
    "--distance",
    metavar="LENGTH",
    help="From the lens to the sheet, to correct the perspective; needs a RUN or --reference. "
    "Default: far away.",
)
@click.option(
    "--tilt-shape",
    type=click.Choice(("run", "cap")),
    help="Shape with which tilt and perspective are corrected: the first RUN, or a spherical cap.",
)
@click.option(
    "--mask-pictures/--no-mask-pictures",
    default=True,
    help="Write the frames with the outline that was found. [on]",
)
@click.option("--force", is_flag=True, help="Replace the files that are in the folder.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
def history(
    runs: tuple[Path, ...],
    films: tuple[Path, ...],
    output: Path,
    force: bool,
    quiet: bool,
    mask_pictures: bool,
    width: Any,
    **given: Any,
) -> None:
    """Compare height over width of runs with films of the oven, taken from the side.

    The folder receives history.csv (h and d of every state), history.png, and for every film a
    table and the frames with the outline found in them: films/NAME.csv and NAME.png. Look at
    those frames before you trust the numbers. h/d needs no --reference; lengths in mm do.

    A camera that looks down sees the far rim too high, one that is near sees near parts too
    large. By how much depends on the shape, which a side view does not show: --tilt and
    --distance take it from the run, or from a spherical cap.

    \b
    Examples:
      sheetmorph history results/bowl results/petals -o history
      sheetmorph history results/bowl --film oven.mp4 --reference "50 mm=10,200,310,205"
      sheetmorph history results/bowl --film a.mp4 --film b.mp4 --tilt auto --start "4 s"
    """
    from sheetmorph.study.history import history_of, mean_of
    from sheetmorph.study.result import Result

    if not runs and not films:
        raise InputError("name a RUN, or a film with --film")
    folder = output
    interval = quantity(given["interval"], "time", "--interval")
    if interval <= 0.0:
        raise InputError("must be above zero", key="--interval", value=given["interval"])
    azimuth = quantity(given["azimuth"], "angle", "--azimuth")
    results = [Result.load(run) for run in runs]
    names = _unlike([_run_name(run, k) for k, run in enumerate(runs)])
    computed = [history_of(r, n, azimuth) for r, n in zip(results, names, strict=True)]
    with at_work(folder, quiet, lambda: _check_folder(folder, films, force)) as listener:
        filmed = _measured(films, results, azimuth, given, listener)
        mean = mean_of(filmed, interval) if any(film.good.any() for film in filmed) else None
        chosen = width or ("side" if films else "feret_max")
        _write(folder, computed, filmed, mean, chosen, mask_pictures)
    if not quiet:
        _tell(folder, computed, filmed, chosen)


def _measured(
    films: Sequence[Path],
    results: Sequence[Result],
    azimuth: float,
    given: dict[str, Any],
    listener: Listener,
) -> list[FilmHistory]:
    from sheetmorph.measure.film import read_film
    from sheetmorph.measure.film_history import read_table
    from sheetmorph.measure.frames import open_film

    histories = []
    if films:
        options = film_options(results, azimuth, given)
        for path in films:
            if path.suffix.lower() == ".csv":
                histories.append(read_table(path))
            else:
                histories.append(read_film(open_film(path, given["rate"]), options, listener))
    names = _film_names(films)
    return [replace(film, name=name) for film, name in zip(histories, names, strict=True)]


def _write(
    folder: Path,
    computed: Sequence[RunHistory],
    filmed: Sequence[FilmHistory],
    mean: MeanHistory | None,
    width: Any,
    mask_pictures: bool,
) -> None:
    from sheetmorph.core.files import write_text
    from sheetmorph.show.film_frames import write_frames
    from sheetmorph.show.history import write_history
    from sheetmorph.study.history import mean_csv, runs_csv

    for old in _ours(folder):
        old.unlink()
    if computed:
        write_text(folder / RUNS, runs_csv(computed))
    for film in filmed:
        write_text(folder / "films" / f"{film.name}.csv", film.to_csv())
        if mask_pictures and film.shots:
            write_frames(film, folder / "films" / f"{film.name}.png")
    if mean is not None and len(filmed) > 1:
        write_text(folder / MEANS, mean_csv(mean))
    write_history(folder / PLOT, computed, filmed, mean, width)


def _ours(folder: Path) -> list[Path]:
    """What an earlier call wrote: its plot, and tables by their titles, with their pictures."""
    from sheetmorph.measure.film_history import is_table

    if not (folder / PLOT).is_file():
        return []
    tables = [path for path in (folder / "films").glob("*.csv") if is_table(path)]
    files = [folder / name for name in (PLOT, RUNS, MEANS)]
    files += [*tables, *(path.with_suffix(".png") for path in tables)]
    return [path for path in files if path.is_file()]


def _check_folder(folder: Path, films: Sequence[Path], force: bool) -> None:
    from sheetmorph.show.guard import check_folder

    for film in films:
        if film.is_dir() and film.resolve() == (folder / "films").resolve():
            raise InputError(
                "the pictures of this film lie where its table would be written; choose another "
                "folder with -o",
                file=film,
            )
    earlier = _ours(folder)
    names = [f"films/{name}{end}" for name in _film_names(films) for end in (".csv", ".png")]
    check_folder(
        folder, (PLOT, RUNS, MEANS, *names), "history", ours=earlier.__contains__, force=force
    )


def _film_names(films: Sequence[Path]) -> list[str]:
    return _unlike([path.resolve().name if path.is_dir() else path.stem for path in films])


def _tell(
    folder: Path, computed: Sequence[RunHistory], filmed: Sequence[FilmHistory], width: Any
) -> None:
    import math

    for film in filmed:
        for note in film.notes:
            click.echo(f"note: {film.name}: {note}", err=True)
    for run in computed:
        ratio = run.ratio(width)[-1]
        click.echo(f"{run.name}: h/d {ratio:.3f} ({width}) at eps_pre {run.actuation[-1]:g}")
    for film in filmed:
        good = film.good
        if not good.any():
            click.echo(f"{film.name}: no frame can be relied on")
            continue
        scale = film.metre_per_pixel
        size = f"h {film.height[good][-1]:.0f} px, d {film.width[good][-1]:.0f} px (no --reference)"
        if scale is not None:
            h, d = 1e3 * scale * film.height[good][-1], 1e3 * scale * film.width[good][-1]
            size = f"h {h:.1f} mm, d {d:.1f} mm"
        if not math.isfinite(film.width[good][-1]):
            size = "sizes not in the table"
        click.echo(
            f"{film.name}: h/d {film.ratio[good][-1]:.3f} at {film.time[good][-1]:g} s, {size}; "
            f"{good.sum()} of {len(good)} frames"
        )
    click.echo(f"history in {folder} (open history.png)")


def _run_name(run: Path, k: int) -> str:
    name = (run.parent if run.suffix == ".h5" else run).resolve().name
    return name or f"run {k + 1}"


def _unlike(names: Sequence[str]) -> list[str]:
    """The names with a number behind those that come again."""
    taken: list[str] = []
    for name in names:
        new, number = name, 2
        while new.lower() in {t.lower() for t in taken}:
            new, number = f"{name}-{number}", number + 1
        taken.append(new)
    return taken
