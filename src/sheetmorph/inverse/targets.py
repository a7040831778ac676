"""Wanted shapes: by name, or from a file."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from sheetmorph.compare.clean import prepare
from sheetmorph.compare.faces import face_of, faces_of
from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.scan import Scan, read_surface
from sheetmorph.compare.scanfiles import READERS
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import InputError, nearest
from sheetmorph.geometry.surface import aspect_ratio, in_plane_width
from sheetmorph.inverse import surfaces
from sheetmorph.inverse.letters import STROKES, letter

USUAL_SIZE = 0.08
"""Largest width of a named target [m] where nobody says how large it shall be."""


@dataclass(frozen=True)
class Numbers:
    """The numbers behind the name of a target, in order: what they are and their limits.

    Attributes:
        names: what each is.
        usual: taken where they are left out.
        limits: least and greatest of each.
    """

    names: tuple[str, ...]
    usual: tuple[float, ...]
    limits: tuple[tuple[float, float], ...]


_DEPTH = Numbers(("h/d",), (0.3,), ((0.02, 1.0),))
_FLATTER = Numbers(("h/d",), (0.3,), ((0.02, 0.5),))

NAMED: dict[str, tuple[Numbers, Callable[..., Surface]]] = {
    "bowl": (_DEPTH, surfaces.bowl),
    "dome": (_DEPTH, surfaces.dome),
    "cone": (_DEPTH, surfaces.cone),
    "saddle": (_DEPTH, surfaces.saddle),
    "cylinder": (_FLATTER, surfaces.cylinder),
    "canoe": (
        Numbers(("length/width", "h/width"), (2.0, 0.35), ((1.0, 6.0), (0.02, 1.0))),
        surfaces.canoe,
    ),
}
LETTER = "letter"
_LETTER = Numbers(("h/stroke",), (0.4,), ((0.02, 1.0),))


@dataclass(frozen=True, eq=False)
class Target:
    """A wanted shape.

    Attributes:
        name: for titles and file names.
        surface: of the size that is wanted [m].
        text: how it was asked for.
        notes: sentences for the user.
    """

    name: str
    surface: Surface
    text: str
    notes: tuple[str, ...] = ()

    @cached_property
    def width(self) -> float:
        """Largest width in the plan [m]."""
        return float(in_plane_width(self.surface.points[self.surface.used]))

    @cached_property
    def aspect_ratio(self) -> float:
        """Height over that width."""
        return float(aspect_ratio(self.surface.points[self.surface.used]))


def read_target(text: str, *, unit: float | None = None, size: float | None = None) -> Target:
    """The target that a text names: a file, or a name with its numbers, as in `bowl:0.4`.

    Args:
        text: as it was typed.
        unit: length of one unit of a file [m]; a millimetre when None.
        size: largest width that the target shall have [m]; by default that of the file, and
            `USUAL_SIZE` for a name.

    Raises:
        InputError: there is no such file, name or number.
    """
    if Path(text).suffix.lower() in READERS or Path(text).exists():
        return target_of(read_surface(text, unit=1e-3 if unit is None else unit), text, size)
    if unit is not None:
        raise InputError("a named target has no unit; say how large it shall be by --size")
    word, *rest = text.strip().lower().split(":")
    if word == LETTER:
        which, numbers = (rest[0].upper() if rest else ""), rest[1:]
        if which not in STROKES:
            raise InputError(
                "there is no rim of this letter",
                key=text,
                value=which or "no letter",
                allowed=f"letter:X with X one of {', '.join(STROKES)}",
            )
        surface = letter(which, *_numbers(text, numbers, _LETTER))
        return _sized(Target(f"{LETTER}-{which}", surface, text), size or USUAL_SIZE)
    if word not in NAMED:
        guess = nearest(word, [*NAMED, LETTER])
        raise InputError(
            "is no file, and no surface of this name"
            + (f"; did you mean {guess}?" if guess else ""),
            key="TARGET",
            value=text,
            allowed=f"{', '.join(READERS)} files, {', '.join([*NAMED, LETTER])}",
        )
    wanted, make = NAMED[word]
    return _sized(Target(word, make(*_numbers(text, rest, wanted)), text), size or USUAL_SIZE)


def target_of(scan: Scan, text: str, size: float | None = None) -> Target:
    """A target from a surface that was read; of a thick sheet its outer face.

    Raises:
        InputError: nothing of it can be used.
    """
    clean = prepare(scan)
    faces = faces_of(clean.surface)
    surface, _ = face_of(clean.surface, faces, "outer" if faces.two_faced else "both")
    notes = (*clean.notes, *faces.notes)
    if faces.two_faced:
        notes = (*notes, "The target is a thick sheet; its outer face is taken.")
    return _sized(Target(Path(scan.name).stem, surface, text, notes), size)


def _sized(target: Target, size: float | None) -> Target:
    if size is None:
        return target
    scale = size / target.width
    pose = Similarity(scale, Similarity.identity().rotation, Similarity.identity().translation)
    return Target(target.name, target.surface.moved(pose), target.text, target.notes)


def _numbers(text: str, given: list[str], wanted: Numbers) -> tuple[float, ...]:
    form = ":".join(["NAME", *wanted.names])
    if len(given) > len(wanted.names):
        raise InputError("has too many numbers", key="TARGET", value=text, allowed=form)
    found = list(wanted.usual)
    for k, word in enumerate(given):
        low, high = wanted.limits[k]
        try:
            found[k] = float(word)
        except ValueError:
            raise InputError("holds no number", key="TARGET", value=text, allowed=form) from None
        if not (math.isfinite(found[k]) and low <= found[k] <= high):
            raise InputError(
                f"{wanted.names[k]} is out of range",
                key="TARGET",
                value=text,
                allowed=f"{low:g} to {high:g}",
            )
    return tuple(found)
