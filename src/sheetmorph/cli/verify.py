"""The command `verify`."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

from sheetmorph.cli.shared import at_work, load_design, naming, output_folder, set_values
from sheetmorph.core.errors import InputError

if TYPE_CHECKING:
    from sheetmorph.core.events import Listener
    from sheetmorph.design.spec import Design
    from sheetmorph.twin.agreement import Agreement

STARTED = perf_counter()
PROGRAMS = ("calculix", "abaqus")
SOLVED, COMPARED = 0.85, 0.93
"""How far the bar is when the twin is solved, and when it is compared."""


@click.command()
@click.argument("file", type=click.Path(path_type=Path), required=False, metavar="[DESIGN]")
@click.option(
    "--fe",
    "program",
    type=click.Choice(PROGRAMS),
    help="Program for the twin: calculix is run if it is installed, abaqus gets its deck.",
)
@output_folder("Folder. Default: NAME-twin, or proofs without a DESIGN.", "strip-twin")
@set_values
@click.option(
    "--law",
    type=click.Choice(("natural", "expansion")),
    default="natural",
    show_default=True,
    help="CalculiX: the exact natural state of each layer, or its *EXPANSION.",
)
@click.option(
    "--steps",
    type=click.IntRange(1, 1000),
    default=20,
    show_default=True,
    help="CalculiX: equal steps of the actuation.",
)
@click.option(
    "--time-limit",
    metavar="TIME",
    default="1 h",
    show_default=True,
    help="CalculiX: stop after this time and compare what was reached.",
)
@click.option(
    "--threads", type=click.IntRange(1, 64), default=1, show_default=True, help="CalculiX."
)
@click.option("--deck-only", is_flag=True, help="CalculiX: write the deck and do not run it.")
@click.option("--no-pictures", is_flag=True, help="Write numbers only.")
@click.option("--only", multiple=True, metavar="PROOF", help="This proof alone. May be repeated.")
@click.option("--reference", metavar="DIR", help="Folder with the published tables of the proofs.")
@click.option("--force", is_flag=True, help="Replace what is in the folder.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
@click.option("--json", "as_json", is_flag=True, help="Print comparison.json, nothing else.")
def verify(
    file: Path | None,
    program: str | None,
    output: Path | None,
    overrides: tuple[str, ...],
    law: Any,
    steps: int,
    time_limit: str,
    threads: int,
    deck_only: bool,
    no_pictures: bool,
    only: tuple[str, ...],
    reference: str | None,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Compute DESIGN a second time with a finite-element program, and compare.

    Without a DESIGN, remake the proofs of the laminate model: cases whose answer is known,
    each number with its limit, as proofs.md with plots and proofs.json.

    With CalculiX (ccx) the folder receives the deck and the results in calculix/, and the
    comparison as that of a scan: comparison.json, comparison.html, pictures and the twin as
    STL. With Abaqus it receives the deck, checked as far as that goes without Abaqus.

    \b
    Examples:
      sheetmorph verify strip.toml --fe calculix -o strip-twin
      sheetmorph verify petals.toml --fe calculix --set actuation.eps_pre=-0.2 --time-limit "10 min"
      sheetmorph verify petals.toml --fe abaqus -o petals-abaqus
      sheetmorph verify -o proofs
      sheetmorph verify --only timoshenko --force
    """
    if file is None and program is not None:
        raise InputError("name the file of a design", key="DESIGN")
    if file is None:
        from sheetmorph.cli.proofs import remake_proofs

        remake_proofs(output, only, reference, force, quiet)
        return
    if only or reference is not None:
        raise InputError("--only and --reference go with the proofs, without a DESIGN")
    if program is None:
        raise InputError(
            "say which program computes the twin", key="--fe", allowed=" or ".join(PROGRAMS)
        )
    design = load_design(file, overrides)
    folder = output or Path(f"{file.stem}-twin")
    with naming(file):
        if program == "abaqus":
            _abaqus(design, folder, force, quiet)
        elif deck_only:
            _deck_only(design, folder, law, steps, force, quiet)
        else:
            limit = _seconds(time_limit)
            pictures = not no_pictures
            _calculix(design, folder, law, steps, limit, threads, pictures, force, quiet, as_json)


def _calculix(
    design: Design,
    folder: Path,
    law: Any,
    steps: int,
    limit: float,
    threads: int,
    pictures: bool,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    from sheetmorph.show.comparison import check_folder
    from sheetmorph.twin.calculix import DeckOptions
    from sheetmorph.twin.ccx import find_program
    from sheetmorph.twin.solve import TwinOptions

    find_program()
    options = TwinOptions(DeckOptions(law, steps), limit, threads)
    working = at_work(folder, quiet or as_json, lambda: check_folder(folder, force))
    with working as listener, _renderer(pictures) as worker:
        from sheetmorph.core.events import Progress
        from sheetmorph.twin.agreement import agree
        from sheetmorph.twin.solve import solve_twin

        try:
            twin = solve_twin(design, folder / "calculix", options, _part(listener, 0.0, SOLVED))
        except KeyboardInterrupt:
            raise click.exceptions.Abort(
                f"interrupted; what CalculiX reached is in {folder / 'calculix'}"
            ) from None
        agreement = agree(design, twin, _part(listener, SOLVED, SOLVED))
        comparison = _compared(agreement, _part(listener, SOLVED, COMPARED))
        from sheetmorph.show.comparison import write_comparison
        from sheetmorph.show.comparison_views import Names

        listener(Progress(COMPARED, "drawing"))
        written = write_comparison(
            comparison,
            folder,
            Names(design.name, "its finite-element twin"),
            worker,
            pictures=pictures,
            force=force,
            more={"twin": agreement.to_json()},
        )
        listener(Progress(1.0, "done"))
    if as_json:
        click.echo((folder / "comparison.json").read_text(encoding="utf-8").rstrip())
    elif not quiet:
        for note in written.notes:
            click.echo(f"note: {note}", err=True)
        data = json.loads((folder / "comparison.json").read_text(encoding="utf-8"))
        click.echo(_summary(design, data))
        click.echo(f"comparison in {str(folder).rstrip('/')}/ (open comparison.html)")


def _compared(agreement: Agreement, listener: Listener) -> Any:
    """The twin laid over the computed shape and measured as a scan of known size."""
    from sheetmorph.compare.comparison import CompareOptions, compare_surfaces
    from sheetmorph.compare.crop import CropOptions
    from sheetmorph.compare.surface import Surface

    triangles = agreement.twin.mesh.triangles.astype("int64")
    return compare_surfaces(
        Surface(agreement.own, triangles),
        Surface(agreement.positions, triangles),
        flat=Surface(agreement.twin.mesh.nodes, triangles),
        options=CompareOptions(scale=1.0, crop=CropOptions("none", None, "all")),
        on_event=listener,
    )


def _deck_only(
    design: Design, folder: Path, law: Any, steps: int, force: bool, quiet: bool
) -> None:
    from sheetmorph.twin.calculix import DeckOptions
    from sheetmorph.twin.solve import JOB, write_twin

    place = folder / "calculix"
    _check_file(place / f"{JOB}.inp", force)
    _, solid, deck = write_twin(design, place, DeckOptions(law, steps))
    if not quiet:
        click.echo(
            f"{place / JOB}.inp: {len(solid.nodes)} nodes, {len(solid.wedges)} wedges, "
            f"{len(deck.ramp)} steps; run it with: ccx {JOB}"
        )


def _abaqus(design: Design, folder: Path, force: bool, quiet: bool) -> None:
    from sheetmorph.core.errors import ComputationError
    from sheetmorph.core.files import write_text
    from sheetmorph.twin.abaqus import abaqus_deck
    from sheetmorph.twin.keywords import check_deck
    from sheetmorph.twin.sheet import Sheet

    place = folder / "abaqus" / "twin.inp"
    _check_file(place, force)
    lines = list(abaqus_deck(Sheet.of(design)))
    text = "".join(lines)
    faults = check_deck(text.splitlines())
    if faults:
        raise ComputationError(f"the deck breaks the grammar of Abaqus: {faults[0]}")
    write_text(place, text)
    if not quiet:
        click.echo(
            f"{place}: {len(text.splitlines())} lines, keywords and references checked; "
            "run it with: abaqus job=twin double"
        )


def _check_file(file: Path, force: bool) -> None:
    if file.exists() and not force:
        raise InputError(
            "this folder holds a twin; add --force to replace it, or choose another with -o",
            file=file,
        )


def _summary(design: Design, data: dict[str, Any]) -> str:
    """The twin in a few lines."""
    twin = data["twin"]
    fe, strains, ratio = twin["twin"], twin["eps_pre"], twin["aspect_ratio"]
    seconds, used, rms = twin["seconds"], twin["processor_seconds"], data["rms_mm"]
    how = {
        "completed": "followed to the end",
        "time_limit": "stopped by the time limit",
        "stopped": f"gave up: {fe['message'] or 'see calculix/twin.log'}; try more --steps",
    }[fe["ended"]]
    times = seconds["twin"] / seconds["shape"]
    return (
        f"{design.name} ({twin['model']} model) and {fe['solver']} ({fe['law']} law), {how}\n"
        f"  eps_pre    {strains['twin']:.4g} of {strains['asked']:.4g}\n"
        f"  SSIM       {data['ssim']:.4f} (grid {data['grid']}, window {data['window']})\n"
        f"  RMS        {rms['scan_to_shape']:.3g} mm between the surfaces, "
        f"{twin['node_rms_mm']:.3g} mm between the nodes, of {twin['size_mm']:.1f} mm\n"
        f"  h/d        {ratio['shape']:.4f} shape, {ratio['twin']:.4f} twin\n"
        f"  time       {seconds['shape']:.2f} s shape, {seconds['twin']:.1f} s twin "
        f"({times:.0f} times)\n"
        f"  processor  {used['shape']:.2f} s shape, meshing and all, {used['twin']:.1f} s twin\n"
        f"  everything {perf_counter() - STARTED:.1f} s"
    )


def _part(listener: Listener, start: float, stop: float) -> Listener:
    """A listener to a part of the work."""
    from sheetmorph.core.events import Event, Progress

    def listen(event: Event) -> None:
        if isinstance(event, Progress):
            listener(Progress(start + (stop - start) * event.fraction, event.text))
        else:
            listener(event)

    return listen


@contextmanager
def _renderer(wanted: bool) -> Iterator[Any]:
    """The process that draws, started at once: it loads while the twin is solved."""
    from sheetmorph.show.render import RenderWorker

    with RenderWorker.start() if wanted else nullcontext() as worker:
        yield worker


def _seconds(text: str) -> float:
    from sheetmorph.core.units import to_si

    try:
        limit = to_si(text.strip(), "time")
    except InputError as error:
        raise InputError(
            error.message, key="--time-limit", value=text, allowed='a time, as in "10 min"'
        ) from None
    if not limit > 0.0:
        raise InputError(
            "must be positive", key="--time-limit", value=text, allowed='a time, as in "10 min"'
        )
    return limit
