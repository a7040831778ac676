"""Errors for people: one line that says where, what, and what to do."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path


class SheetmorphError(Exception):
    """Base of all errors that sheetmorph raises on purpose.

    `exit_code` is the status with which the command line ends: 2 for bad input or a place
    that cannot be written, 1 for a computation that failed.
    """

    exit_code = 1


class InputError(SheetmorphError):
    """Something the user gave is not usable: a design, a mesh, a result, an option."""

    exit_code = 2

    def __init__(
        self,
        message: str,
        *,
        file: str | Path | None = None,
        key: str | None = None,
        value: object = None,
        allowed: str | None = None,
    ) -> None:
        self.message = message
        self.file = None if file is None else str(file)
        self.key = key
        self.value = value
        self.allowed = allowed
        super().__init__(str(self))

    def __str__(self) -> str:
        where = ": ".join(part for part in (self.file, self.key) if part)
        text = f"{where}: {self.message}" if where else self.message
        if self.value is not None:
            text += f" (got {shorten(self.value)})"
        if self.allowed is not None:
            text += f"; allowed: {self.allowed}"
        return text

    def located(self, file: str | Path) -> InputError:
        """The same error with the file named, unless it already names one."""
        return InputError(
            self.message,
            file=self.file or file,
            key=self.key,
            value=self.value,
            allowed=self.allowed,
        )


class ComputationError(SheetmorphError):
    """A computation did not reach its end. The message carries the remedy."""


class OutputError(SheetmorphError):
    """A file could not be written (disk full, folder read-only): choose another place."""

    exit_code = 2


def shorten(value: object, limit: int = 80) -> str:
    """`repr` of a value on one line, cut to `limit` characters."""
    text = " ".join(repr(value).split())
    return text if len(text) <= limit else text[: limit - 1] + "…"


def nearest(name: str, allowed: Iterable[str]) -> str | None:
    """The allowed name that looks most like `name`, or None when none does."""
    matches = get_close_matches(name, list(allowed), n=1, cutoff=0.5)
    return matches[0] if matches else None
