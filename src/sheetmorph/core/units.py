"""Human units at the border, SI floats inside.

A quantity is text such as `"0.3 mm"`: one decimal number, a space if you like, one unit.
The text is checked against a fixed grammar before anything interprets it, and pint sees
the unit alone, in a registry that knows the units below and no others: it is read in
milliseconds and has no surprises. Numbers are converted as decimals, so that
`"5.9 mm"` and `"0.0059 m"` are the same float, to the last bit.
"""

from __future__ import annotations

import math
import re
from decimal import Decimal, localcontext
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Literal, get_args

from sheetmorph.core.errors import InputError, shorten

if TYPE_CHECKING:
    from pint import UnitRegistry

Kind = Literal[
    "length",
    "pressure",
    "density",
    "force",
    "force per length",
    "acceleration",
    "temperature",
    "angle",
    "time",
    "rate",
    "dimensionless",
]

MAX_CHARACTERS = 80

SI_UNITS: dict[str, str] = {
    "length": "m",
    "pressure": "Pa",
    "density": "kg/m^3",
    "force": "N",
    "force per length": "N/m",
    "acceleration": "m/s^2",
    "temperature": "K",
    "angle": "rad",
    "time": "s",
    "rate": "1/s",
    "dimensionless": "",
}

_EXAMPLES: dict[str, str] = {
    "length": "0.3 mm",
    "pressure": "0.9 MPa",
    "density": "1050 kg/m^3",
    "force": "9.81e-7 N",
    "force per length": "0.8 N/m",
    "acceleration": "9.81 m/s^2",
    "temperature": "150 degC",
    "angle": "45 deg",
    "time": "5 min",
    "rate": "2.5 1/s",
    "dimensionless": "0.33",
}

_ARTICLES: dict[str, str] = {
    "acceleration": "an acceleration",
    "angle": "an angle",
    "dimensionless": "a number without unit",
}

_DEFINITIONS = """
nano- = 1e-9 = n-
micro- = 1e-6 = µ- = μ- = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
deci- = 1e-1 = d-
hecto- = 1e2 = h-
kilo- = 1e3 = k-
mega- = 1e6 = M-
giga- = 1e9 = G-
metre = [length] = m = meter
gram = [mass] = g
second = [time] = s = sec
kelvin = [temperature]; offset: 0 = K
radian = [angle] = rad
percent = 0.01 = %
inch = 0.0254 * metre = inch = in
foot = 0.3048 * metre = ft
mil = 0.0000254 * metre = mil = thou
litre = 0.001 * metre ** 3 = l = liter = L
pound = 0.45359237 * kilogram = lb
minute = 60 * second = min
hour = 3600 * second = h
degree = 3.14159265358979323846264338327950288 / 180 * radian = deg
degree_Celsius = kelvin; offset: 273.15 = degC = celsius
degree_Fahrenheit = 5 / 9 * kelvin; offset: 233.15 + 200 / 9 = degF = fahrenheit
newton = kilogram * metre / second ** 2 = N
kilogram_force = 9.80665 * newton = kgf
pound_force = 4.4482216152605 * newton = lbf
pascal = newton / metre ** 2 = Pa
bar = 100000 * pascal = bar
pound_force_per_square_inch = pound_force / inch ** 2 = psi
"""

_NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?"
_FACTOR = r"(?:[A-Za-zµμ]+|%)(?:\s?(?:\^|\*\*)\s?-?[1-9])?"
_UNITS = rf"(?:1?\s?/\s?)?{_FACTOR}(?:\s?[*/·]\s?{_FACTOR}){{0,5}}"
_QUANTITY = re.compile(rf"\s*({_NUMBER})\s*((?:{_UNITS})?)\s*")
_UNIT = re.compile(rf"\s*({_UNITS})\s*")
_PLAIN = str.maketrans({"²": "^2", "³": "^3", "°": "deg", "−": "-", "\u00a0": " "})


def to_si(value: object, kind: Kind) -> float:
    """Convert a quantity from the outside into an SI number.

    Args:
        value: text of a number and a unit, such as `"0.3 mm"`. A `dimensionless`
            quantity may also be a plain number, or a percentage such as `"-30 %"`.
        kind: what is wanted; decides the unit of the answer (m, Pa, kg/m³, N, N/m, m/s², K,
            rad, s, 1/s, or none).

    Raises:
        InputError: no number with a unit of that kind, or not finite.
    """
    if kind == "dimensionless" and isinstance(value, int | float) and not isinstance(value, bool):
        return _finite(float(value), value)
    if not isinstance(value, str):
        raise InputError(_wanted(kind), value=value)
    if len(value) > MAX_CHARACTERS:
        raise InputError(f"too long for a quantity; {_wanted(kind)}", value=shorten(value, 40))
    match = _QUANTITY.fullmatch(value.translate(_PLAIN))
    if match is None or (not match[2] and kind != "dimensionless"):
        raise InputError(_wanted(kind), value=value)
    try:
        factor, offset = _conversion(match[2], kind)
    except InputError as error:
        raise InputError(error.message, value=value, allowed=error.allowed) from None
    with localcontext() as context:
        context.prec = 40
        return _finite(float(Decimal(match[1]) * factor + offset), value)


def scale_of(unit: object, kind: Kind) -> float:
    """SI value of one `unit`, such as 0.001 for `"mm"` as a length.

    Raises:
        InputError: not a unit of that kind, or one with an offset such as degC.
    """
    text = unit.translate(_PLAIN) if isinstance(unit, str) else ""
    match = _UNIT.fullmatch(text) if len(text) <= MAX_CHARACTERS else None
    if match is None:
        example = _EXAMPLES[kind].split()[-1]
        raise InputError(f'write a unit of {kind}, such as "{example}"', value=unit)
    factor, offset = _conversion(match[1], kind)
    if offset:
        raise InputError("a unit with an offset cannot be used here", value=unit)
    return float(factor)


def format_si(value: float, kind: Kind, unit: str, digits: int = 12) -> str:
    """Text of an SI number in another unit: `format_si(3e-4, "length", "mm")` is `"0.3 mm"`."""
    factor, offset = _conversion(unit, kind)
    number = (Decimal(repr(float(value))) - offset) / factor
    return f"{float(number):.{digits}g} {unit}".rstrip()


def _wanted(kind: str) -> str:
    noun = _ARTICLES.get(kind, f"a {kind}")
    suffix = "" if kind == "dimensionless" else " with its unit"
    return f'write {noun}{suffix}, such as "{_EXAMPLES[kind]}"'


def _finite(number: float, value: object) -> float:
    if not math.isfinite(number):
        raise InputError("must be a finite number", value=value)
    return number


@lru_cache(maxsize=512)
def _conversion(unit: str, kind: str) -> tuple[Decimal, Decimal]:
    """Factor and offset with which a number in `unit` becomes SI of the kind."""
    from pint.errors import DimensionalityError, UndefinedUnitError

    if not unit:
        return Decimal(1), Decimal(0)
    registry = _registry()
    try:
        plain = unit.replace("·", "*").replace(" ", "")
        parsed = registry.parse_units(f"1{plain}" if plain.startswith("/") else plain)
        zero, one = (_convert(registry, n, parsed, SI_UNITS[kind]) for n in (0, 1))
    except DimensionalityError:
        raise InputError(f'"{unit}" is not a unit of {_noun(kind)}; {_wanted(kind)}') from None
    except UndefinedUnitError:
        raise InputError(f'the unit "{unit}" is not known; {_wanted(kind)}') from None
    except (ValueError, ArithmeticError, AssertionError):
        raise InputError(f'"{unit}" cannot be read as a unit; {_wanted(kind)}') from None
    return one - zero, zero


def _noun(kind: str) -> str:
    return "a pure number" if kind == "dimensionless" else kind


def _convert(registry: UnitRegistry[Any], number: int, unit: Any, target: str) -> Decimal:
    goal = registry.parse_units(target) if target else registry.dimensionless
    return Decimal(registry.Quantity(Decimal(number), unit).to(goal).magnitude)


@lru_cache(maxsize=1)
def _registry() -> UnitRegistry[Any]:
    # A registry of these units alone is built in 6 ms; pint's own takes 130 ms and knows
    # thousands of units. Importing pint costs 170 ms, so that happens here, on first use.
    import pint

    registry: UnitRegistry[Any] = pint.UnitRegistry(None, non_int_type=Decimal)
    registry.load_definitions(_DEFINITIONS.strip().splitlines())
    return registry


KINDS: tuple[Kind, ...] = get_args(Kind)
