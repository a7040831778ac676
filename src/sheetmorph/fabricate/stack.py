"""The layers as they lie on each other in the flat, assembled sheet."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

    from sheetmorph.design.layout import InertPart
    from sheetmorph.design.sections import Layer
    from sheetmorph.design.spec import Design


@dataclass(frozen=True, eq=False)
class Level:
    """One layer in its place; z = 0 is the underside of the lowest active layer.

    Attributes:
        layer: what it is made of.
        region: its plan [m].
        part: the printed part, or None for a layer that covers the whole sheet.
        low: height of its lower face [m].
        high: height of its upper face [m].
        face: the side of the active film on which it lies; "film" within it.
    """

    layer: Layer
    region: BaseGeometry
    part: InertPart | None
    low: float
    high: float
    face: Literal["bottom", "film", "top"]


def levels_of(design: Design) -> tuple[Level, ...]:
    """The layers from the bottom up, each upon the ones beneath its own part."""
    layers = design.layers
    parts = {part.name: part for part in design.inert_parts}
    active = [index for index, layer in enumerate(layers) if layer.role == "active"]
    first, last = active[0], active[-1]
    found = []
    for index, layer in enumerate(layers):
        part = parts.get(layer.name)
        region = design.outline_polygon() if part is None else part.region
        if index < first:
            high = -_height(layers[index + 1 : first], layer)
            level = Level(layer, region, part, high - layer.thickness, high, "bottom")
        else:
            low = _height(layers[first:index], layer)
            face: Literal["film", "top"] = "film" if index <= last else "top"
            level = Level(layer, region, part, low, low + layer.thickness, face)
        found.append(level)
    return tuple(found)


def check_stack(levels: tuple[Level, ...]) -> list[str]:
    """What cannot lie flat: parts and sheets that lie partly upon parts."""
    told = []
    for face, ordered in (("top", levels), ("bottom", levels[::-1])):
        outward = [level for level in ordered if level.face == face]
        covered = [level.layer.name for level in outward if level.part is None]
        first = next((k for k, level in enumerate(outward) if level.part is not None), None)
        if first is not None and any(level.part is None for level in outward[first:]):
            told.append(
                f"{covered[-1]} covers the whole sheet and lies over {outward[first].layer.name}: "
                "it bridges the places beside that part and is glued to the part alone."
            )
    for one, other in combinations([level for level in levels if level.part is not None], 2):
        if one.face != other.face or one.layer.where == other.layer.where:
            continue
        common = one.region.intersection(other.region)
        if common.area > 1e-9:
            place = common.representative_point()
            told.append(
                f"{one.layer.name} and {other.layer.name} overlap by {1e6 * common.area:.3g} mm² "
                f"near ({1e3 * place.x:.1f}, {1e3 * place.y:.1f}) mm on the same face: the outer "
                "one cannot lie flat; take one away from the other with operation = difference."
            )
    return told


def glued_area(levels: tuple[Level, ...], face: Literal["bottom", "top"]) -> float:
    """Area of the film that is covered by glue on one face [m²]."""
    import shapely

    regions = [level.region for level in levels if level.face == face]
    return float(shapely.union_all(regions).area) if regions else 0.0


def _height(between: tuple[Layer, ...], layer: Layer) -> float:
    """Thickness of the layers between the film and a layer, where that layer lies."""
    return sum(
        other.thickness
        for other in between
        if other.where == "everywhere" or other.where == layer.where
    )
