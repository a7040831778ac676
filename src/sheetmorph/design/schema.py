"""The schema of a whole design file, with the rules that tie its tables together."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from sheetmorph.design.actuation_table import NO_ACTUATION, Actuation
from sheetmorph.design.fields import MAX_NAME, NAME_PATTERN, Section, problem
from sheetmorph.design.layout import Layout, lay_out
from sheetmorph.design.load_tables import Load
from sheetmorph.design.outlines import Outline, PatternShape
from sheetmorph.design.rules import (
    check_layers,
    check_model,
    check_smoothing,
    check_supports,
)
from sheetmorph.design.rules_of_surroundings import check_surroundings
from sheetmorph.design.sections import (
    LaminateOptions,
    Layer,
    MeshSource,
    Outputs,
    Perturbation,
    PublishedOptions,
    SolverOptions,
)
from sheetmorph.design.support_tables import Support
from sheetmorph.design.surroundings import NO_CONTACT, Contact, Gravity

MAX_LAYERS = 20
MAX_SHAPES = 500
MAX_NODES = 500_000

Name = Annotated[str, Field(min_length=1, max_length=MAX_NAME, pattern=NAME_PATTERN)]


class DesignSchema(Section):
    """A design as the file states it, checked and in SI units."""

    name: Name
    model: Literal["published", "laminate"] = "published"
    outline: Outline
    pattern: Annotated[tuple[PatternShape, ...], Field(max_length=MAX_SHAPES)] = ()
    layers: Annotated[tuple[Layer, ...], Field(min_length=1, max_length=MAX_LAYERS)]
    actuation: Actuation = NO_ACTUATION
    supports: Annotated[tuple[Support, ...], Field(max_length=100)] = ()
    loads: Annotated[tuple[Load, ...], Field(max_length=100)] = ()
    gravity: Gravity | None = None
    contact: Contact = NO_CONTACT
    perturbation: Perturbation = Perturbation()
    mesh: MeshSource
    published: PublishedOptions = PublishedOptions()
    laminate: LaminateOptions = LaminateOptions()
    solver: SolverOptions = SolverOptions()
    outputs: Outputs = Outputs()

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        check_model(self)
        check_layers(self)
        check_supports(self)
        check_smoothing(self)
        check_surroundings(self)
        _check_size(self)
        return self

    @cached_property
    def layout(self) -> Layout:
        """The plan of the sheet that outline and pattern make."""
        return lay_out(self.outline, self.pattern)


def _check_size(design: DesignSchema) -> None:
    sheet = design.layout.sheet
    x_low, y_low, x_high, y_high = sheet.bounds
    size = design.mesh.size
    if size is not None:
        nodes = sheet.area / (size * size * math.sqrt(3) / 2)
        if nodes > MAX_NODES:
            least = math.sqrt(sheet.area / (MAX_NODES * math.sqrt(3) / 2))
            raise problem(
                f"would make about {nodes:.2g} nodes, more than {MAX_NODES}",
                key="mesh.size",
                allowed=f"≥ {1e3 * least:.2g} mm for this sheet",
            )
        shorter = min(x_high - x_low, y_high - y_low)
        if size > shorter / 2:
            raise problem(
                "is too coarse for this sheet",
                key="mesh.size",
                allowed=f"≤ {1e3 * shorter / 2:.3g} mm, half its shorter side",
            )
