"""Families of patterns that a sweep may draw its designs from, by name."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping

from sheetmorph.core.errors import InputError, nearest
from sheetmorph.design.families import random_kirigami
from sheetmorph.design.spec import Design
from sheetmorph.sweep.random_designs import random_design

FAMILIES: dict[str, Callable[..., Design]] = {
    "random_kirigami": random_kirigami,
    "random_design": random_design,
}
"""Functions from a seed and a few numbers in SI units to a design."""


def check_arguments(kind: object, names: Mapping[str, str]) -> str:
    """The family, when it has all these arguments.

    Args:
        kind: its name.
        names: of the arguments, with the key under which each of them was given.

    Raises:
        InputError: no such family, no such argument, or no seed.
    """
    if not isinstance(kind, str) or kind not in FAMILIES:
        raise InputError(
            "no such family", key="family.kind", value=kind, allowed=", ".join(FAMILIES)
        )
    known = list(inspect.signature(FAMILIES[kind]).parameters)
    for name, key in names.items():
        if name not in known:
            guess = nearest(name, known)
            hint = f"; did you mean {guess}?" if guess else ""
            raise InputError(f"the family has no {name}{hint}", key=key, allowed=", ".join(known))
    if "seed" not in names:
        raise InputError(
            "the family needs a seed", key="family", allowed='"family.seed" in list, grid, samples'
        )
    return kind


def family_design(kind: str, arguments: Mapping[str, object]) -> Design:
    """The design of a family.

    Args:
        kind: name of the family.
        arguments: in SI units.

    Raises:
        InputError: an argument is not allowed, or there is no such design.
    """
    try:
        return FAMILIES[kind](**arguments)
    except (TypeError, ValueError) as error:
        raise InputError(f"an argument of the family is not usable ({error})") from None
