"""What a reader is asked for and what it hands back: items by their names, within bounds."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.contours import cleaned
from sheetmorph.drawing.model import Curve, DrawnItem, DrawnLayer, Floats
from sheetmorph.drawing.notes import Budget, Notes, at

UNITS: dict[str, float] = {
    "um": 1e-6,
    "mm": 1e-3,
    "cm": 1e-2,
    "dm": 1e-1,
    "m": 1.0,
    "mil": 2.54e-5,
    "in": 0.0254,
    "ft": 0.3048,
    "px": 0.0254 / 96.0,
    "pt": 0.0254 / 72.0,
}
"""Lengths [m] of the units that a drawing may be said to have."""

MAX_COORDINATE = 1e4
MAX_NAMES = 50_000
MAX_NAME_LENGTH = 200


@dataclass(frozen=True)
class Request:
    """How to read: the unit if the user gave one, the tolerances [m], the notes and bounds."""

    unit: str | None
    flatness: float
    gap: float
    notes: Notes = field(default_factory=Notes)
    budget: Budget = field(default_factory=Budget)

    @property
    def scale(self) -> float | None:
        """Length of the unit that the user gave [m], or None."""
        return None if self.unit is None else UNITS[self.unit]

    def curve(self, points: Floats, closed: bool) -> Curve | None:
        """A cleaned curve, or None when it has no length.

        Raises:
            InputError: a point is not finite or farther than 10 km away.
        """
        if not (np.abs(points) <= MAX_COORDINATE).all():
            bad = points[np.argmax(~(np.abs(points) <= MAX_COORDINATE).all(axis=1))]
            place = at(bad) if np.isfinite(bad).all() else "a coordinate that is not finite"
            raise InputError(f"a point lies out of bounds, at {place}", allowed="within 10 km")
        return cleaned(points, closed, self.notes)


class Contents:
    """Items under the names that select them."""

    def __init__(self) -> None:
        self.items: list[DrawnItem] = []
        self._named: dict[str, tuple[str, list[DrawnItem]]] = {}

    def add(self, item: DrawnItem, names: Iterable[tuple[str, str]]) -> None:
        """Add an item with its names, each a pair (kind, name)."""
        self.items.append(item)
        for name, kind in {name[:MAX_NAME_LENGTH]: kind for kind, name in names if name}.items():
            self._named.setdefault(name, (kind, []))[1].append(item)
        if len(self._named) > MAX_NAMES:
            raise InputError("the drawing has too many names", allowed=f"≤ {MAX_NAMES}")

    @property
    def layers(self) -> dict[str, DrawnLayer]:
        """The items by name."""
        return {
            name: DrawnLayer(name, kind, tuple(items))
            for name, (kind, items) in self._named.items()
        }


def unit_name(length: float) -> str:
    """The name of a unit of some length [m], or the length in mm."""
    for name, value in UNITS.items():
        if math.isclose(length, value, rel_tol=1e-6):
            return name
    return f"{1e3 * length:.6g} mm"


def check_extent(items: Sequence[DrawnItem], unit: float) -> None:
    """Refuse a drawing that is smaller than 0.5 mm or larger than 10 m.

    Args:
        items: what is drawn [m].
        unit: the length of a unit of the file that was assumed [m].

    Raises:
        InputError: names a unit that would give a sheet of a usual size.
    """
    points = [curve.points for item in items for curve in item.curves]
    if not points:
        raise InputError("nothing that can be read is drawn in it")
    width, height = np.ptp(np.vstack(points), axis=0).tolist()
    size = max(width, height)
    if 0.5e-3 <= size <= 10.0:
        return
    fits = [
        name for name in ("mm", "cm", "in", "m", "um") if 0.01 <= size / unit * UNITS[name] <= 1.0
    ]
    hint = f"did you draw in {fits[0]}? set unit = {fits[0]!r}" if fits else "check its unit"
    small = size < 0.5e-3
    shown = f"{1e3 * size:.3g} mm" if small else f"{size:.4g} m"
    what = "wide" if width >= height else "high"
    raise InputError(
        f"the drawing is {shown} {what}; {hint}", key="unit", allowed="between 0.5 mm and 10 m"
    )
