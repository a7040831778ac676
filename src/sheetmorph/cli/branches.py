"""The command `branches`."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sheetmorph.cli.shared import (
    at_work,
    design_file,
    load_design,
    naming,
    output_folder,
    set_values,
)

if TYPE_CHECKING:
    from sheetmorph.branches.result import Branches


@click.command()
@design_file
@output_folder("Folder. Default: results/NAME-branches.", "results/bowl-branches")
@set_values
@click.option(
    "--modes",
    type=click.IntRange(0, 12),
    default=3,
    show_default=True,
    help="Modes kicked at each bifurcation, and from the final shape.",
)
@click.option("--no-sectors", is_flag=True, help="Do not invert sectors of symmetric designs.")
@click.option(
    "--random",
    type=click.IntRange(0, 1000),
    default=4,
    show_default=True,
    help="Random loads that are tried.",
)
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of the first.")
@click.option(
    "--barriers",
    type=click.IntRange(0, 50),
    default=0,
    show_default=True,
    metavar="N",
    help="Barriers from the lowest shape to the next N stable ones, other positions included.",
)
@click.option("--force", is_flag=True, help="Replace the branches that are in the folder.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
@click.option("--json", "as_json", is_flag=True, help="Print branches.json, nothing else.")
def branches(
    file: Path,
    output: Path | None,
    overrides: tuple[str, ...],
    modes: int,
    no_sectors: bool,
    random: int,
    seed: int,
    barriers: int,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Find the shapes into which the design FILE can morph, or be snapped.

    The run of the design is one of them. Others are sought from the opposite perturbation, from
    kicks along the modes that lose their stability, from random loads, and by turning shapes
    over. The folder receives branches.json, branches.h5 (the states) and branches.png.

    \b
    Examples:
      sheetmorph branches bowl.toml
      sheetmorph branches bowl.toml --barriers 1
      sheetmorph branches bowl.toml --random 20 --seed 100 -o bowl-shapes
    """
    design = load_design(file, overrides)
    folder = output or Path("results") / f"{file.stem}-branches"
    from sheetmorph.show.branches import check_folder

    def check() -> None:
        check_folder(folder, force, [file])

    with at_work(folder, quiet or as_json, check) as listener, naming(file):
        from sheetmorph.branches.barriers import with_barriers
        from sheetmorph.branches.search import SearchOptions, find_branches
        from sheetmorph.core.events import Progress, Started
        from sheetmorph.show.branches import write_branches

        listener(Started(design.name))
        options = SearchOptions(modes, not no_sectors, random, seed)
        found = find_branches(design, options, on_event=listener)
        if barriers:
            listener(Progress(0.92, "barriers"))
            found = with_barriers(found, barriers)
        listener(Progress(0.95, "drawing"))
        written = write_branches(found, folder)
    if as_json:
        click.echo(json.dumps(found.to_json(), indent=2, ensure_ascii=False))
    elif not quiet:
        for note in (*design.notes, *written.notes):
            click.echo(f"note: {note}", err=True)
        _tell(found, folder)


def _tell(found: Branches, folder: Path) -> None:
    """The shapes in a line each."""
    from sheetmorph.show.branches import joules

    for ramp, before, beyond in found.bifurcations:
        click.echo(
            f"bifurcation at eps_pre {ramp * found.result.design.eps_pre:.4g} "
            f"({100 * ramp:.3g} %): {before} to {beyond} negative eigenvalues"
        )
    if found.followed < 1.0:
        click.echo(f"the path without perturbation was followed to {100 * found.followed:.3g} %")
    lowest = found.branches[0].energy
    for one in found.to_json()["branches"]:
        kind = "stable" if one["stable"] else f"unstable ({one['negative_eigenvalues']})"
        images = len(one["images"])
        positions = f", in {images} positions" if images > 1 else ""
        click.echo(
            f"{one['number']:3d}  {kind:12s}  {joules(one['energy_J'] - lowest):>10s} above the "
            f"lowest  h/d {one['aspect_ratio']:.3f}  {_seeds(one['seeds'])}{positions}"
            f"{_guarded(one['places_held_by_guards'])}"
        )
    for barrier in found.barriers:
        other = f"{barrier.second}{f' ({barrier.image})' if barrier.image else ''}"
        kind = "a saddle" if barrier.converged else "at most: the string did not settle"
        between = "" if barrier.connects or not barrier.converged else ", by way of other shapes"
        click.echo(
            f"from {barrier.first} to {other}: barrier {joules(barrier.height)}, "
            f"{joules(barrier.back)} back ({kind}{between})"
        )
    lost = Counter(one.status.replace("_", " ") for one in found.attempts if one.branch is None)
    if lost:
        told = ", ".join(f"{status} ({count})" for status, count in lost.most_common())
        click.echo(f"{lost.total()} of {len(found.attempts)} seeds are left out: {told}")
    click.echo(f"branches in {folder} (open branches.png)")


def _seeds(names: list[str]) -> str:
    return "1 seed" if len(names) == 1 else f"{len(names)} seeds"


def _guarded(places: int) -> str:
    place = "a place" if places == 1 else f"{places} places"
    return f", leans on a guard in {place}" if places else ""
