"""The command `check`."""

from __future__ import annotations

import json
from pathlib import Path

import click

from sheetmorph.cli.shared import design_file, load_design, naming, set_values


@click.command()
@design_file
@set_values
@click.option("--json", "as_json", is_flag=True, help="Print the numbers as JSON.")
def check(file: Path, overrides: tuple[str, ...], as_json: bool) -> None:
    """Validate the design FILE and print what would be computed. Writes nothing.

    \b
    Example:
      sheetmorph check bowl.toml --set mesh.size="2 mm"
    """
    from sheetmorph.design.check import describe, format_description

    with naming(file):
        description = describe(load_design(file, overrides))
    click.echo(json.dumps(description, indent=2) if as_json else format_description(description))
