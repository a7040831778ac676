"""The pages are true to the program: commands, options, statuses, files, versions."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import click
import pytest

import sheetmorph
from sheetmorph.cli.entry import cli
from sheetmorph.solve.path import Status

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = sorted([ROOT / "README.md", *DOCS.rglob("*.md"), *ROOT.glob("examples/*.md")])


def text(name: str) -> str:
    return (DOCS / name).read_text("utf-8")


def calls() -> list[tuple[str, str]]:
    """Every call of the program in a block of shell on a page: page, call."""
    found = []
    for page in PAGES:
        for _, block in re.findall(r"```(sh|console)\n(.*?)```", page.read_text("utf-8"), re.S):
            lines = re.findall(r"(?m)^\s*(?:\$ )?(?:\S*/)?(sheetmorph .*)$", block)
            found += [(page.name, line) for line in lines]
    return found


def test_every_command_has_a_page() -> None:
    pages = {page.stem for page in (DOCS / "commands").glob("*.md")} - {"index"}
    assert pages == set(cli.commands), "a page in docs/commands for each command, no other"


@pytest.mark.parametrize(("page", "call"), calls(), ids=lambda value: value[:70])
def test_calls_on_the_pages_have_commands_and_options_that_exist(page: str, call: str) -> None:
    words = [word for word in shlex.split(call, comments=True) if word not in {"&&", "\\"}]
    command: click.Command = cli
    context = click.Context(cli, info_name="sheetmorph")
    rest = words[1:]
    while isinstance(command, click.Group) and rest and not rest[0].startswith("-"):
        name = rest.pop(0)
        assert name in command.commands, f"{page}: {name} is not a command"
        command = command.commands[name]
        context = click.Context(command, info_name=name, parent=context)
    command.make_parser(context).parse_args(rest)  # raises NoSuchOption


def test_there_are_many_calls_to_look_at() -> None:
    assert len(calls()) > 60


def test_every_status_has_its_remedy_on_two_pages() -> None:
    for page in ("when-it-fails.md", "solver.md"):
        rows = set(re.findall(r"(?m)^\| `([a-z_]+)` \|", text(page)))
        assert {status.value for status in Status} <= rows, page


def test_files_named_beside_the_equations_are_there() -> None:
    names = re.findall(r"`([\w/]+\.py)`", text("equations.md"))
    assert len(names) > 40
    for name in names:
        assert (ROOT / name).exists() or (ROOT / "src/sheetmorph" / name).exists(), name


def test_equations_cite_what_they_list() -> None:
    body, references = text("equations.md").split("## References")
    listed = {int(number) for number in re.findall(r"(?m)^(\d+)\. ", references)}
    assert {int(number) for number in re.findall(r"\[(\d+)\]", body)} == listed


def test_the_modules_of_the_interface_are_there() -> None:
    for page in (DOCS / "api").glob("*.md"):
        names = re.search(r"(?m)^modules: \[(.*)\]$", page.read_text("utf-8"))
        assert names or page.stem == "index"
        for name in names[1].split(", ") if names else []:
            folder = ROOT / "src" / "sheetmorph" / page.stem
            assert (folder / f"{name}.py").exists() or (folder / name).is_dir(), (page.stem, name)


def test_the_citation_names_this_version() -> None:
    version = sheetmorph.__version__
    assert f"version = {{{version}}}" in text("citing.md")
    assert f"version: {version}\n" in (ROOT / "CITATION.cff").read_text("utf-8")
