"""Notes about what reading a drawing changed, and the bounds on its work."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.model import Floats

MAX_NOTES_OF_A_KIND = 20
MAX_VERTICES = 1_000_000
MAX_ENTITIES = 100_000


def at(point: Sequence[float] | Floats) -> str:
    """A position [m] in words: "(1.5, 20) mm"."""
    x, y = (round(1e3 * float(value), 4) + 0.0 for value in point[:2])
    return f"({x:.9g}, {y:.9g}) mm"


def mm(length: float) -> str:
    """A length [m] in words: "0.4 mm"."""
    return f"{1e3 * length:.3g} mm"


class Notes:
    """Collects notes; of each kind the first twenty are kept and the others counted."""

    def __init__(self) -> None:
        self._texts: list[tuple[str, str]] = []
        self._counts: Counter[str] = Counter()

    def add(self, kind: str, text: str) -> None:
        """Note something, once for every equal text."""
        if (kind, text) in self._texts[-MAX_NOTES_OF_A_KIND:]:
            return
        self._counts[kind] += 1
        if self._counts[kind] <= MAX_NOTES_OF_A_KIND:
            self._texts.append((kind, text[:300]))

    @property
    def texts(self) -> tuple[str, ...]:
        """The notes, and for each kind how many more there were."""
        more = [
            f"{kind}: {count - MAX_NOTES_OF_A_KIND} more"
            for kind, count in self._counts.items()
            if count > MAX_NOTES_OF_A_KIND
        ]
        return (*(text for _, text in self._texts), *more)


class Budget:
    """What a drawing may still spend: entities (blocks and clones unfolded) and vertices."""

    def __init__(self) -> None:
        self._entities = MAX_ENTITIES
        self._vertices = MAX_VERTICES

    def entity(self) -> None:
        """Spend one entity.

        Raises:
            InputError: the drawing has too many.
        """
        self._entities -= 1
        if self._entities < 0:
            raise InputError(
                "the drawing has too many elements when its blocks and copies are unfolded",
                allowed=f"≤ {MAX_ENTITIES}",
            )

    def vertices(self, count: float) -> int:
        """Spend vertices before they are made; returns their number.

        Raises:
            InputError: the drawing has too many, or their number is not finite.
        """
        if not count <= self._vertices:
            raise InputError(
                "the drawing needs too many points; draw it simpler, or allow a coarser flatness",
                allowed=f"≤ {MAX_VERTICES} points",
            )
        self._vertices -= int(count)
        return int(count)
