"""The table `actuation` of the design file: how far, where and which way the layers shrink."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from sheetmorph.design.fields import (
    FileName,
    Number,
    Point,
    Quantity,
    Section,
    problem,
)

WHOLE_SHEET = ("uniform", "radial", "field")
"""Profiles that act on the whole sheet, under the pattern too."""
RADIAL, FIELD = "radial", "field"
OF_LAMINATE = ("under_pattern", "transverse", "direction", "centre", "radial_profile")
"""Keys that the published model does not know."""


class Direction(Quantity):
    """Annotation of a main direction: an angle from the x axis, or "radial"."""

    def read(self, value: object) -> Any:
        """The angle [rad], or "radial"; raises a pydantic error for people."""
        if value == RADIAL:
            return RADIAL
        try:
            return super().read(value)
        except PydanticCustomError as error:
            told = error.context or {}
            allowed = f'"{RADIAL}", or an angle from {self.low} to {self.high}'
            raise problem(told["text"], value=value, allowed=allowed) from None


class Actuation(Section):
    """How far the active layers shrink, and how that varies over the sheet.

    Attributes:
        eps_pre: free strain of an unconstrained active layer; negative is shrinkage. With a
            radial profile or a field, the factor on the strains of its table.
        temperature: [K]; gives eps_pre through the shrink curve.
        shrink_curve: "polystyrene" (built in) or the name of a CSV file.
        profile: how the strain grows with the distance from the pattern; "uniform" is the
            whole sheet alike, "radial" a table over the distance from `centre`, "field" a
            table over places.
        gamma: steepness of the exponential profile; 0 is linear, large is a step.
        distance: measured to the nearest midpoint of a bilayer edge (as published), or
            to the boundary of the pattern (does not depend on the mesh).
        under_pattern: share of the free strain that active layers have where inert layers
            of the pattern lie, 0 to 1.
        transverse: strain across the main direction over that along it.
        direction: of the strain `eps_pre`, an angle from the x axis [rad] or "radial".
        centre: of radial directions and profiles [m].
        radial_profile: name of a CSV file with the columns r, e_radial and e_hoop.
        field: name of a CSV file with the columns x, y and strain.
    """

    eps_pre: Annotated[float, Quantity("dimensionless", "-0.95", "1", above=True)] | None = None
    temperature: Annotated[float, Quantity("temperature", "0 K", "3000 K")] | None = None
    shrink_curve: FileName = "polystyrene"
    profile: Literal["linear", "exponential", "step", "uniform", "radial", "field"] = "linear"
    gamma: Annotated[Number, Field(ge=0, le=1e12)] | None = None
    distance: Literal["bilayer_edges", "pattern_boundary"] = "pattern_boundary"
    under_pattern: Annotated[Number, Field(ge=0, le=1)] = 0.0
    transverse: Annotated[Number, Field(ge=-10, le=10)] = 1.0
    direction: Annotated[float | Literal["radial"], Direction("angle", "-360 deg", "360 deg")] = 0.0
    centre: Point = (0.0, 0.0)
    radial_profile: FileName | None = None
    field: FileName | None = None

    @property
    def whole_sheet(self) -> bool:
        """True when the strain does not depend on the pattern."""
        return self.profile in WHOLE_SHEET

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        radial = self.profile == RADIAL
        tabled = self.profile in (RADIAL, FIELD)
        if self.eps_pre is None and self.temperature is None and not tabled:
            raise problem("say how far to actuate", key="eps_pre", allowed="eps_pre or temperature")
        if self.eps_pre is not None and self.temperature is not None:
            raise problem(
                "eps_pre and temperature exclude each other; keep one of them", key="temperature"
            )
        if self.profile == "exponential" and self.gamma is None:
            raise problem("the exponential profile needs a gamma, such as 3.0", key="gamma")
        if self.profile != "exponential" and self.gamma is not None:
            raise problem(
                f"the {self.profile} profile has no gamma; remove it, or choose exponential",
                key="gamma",
            )
        if self.whole_sheet and "under_pattern" in self.model_fields_set:
            raise problem(
                f"the {self.profile} profile does not depend on the pattern; remove it",
                key="under_pattern",
                value=self.under_pattern,
            )
        self._check_radial(radial)
        self._check_field()
        return self

    def _check_field(self) -> None:
        field = self.profile == FIELD
        if field and self.field is None:
            raise problem("the field needs a table", key="field", allowed='"table.csv"')
        if self.field is not None and not field:
            raise problem(
                f"the {self.profile} profile has no field; remove it, or choose field",
                key="field",
                value=self.field,
            )
        for key in ("temperature", "transverse", "direction") if field else ():
            if key in self.model_fields_set and getattr(self, key) is not None:
                raise problem("the table of the field says the strain; remove it", key=key)

    def _check_radial(self, radial: bool) -> None:
        given = self.model_fields_set
        if radial and self.radial_profile is None:
            raise problem(
                "the radial profile needs a table", key="radial_profile", allowed='"table.csv"'
            )
        if self.radial_profile is not None and not radial:
            raise problem(
                f"the {self.profile} profile has no table; remove it, or choose radial",
                key="radial_profile",
                value=self.radial_profile,
            )
        for key in ("temperature", "transverse", "direction") if radial else ():
            if key in given and getattr(self, key) is not None:
                raise problem(
                    "the table of the radial profile says both strains; remove it", key=key
                )
        if "direction" in given and "transverse" not in given:
            raise problem(
                "a direction needs the ratio of the strain across it",
                key="transverse",
                allowed="-10 to 10, such as 0.2",
            )
        if "centre" in given and not radial and self.direction != RADIAL:
            raise problem(
                "belongs to a radial direction or profile; remove it",
                key="centre",
                allowed='with direction = "radial" or profile = "radial"',
            )


NO_ACTUATION = Actuation.model_construct(eps_pre=0.0)
"""What a design has that says nothing: loads alone move its sheet."""
