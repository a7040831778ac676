"""The tables `loads` of the design file: forces that grow with the actuation and stay."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from sheetmorph.design.fields import Coordinate, Interval, Quantity, Section, Whole, problem
from sheetmorph.design.support_tables import AXES, check_box
from sheetmorph.design.surroundings import STANDARD, Acceleration, Direction, some_direction

_THREE = Field(min_length=3, max_length=3)
_NODE = Annotated[Whole, Field(ge=0, le=2_000_000)]
Force = Annotated[float, Quantity("force", "-1000000 N", "1000000 N")]
ForcePerLength = Annotated[float, Quantity("force per length", "-1000000 N/m", "1000000 N/m")]
ForcePerArea = Annotated[float, Quantity("pressure", "-1 GPa", "1 GPa")]


class PointLoad(Section):
    """A force on one node.

    Attributes:
        at: the place [m], two or three coordinates; the nearest node bears the force.
        node: its index from 0 instead.
        force: [N].
    """

    kind: Literal["point"]
    at: Annotated[tuple[Coordinate, ...], Field(min_length=2, max_length=3)] | None = None
    node: _NODE | None = None
    force: Annotated[tuple[Force, ...], _THREE]

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        if self.at is None and self.node is None:
            raise problem("say where the force acts", key="at", allowed="at or node")
        if self.at is not None and self.node is not None:
            raise problem("at and node exclude each other; keep one of them", key="node")
        return self


class LineLoad(Section):
    """A force along edges of the rim: those whose two nodes are chosen.

    Attributes:
        x, y, z: the box that chooses nodes [m].
        nodes: their indices from 0 instead.
        force_per_length: per length of the reference sheet [N/m].
    """

    kind: Literal["line"]
    x: Interval | None = None
    y: Interval | None = None
    z: Interval | None = None
    nodes: Annotated[tuple[_NODE, ...], Field(min_length=2, max_length=100_000)] | None = None
    force_per_length: Annotated[tuple[ForcePerLength, ...], _THREE]

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        box = [key for key in AXES if getattr(self, key) is not None]
        if self.nodes is None and ("x" not in box or "y" not in box):
            key = "y" if "x" in box else "x"
            raise problem("say where the force acts", key=key, allowed="x and y, or nodes")
        if self.nodes is not None and box:
            raise problem(f"{box[0]} and nodes exclude each other; keep one of them", key="nodes")
        check_box(self)
        return self


class AreaLoad(Section):
    """A force on the whole sheet.

    Attributes:
        force_per_area: per area of the reference sheet [N/m²].
    """

    kind: Literal["area"]
    force_per_area: Annotated[tuple[ForcePerArea, ...], _THREE]


class WeightLoad(Section):
    """The weight of the layers, by their densities.

    Attributes:
        gravity: [m/s²].
        direction: in which it pulls; its length does not matter.
    """

    kind: Literal["weight"]
    gravity: Acceleration = STANDARD
    direction: Direction = (0.0, 0.0, -1.0)

    @model_validator(mode="after")
    def _some_direction(self) -> Self:
        some_direction(self.direction)
        return self


Load = Annotated[PointLoad | LineLoad | AreaLoad | WeightLoad, Field(discriminator="kind")]
