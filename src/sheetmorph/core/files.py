"""Files that are either whole or absent: written beside, flushed, then renamed into place."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sheetmorph.core.errors import OutputError

REMEDY = "free some space or choose another folder with -o"
GO_ON = "free some space, then add --resume"
"""What to do for a job that keeps what it has computed."""


@contextmanager
def writing(path: str | Path, remedy: str = REMEDY) -> Iterator[None]:
    """What the system says against writing, in one line for people.

    Args:
        path: what is written.
        remedy: what to do.

    Raises:
        OutputError: the disk is full, or the folder cannot be written.
    """
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(f"{path}: cannot be written ({reason}); {remedy}") from error


@contextmanager
def resumable() -> Iterator[None]:
    """Say, where something cannot be written, that what is computed is kept.

    Raises:
        OutputError: what the block raises, with that said.
    """
    try:
        yield
    except OutputError as error:
        raise OutputError(f"{error}; then --resume goes on with what is computed") from error


@contextmanager
def replacing(path: str | Path, remedy: str = REMEDY) -> Iterator[Path]:
    """Yield a temporary path beside `path`; rename it into place when the block succeeds.

    The temporary name keeps the ending of `path`, because many writers choose their
    format by it. When the block raises, the temporary file is removed and `path` is
    left as it was.

    Raises:
        OutputError: the disk is full, or the folder cannot be written.
    """
    target = Path(path)
    partial: Path | None = None
    with writing(target, remedy):
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            handle, name = tempfile.mkstemp(
                prefix=f".{target.stem}.", suffix=f".partial{target.suffix}", dir=target.parent
            )
            os.close(handle)
            partial = Path(name)
            yield partial
            with partial.open("rb+") as stream:
                os.fsync(stream.fileno())
            partial.chmod(0o666 & ~_umask())
            partial.replace(target)
            partial = None
        finally:
            if partial is not None:
                partial.unlink(missing_ok=True)


def write_text(path: str | Path, text: str) -> None:
    """Write UTF-8 text with `\\n` line ends, whole or not at all."""
    with replacing(path) as partial:
        partial.write_text(text, encoding="utf-8", newline="\n")


def write_bytes(path: str | Path, data: bytes) -> None:
    """Write bytes, whole or not at all."""
    with replacing(path) as partial:
        partial.write_bytes(data)


def _umask() -> int:
    current = os.umask(0o022)
    os.umask(current)
    return current
