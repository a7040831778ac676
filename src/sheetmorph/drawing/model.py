"""What a drawing is: curves with the names by which they can be selected."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError, nearest
from sheetmorph.drawing.colours import colour_hex

if TYPE_CHECKING:
    from shapely import MultiLineString, MultiPolygon

Floats = NDArray[np.float64]
Overlaps = Literal["error", "union"]
FillRule = Literal["evenodd", "nonzero"]

MAX_NAMES_SHOWN = 12


@dataclass(frozen=True)
class Curve:
    """A flattened curve.

    `points` has shape (N, 2) [m]; a closed curve does not repeat its first point.
    """

    points: Floats
    closed: bool

    @property
    def path(self) -> Floats:
        """The points from end to end; a closed curve comes back to its first point."""
        return np.vstack([self.points, self.points[:1]]) if self.closed else self.points


@dataclass(frozen=True)
class Pen:
    """The stroke of an element, in the element's own coordinates.

    `curves` are in those coordinates and `matrix`, shape (2, 3), takes them to metres:
    a pen under an uneven scale draws an uneven line.
    """

    curves: tuple[Curve, ...]
    matrix: Floats
    width: float
    cap: Literal["butt", "round", "square"]
    join: Literal["miter", "round", "bevel"]
    miter_limit: float


@dataclass(frozen=True)
class DrawnItem:
    """One drawn thing: its curves, the rule by which they are filled, and its stroke.

    Without `fill` the curves are contours or lines.
    """

    curves: tuple[Curve, ...]
    fill: FillRule | None = None
    pen: Pen | None = None


@dataclass(frozen=True)
class DrawnLayer:
    """The items that carry one name; `kind` says what the name is (layer, id, colour, …)."""

    name: str
    kind: str
    items: tuple[DrawnItem, ...]


@dataclass(frozen=True)
class Region:
    """The area of a selection [m] and what was mended, united or dropped to get it."""

    shape: MultiPolygon
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Drawing:
    """A drawing in the plane, in metres, y upward.

    Attributes:
        items: everything that is drawn, in the order of the file.
        layers: the same items by every name that selects them.
        notes: what was closed, converted or ignored in reading; coordinates in mm.
        unit: the length of one unit of the file, such as "mm".
        gap: ends of lines that are no farther apart [m] are joined.
        flatness: how far a flattened curve may be from the true one [m].
        file: the file, for messages.
    """

    items: tuple[DrawnItem, ...]
    layers: Mapping[str, DrawnLayer]
    notes: tuple[str, ...]
    unit: str
    gap: float = 1e-5
    flatness: float = 5e-6
    file: str = field(default="", compare=False)

    def area(
        self, select: str | None = None, *, strokes: bool = False, overlaps: Overlaps = "error"
    ) -> MultiPolygon:
        """The area of a selection [m]; `region` gives the notes as well.

        Filled elements are areas by their fill-rule and are united. Contours nest: outer,
        hole, island. With `strokes`, a stroke is a rib as wide as its pen.

        Args:
            select: name of a layer (DXF), an id, label, class or colour (SVG), the name of
                an object (3MF); None for everything.
            strokes: read the strokes of an SVG as ribs rather than as contours.
            overlaps: what to do with contours that cross: refuse them or unite their areas.

        Raises:
            InputError: nothing has that name; a contour is open, crosses itself or another;
                nothing is closed.
        """
        return self.region(select, strokes=strokes, overlaps=overlaps).shape

    def region(
        self, select: str | None = None, *, strokes: bool = False, overlaps: Overlaps = "error"
    ) -> Region:
        """The area of a selection with the notes of its making; see `area`."""
        from shapely.errors import GEOSException

        from sheetmorph.drawing.areas import region_of

        if overlaps not in ("error", "union"):
            raise InputError("no such choice for overlaps", value=overlaps, allowed="error, union")
        try:
            return region_of(
                self._selected(select), self.gap, self.flatness, strokes=strokes, overlaps=overlaps
            )
        except InputError as error:
            raise self._located(error, select) from error.__cause__
        except (GEOSException, MemoryError) as error:
            raise self._located(
                InputError("the shapes are too tangled to be united; simplify them"), select
            ) from error

    def lines(self, select: str | None = None) -> MultiLineString:
        """The lines of a selection [m], joined where ends meet; closed ones come back.

        Raises:
            InputError: nothing has that name, or it holds no lines.
        """
        import shapely

        from sheetmorph.drawing.contours import joined
        from sheetmorph.drawing.notes import Notes

        try:
            curves = [curve for item in self._selected(select) for curve in item.curves]
            curves = joined(curves, self.gap, Notes())
            if not curves:
                raise InputError("no lines are drawn here")
        except InputError as error:
            raise self._located(error, select) from error.__cause__
        return shapely.MultiLineString([shapely.LineString(curve.path) for curve in curves])

    def _selected(self, select: str | None) -> tuple[DrawnItem, ...]:
        if select is None:
            return self.items
        if not isinstance(select, str):
            raise InputError("a selection is a name", value=select)
        colour = colour_hex(select)
        for name in (select, colour):
            if name is not None and name in self.layers:
                return self.layers[name].items
        alike = [name for name in self.layers if name.casefold() == select.casefold()]
        if len(alike) == 1:
            return self.layers[alike[0]].items
        names = sorted(self.layers, key=lambda name: (name.startswith("#"), name))
        hint = nearest(select, names)
        shown = ", ".join(names[:MAX_NAMES_SHOWN]) or "nothing has a name"
        if len(names) > MAX_NAMES_SHOWN:
            shown += f", … ({len(names)} names)"
        raise InputError(
            "nothing in the drawing has that name" + (f"; did you mean {hint!r}?" if hint else ""),
            value=select,
            allowed=shown,
        )

    def _located(self, error: InputError, select: str | None) -> InputError:
        where = error.key or (None if select is None else repr(select)[:80])
        return InputError(
            error.message,
            file=error.file or self.file or None,
            key=where,
            value=error.value,
            allowed=error.allowed,
        )
