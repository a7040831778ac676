"""Files that strangers wrote: read whole, within bounds, and refused in one line."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from sheetmorph.core.errors import InputError, nearest


@contextmanager
def reading(file: Path, what: str) -> Iterator[None]:
    """Errors while a file is read become one line that names it.

    Args:
        file: the file that is read.
        what: what messages call it, such as "the scan".
    """
    try:
        yield
    except InputError as error:
        raise error.located(file) from error.__cause__
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror or error})", file=file) from error
    except MemoryError as error:
        raise InputError(f"{what} does not fit into memory", file=file) from error
    except RecursionError as error:
        raise InputError(f"{what} is too deeply nested", file=file) from error


def ending_of(file: Path, known: Collection[str], what: str) -> str:
    """The ending of a file, in lower case.

    Args:
        file: it need not exist.
        known: endings that can be read, with their dots.
        what: they are, such as "mesh format".

    Raises:
        InputError: an ending of another format.
    """
    ending = file.suffix.lower()
    if ending not in known:
        hint = nearest(ending, known)
        raise InputError(
            f"no such {what}" + (f"; did you mean {hint}?" if hint else ""),
            file=file,
            value=ending or "no ending",
            allowed=", ".join(known),
        )
    return ending


def check_size(file: Path, most: int, remedy: str = "") -> None:
    """Refuse a file that is none, is empty, or is larger than `most` bytes.

    Args:
        file: to be read.
        most: bytes it may have.
        remedy: what to do about one that is larger.

    Raises:
        InputError: see above, or there is no such file.
        OSError: it cannot be looked at.
    """
    try:
        size = file.stat().st_size
    except FileNotFoundError:
        raise InputError("there is no such file", file=file) from None
    if not file.is_file():
        raise InputError("is not a file", file=file)
    if size > most:
        raise _too_large(file, most, remedy, f"{size / 1e6:.4g} MB")
    if size == 0:
        raise InputError("the file is empty", file=file)


def read_bytes(file: Path, most: int, remedy: str = "") -> bytes:
    """What is in a file; never more than `most` bytes of it are read, even if it grows.

    Raises:
        InputError, OSError: see `check_size`.
    """
    check_size(file, most, remedy)
    with file.open("rb") as stream:
        data = stream.read(most + 1)
    if len(data) > most:
        raise _too_large(file, most, remedy)
    return data


def read_text(file: Path, most: int, what: str) -> str:
    """The text of a file; a mark of the byte order is taken away.

    Args:
        file: may be a pipe, such as the standard input of another program.
        most: bytes it may have.
        what: it should be, such as "a design file".

    Raises:
        InputError: no such file, a folder, unreadable, too large, or not UTF-8 (with the line).
    """
    try:
        with file.open("rb") as stream:
            data = stream.read(most + 1)
    except FileNotFoundError:
        raise InputError("there is no such file", file=file) from None
    except IsADirectoryError:
        raise InputError(f"is a folder, not {what}", file=file) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"cannot be read ({reason})", file=file) from None
    if len(data) > most:
        raise _too_large(file, most)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError(f"is not UTF-8 text (line {line})", file=file) from None


def _too_large(file: Path, most: int, remedy: str = "", size: str | None = None) -> InputError:
    text = "the file is too large" + (f"; {remedy}" if remedy else "")
    return InputError(text, file=file, value=size, allowed=f"≤ {most / 1e6:.4g} MB")
