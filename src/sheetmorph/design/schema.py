"""The schema of a whole design file, with the rules that tie its tables together."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from sheetmorph.core.errors import nearest
from sheetmorph.design.fields import MAX_NAME, NAME_PATTERN, Section, problem
from sheetmorph.design.layout import Layout, lay_out
from sheetmorph.design.outlines import Outline, PatternShape
from sheetmorph.design.sections import (
    EVERYWHERE,
    Actuation,
    FreeSupport,
    Layer,
    MeshSource,
    Outputs,
    Perturbation,
    PublishedOptions,
    SolverOptions,
    Support,
)

MAX_LAYERS = 20
MAX_SHAPES = 500
MAX_NODES = 500_000

Name = Annotated[str, Field(min_length=1, max_length=MAX_NAME, pattern=NAME_PATTERN)]


class DesignSchema(Section):
    """A design as the file states it, checked and in SI units."""

    name: Name
    model: Literal["published"] = "published"
    outline: Outline
    pattern: Annotated[tuple[PatternShape, ...], Field(max_length=MAX_SHAPES)] = ()
    layers: Annotated[tuple[Layer, ...], Field(min_length=1, max_length=MAX_LAYERS)]
    actuation: Actuation
    supports: Annotated[tuple[Support, ...], Field(max_length=100)] = ()
    perturbation: Perturbation = Perturbation()
    mesh: MeshSource
    published: PublishedOptions = PublishedOptions()
    solver: SolverOptions = SolverOptions()
    outputs: Outputs = Outputs()

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        _check_layers(self)
        _check_supports(self)
        _check_size(self)
        return self

    @cached_property
    def layout(self) -> Layout:
        """The plan of the sheet that outline and pattern make."""
        return lay_out(self.outline, self.pattern)


def _check_layers(design: DesignSchema) -> None:
    seen: set[str] = set()
    parts = list(dict.fromkeys(piece.part for piece in design.pattern))
    if EVERYWHERE in parts:
        raise problem("is the name of the whole sheet", key="pattern.part", value=EVERYWHERE)
    for index, layer in enumerate(design.layers):
        key = f"layers[{index}]"
        if layer.name in seen:
            raise problem("two layers have the same name", key=f"{key}.name", value=layer.name)
        seen.add(layer.name)
        if layer.where == EVERYWHERE:
            continue
        if layer.role == "active":
            raise problem(
                "an active layer covers the whole sheet",
                key=f"{key}.where",
                value=layer.where,
                allowed=EVERYWHERE,
            )
        if not parts:
            raise problem(
                "this layer lies in a part of the pattern, and the design has none: "
                "add a [[pattern]] shape, or write everywhere",
                key=f"{key}.where",
            )
        if layer.where not in parts:
            guess = nearest(layer.where, [EVERYWHERE, *parts])
            hint = f"; did you mean {guess}?" if guess else ""
            raise problem(
                f"no shape of the pattern belongs to this part{hint}",
                key=f"{key}.where",
                value=layer.where,
                allowed=", ".join([EVERYWHERE, *parts]),
            )
    if not any(layer.role == "active" for layer in design.layers):
        raise problem("no layer is active, so nothing moves", key="layers", allowed="role = active")
    for part in parts:
        if not any(layer.where == part for layer in design.layers):
            raise problem(f"no layer has where = {part}, so it is made of nothing", key="pattern")


def _check_supports(design: DesignSchema) -> None:
    free = [isinstance(support, FreeSupport) for support in design.supports]
    if any(free) and not all(free):
        raise problem(
            "a free sheet has no other support; remove one of the two",
            key=f"supports[{free.index(True)}].kind",
        )
    if (not free or all(free)) and design.perturbation.shape == "uniform":
        raise problem(
            "a uniform force does nothing to a free sheet",
            key="perturbation.shape",
            value="uniform",
            allowed="bowl, or add a [[supports]] table",
        )
    for index, support in enumerate(design.supports):
        if getattr(support, "kind", "") == "pattern_in_box" and not design.pattern:
            raise problem(
                "the design has no pattern to hold", key=f"supports[{index}].kind", allowed="box"
            )


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
