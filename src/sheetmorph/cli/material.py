"""The commands `material list`, `show`, `shrink` and `cantilever`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sheetmorph.cli.material_text import tell_cantilever, tell_shrink
from sheetmorph.cli.shared import output_folder
from sheetmorph.core.errors import InputError

if TYPE_CHECKING:
    from sheetmorph.design.materials import Material, Sourced
    from sheetmorph.design.shrink_fit import ShrinkFit

rows_file = click.argument("file", type=click.Path(path_type=Path))
to_folder = output_folder("Folder for the files. Default: material/NAME.", "material/film")
force_files = click.option("--force", is_flag=True, help="Replace the files that it wrote there.")
quietly = click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
print_json = click.option("--json", "as_json", is_flag=True, help="Print the numbers as JSON.")

_NAMES = {
    "young_modulus_room": "Young's modulus, room",
    "young_modulus": "Young's modulus, actuation",
    "poisson_ratio": "Poisson's ratio",
    "density": "density",
    "glass_temperature": "glass temperature",
}


@click.group()
def material() -> None:
    """Material data: a library with sources, shrink curves, moduli from bench tests.

    \b
    Examples:
      sheetmorph material list
      sheetmorph material show PLA
      sheetmorph material shrink lengths.csv -o film
      sheetmorph material cantilever strips.csv -o strips
    """


@material.command("list")
@click.option("--json", "as_json", is_flag=True, help="Print all values as JSON.")
def list_materials(as_json: bool) -> None:
    """Print the materials that a layer may name in `material =`.

    \b
    Example:
      sheetmorph material list
    """
    from sheetmorph.design.materials import library

    if as_json:
        told = {name: _as_data(found) for name, found in library().items()}
        click.echo(json.dumps(told, indent=2, ensure_ascii=False))
        return
    for found in library().values():
        values = found.values()
        soft, stiff = (values.get(key) for key in ("young_modulus", "young_modulus_room"))
        click.echo(
            f"{found.name:<12}  {found.role:<8}  {found.title}\n"
            f"{'':<12}  E {_text(soft)} at actuation, {_text(stiff)} at room temperature, "
            f"density {_text(values.get('density'))}"
        )


@material.command("show")
@click.argument("name")
@click.option("--json", "as_json", is_flag=True, help="Print the values as JSON, in SI units.")
def show_material(name: str, as_json: bool) -> None:
    """Print every value of the material NAME with its range and its source.

    \b
    Example:
      sheetmorph material show PLA
    """
    from sheetmorph.design.materials import find_material

    found = find_material(name)
    if as_json:
        click.echo(json.dumps(_as_data(found), indent=2, ensure_ascii=False))
        return
    click.echo(f"{found.name}: {found.title} ({found.role})")
    for key, value in found.values().items():
        mark = " (assumed)" if value.assumed else ""
        click.echo(f"  {_NAMES[key]:<26}  {value.text}{_range(key, value)}{mark}")
        margin = 32 * " "
        click.echo(click.wrap_text(value.source, 100, margin, margin))
    for key, title in _NAMES.items():
        if key not in found.values():
            click.echo(f"  {title:<26}  not known")
    if found.shrink_curve is not None:
        click.echo(f'  {"shrink curve":<26}  actuation.shrink_curve = "{found.shrink_curve}"')
    click.echo(f'in a design: [[layers]] … material = "{found.name}"')


@material.command()
@rows_file
@to_folder
@click.option("--tg", metavar="TEMPERATURE", help='Glass temperature, such as "366.5 K".')
@force_files
@quietly
@print_json
def shrink(
    file: Path, output: Path | None, tg: str | None, force: bool, quiet: bool, as_json: bool
) -> None:
    """Fit a monotone shrink curve to the measured rows of the CSV FILE.

    Columns: temperature [degC] (or T/Tg, with --tg or a line "# Tg = 366.5 K"), and L/L0, or
    L [mm] and L0 [mm]; also direction (x, y), sample, note. The folder receives curve.csv, which
    a design uses by actuation.shrink_curve, shrink.png and shrink.json.

    \b
    Examples:
      sheetmorph material shrink lengths.csv -o film
      sheetmorph material shrink lengths.csv --tg "200 degF" --json
    """
    from sheetmorph.show.material_files import (
        SHRINK_FILES,
        check_place,
        shrink_numbers,
        write_shrink_files,
    )

    folder = output or Path("material") / file.stem
    check_place(folder, SHRINK_FILES, force, file)
    fit = _fitted(file, _temperature(tg))
    write_shrink_files(fit, folder)
    if as_json:
        click.echo(json.dumps(shrink_numbers(fit), indent=2, ensure_ascii=False))
    elif not quiet:
        tell_shrink(fit, folder)


@material.command()
@rows_file
@to_folder
@click.option(
    "--large-deflection",
    is_flag=True,
    help="Take E from the elastica, exact for large deflections.",
)
@force_files
@quietly
@print_json
def cantilever(
    file: Path,
    output: Path | None,
    large_deflection: bool,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Young's modulus and nominal stiffness from the cantilever tests in the CSV FILE.

    Columns: length [mm], width [mm], thickness [mm], deflection [mm], and density [kg/m^3] for
    strips that bend by their own weight or force [N] for a force at the tip; also sample, note,
    and uncertainties such as "± length [mm]". The folder receives cantilever.csv (every sample),
    cantilever.json and cantilever.png.

    \b
    Examples:
      sheetmorph material cantilever strips.csv -o strips
      sheetmorph material cantilever strips.csv --large-deflection -o exact
    """
    from sheetmorph.measure.cantilever import evaluate_cantilever, read_cantilever
    from sheetmorph.show.material_files import (
        CANTILEVER_FILES,
        cantilever_numbers,
        check_place,
        write_cantilever_files,
    )

    folder = output or Path("material") / file.stem
    check_place(folder, CANTILEVER_FILES, force, file)
    result = evaluate_cantilever(read_cantilever(file), large_deflection=large_deflection)
    write_cantilever_files(result, folder)
    if as_json:
        click.echo(json.dumps(cantilever_numbers(result), indent=2, ensure_ascii=False))
    elif not quiet:
        tell_cantilever(result, folder)


def _temperature(text: str | None) -> float | None:
    from sheetmorph.core.units import to_si

    if text is None:
        return None
    try:
        value = to_si(text.strip(), "temperature")
    except InputError as error:
        raise InputError(error.message, key="--tg", value=text, allowed='as in "366.5 K"') from None
    if value <= 0.0:
        raise InputError("is below absolute zero", key="--tg", value=text)
    return value


def _fitted(file: Path, glass: float | None) -> ShrinkFit:
    from sheetmorph.design.shrink_fit import fit_shrinkage
    from sheetmorph.design.shrink_rows import read_shrinkage

    data = read_shrinkage(file, glass)
    try:
        return fit_shrinkage(data)
    except InputError as error:
        raise error.located(file) from None


def _text(value: Sourced | None) -> str:
    return "not known" if value is None else value.text


def _range(key: str, value: Sourced) -> str:
    from sheetmorph.core.units import format_si
    from sheetmorph.design.materials import KINDS

    if value.low is None or value.high is None:
        return ""
    unit = value.text.partition(" ")[2]
    low, high = (format_si(bound, KINDS[key], unit, 6) for bound in (value.low, value.high))
    return f" ({low} to {high})"


def _as_data(found: Material) -> dict[str, Any]:
    return {
        "name": found.name,
        "title": found.title,
        "role": found.role,
        "shrink_curve": found.shrink_curve,
        "values": {
            key: {
                "value": value.value,
                "range": None if value.low is None else [value.low, value.high],
                "assumed": value.assumed,
                "source": value.source,
            }
            for key, value in found.values().items()
        },
    }
