"""The tables `supports` of the design file: what is held."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from sheetmorph.design.fields import Coordinate, Flag, Interval, Section, Whole, problem

AXES = ("x", "y", "z")
OF_LAMINATE = ("hold", "z", "clamp", "plane", "at")
"""Keys that the published model does not know."""

Axis = Literal["x", "y", "z"]


def _sorted(axes: tuple[Axis, ...]) -> tuple[Axis, ...]:
    if len(set(axes)) < len(axes):
        raise problem("names a direction twice", value=list(axes))
    return tuple(sorted(axes))


def check_box(table: Section) -> None:
    """Refuse intervals `x`, `y`, `z` that begin at their larger end."""
    for key in AXES:
        interval = getattr(table, key)
        if interval is not None and interval[0] > interval[1]:
            raise problem("write the smaller coordinate first", key=key)


class HoldingSupport(Section):
    """Holds the nodes that it chooses.

    Attributes:
        hold: directions in which the chosen nodes keep their coordinate.
        clamp: the rim's edges between chosen nodes keep the direction of their surface normal.
    """

    hold: Annotated[
        tuple[Axis, ...], Field(min_length=1, max_length=3), AfterValidator(_sorted)
    ] = ("x", "y", "z")
    clamp: Flag = False


class BoxSupport(HoldingSupport):
    """Holds every node in a box; `pattern_in_box` only those in the pattern too."""

    kind: Literal["box", "pattern_in_box"]
    x: Interval
    y: Interval
    z: Interval | None = None

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        check_box(self)
        return self


class NodeSupport(HoldingSupport):
    """Holds the nodes with these indices (counted from 0)."""

    kind: Literal["nodes"]
    nodes: Annotated[
        tuple[Annotated[Whole, Field(ge=0, le=2_000_000)], ...],
        Field(min_length=1, max_length=100_000),
    ]


class FreeSupport(Section):
    """Holds nothing: the six rigid motions are removed instead. Same as no support."""

    kind: Literal["free"]


class SymmetrySupport(Section):
    """A plane of symmetry at which the sheet is cut: half of it stands for the whole.

    Attributes:
        plane: the coordinate that the plane keeps.
        at: its value [m].
    """

    kind: Literal["symmetry"]
    plane: Literal["x", "y"]
    at: Coordinate = 0.0


Support = Annotated[
    BoxSupport | NodeSupport | FreeSupport | SymmetrySupport, Field(discriminator="kind")
]
