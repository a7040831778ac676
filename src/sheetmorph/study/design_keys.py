"""Dotted keys of numbers in a checked design: read, changed a little, refused with a reason."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from pydantic import BaseModel

from sheetmorph.core.errors import InputError, nearest
from sheetmorph.design.piece import Piece
from sheetmorph.design.spec import Design

UNCHANGED = ("outline", "mesh", "supports")
"""Tables of the design that decide on the mesh and on what is held: not differentiated."""

DISCRETE = ("random_polygons", "drawing")
"""Kinds of shapes that do not follow their numbers smoothly."""

FROM_ZERO = ("fillet", "corner_radius", "hub_radius", "disc_radius")
"""Sizes in a pattern that are nothing at 0."""


def number_at(design: Design, key: str) -> float:
    """The number at a dotted key of the checked design, in SI units.

    Raises:
        InputError: there is no such key, it holds no number, or it belongs to the geometry.
    """
    parts = key.split(".")
    if parts[0] in UNCHANGED:
        raise InputError(
            "belongs to the geometry of the sheet, whose mesh is held fixed here",
            key=key,
            allowed="keys of layers, actuation, pattern, published, laminate, loads, gravity, "
            "contact",
        )
    value: Any = design.spec
    for part in parts:
        value = _part(value, part, key)
    if parts[0] == "pattern":
        _check_pattern(design, key, value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError("holds no number", key=key, value=value)
    return float(value)


def _check_pattern(design: Design, key: str, value: object) -> None:
    """Refuse keys of a pattern with which its boundary does not move smoothly."""
    if design.spec.mesh.pattern_smoothing is None:
        raise InputError(
            "moves the boundary of the pattern, which is sharp: on a mesh the shape jumps with it",
            key=key,
            allowed="pattern keys of designs with mesh.pattern_smoothing, such as an edge length",
        )
    shape = design.pattern[place_of(design.pattern, key.split(".")[1])]
    if shape.kind in DISCRETE or isinstance(value, int):
        what = "a whole number" if isinstance(value, int) else f"a key of the shape {shape.kind}"
        raise InputError(f"is {what}, which cannot change a little", key=key, value=value)
    if value == 0.0 and key.split(".")[-1] in FROM_ZERO:
        raise InputError(
            "is 0, the end of its range, where the shape begins to have it", key=key, value=value
        )


def with_number(design: Design, key: str, value: float) -> Design:
    """The same design with another number at a key, in SI units; its text is left as it is."""
    return replace(design, spec=_changed(design.spec, key.split("."), key, value))


def piece_with(design: Design, key: str, value: float) -> Piece:
    """The shape of the pattern to which a key belongs, with another number there."""
    parts = key.split(".")
    shape = design.pattern[place_of(design.pattern, parts[1])]
    found = _changed(shape, parts[2:], key, value)
    assert isinstance(found, Piece)  # noqa: S101  as the one before
    return found


def place_of(table: tuple[Any, ...], part: str) -> int:
    """Place of an entry by its number or its name; −1 where there is none."""
    if part.isdigit():
        return int(part)
    names = [getattr(entry, "name", None) for entry in table]
    return names.index(part) if part in names else -1


def _changed(table: Any, parts: list[str], key: str, value: float) -> Any:
    if not parts:
        return value
    inner = _changed(_part(table, parts[0], key), parts[1:], key, value)
    if isinstance(table, tuple):
        index = place_of(table, parts[0])
        return (*table[:index], inner, *table[index + 1 :])
    copied = table.model_copy(update={parts[0]: inner})
    copied.__dict__.pop("layout", None)  # drawn anew where the pattern moves
    return copied


def _part(value: Any, part: str, key: str) -> Any:
    if isinstance(value, tuple) and -1 < place_of(value, part) < len(value):
        return value[place_of(value, part)]
    if isinstance(value, BaseModel) and part in type(value).model_fields:
        return getattr(value, part)
    names = list(type(value).model_fields) if isinstance(value, BaseModel) else []
    guess = nearest(part, names)
    raise InputError(
        f"the design has no such key{f'; did you mean {guess}?' if guess else ''}", key=key
    )
