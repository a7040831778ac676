"""What the commands have in common: the design they read, the progress they show."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sheetmorph.core.errors import InputError

if TYPE_CHECKING:
    from sheetmorph.core.events import Event, Listener
    from sheetmorph.design.spec import Design

design_file = click.argument("file", type=click.Path(path_type=Path))
set_values = click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="KEY=VALUE",
    help="Override a key of the design, such as actuation.eps_pre=-0.3. May be repeated.",
)


def output_folder(
    text: str, example: str, default: str | None = None
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """The option -o of a command, a path; None where it is neither given nor has a default.

    Args:
        text: the help of the option.
        example: a folder, for the error about one without a name.
        default: the folder where none is given.
    """

    def as_path(_context: object, _option: object, given: str | None) -> Path | None:
        if given is not None and not given.strip():
            raise InputError(f"-o wants a folder, such as {example}", value=given)
        return None if given is None else Path(given)

    return click.option(
        "-o",
        "--output",
        metavar="DIR",
        help=text,
        default=default,
        show_default=default is not None,
        callback=as_path,
    )


def load_design(file: Path, overrides: tuple[str, ...]) -> Design:
    """The design of a file with the values that --set gives."""
    from sheetmorph.design.spec import Design

    return Design.load(file, read_values(overrides))


def read_values(overrides: tuple[str, ...]) -> dict[str, object]:
    """The keys that --set gives, with their values as text."""
    values: dict[str, object] = {}
    for text in overrides:
        key, equals, value = text.partition("=")
        if not equals or not key.strip():
            raise InputError("--set wants KEY=VALUE, such as actuation.eps_pre=-0.3", value=text)
        values[key.strip()] = value.strip()
    return values


def read_length(text: str | None, option: str) -> float | None:
    """The length that an option gives [m]; None where it is not given.

    Raises:
        InputError: no number with a unit of length.
    """
    from sheetmorph.core.units import to_si

    if text is None:
        return None
    try:
        return to_si(text.strip(), "length")
    except InputError as error:
        raise InputError(
            error.message, key=option, value=text, allowed='a length, as in "0.2 mm"'
        ) from None


@contextmanager
def naming(file: Path) -> Iterator[None]:
    """Name the design file in errors about one of its keys that name no file."""
    try:
        yield
    except InputError as error:
        names_key = error.key is not None and not error.key.startswith(("SHEETMORPH_", "--"))
        raise (error.located(file) if names_key else error) from None


class ProgressBar:
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


def notices_above(listener: Listener) -> Listener:
    """Notices go above the progress bar, all else to it."""
    from sheetmorph.core.events import Notice

    def tell(event: Event) -> None:
        if isinstance(event, Notice):
            click.echo(event.text, err=True)
        else:
            listener(event)

    return tell


@contextmanager
def at_work(folder: Path, silent: bool, check: Callable[[], None]) -> Iterator[Listener]:
    """The progress of a job, which has its folder to itself meanwhile.

    Args:
        folder: of the job.
        silent: no progress is shown.
        check: refuses the folder. It is asked before the folder is touched, and again when no
            other job can finish in it.

    Raises:
        InputError, OutputError: those of `check`, or see `sheetmorph.core.locks.sole_user`.
    """
    from sheetmorph.core.locks import sole_user

    check()
    with sole_user(folder):
        check()
        with ProgressBar(silent) as listener:
            yield listener


@contextmanager
def by_their_options(names: Mapping[str, str]) -> Iterator[None]:
    """Errors about fields of options name the options of the command line.

    Args:
        names: of the fields, with those of their options.
    """
    try:
        yield
    except InputError as error:
        key = names.get(error.key or "")
        if key is None:
            raise
        raise InputError(
            error.message, file=error.file, key=key, value=error.value, allowed=error.allowed
        ) from None
