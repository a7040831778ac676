"""Names of files and layers that every system takes, made from the names people give."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable

MAX_LENGTH = 60
PLATE = re.compile(r"plate(-\d+)?", re.IGNORECASE)
"""Names that files of several parts on one bed can have."""

_RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)", re.IGNORECASE)


def safe_name(text: str, fallback: str = "part") -> str:
    """A file name of letters, digits, `-` and `_` that resembles `text`.

    Letters with accents lose them; what cannot be written so becomes `-`.
    """
    plain = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode("ascii")
    name = re.sub(r"[^A-Za-z0-9_]+", "-", plain).strip("-_")[:MAX_LENGTH].rstrip("-_")
    if not name:
        return fallback
    return f"{name}-" if _RESERVED.fullmatch(name) else name


def part_names(layers: Iterable[str]) -> list[str]:
    """For each layer the name of its file, which no other and no plate has."""
    names = [safe_name(layer) for layer in layers]
    return distinct([f"{name}-part" if PLATE.fullmatch(name) else name for name in names])


def plate_names(count: int) -> list[str]:
    """Names of the files for so many beds."""
    return ["plate"] if count == 1 else [f"plate-{number}" for number in range(1, count + 1)]


def distinct(names: Iterable[str], taken: Iterable[str] = ()) -> list[str]:
    """The names, with `-2`, `-3` … appended where one is there already, case left aside."""
    seen = {name.casefold() for name in taken}
    found = []
    for name in names:
        candidate, number = name, 1
        while candidate.casefold() in seen:
            number += 1
            candidate = f"{name}-{number}"
        seen.add(candidate.casefold())
        found.append(candidate)
    return found
