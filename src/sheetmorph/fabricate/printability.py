"""What a printer cannot make of a part: too narrow, too close, too small, not in whole layers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.fabricate.printer import PrinterProfile

if TYPE_CHECKING:
    from collections.abc import Callable

    from shapely.geometry.base import BaseGeometry

    from sheetmorph.design.layout import InertPart

    Sentence = Callable[["Place"], str]

MAX_TOLD = 4
"""So many places of one kind are named; the others are counted."""

_HALVINGS = 9
_MEASURED = 40
_CORNER = 0.1
"""Leftovers below this fraction of a width squared are corners, not narrow places."""


@dataclass(frozen=True)
class Place:
    """A place in the plan where something is too narrow.

    Attributes:
        x: [m].
        y: [m].
        width: [m].
    """

    x: float
    y: float
    width: float


def check_part(part: InertPart, profile: PrinterProfile) -> list[str]:
    """What the printer will make worse of a part, in sentences; its place on the bed left aside.

    Places are coordinates of the design.
    """
    region, name = part.region, part.name
    least = max(profile.nozzle_width, profile.minimum_feature)
    told = _tell_features(name, narrow_places(region, least), profile, least)
    holes = small_holes(region, 2.5 * profile.nozzle_width)
    gaps = [gap for gap in narrow_places(_around(region, least), least) if not _in_hole(gap, holes)]
    told += _listed(
        gaps,
        lambda place: (
            f"{name}: the gap near {_at(place)} is {_width(place)} wide, narrower than "
            f"{_mm(least)}: its sides {'will' if place.width < profile.nozzle_width else 'may'} "
            "fuse; widen it."
        ),
    )
    told += _listed(
        holes,
        lambda place: (
            f"{name}: the hole at {_at(place)} is {_width(place)} across: holes this "
            f"small close when printed; drill it, or make it {_mm(2.5 * profile.nozzle_width)}."
        ),
    )
    told += _listed(
        touching_points(region),
        lambda place: (
            f"{name}: at {_at(place)} it meets itself in a single point, neither joined nor "
            "apart; widen it there, or move it away."
        ),
    )
    told += _tell_thickness(part, profile)
    pieces = len(region.geoms)
    if pieces > 1:
        told.append(
            f"{name}: consists of {pieces} loose pieces; each is a body of its own in the file, "
            "and the template shows where each belongs."
        )
    return told


def narrow_places(region: BaseGeometry, width: float) -> list[Place]:
    """Where a region of the plane is narrower than `width`, the narrowest first.

    A place is what no square brush of that width can paint without leaving the region;
    pointed corners of the region down to 23 degrees are not counted.

    Args:
        region: polygons [m].
        width: [m].
    """
    left = sorted(_unpainted(region, width), key=lambda piece: -piece.area)
    found = []
    for number, piece in enumerate(left):
        centre = piece.representative_point()
        if number >= _MEASURED:
            # Of very many, the mean width is enough.
            found.append(Place(centre.x, centre.y, min(2.0 * piece.area / piece.length, width)))
            continue
        near = region.intersection(piece.buffer(3.0 * width))
        low, high = 0.0, width
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            if any(other.intersects(piece) for other in _unpainted(near, middle)):
                high = middle
            else:
                low = middle
        found.append(Place(centre.x, centre.y, high))
    return sorted(found, key=lambda place: (place.width, place.x, place.y))


def small_holes(region: BaseGeometry, width: float) -> list[Place]:
    """Holes of a region into which no disc of this diameter [m] goes, the smallest first."""
    import shapely

    rings = [ring for part in shapely.get_parts(region) for ring in part.interiors]
    found = []
    for ring in rings:
        hole = shapely.Polygon(ring)
        low_x, low_y, high_x, high_y = hole.bounds
        if min(high_x - low_x, high_y - low_y) > 3.0 * width:
            continue
        radius = shapely.maximum_inscribed_circle(hole, tolerance=0.01 * width)
        if 2.0 * radius.length < width:
            x, y = radius.coords[0]
            found.append(Place(x, y, 2.0 * radius.length))
    return sorted(found, key=lambda place: (place.width, place.x, place.y))


def touching_points(region: BaseGeometry) -> list[Place]:
    """Where contours of a region touch each other in a point."""
    import shapely

    rings = shapely.get_rings(shapely.get_parts(region))
    one, other = shapely.STRtree(rings).query(rings, predicate="intersects")
    pairs = one < other
    common = shapely.intersection(rings[one[pairs]], rings[other[pairs]])
    points = np.unique(np.round(shapely.get_coordinates(common), 7), axis=0)
    return [Place(x, y, 0.0) for x, y in points.tolist()]


def _unpainted(region: BaseGeometry, width: float) -> list[BaseGeometry]:
    import shapely

    radius = 0.4995 * width
    core = region.buffer(-radius, join_style="mitre", mitre_limit=5.0)
    painted = core.buffer(1.002 * radius, join_style="mitre", mitre_limit=5.0)
    rest = shapely.get_parts(shapely.difference(region, painted))
    return [piece for piece in rest if piece.area > _CORNER * width**2]


def _around(region: BaseGeometry, width: float) -> BaseGeometry:
    import shapely

    return shapely.difference(region.envelope.buffer(4.0 * width), region)


def _in_hole(place: Place, holes: Sequence[Place]) -> bool:
    return any(math.hypot(place.x - h.x, place.y - h.y) <= h.width for h in holes)


def _tell_features(
    name: str, places: Sequence[Place], profile: PrinterProfile, least: float
) -> list[str]:
    nozzle = profile.nozzle_width
    lost = [place for place in places if place.width < 0.999 * nozzle]
    weak = [place for place in places if place.width >= 0.999 * nozzle]
    return _listed(
        lost,
        lambda place: (
            f"{name}: only {_width(place)} wide near {_at(place)}, narrower than the "
            f"nozzle of {_mm(nozzle)}: it will not be printed; make it {_mm(least)} or wider."
        ),
    ) + _listed(
        weak,
        lambda place: (
            f"{name}: only {_width(place)} wide near {_at(place)}: printed as a "
            f"single weak line; make it {_mm(least)} or wider."
        ),
    )


def _tell_thickness(part: InertPart, profile: PrinterProfile) -> list[str]:
    layers = part.thickness / profile.layer_height
    count = max(math.floor(layers + 0.5), 1)
    if abs(layers - count) < 1e-6 * count:
        return []
    finer = math.ceil(layers - 1e-9)
    return [
        (
            f"{part.name}: {_mm(part.thickness)} is no multiple of the layer height "
            f"{_mm(profile.layer_height)}: it becomes {_mm(count * profile.layer_height)} "
            f"({count} {'layer' if count == 1 else 'layers'}); choose layers of "
            f"{1e3 * part.thickness / finer:.3g} mm ({finer} of them) to keep it."
        )
    ]


def _listed(places: Sequence[Place], sentence: Sentence) -> list[str]:
    told = [sentence(place) for place in places[:MAX_TOLD]]
    if len(places) > MAX_TOLD:
        told[-1] += f" ({len(places) - MAX_TOLD} more places like this)"
    return told


def _mm(length: float) -> str:
    return f"{1e3 * length:.3g} mm"


def _width(place: Place) -> str:
    return f"{round(1e3 * place.width, 2):g} mm"


def _at(place: Place) -> str:
    x, y = np.round([1e3 * place.x, 1e3 * place.y], 1) + 0.0
    return f"({x:g}, {y:g}) mm"
