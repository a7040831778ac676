"""Files that come from a browser: few endings, bounded sizes, and names of our own."""

from __future__ import annotations

from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path

from sheetmorph.core.errors import InputError
from sheetmorph.core.files import writing

MB = 2**20


@dataclass(frozen=True)
class Kind:
    """What may be uploaded.

    Attributes:
        endings: of the file's name, which alone is taken from it.
        most: bytes.
    """

    endings: tuple[str, ...]
    most: int


ROOM = "free some space in the folder of temporary files of the machine that runs the studio"
"""What to do where a tab cannot have files."""

KINDS = {
    "drawing": Kind((".svg", ".dxf", ".3mf", ".stl"), 20 * MB),
    "scan": Kind((".stl", ".obj", ".ply"), 200 * MB),
}
"""Kinds of uploads, by the names in their addresses."""


def checked_ending(what: str, name: str) -> str:
    """The ending of an uploaded file's name, if it is one of those that are read.

    Raises:
        InputError: it is not.
    """
    kind = KINDS[what]
    ending = "." + name.rpartition(".")[2].lower() if "." in name else ""
    if ending not in kind.endings:
        raise InputError(
            f"this is no {what} that the studio reads",
            value=name[-40:],
            allowed=", ".join(kind.endings),
        )
    return ending


async def stored(
    what: str, name: str, announced: str | None, chunks: AsyncIterator[bytes], folder: Path
) -> Path:
    """Write an upload into a folder, under a name of ours.

    Args:
        what: its kind.
        name: what the browser calls it.
        announced: its size as announced, if it was.
        chunks: its bytes.
        folder: where to put it.

    Raises:
        InputError: of a format that is not read, empty, or too large; nothing is left of it.
        OutputError: there is no room for it; nothing is left of it.
    """
    kind = KINDS[what]
    ending = checked_ending(what, name)
    allowed = f"≤ {kind.most // MB} MB"
    if announced is not None and announced.isdigit() and int(announced) > kind.most:
        raise InputError("the file is too large", allowed=allowed)
    target = folder / f"{what}{ending}"
    size = 0
    try:
        with writing(target.name, ROOM), target.open("wb") as stream:
            async for chunk in chunks:
                size += len(chunk)
                if size > kind.most:
                    raise InputError("the file is too large", allowed=allowed)
                stream.write(chunk)
        if size == 0:
            raise InputError("the file is empty")
    except BaseException:
        target.unlink(missing_ok=True)
        raise
    return target
