"""The command `compare`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

from sheetmorph.cli.shared import at_work, by_their_options, output_folder
from sheetmorph.core.errors import InputError

if TYPE_CHECKING:
    from sheetmorph.compare.comparison import CompareOptions, Comparison
    from sheetmorph.core.events import Listener

STARTED = perf_counter()
DRAWN_FROM = 0.75  # where on the progress bar the pictures begin
# As in compare.faces, which --help must not import.
FACES = ("auto", "outer", "inner", "both")
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?"


@click.command()
@click.argument("result", type=click.Path(path_type=Path))
@click.argument("scan", type=click.Path(path_type=Path))
@output_folder("Folder for the comparison. Default: SCAN-comparison.", "petals-scan")
@click.option("--unit", metavar="UNIT", help="Unit of SCAN, such as mm; else its size is fitted.")
@click.option("--scale", metavar="NUMBER", help="Length of one unit of SCAN in metres.")
@click.option(
    "--known-length",
    metavar="LENGTH=LENGTH",
    help='A length in SCAN and what it is in truth, such as "523.1=100 mm".',
)
@click.option(
    "--face",
    type=click.Choice(FACES),
    default=FACES[0],
    show_default=True,
    help="Which face of a scan that has the thickness of the sheet.",
)
@click.option("--mirror", is_flag=True, help="Let SCAN be mirrored where it fits better so.")
@click.option("--crop", metavar="BOX", help='Keep what lies in "x0,x1,y0,y1,z0,z1" (unit of SCAN).')
@click.option("--no-crop", is_flag=True, help="Keep the floor and loose pieces of SCAN.")
@click.option("--grid", type=int, default=64, show_default=True, help="Grid points of SSIM.")
@click.option("--window", type=int, default=10, show_default=True, help="Window of SSIM.")
@click.option(
    "--state", metavar="STATE", help="State of RESULT: a number, or an actuation such as -0.3."
)
@click.option("--shape-unit", metavar="UNIT", help="Unit of RESULT when it is a mesh. Default: m.")
@click.option("--no-pictures", is_flag=True, help="Write numbers only.")
@click.option("--force", is_flag=True, help="Replace the comparison that is in the folder.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
@click.option("--json", "as_json", is_flag=True, help="Print comparison.json, nothing else.")
def compare(
    result: Path,
    scan: Path,
    output: Path | None,
    unit: str | None,
    scale: str | None,
    known_length: str | None,
    face: str,
    mirror: bool,
    crop: str | None,
    no_crop: bool,
    grid: int,
    window: int,
    state: str | None,
    shape_unit: str | None,
    no_pictures: bool,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Compare RESULT, a computed shape, with SCAN, a measured one.

    RESULT is the folder of a run or the file of a mesh (STL, OBJ, PLY, VTU); SCAN is such a file,
    or another run. SCAN is moved, turned and scaled until it fits. The folder receives
    comparison.json, comparison.html, pictures, and the scan in the frame of RESULT as STL.

    \b
    Examples:
      sheetmorph compare results/petals scan.stl
      sheetmorph compare results/petals scan.ply --unit mm -o petals-scan
      sheetmorph compare results/petals scan.obj --known-length "523.1=100 mm"
      sheetmorph compare results/coarse results/fine
    """
    from sheetmorph.cli.surfaces import is_run, read_scan, read_shape
    from sheetmorph.show.comparison import check_folder

    length = _length_of_unit(unit, scale, known_length)
    if length is not None and is_run(scan):
        raise InputError("a run is in metres; leave out --unit, --scale, --known-length", file=scan)
    shape_length = _unit_of(shape_unit, "--shape-unit") if shape_unit is not None else 1.0
    if shape_unit is not None and is_run(result):
        raise InputError("a run is in metres; leave out --shape-unit", file=result)
    box = _box(crop) if crop is not None else None
    with by_their_options(_OPTIONS):
        options = _options(length, face, mirror, box, no_crop or is_run(scan), grid, window)
    folder = output or Path(f"{scan.stem or scan.resolve().name}-comparison")
    for path in (result, scan):
        if not path.exists():
            raise InputError("there is no such file or folder", file=path)

    def check() -> None:
        check_folder(folder, force, [path for path in (result, scan) if path.is_file()])

    working = at_work(folder, quiet or as_json, check)
    with working as listener, _renderer(not no_pictures) as worker:
        from sheetmorph.core.events import Progress, Started

        listener(Started(f"{result.name} and {scan.name}"))
        listener(Progress(0.0, "reading"))
        with by_their_options(_OPTIONS):
            shape = read_shape(result, unit=shape_length, state=state)
            measured = read_scan(scan)

            from sheetmorph.compare.comparison import compare_surfaces

            comparison = compare_surfaces(
                shape.surface,
                measured,
                flat=shape.flat,
                options=options,
                on_event=_as_part(listener),
            )
        from sheetmorph.show.comparison import write_comparison
        from sheetmorph.show.comparison_views import Names

        listener(Progress(DRAWN_FROM, "drawing"))
        names = Names(shape.name, measured.name)
        written = write_comparison(
            comparison,
            folder,
            names,
            worker,
            pictures=not no_pictures,
            force=force,
            more={"result": str(result), "scan": str(scan)},
        )
        listener(Progress(1.0, "done"))
    if as_json:
        click.echo((folder / "comparison.json").read_text(encoding="utf-8").rstrip())
    elif not quiet:
        for note in (*shape.notes, *comparison.notes, *written.notes):
            click.echo(f"note: {note}", err=True)
        click.echo(_summary(comparison, names.shape, names.scan))
        click.echo(f"comparison in {str(folder).rstrip('/')}/ (open comparison.html)")


def _as_part(listener: Listener) -> Listener:
    """A listener to the comparison, which is not all of the work: the pictures follow."""
    from sheetmorph.core.events import Event, Progress

    def listen(event: Event) -> None:
        if isinstance(event, Progress):
            listener(Progress(DRAWN_FROM * event.fraction, event.text))

    return listen


def _summary(comparison: Comparison, shape: str, scan: str) -> str:
    """The comparison in a few lines."""
    from sheetmorph.show.comparison_numbers import baselines_of, length_of_unit, millimetres

    data = comparison.to_json()
    found, alignment = comparison.similarity, comparison.alignment
    beside = ", ".join(
        f"{name.replace('_', ' ')} {value:.2f}" for name, value in baselines_of(data).items()
    )
    ways = (comparison.scan_to_shape, comparison.shape_to_scan)

    def both(name: str) -> str:
        there, back = (getattr(way, name) for way in ways)
        return f"{millimetres(there)} scan to shape, {millimetres(back)} shape to scan"

    ratio = comparison.aspect_ratio
    poses = len(alignment.equivalent_poses) + 1
    return (
        f"{shape} and {scan}\n"
        f"  SSIM       {found.value:.3f} (grid {found.grid}, window {found.window})"
        f"{f'; {beside}' if beside else ''}\n"
        f"  RMS        {both('rms')}\n"
        f"  farthest   {both('maximum')}\n"
        f"  h/d        {ratio.scan:.3f} scan, {ratio.shape:.3f} shape\n"
        f"  pose       confidence {alignment.confidence:.2f}, "
        f"1 unit of the scan is {length_of_unit(data)}"
        f"{f', {poses} poses fit alike' if poses > 1 else ''}\n"
        f"  everything {perf_counter() - STARTED:.1f} s"
    )


@contextmanager
def _renderer(wanted: bool) -> Iterator[Any]:
    """The process that draws, started at once: it loads while the shapes are compared."""
    from sheetmorph.show.render import RenderWorker

    with RenderWorker.start() if wanted else nullcontext() as worker:
        yield worker


def _options(
    scale: float | None,
    face: Any,
    mirror: bool,
    box: Any,
    no_crop: bool,
    grid: int,
    window: int,
) -> CompareOptions:
    from sheetmorph.compare.comparison import CompareOptions
    from sheetmorph.compare.crop import CropOptions

    crop = CropOptions("none", box, "all") if no_crop else CropOptions(box=box)
    return CompareOptions(
        scale=scale, face=face, mirror=mirror, crop=crop, grid=grid, window=window
    )


def _length_of_unit(unit: str | None, scale: str | None, known: str | None) -> float | None:
    """Length of one unit of the scan [m]; None where nothing is said about it."""
    if sum(option is not None for option in (unit, scale, known)) > 1:
        raise InputError("--unit, --scale and --known-length exclude each other; keep one of them")
    if unit is not None:
        return _unit_of(unit, "--unit")
    if scale is not None:
        return _positive(scale, "--scale", "a positive number of metres, as in 0.001")
    if known is None:
        return None
    measured, equals, true = known.partition("=")
    allowed = 'a number and a length, as in "523.1=100 mm"'
    if not equals:
        raise InputError("wants LENGTH=LENGTH", key="--known-length", value=known, allowed=allowed)
    from sheetmorph.core.units import to_si

    try:
        length = to_si(true.strip(), "length")
    except InputError as error:
        raise InputError(
            error.message, key="--known-length", value=known, allowed=allowed
        ) from None
    ratio = length / _positive(measured, "--known-length", allowed)
    return _positive(repr(ratio), "--known-length", allowed)


def _unit_of(text: str, option: str) -> float:
    from sheetmorph.core.units import scale_of

    try:
        return scale_of(text.strip(), "length")
    except InputError as error:
        raise InputError(
            error.message, key=option, value=text, allowed="mm, cm, m, in, ft, …"
        ) from None


def _positive(text: str, option: str, allowed: str) -> float:
    value = float(text) if re.fullmatch(_NUMBER, text.strip()) else 0.0
    if not 1e-12 <= value <= 1e12:
        raise InputError("is out of range", key=option, value=text, allowed=allowed)
    return value


def _box(text: str) -> tuple[float, ...]:
    parts = text.replace(",", " ").split()
    if len(parts) != 6 or not all(re.fullmatch(_NUMBER, part) for part in parts):
        raise InputError("wants six numbers", key="--crop", value=text, allowed='"0,1,0,1,-1,2"')
    return tuple(float(part) for part in parts)


_OPTIONS = {"box": "--crop", "face": "--face", "grid": "--grid", "window": "--window"}
"""Fields of the options of a comparison, as they are called on the command line."""
