"""Names of files and layers that every system takes, made from the names people give."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable

MAX_LENGTH = 60
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
