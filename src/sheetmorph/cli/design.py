"""The command `design`."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sheetmorph.cli.shared import (
    ProgressBar,
    by_their_options,
    notices_above,
    output_folder,
    read_length,
    read_values,
    set_values,
)
from sheetmorph.core.errors import InputError

if TYPE_CHECKING:
    from sheetmorph.inverse.result import Found
    from sheetmorph.inverse.targets import Target

# As in inverse.families, which --help must not import.
FAMILIES = ("star", "lotus", "ring", "cross", "canoe", "stripes", "free")
MOST_WORKERS = 8


@click.command()
@click.argument("target")
@click.option(
    "--family",
    "families",
    multiple=True,
    metavar="NAME",
    help=f"Of designs: {', '.join(FAMILIES)}. May be repeated; the best wins. [star]",
)
@output_folder("Folder. Default: designs/TARGET-FAMILY.", "designs/bowl")
@click.option("--unit", metavar="UNIT", help="Of a target file's lengths. Default: mm.")
@click.option("--size", metavar="LENGTH", help='Largest width of the target, such as "80 mm".')
@click.option("--sheet", metavar="LENGTH", help="Size of the sheet; the target is then scaled.")
@click.option(
    "--fix", "fixes", multiple=True, metavar="NAME=VALUE", help="Hold a parameter, as in arms=6."
)
@set_values
@click.option("--minimum-width", metavar="LENGTH", help="Of ribs and gaps. Default: 2 mm.")
@click.option("--connected", is_flag=True, help="The pattern must be of one piece.")
@click.option(
    "--most-inert", type=float, metavar="SHARE", help="Of the sheet, at most covered by it. [0.95]"
)
@click.option("--symmetry", type=int, metavar="N", help="N rotations must leave the pattern alike.")
@click.option("--budget", type=int, default=240, show_default=True, help="Designs per family.")
@click.option("--descents", type=int, default=2, show_default=True, help="Ways down at the end.")
@click.option(
    "--accuracy",
    type=float,
    default=0.2,
    show_default=True,
    metavar="PERCENT",
    help="Distance, in percent of the size, at which the search ends.",
)
@click.option("--steps", type=int, default=25, show_default=True, help="Of the field of free.")
@click.option("--seed", type=int, default=0, show_default=True, help="Of the search.")
@click.option("--workers", type=int, help=f"Processes. Default: the processors, ≤ {MOST_WORKERS}.")
@click.option("--scheduler", metavar="ADDRESS", help="A Dask scheduler in place of processes.")
@click.option("--resume", is_flag=True, help="Go on with a search that was cut off in the folder.")
@click.option("--force", is_flag=True, help="Replace the search that is in the folder.")
@click.option("--no-pictures", is_flag=True, help="Draw nothing.")
@click.option("--no-fabricate", is_flag=True, help="Do not write the files to make it.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
@click.option("--json", "as_json", is_flag=True, help="Print inverse.json, nothing else.")
def design(
    target: str,
    families: tuple[str, ...],
    output: Path | None,
    unit: str | None,
    size: str | None,
    sheet: str | None,
    fixes: tuple[str, ...],
    overrides: tuple[str, ...],
    minimum_width: str | None,
    connected: bool,
    most_inert: float | None,
    symmetry: int | None,
    budget: int,
    descents: int,
    accuracy: float,
    steps: int,
    seed: int,
    workers: int | None,
    scheduler: str | None,
    resume: bool,
    force: bool,
    no_pictures: bool,
    no_fabricate: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Find a pattern and an actuation whose shape is TARGET.

    TARGET is a surface in an STL, OBJ or PLY file, the folder of a run, or a name with numbers:
    bowl:H, dome:H, cone:H, saddle:H, cylinder:H with H = height over width; canoe:L:H with
    L = length over width; letter:X:H, a tray whose rim is a letter. The folder receives
    design.toml, which the other commands read, its result.h5 and shape.stl, inverse.json,
    pictures, inverse.html, and fabricate/. best.png is redrawn while the search goes on.

    \b
    Examples:
      sheetmorph design bowl:0.4 --family star
      sheetmorph design target.stl --family star --family lotus --unit mm -o mine
      sheetmorph design saddle:0.4 --family ring --size "80 mm" --minimum-width "3 mm"
      sheetmorph design canoe:2.0 --family canoe --fix half_width=0.05
      sheetmorph design scan.stl --family free --minimum-width "3 mm"
      sheetmorph design bowl:0.4 --family star --resume
    """
    from sheetmorph.inverse.find import SearchOptions
    from sheetmorph.inverse.limits import Limits
    from sheetmorph.show.inverse import DATA, check_folder, design_into

    if scheduler is not None and workers is not None:
        raise InputError("--workers and --scheduler exclude each other")
    wanted = _target(target, unit, size)
    chosen = families or ("star",)
    with by_their_options(_OPTIONS):
        given = {
            "minimum_width": read_length(minimum_width, "--minimum-width"),
            "most_inert": most_inert,
            "symmetry": symmetry,
        }
        options = SearchOptions(
            families=tuple(dict.fromkeys(chosen)),
            limits=Limits(
                connected=connected,
                **{key: value for key, value in given.items() if value is not None},  # type: ignore[arg-type]
            ),
            budget=budget,
            descents=descents,
            accuracy=0.01 * accuracy,
            steps=steps,
            sheet=read_length(sheet, "--sheet"),
            fixed=_fixed(fixes),
            overrides=read_values(overrides),
            seed=seed,
        )
    name = f"{wanted.name}-{'-'.join(options.families)}"
    folder = output or Path("designs") / name
    check_folder(folder, resume=resume, force=force)
    silent = quiet or as_json
    with ProgressBar(silent) as listener:
        try:
            found, written = design_into(
                folder,
                wanted,
                options,
                resume=resume,
                force=force,
                processes=_processes(workers, scheduler),
                scheduler=scheduler,
                pictures=not no_pictures,
                on_event=listener if silent else notices_above(listener),
            )
        except KeyboardInterrupt:
            raise click.exceptions.Abort("interrupted; add --resume to go on") from None
    notes = [*found.notes, *written.notes]
    if not no_fabricate:
        notes += _fabricate(found, folder / "fabricate", resume or force)
    if as_json:
        click.echo((folder / DATA).read_text(encoding="utf-8").rstrip())
    elif not quiet:
        _tell(found, folder, notes)


def _target(text: str, unit: str | None, size: str | None) -> Target:
    from sheetmorph.cli.surfaces import is_run, read_shape
    from sheetmorph.compare.scan import Scan
    from sheetmorph.core.units import scale_of
    from sheetmorph.inverse.targets import read_target, target_of

    width = read_length(size, "--size")
    if width is not None and not 1e-3 <= width <= 3.0:
        raise InputError("is out of range", key="--size", value=size, allowed="1 mm to 3 m")
    path = Path(text)
    if path.exists() and is_run(path):
        if unit is not None:
            raise InputError("a run is in metres", key="--unit", value=unit)
        shape = read_shape(path)
        return target_of(Scan(shape.surface, shape.name, shape.notes, 1.0), text, width)
    scale = None
    if unit is not None:
        try:
            scale = scale_of(unit.strip(), "length")
        except InputError as error:
            raise InputError(
                error.message, key="--unit", value=unit, allowed="mm, cm, m, in, ft, …"
            ) from None
    return read_target(text, unit=scale, size=width)


def _fixed(texts: tuple[str, ...]) -> dict[str, float]:
    values = {}
    for text in texts:
        key, equals, value = text.partition("=")
        try:
            values[key.strip()] = float(value)
        except ValueError:
            equals = ""
        if not equals:
            raise InputError("--fix wants NAME=NUMBER, such as arms=6", value=text)
    return values


def _processes(workers: int | None, scheduler: str | None) -> int:
    if scheduler is not None:
        return 1
    if workers is None:
        from sheetmorph.sweep.cluster import usual_workers

        there = find_spec("distributed") is not None  # of the extra; one process needs none
        return min(usual_workers(), MOST_WORKERS) if there else 1
    if not 1 <= workers <= 1024:
        raise InputError(
            "must be a whole number", key="--workers", value=workers, allowed="1 to 1024"
        )
    return workers


def _fabricate(found: Found, folder: Path, replace: bool) -> list[str]:
    """Write the files to make the design; what stands in the way of it as notes."""
    from sheetmorph.cli.fabricate import prediction_of
    from sheetmorph.fabricate.package import MANIFEST, fabricate_design

    try:
        package = fabricate_design(
            found.design,
            folder,
            prediction=prediction_of(found.result),
            force=replace and (folder / MANIFEST).is_file(),
        )
    except InputError as error:
        return [f"nothing to fabricate: {error}"]
    return list(package.warnings)


def _tell(found: Found, folder: Path, notes: list[str]) -> None:
    """The design in a few lines."""
    from sheetmorph.show.inverse import told

    for note in notes:
        click.echo(f"note: {note}", err=True)
    values = ", ".join(f"{key} {value:.4g}" for key, value in found.values.items())
    data = found.to_json()
    limits = [] if found.made is None else [f"limit missed: {one}" for one in found.made.broken]
    lines = [
        f"{found.target.text}: {told(found)}",
        f"  {found.family}: {values}",
        f"  h/d {data['found']['aspect_ratio']:.3f}, wanted {data['wanted']['aspect_ratio']:.3f}",
        *(f"  {one}" for one in limits),
        *(f"  {name}: {told(one)} (in {name}/)" for name, one in found.others.items()),
        f"  {found.evaluations} designs ({found.failed} failed), {found.seconds:.0f} s",
        f"design in {str(folder).rstrip('/')}/ (inverse.html, design.toml)",
    ]
    click.echo("\n".join(lines))


_OPTIONS = {
    "minimum_width": "--minimum-width",
    "most_inert": "--most-inert",
    "symmetry": "--symmetry",
    "budget": "--budget",
    "descents": "--descents",
    "accuracy": "--accuracy",
    "steps": "--steps",
    "seed": "--seed",
    "sheet": "--sheet",
}
"""Fields of the options, as they are called on the command line."""
