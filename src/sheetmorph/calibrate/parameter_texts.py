"""Parameters of a fit as a user writes them: `eps_pre=-0.8:-0.2`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from sheetmorph.calibrate.parameters import INDEX, NAMED, Parameter, number_at
from sheetmorph.core.errors import InputError, nearest
from sheetmorph.core.units import KINDS, Kind, scale_of, to_si
from sheetmorph.design.spec import Design

MAX_PARAMETERS = 6

_UNITS: dict[str, str] = {
    "length": "m",
    "pressure": "Pa",
    "density": "kg/m^3",
    "force": "N",
    "temperature": "K",
    "angle": "rad",
    "time": "s",
    "dimensionless": "",
}
_UNIT = re.compile(r"[^\s\d.+-][^\s]*$")


def read_parameters(texts: Iterable[str], design: Design) -> tuple[Parameter, ...]:
    """The parameters that texts such as `eps_pre=-0.8:-0.2` ask for.

    Args:
        texts: a name, or a name, "=" and two bounds with ":" between; with units where the
            key of the design has one. A name without bounds takes its default ones.
        design: the design that is fitted.

    Raises:
        InputError: none, too many, an unknown or repeated name, bounds that are not numbers,
            not in order, or not allowed by the design.
    """
    found = [_read(text, design) for text in texts]
    if not found:
        raise InputError(
            "nothing to fit; name a parameter", key="--fit", allowed="as in eps_pre=-0.8:-0.2"
        )
    if len(found) > MAX_PARAMETERS:
        raise InputError(
            f"{len(found)} parameters are too many", key="--fit", allowed=f"≤ {MAX_PARAMETERS}"
        )
    touched: dict[str, str] = {}
    for parameter in found:
        for key in parameter.values(design, parameter.low):
            plain = INDEX.sub(r".\1", key)
            if plain in touched and not _may_share(plain):
                what = "is given twice" if touched[plain] == parameter.name else (
                    f"sets the same key as {touched[plain]}; keep one of them"
                )  # fmt: skip
                raise InputError(what, key=f"--fit {parameter.name}")
            touched[plain] = parameter.name
    for parameter in found:
        for bound in (parameter.low, parameter.high):
            try:
                design.with_values(parameter.values(design, bound))
            except InputError as error:
                raise InputError(
                    f"the design does not allow this bound: {error.message}",
                    key=f"--fit {parameter.name}",
                    value=bound,
                    allowed=error.allowed,
                ) from None
    return tuple(found)


def _may_share(key: str) -> bool:
    # The profile has one value for all; every other key belongs to one parameter.
    return key == "actuation.profile"


def _read(text: str, design: Design) -> Parameter:
    name, equals, bounds = text.partition("=")
    name = name.strip()
    key = f"--fit {name}" if name else "--fit"
    form = "NAME=LOW:HIGH, such as eps_pre=-0.8:-0.2"
    if name not in NAMED and "." not in name:
        guess = nearest(name, NAMED)
        hint = f"; did you mean {guess}?" if guess else ""
        raise InputError(
            f"is no parameter{hint}",
            key="--fit",
            value=name,
            allowed=f"{', '.join(NAMED)}, or a key of the design with a number",
        )
    named = NAMED.get(name)
    if named is not None:
        named.own(design)  # says so when the design has none
    if not equals:
        if named is None:
            raise InputError("a key of the design needs bounds", key=key, allowed=form)
        low, high = named.bounds(design)
        return Parameter(name, low, high, named.logarithmic, "", named.meaning)
    ends = bounds.split(":")
    if len(ends) != 2:
        raise InputError("wants two bounds", key=key, value=bounds, allowed=form)
    kind = "dimensionless" if named is not None else _kind_of(ends)
    low, high = (_bound(end, kind, key) for end in ends)
    if low >= high:
        raise InputError(
            "the bounds are not in order", key=key, value=bounds, allowed="LOW below HIGH"
        )
    logarithmic = named is not None and named.logarithmic
    if logarithmic and low <= 0:
        raise InputError("must be above zero", key=key, value=low, allowed="> 0")
    if named is None:
        number_at(design, name)
    meaning = named.meaning if named else f"the design's {name}"
    return Parameter(name, low, high, logarithmic, _UNITS[kind], meaning)


def _bound(text: str, kind: Kind, key: str) -> float:
    try:
        return to_si(text.strip(), kind)
    except InputError as error:
        raise InputError(error.message, key=key, value=text, allowed=error.allowed) from None


def _kind_of(ends: Sequence[str]) -> Kind:
    """The kind of quantity that two texts with a unit name."""
    match = _UNIT.search(ends[1].strip())
    if match is None:
        return "dimensionless"
    for kind in KINDS:
        try:
            scale_of(match[0], kind)
        except InputError:
            continue
        return kind
    return "temperature" if match[0] in ("degC", "degF") else "dimensionless"
