"""The command line. Commands import what they need when they run, so that --help is fast."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

from sheetmorph import __version__
from sheetmorph.core.errors import InputError, SheetmorphError

if TYPE_CHECKING:
    from sheetmorph.core.events import Event, Listener
    from sheetmorph.design.spec import Design

STARTED = perf_counter()
# As in design.presets, which --help must not import.
PRESETS = ("bowl", "canoe", "petals", "kirigami", "blank")


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, "-V", "--version", prog_name="sheetmorph")
def cli() -> None:
    """Predict the 3D shape into which a flat, patterned, layered sheet morphs.

    \b
    Start here:
      sheetmorph new bowl --preset bowl     write bowl.toml, a commented design
      sheetmorph check bowl.toml            see what would be computed
      sheetmorph run bowl.toml -o bowl      compute it, with pictures and a report
    """


@cli.command()
@click.argument("name")
@click.option(
    "--preset", type=click.Choice(PRESETS), default="blank", show_default=True, help="Start from."
)
@click.option(
    "--drawing",
    type=click.Path(path_type=Path),
    help="Start from a drawing instead: .dxf, .svg, .stl or .3mf.",
)
@click.option("--sheet", metavar="LAYER", help="Its layer, id or colour of the sheet [SHEET].")
@click.option("--pattern", metavar="LAYER", help="That of the pattern [PATTERN].")
@click.option("--slits", metavar="LAYER", help="That of the slits [SLITS, if there is one].")
@click.option("--force", is_flag=True, help="Replace a file that is already there.")
def new(
    name: str,
    preset: str,
    drawing: Path | None,
    sheet: str | None,
    pattern: str | None,
    slits: str | None,
    force: bool,
) -> None:
    """Write NAME.toml, a commented design file to start from.

    \b
    Examples:
      sheetmorph new my_bowl --preset bowl
      sheetmorph new leaf --drawing leaf.svg
    """
    from sheetmorph.core.files import write_text
    from sheetmorph.design.presets import preset_text

    if drawing is None and (sheet or pattern or slits):
        raise InputError("--sheet, --pattern and --slits go with --drawing")
    if not Path(name).name or name.endswith(("/", "\\")):
        raise InputError("give a name for the design, such as my_bowl", value=name)
    path = Path(name if name.endswith(".toml") else f"{name}.toml")
    if path.exists() and not force:
        raise InputError("this file exists; choose another name or add --force", file=path)
    if drawing is None:
        text = preset_text(preset, path.stem)
    else:
        from sheetmorph.design.from_drawing import design_text

        if drawing.resolve().parent != path.resolve().parent:
            raise InputError(
                "a design and its drawing lie in one folder; copy the drawing there",
                file=drawing,
                allowed=str(path.resolve().parent / drawing.name),
            )
        text = design_text(drawing, path.stem, sheet, pattern, slits)
    write_text(path, text)
    click.echo(f"wrote {path}; next: sheetmorph run {path}")


_design_file = click.argument("file", type=click.Path(path_type=Path))
_set = click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="KEY=VALUE",
    help="Override a key of the design, such as actuation.eps_pre=-0.3. May be repeated.",
)


@cli.command()
@_design_file
@_set
@click.option("--json", "as_json", is_flag=True, help="Print the numbers as JSON.")
def check(file: Path, overrides: tuple[str, ...], as_json: bool) -> None:
    """Validate the design FILE and print what would be computed. Writes nothing.

    \b
    Example:
      sheetmorph check bowl.toml --set mesh.size="2 mm"
    """
    from sheetmorph.design.check import describe, format_description

    with _naming(file):
        description = describe(_load_design(file, overrides))
    click.echo(json.dumps(description, indent=2) if as_json else format_description(description))


@cli.command()
@_design_file
@click.option(
    "-o",
    "--output",
    metavar="DIR",
    help="Folder for the results. Default: results/NAME.",
)
@_set
@click.option("--resume", is_flag=True, help="Go on with a run that was cut off in this folder.")
@click.option("--force", is_flag=True, help="Replace the results that are in the folder.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON, nothing else.")
def run(
    file: Path,
    output: str | None,
    overrides: tuple[str, ...],
    resume: bool,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Compute the shape of the design FILE and write a folder of results.

    The folder receives result.h5 (every state), summary.json, shape.stl, a series for
    ParaView, pictures, an animation and report.html.

    \b
    Examples:
      sheetmorph run bowl.toml -o results/bowl
      sheetmorph run bowl.toml --set actuation.eps_pre=-0.3 --set mesh.size="2 mm"
      sheetmorph run bowl.toml -o results/bowl --resume
    """
    design = _load_design(file, overrides)
    if output is not None and not output.strip():
        raise InputError("-o wants a folder, such as results/bowl", value=output)
    folder = Path(output) if output is not None else Path("results") / file.stem
    silent = quiet or as_json
    with _Progress(silent) as listener, _naming(file):
        from sheetmorph.show.outputs import run_design

        result, notes = run_design(
            design, folder, resume=resume, force=force, on_event=listener, started=STARTED
        )
    if as_json:
        click.echo(json.dumps(result.summary, indent=2, ensure_ascii=False))
    elif not quiet:
        _tell(result.summary, folder, [*design.drawing_notes, *notes])
    if result.status == "interrupted":
        raise click.exceptions.Abort(
            f"interrupted after {len(result.positions) - 1} states; add --resume to go on"
        )
    if result.status != "completed":
        raise SheetmorphError(
            f"{file}: the run ended as {result.status} ({result.summary['detail']}): "
            f"{result.summary['remedy']}"
        )


def main(arguments: list[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: as typed after `sheetmorph`; those of the process by default.

    Returns:
        The exit code: 0, 1 for a computation that failed, 2 for bad input, 130 when
        interrupted.
    """
    try:
        code = cli.main(arguments, prog_name="sheetmorph", standalone_mode=False)
    except SheetmorphError as error:
        return _fail(str(error), error.exit_code)
    except click.exceptions.Abort as error:
        return _fail(str(error) or "interrupted; add --resume to go on", 130)
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        help_of = context.command_path if context is not None else "sheetmorph"
        return _fail(f"{error.format_message()} (see {help_of} --help)", 2)
    except KeyboardInterrupt:
        return _fail("interrupted; add --resume to go on", 130)
    except MemoryError:
        return _fail("out of memory; use a larger mesh.size", 1)
    except BrokenPipeError:
        # The reader of our output has gone (as in `| head`); nothing is left to tell.
        sys.stderr.close()
        return 1
    return code if isinstance(code, int) else 0


def script() -> None:
    """Entry point of the `sheetmorph` program."""
    sys.exit(main())


def _fail(message: str, code: int) -> int:
    click.echo(f"sheetmorph: {' '.join(message.split())}", err=True)
    return code


def _load_design(file: Path, overrides: tuple[str, ...]) -> Design:
    from sheetmorph.design.spec import Design

    design = Design.load(file)
    values: dict[str, object] = {}
    for text in overrides:
        key, equals, value = text.partition("=")
        if not equals or not key.strip():
            raise InputError("--set wants KEY=VALUE, such as actuation.eps_pre=-0.3", value=text)
        values[key.strip()] = value.strip()
    return design.with_values(values) if values else design


@contextmanager
def _naming(file: Path) -> Iterator[None]:
    """Name the design file in errors about one of its keys that name no file."""
    try:
        yield
    except InputError as error:
        names_key = error.key is not None and not error.key.startswith("SHEETMORPH_")
        raise (error.located(file) if names_key else error) from None


class _Progress:
    """A progress bar on the terminal, fed by events; nothing when silenced or piped."""

    def __init__(self, silent: bool) -> None:
        self._shown = not silent and sys.stderr.isatty()
        self._bar: Any = None
        self._task: Any = None

    def __enter__(self) -> Listener:
        if not self._shown:
            from sheetmorph.core.events import silent

            return silent
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        self._bar = Progress(
            TextColumn("{task.fields[title]}", markup=False),
            BarColumn(),
            TextColumn("{task.percentage:>3.0f} %"),
            TimeElapsedColumn(),
            TextColumn("{task.description}", markup=False),
            console=Console(stderr=True),
            transient=True,
        )
        self._bar.start()
        self._task = self._bar.add_task("meshing", total=1.0, title="sheetmorph")
        return self._listen

    def __exit__(self, *error: object) -> None:
        if self._bar is not None:
            self._bar.stop()

    def _listen(self, event: Event) -> None:
        from sheetmorph.core.events import Progress, Started

        if isinstance(event, Started):
            self._bar.update(self._task, title=event.title)
        elif isinstance(event, Progress):
            self._bar.update(self._task, completed=event.fraction, description=event.text)


def _tell(summary: dict[str, Any], folder: Path, notes: list[str]) -> None:
    """The result in a few lines."""
    for note in notes:
        click.echo(f"note: {note}", err=True)
    if summary["status"] == "interrupted":
        return
    width, depth, height = (1e3 * value for value in summary["bbox_m"])
    stable = "stable" if summary["stable"] else f"{summary['negative_pivots']} negative pivots"
    seconds = summary["seconds"]
    click.echo(
        f"{summary['name']}: {summary['status']} at {100 * summary['actuation_reached']:.0f} % of "
        f"eps_pre {summary['eps_pre']:g}, {stable}\n"
        f"  size       {width:.1f} × {depth:.1f} × {height:.1f} mm, "
        f"h/d {summary['aspect_ratio']:.3f}\n"
        f"  mesh       {summary['nodes']} nodes, {summary['triangles']} triangles\n"
        f"  solve      {seconds['total']:.2f} s, {summary['factorisations']} factorisations by "
        f"{summary['solver']}, {summary['states']} states\n"
        f"  everything {seconds['wall']:.1f} s\n"
        f"results in {folder}{'/' if not str(folder).endswith('/') else ''}"
        f"{' (open report.html)' if (folder / 'report.html').is_file() else ''}"
    )
