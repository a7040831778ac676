"""Field types of the design file: quantities with units, ranges, strict numbers.

Each type is an `Annotated` alias, so a schema reads like its documentation:
`thickness: Annotated[float, Quantity("length", "1 um", "10 cm")]`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, Strict, model_validator
from pydantic_core import PydanticCustomError, core_schema

from sheetmorph.core.errors import InputError, nearest, shorten
from sheetmorph.core.units import Kind, to_si

MAX_NAME = 100
NAME_PATTERN = r"^\w[\w .+-]*$"
PART_PATTERN = r"^[A-Za-z][A-Za-z0-9_-]*$"
NAME_ALLOWED = "letters, digits, spaces, and . _ + -, beginning with a letter or digit"

PROBLEM = "sheetmorph"
"""Type of the pydantic errors that carry a message of ours."""


def problem(
    message: str, *, key: str = "", value: object = None, allowed: str | None = None
) -> PydanticCustomError:
    """An error for a validator to raise; `key` is relative to the validated section."""
    context = {"text": message, "key": key, "value": value, "allowed": allowed}
    return PydanticCustomError(PROBLEM, "{text}", context)


class Section(BaseModel):
    """A table of the design file: frozen, and without keys that nobody reads."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        names = list(cls.model_fields)
        for key in data:
            if key not in names:
                raise unknown_key(str(key), names)
        return data


def unknown_key(key: str, names: list[str]) -> PydanticCustomError:
    """The error for a key that is not among `names`."""
    guess = nearest(key, names)
    hint = f"; did you mean {guess}?" if guess else ""
    return problem(f"unknown key{hint}", key=shorten(key, 40)[1:-1], allowed=", ".join(names))


@dataclass(frozen=True)
class Quantity:
    """Annotation of a float that is written with a unit and kept in SI.

    Attributes:
        kind: kind of quantity, see `sheetmorph.core.units`.
        low: least value as text, or None for no limit.
        high: greatest value as text, or None for no limit.
        above: True when `low` itself is not allowed.
    """

    kind: Kind
    low: str | None = None
    high: str | None = None
    above: bool = False

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def read(self, value: object) -> float:
        """SI value of what the file says; raises a pydantic error for people."""
        try:
            number = to_si(value, self.kind)
        except InputError as error:
            raise problem(error.message, value=error.value, allowed=self._range()) from None
        low = None if self.low is None else to_si(self.low, self.kind)
        high = None if self.high is None else to_si(self.high, self.kind)
        too_low = low is not None and (number <= low if self.above else number < low)
        if too_low or (high is not None and number > high):
            raise problem("is out of range", value=value, allowed=self._range())
        return number

    def _range(self) -> str | None:
        if self.low is None or self.high is None:
            bound, sign = (self.low, ">" if self.above else "≥") if self.low else (self.high, "≤")
            return None if bound is None else f"{sign} {bound}"
        return f"{'above ' if self.above else ''}{self.low} to {self.high}"


def _number(value: object) -> object:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise problem("must be a number without quotes", value=value)
    return value


Number = Annotated[float, BeforeValidator(_number)]
Whole = Annotated[int, Strict()]
FileName = Annotated[str, Field(min_length=1, max_length=200)]
Flag = Annotated[bool, Strict()]

Coordinate = Annotated[float, Quantity("length", "-100 m", "100 m")]
Size = Annotated[float, Quantity("length", "10 um", "10 m")]
Angle = Annotated[float, Quantity("angle", "-360 deg", "360 deg")]
Point = tuple[Coordinate, Coordinate]
Interval = tuple[Coordinate, Coordinate]
