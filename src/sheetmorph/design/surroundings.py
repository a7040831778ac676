"""The tables `gravity` and `contact` of the design file: what is around the sheet in the oven."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from sheetmorph.design.fields import Flag, Number, Quantity, Section, problem

DOWN: dict[str, tuple[float, float, float]] = {
    "as_drawn": (0.0, 0.0, -1.0),
    "turned_over": (0.0, 0.0, 1.0),
    "upright": (0.0, -1.0, 0.0),
}
"""Orientation of the sheet in the oven → where down is in its own coordinates."""

STANDARD = 9.80665
"""Standard gravity [m/s²]."""

Acceleration = Annotated[float, Quantity("acceleration", "0 m/s^2", "10000 m/s^2")]
Direction = Annotated[tuple[Number, ...], Field(min_length=3, max_length=3)]
Distance = Annotated[float, Quantity("length", "0 m", "10 m")]


def some_direction(direction: Direction) -> None:
    """Refuse three numbers that are no direction."""
    if not 1e-6 < max(abs(part) for part in direction) < 1e6:
        raise problem(
            "is no direction",
            key="direction",
            value=list(direction),
            allowed="three numbers, such as [0, 0, -1]",
        )


class Gravity(Section):
    """The weight of the layers, there from before the actuation to the end.

    Attributes:
        magnitude: [m/s²].
        orientation: how the sheet lies or hangs: "as_drawn" with its first layer below,
            "turned_over" with its first layer above, "upright" with its y axis up.
        direction: where down is, in its place; its length does not matter.
    """

    magnitude: Acceleration = STANDARD
    orientation: Literal["as_drawn", "turned_over", "upright"] = "as_drawn"
    direction: Direction | None = None

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if self.direction is not None:
            some_direction(self.direction)
            if "orientation" in self.model_fields_set:
                raise problem(
                    "orientation and direction exclude each other; keep one of them",
                    key="direction",
                )
        return self

    @property
    def down(self) -> tuple[float, ...]:
        """Where down is; of any length."""
        return DOWN[self.orientation] if self.direction is None else self.direction


class Contact(Section):
    """What the sheet may not pass through.

    Attributes:
        self_contact: itself.
        table: a table, level and without friction, below it.
        table_distance: from the lower face of the flat sheet down to the table [m].
        gap: least distance of the middle surfaces of two parts of the sheet [m]; half of it
            from the table. The thickness of the film by default.
        range: over which the forces of contact rise, beyond the gap [m]; a fifth of the
            thickness of the film by default.
    """

    self_contact: Flag = False
    table: Flag = False
    table_distance: Distance = 0.0
    gap: Annotated[float, Quantity("length", "0 m", "10 cm")] | None = None
    range: Annotated[float, Quantity("length", "0.1 um", "10 cm")] | None = None

    @model_validator(mode="after")
    def _used(self) -> Self:
        if "table_distance" in self.model_fields_set and not self.table:
            raise problem("belongs to a table; write table = true", key="table_distance")
        return self


NO_CONTACT = Contact()
