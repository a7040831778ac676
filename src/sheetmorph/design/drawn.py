"""Shapes that stand in a drawing beside the design file: DXF, SVG, STL or 3MF."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field, PrivateAttr, ValidationInfo, model_validator

from sheetmorph.core.errors import InputError
from sheetmorph.design import files
from sheetmorph.design.fields import Flag, Quantity, problem
from sheetmorph.design.shapes import MAX_POINTS, Shape

if TYPE_CHECKING:
    from pydantic_core import PydanticCustomError
    from shapely.geometry.base import BaseGeometry

    from sheetmorph.drawing.model import Drawing as FlatDrawing

FLATNESS = 5e-6
"""Arcs and splines are replaced by chords that leave them by no more than this [m]."""

Selection = Annotated[str, Field(min_length=1, max_length=200, pattern=r"^[^\x00-\x1f\x7f]+$")]


class Drawing(Shape):
    """What a drawing shows, or what it shows on one layer.

    Attributes:
        file: name of the drawing in the folder of the design file.
        select: layer of a DXF; id, label, class or colour in an SVG; object of a 3MF.
        unit: of the drawing's numbers, where it names none or the wrong one.
        strokes: True when the strokes of an SVG are ribs as wide as they are drawn.
        overlaps: what to do with closed contours that cross.
        gap: ends of contours closer than this are joined [m].
    """

    kind: Literal["drawing"]
    file: Annotated[str, Field(min_length=1, max_length=200)]
    select: Selection | None = None
    unit: str | None = None
    strokes: Flag = False
    overlaps: Literal["error", "union"] = "error"
    gap: Annotated[float, Quantity("length", "0 mm", "10 mm")] = 1e-5

    _area: Any = PrivateAttr(default=None)
    _notes: Any = PrivateAttr(default=())

    @model_validator(mode="after")
    def _read(self, info: ValidationInfo) -> Self:
        import shapely

        drawing = self._open(info)
        try:
            region = drawing.region(self.select, strokes=self.strokes, overlaps=self.overlaps)
        except InputError as error:
            raise told(error, self.file, "select") from None
        corners = shapely.get_num_coordinates(region.shape)
        if corners > MAX_POINTS:
            raise problem(
                f"{self.file}: has {corners} corners; draw it with fewer points",
                key="file",
                allowed=f"≤ {MAX_POINTS}",
            )
        self._area = region.shape
        self._notes = tuple(f"{self.file}: {note}" for note in (*drawing.notes, *region.notes))
        return self

    def notes(self) -> tuple[str, ...]:
        """What was closed, joined, converted or left out in reading, with coordinates."""
        notes: tuple[str, ...] = self._notes
        return notes

    def _open(self, info: ValidationInfo) -> FlatDrawing:
        folder = info.context
        if not isinstance(folder, Path):
            raise problem(
                "the design has no folder in which to look for it", key="file", value=self.file
            )
        try:
            path = files.path_inside(folder, self.file, "file")
            stamp = path.stat()
            return _read(path, self.unit, self.gap, stamp.st_mtime_ns, stamp.st_size)
        except InputError as error:
            raise told(error, self.file, "file") from None

    def polygon(self) -> BaseGeometry:
        """The areas of the drawing [m]."""
        area: BaseGeometry = self._area
        return area

    def wkb(self) -> bytes:
        """What the drawing shows, as bytes that only change with it."""
        import shapely

        shown: bytes = shapely.to_wkb(self.polygon(), byte_order=1)
        return shown


@lru_cache(maxsize=16)
def _read(path: Path, unit: str | None, gap: float, modified: int, size: int) -> FlatDrawing:
    """A drawing is read once for all shapes that stand in it, as long as it does not change."""
    from sheetmorph.drawing.read import read_drawing

    return read_drawing(path, unit=unit, flatness=FLATNESS, gap=gap)


def told(error: InputError, file: str, key: str) -> PydanticCustomError:
    """A problem with the drawing as a problem of the design."""
    place = error.key if error.key in ("unit", "gap", "overlaps", "select", "strokes") else key
    return problem(f"{file}: {error.message}", key=place, value=error.value, allowed=error.allowed)
