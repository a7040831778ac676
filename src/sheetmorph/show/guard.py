"""May a command write into this folder? One rule for all that replace only their own files."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sheetmorph.core.errors import InputError, OutputError
from sheetmorph.core.strangers import read_bytes

LARGEST_NUMBERS = 20_000_000
"""Most bytes of a file of numbers that tells whose a folder is."""


@dataclass(frozen=True)
class Written:
    """What a command wrote.

    Attributes:
        files: in the order of the command's outputs.
        notes: lines for the user, such as what to install for better pictures.
    """

    files: tuple[Path, ...]
    notes: tuple[str, ...]


def numbers_of(marker: Path, form: str) -> dict[str, Any] | None:
    """The content of a file of numbers, JSON, with `form` as its "format"; None if it is none."""
    try:
        numbers = json.loads(read_bytes(marker, LARGEST_NUMBERS))
    except (InputError, OSError, ValueError, RecursionError):
        return None
    return numbers if isinstance(numbers, dict) and numbers.get("format") == form else None


def wrote(marker: Path, form: str) -> bool:
    """Is this a file of numbers of that format?"""
    return numbers_of(marker, form) is not None


def check_folder(
    folder: str | Path,
    outputs: Iterable[str],
    what: str,
    *,
    ours: Callable[[Path], bool],
    force: bool,
    inputs: Iterable[Path] = (),
) -> None:
    """Refuse a folder in which files cannot be written, before anything is computed.

    Args:
        folder: where to write; need not exist.
        outputs: names of the files in it, such as "pictures/overlay.png".
        what: they are together, such as "comparison".
        ours: whether an earlier call of the same command wrote a file that is there.
        force: replace such files.
        inputs: files that are read, and must not be written over.

    Raises:
        InputError: the folder is a file; or holds a file of these names that is an input, that
            the command did not write, or that it did write and `force` is not set.
        OutputError: nothing can be written there.
    """
    place, names = Path(folder), tuple(outputs)
    if place.exists() and not place.is_dir():
        raise InputError("this is a file; choose another folder with -o", file=place)
    home = next(parent for parent in (place, *place.absolute().parents) if parent.exists())
    if not os.access(home, os.W_OK):
        raise OutputError(f"{home}: nothing can be written here; choose another folder with -o")
    written = {(place / name).resolve() for name in names}
    for source in inputs:
        if source.resolve() in written:
            raise InputError(
                "this file would be written over; choose another folder with -o", file=source
            )
    there = [place / name for name in names if os.path.lexists(place / name)]
    for file in there:
        if not file.is_file() or not ours(file):
            raise InputError(
                f"this file would be replaced, and no {what} wrote it; choose another folder "
                "with -o",
                file=file,
            )
    if there and not force:
        raise InputError(
            f"this folder holds a {what}; add --force to replace it, or choose another with -o",
            file=place,
        )
