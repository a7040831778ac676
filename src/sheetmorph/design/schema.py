"""The schema of a whole design file, with the rules that tie its tables together."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator

from sheetmorph.design.fields import MAX_NAME, NAME_PATTERN, Section, problem
from sheetmorph.design.sections import (
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
from sheetmorph.design.shapes import Outline, PatternShape

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

MAX_LAYERS = 20
MAX_SHAPES = 500
MAX_NODES = 500_000
EDGE_TOLERANCE = 2e-4
"""How far a pattern may reach past the sheet, as a fraction of the sheet's diagonal."""

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
        _check_geometry(self)
        return self


def outline_polygon(design: DesignSchema) -> Polygon:
    """The outline of the sheet [m], circles as inscribed polygons."""
    return design.outline.polygon()


def pattern_polygon(design: DesignSchema, clipped: bool = True) -> MultiPolygon:
    """The union of the pattern's shapes [m]; empty without a pattern.

    Args:
        design: the validated file.
        clipped: cut the union off at the outline of the sheet.
    """
    import shapely

    if not design.pattern:
        return shapely.MultiPolygon()
    inside = shapely.union_all([shape.polygon() for shape in design.pattern])
    if clipped:
        inside = shapely.intersection(inside, design.outline.polygon())
    parts = [part for part in shapely.get_parts(inside) if isinstance(part, shapely.Polygon)]
    return shapely.MultiPolygon([part for part in parts if part.area > 0])


def _check_layers(design: DesignSchema) -> None:
    seen: set[str] = set()
    for index, layer in enumerate(design.layers):
        key = f"layers[{index}]"
        if layer.name in seen:
            raise problem("two layers have the same name", key=f"{key}.name", value=layer.name)
        seen.add(layer.name)
        if layer.role == "active" and layer.where == "pattern":
            raise problem(
                "an active layer covers the whole sheet",
                key=f"{key}.where",
                value=layer.where,
                allowed="everywhere",
            )
        if layer.where == "pattern" and not design.pattern:
            raise problem(
                "this layer lies in the pattern, and the design has none: "
                "add a [[pattern]] shape, or write everywhere",
                key=f"{key}.where",
            )
    if not any(layer.role == "active" for layer in design.layers):
        raise problem("no layer is active, so nothing moves", key="layers", allowed="role = active")
    if design.pattern and not any(layer.where == "pattern" for layer in design.layers):
        raise problem(
            "no layer has where = pattern, so the pattern is made of nothing", key="pattern"
        )


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


def _check_geometry(design: DesignSchema) -> None:
    import shapely

    if "clip" in design.outline.model_fields_set:
        raise problem("clip belongs to pattern shapes", key="outline.clip")
    sheet = design.outline.polygon()
    x_low, y_low, x_high, y_high = sheet.bounds
    diagonal = math.hypot(x_high - x_low, y_high - y_low)
    grown = sheet.buffer(EDGE_TOLERANCE * diagonal, join_style="mitre")
    shapely.prepare(grown)
    for index, shape in enumerate(design.pattern):
        piece = shape.polygon()
        if not piece.intersects(sheet) or piece.intersection(sheet).area < 1e-12:
            raise problem("lies outside the sheet", key=f"pattern[{index}]")
        if not shape.clip and not grown.covers(piece):
            excess = shapely.hausdorff_distance(shapely.union(piece, sheet), sheet)
            raise problem(
                f"reaches {1e3 * excess:.3g} mm past the edge of the sheet",
                key=f"pattern[{index}]",
                allowed="a shape inside the outline, or clip = true to cut it off there",
            )
    if design.pattern and pattern_polygon(design).area > 0.999 * sheet.area:
        raise problem("covers the whole sheet, so nothing is free to shrink", key="pattern")
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
