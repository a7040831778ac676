"""The layers as they lie on each other in the flat, assembled sheet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING, Literal

from sheetmorph.core.errors import InputError
from sheetmorph.fabricate.makeable import check_makeable

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

    from sheetmorph.design.layout import InertPart
    from sheetmorph.design.sections import Layer
    from sheetmorph.design.spec import Design

_TOUCHES = 1e-9
"""Layers that share less than this area [m²] do not lie upon each other."""


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
        on: names of the layers to which it is glued, its nearest ones toward the lowest
            active film; empty for that film.
    """

    layer: Layer
    region: BaseGeometry
    part: InertPart | None
    low: float
    high: float
    face: Literal["bottom", "film", "top"]
    on: tuple[str, ...] = ()


def levels_of(design: Design) -> tuple[Level, ...]:
    """The layers from the bottom up, each upon the ones beneath its own part.

    Raises:
        InputError: a part lies between two active films, where it cannot be glued on; or as for
            `check_makeable`.
    """
    check_makeable(design)
    layers = design.layers
    parts = {part.name: part for part in design.inert_parts}
    active = [index for index, layer in enumerate(layers) if layer.role == "active"]
    first, last = active[0], active[-1]
    found = []
    for index, layer in enumerate(layers):
        part = parts.get(layer.name)
        region = design.outline_polygon() if part is None else part.region
        if part is not None and first < index < last:
            raise InputError(
                f"{layer.name} lies between two active films and cannot be glued on from outside, "
                "though it can be computed; move it below the lowest or above the highest active "
                "layer",
                key=f"layers[{index}].where",
                value=layer.where,
                allowed="everywhere, between active layers",
            )
        if index < first:
            high = -_height(layers[index + 1 : first], layer)
            level = Level(layer, region, part, high - layer.thickness, high, "bottom")
        else:
            low = _height(layers[first:index], layer)
            face: Literal["film", "top"] = "film" if index <= last else "top"
            level = Level(layer, region, part, low, low + layer.thickness, face)
        found.append(level)
    for index, level in enumerate(found):
        inward = found[index + 1 : first + 1] if index < first else found[first:index][::-1]
        found[index] = replace(level, on=_carriers(level, inward))
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
        if common.area > _TOUCHES:
            place = common.representative_point()
            told.append(
                f"{one.layer.name} and {other.layer.name} overlap by {1e6 * common.area:.3g} mm² "
                f"near ({1e3 * place.x:.1f}, {1e3 * place.y:.1f}) mm on the same face: the outer "
                "one cannot lie flat; take one away from the other with operation = difference."
            )
    return told


def bonded_first(levels: tuple[Level, ...]) -> tuple[Level, ...]:
    """The whole sheets that lie on whole sheets alone, from the bottom up."""
    names: set[str] = set()
    outward = [level for level in levels if level.face != "bottom"]
    outward += [level for level in levels if level.face == "bottom"][::-1]
    for level in outward:
        if level.part is None and names.issuperset(level.on):
            names.add(level.layer.name)
    return tuple(level for level in levels if level.layer.name in names)


def glued_area(levels: tuple[Level, ...]) -> float:
    """Area of the plan with glue somewhere above it, on the face that has more of it [m²]."""
    import shapely

    regions = {level.layer.name: level.region for level in levels}
    areas = []
    for face in ("bottom", "film", "top"):
        glued = [
            level.region.intersection(shapely.union_all([regions[name] for name in level.on]))
            for level in levels
            if level.face == face and level.on
        ]
        areas.append(float(shapely.union_all(glued).area))
    return max(areas)


def _carriers(level: Level, inward: Sequence[Level]) -> tuple[str, ...]:
    """Names of the layers that a layer touches, of those toward the film, nearest first."""
    found: list[Level] = []
    left = level.region
    for other in inward:
        if left.intersection(other.region).area > _TOUCHES:
            found.append(other)
            left = left.difference(other.region)
    # A whole sheet bridges the places beside the parts on which it lies.
    if level.part is None and found and found[0].part is not None:
        found = [other for other in found if other.part is not None]
    return tuple(other.layer.name for other in found)


def _height(between: tuple[Layer, ...], layer: Layer) -> float:
    """Thickness of the layers between the film and a layer, where that layer lies."""
    return sum(
        other.thickness
        for other in between
        if other.where == "everywhere" or other.where == layer.where
    )
