"""What is added to pages while they are read, so that nothing has to be written twice.

- docs/index.md and the index of a folder: tables of pages become the navigation. A page that no
  table names is an error of the build ("document isn't included in any toctree").
- docs/commands/NAME.md: the options of the command, as `--help` prints them.
- docs/api/ROOM.md: the modules that its head names, from their docstrings.
"""

from __future__ import annotations

import posixpath
import re
from typing import Any

import click
import yaml
from docutils import nodes
from sphinx import addnodes

from sheetmorph.cli.entry import cli


def setup(app: Any) -> None:
    """Listen for pages that are read."""
    app.connect("source-read", extend)
    app.connect("autodoc-process-docstring", as_written, priority=100)
    app.connect("doctree-read", by_full_name)


def extend(app: Any, name: str, source: list[str]) -> None:
    """Add to the text of the page `name`, which is the one element of `source`."""
    folder, page = posixpath.split(name)
    if page == "index":
        source[0] = with_navigation(folder, source[0])
    elif folder == "docs/commands":
        source[0] += options_of(page)
    elif folder == "docs/api":
        source[0] += modules_of(page, source[0])


def as_written(
    app: Any, what: str, name: str, obj: object, options: object, lines: list[str]
) -> None:
    """Docstrings are shown as they are written.

    They write |x| for a norm, which reStructuredText takes for a substitution; and a colon in the
    first line of an attribute is not the end of its type, which an empty line before it tells.
    """
    lines[:] = [line.replace("|", "\\|") if "``" not in line else line for line in lines]
    if what in {"attribute", "data", "property"}:
        lines.insert(0, "")


def by_full_name(app: Any, tree: nodes.document) -> None:
    """Types are looked up by their full name alone: many rooms have a `Plan` or a `Curve`.

    (Sphinx would go through all names for every `float`: a third of the time of a build.)
    """
    for reference in tree.findall(addnodes.pending_xref):
        if reference.get("refdomain") == "py":
            reference.attributes.pop("refspecific", None)


def with_navigation(folder: str, text: str) -> str:
    """An index with a hidden table of contents after every section that has a table of pages."""
    sections = re.split(r"(?m)^(?=## )", text)
    return "".join(section + contents_of(folder, section) for section in sections)


def contents_of(folder: str, section: str) -> str:
    """The table of contents of a section: the pages named in the first column of its tables."""
    pages = re.findall(r"(?m)^\| \[[^\]]+\]\(([^)#]+)\.md\)", section)
    if not pages:
        return ""
    heading = re.match(r"## (.+)", section)
    caption = f":caption: {heading[1]}\n" if heading else ""
    names = "\n".join("/" + posixpath.normpath(f"{folder}/{page}") for page in pages)
    return f"\n```{{toctree}}\n:hidden:\n{caption}\n{names}\n```\n\n"


def options_of(command: str) -> str:
    """What `sheetmorph COMMAND --help` prints, and the same for its own commands."""
    found = cli.commands[command]
    texts = [help_of(found, f"sheetmorph {command}")]
    if isinstance(found, click.Group):
        texts += [
            help_of(each, f"sheetmorph {command} {name}")
            for name, each in sorted(found.commands.items())
        ]
    blocks = "\n".join(f"```text\n{text}\n```\n" for text in texts)
    return f"\n## All options\n\n{blocks}"


def help_of(command: click.Command, name: str) -> str:
    """The help of one command."""
    context = click.Context(
        command,
        info_name=name,
        max_content_width=88,
        terminal_width=88,
        help_option_names=["-h", "--help"],
    )
    return command.get_help(context)


def modules_of(room: str, text: str) -> str:
    """What the docstrings say of the modules that the head of the page of a room names."""
    head = yaml.safe_load(text.split("---")[1])
    parts = [
        f"\n## {name}\n\n```{{eval-rst}}\n"
        f".. automodule:: sheetmorph.{room}.{name}\n   :members:\n```\n"
        for name in head["modules"]
    ]
    return "".join(parts)
