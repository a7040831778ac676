"""What a workshop can make of a pattern: widths, pieces, amount of material, symmetry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from sheetmorph.core.errors import InputError

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

    from sheetmorph.design.spec import Design

_EXACT = 0.999
"""A width counts as met from this share of it: contours are polygons."""
_CORNER = 0.35
"""Leftovers below this fraction of a width squared are corners, not narrow places."""


@dataclass(frozen=True)
class Limits:
    """Limits of fabrication.

    Attributes:
        minimum_width: of ribs and gaps of the pattern [m].
        connected: whether the pattern must be of one piece.
        most_inert: share of the sheet that inert material may cover.
        symmetry: order of the rotations that must leave the pattern as it is; 1 for none.

    Raises:
        InputError: a number is out of range.
    """

    minimum_width: float = 2e-3
    connected: bool = False
    most_inert: float = 0.95
    symmetry: int = 1

    def __post_init__(self) -> None:
        for name, low, high in (
            ("minimum_width", 1e-4, 0.1),
            ("most_inert", 0.01, 0.99),
            ("symmetry", 1, 60),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise InputError(
                    "is out of range", key=name, value=value, allowed=f"{low:g} to {high:g}"
                )


@dataclass(frozen=True)
class Made:
    """How a pattern stands to the limits.

    Attributes:
        narrow: share of the pattern, or of the gaps beside it, that is narrower than allowed.
        pieces: how many the pattern has.
        inert: share of the sheet that it covers.
        symmetry: order of the rotations that leave sheet and pattern as they are; None
            where nobody asked for one.
        broken: names of the limits that are not met, with the reason.
    """

    narrow: float
    pieces: int
    inert: float
    symmetry: int | None
    broken: tuple[str, ...]

    def excess(self, limits: Limits) -> float:
        """By how much the limits are missed, 0 where they are met; without unit."""
        loose = max(0, self.pieces - 1) if limits.connected else 0
        uneven = self.symmetry is not None and self.symmetry % limits.symmetry != 0
        much = max(0.0, self.inert - limits.most_inert)
        return self.narrow + much + 0.1 * (loose + uneven)


def measured(design: Design, limits: Limits) -> Made:
    """Hold the pattern of a design against the limits."""
    import shapely

    layout = design.layout
    pattern = layout.pattern
    gaps = shapely.difference(layout.sheet, pattern)
    pieces = len(shapely.get_parts(pattern))
    inert = float(pattern.area / layout.sheet.area)
    least = _EXACT * limits.minimum_width
    narrow = max(narrow_share(pattern, least), narrow_share(gaps, least))
    order = design.symmetry.order if limits.symmetry > 1 else None
    broken = []
    if narrow > 0.0:
        broken.append(
            f"{100 * narrow:.2g} % of the pattern or its gaps is narrower than "
            f"{1e3 * limits.minimum_width:g} mm"
        )
    if limits.connected and pieces > 1:
        broken.append(f"the pattern has {pieces} pieces")
    if inert > limits.most_inert:
        broken.append(
            f"it covers {100 * inert:.1f} % of the sheet, more than {100 * limits.most_inert:g} %"
        )
    if order is not None and order % limits.symmetry:
        broken.append(f"no rotation of order {limits.symmetry} leaves it as it is")
    return Made(narrow, pieces, inert, order, tuple(broken))


def narrow_share(region: BaseGeometry, width: float) -> float:
    """Share of a region that no disc of this diameter [m], rolling inside it, reaches.

    What it leaves in a corner is not counted, down to corners of about 43 degrees.
    """
    import shapely

    if region.area <= 0.0:
        return 0.0
    radius = 0.4995 * width
    core = shapely.buffer(region, -radius, quad_segs=16)
    reached = shapely.buffer(core, 1.002 * radius, quad_segs=16)
    parts = shapely.get_parts(shapely.difference(region, reached))
    left = sum(part.area for part in parts if part.area > _CORNER * width**2)
    return float(left / region.area)
