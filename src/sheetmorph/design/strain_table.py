"""Tables of strains that designs name: what every kind of them has in common."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from sheetmorph.core.columns import read_text
from sheetmorph.core.errors import InputError

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design

LEAST, MOST = -0.95, 4.0
"""Strains that any layer may have."""

T = TypeVar("T")


def load_table(design: Design, name: str, key: str, parse: Callable[[str, str], T]) -> T:
    """What the table holds that a design names.

    Args:
        design: whose folder the file lies in.
        name: of the file, as the design has it.
        key: of the design, for messages.
        parse: makes an object of text and name.

    Raises:
        InputError: no such file, or no usable table; the message names the line.
    """
    if not name.lower().endswith(".csv"):
        raise InputError("is no table", key=key, value=name, allowed="a .csv file")
    path = design.resolve_file(name, key)
    try:
        return parse(read_text(path), name)
    except InputError as error:
        raise error.located(path) from None
