"""The command `new`."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

from sheetmorph.cli.shared import read_length
from sheetmorph.core.errors import InputError

# As in design.presets, which --help must not import.
PRESETS = ("bowl", "canoe", "petals", "kirigami", "blank")


@click.command()
@click.argument("name")
@click.option(
    "--preset", type=click.Choice(PRESETS), default="blank", show_default=True, help="Start from."
)
@click.option(
    "--drawing",
    type=click.Path(path_type=Path),
    help="Start from a drawing instead: .dxf, .svg or .3mf.",
)
@click.option("--sheet", metavar="LAYER", help="Its layer, id or colour of the sheet [SHEET].")
@click.option("--pattern", metavar="LAYER", help="That of the pattern [PATTERN].")
@click.option("--slits", metavar="LAYER", help="That of the slits [SLITS, if there is one].")
@click.option("--unit", help="Of its numbers, where it names none: mm, in, px, …")
@click.option("--gap", metavar="LENGTH", help='Join ends of lines this close, as in "0.5 mm".')
@click.option("--force", is_flag=True, help="Replace a file that is already there.")
def new(
    name: str,
    preset: str,
    drawing: Path | None,
    sheet: str | None,
    pattern: str | None,
    slits: str | None,
    unit: str | None,
    gap: str | None,
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

    if drawing is None and (sheet or pattern or slits or unit or gap):
        raise InputError("--sheet, --pattern, --slits, --unit and --gap go with --drawing")
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
        joined = read_length(gap, "--gap")
        try:
            text = design_text(drawing, path.stem, sheet, pattern, slits, unit, joined)
        except InputError as error:
            # The keys of a design, which is not there yet, are options here.
            key = f"--{error.key}" if error.key in ("unit", "gap") else error.key
            raise InputError(
                error.message, file=error.file, key=key, value=error.value, allowed=error.allowed
            ) from None
    write_text(path, text)
    click.echo(f"wrote {path}; next: sheetmorph run {shlex.quote(str(path))}")
