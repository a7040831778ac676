"""How the cells of a plan are painted: a colour each, by face and by number of parts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.show import style

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

    from sheetmorph.study.result import Result

Colour = tuple[int, int, int]

_BASES: dict[int, Colour] = {1: style.BILAYER, -1: style.BOTTOM, 0: style.BALANCED}
_SIDES = {1: "", -1: " (below)", 0: " (both faces)"}
_WHITE, _BLACK = (255, 255, 255), (0, 0, 0)
_SPREAD = 0.45  # how far the shades of one face reach towards white and black
_FADED = 0.56  # the underside is mixed with so much white


@dataclass(frozen=True, eq=False)
class PaintedCell:
    """One cell of a plan as pictures show it.

    Attributes:
        name: for the legend.
        area: the plan [m]; empty for the film, which is everywhere else.
        colour: seen from above, 0 to 255.
        under: seen from below.
    """

    name: str
    area: BaseGeometry
    colour: Colour
    under: Colour


def painted_cells(result: Result) -> list[PaintedCell]:
    """The cells of a result's plan, the film first, in the order of its regions."""
    cells = result.regions.cells
    faces = [cell.stack.face for cell in cells]
    painted = [PaintedCell("film", cells[0].area, style.FILM, style.UNDER_FILM)]
    for index, (cell, face) in enumerate(zip(cells[1:], faces[1:], strict=True), 1):
        rank, count = faces[1:index].count(face), faces[1:].count(face)
        shade = 2 * _SPREAD * (rank / (count - 1) - 0.5) if count > 1 else 0.0
        colour = _mixed(_BASES[face], _BLACK if shade > 0 else _WHITE, abs(shade))
        name = " + ".join(["film", *cell.parts]) + _SIDES[face]
        painted.append(PaintedCell(name, cell.area, colour, _mixed(colour, _WHITE, _FADED)))
    return painted


def triangle_colours(result: Result) -> NDArray[np.float64]:
    """Colours of the triangles seen from above, 0 to 1, shape (T, 3)."""
    table = np.array([cell.colour for cell in painted_cells(result)]) / 255.0
    return np.asarray(table[result.regions.triangle_cell])


def _mixed(colour: Colour, other: Colour, share: float) -> Colour:
    r, g, b = (round((1 - share) * a + share * c) for a, c in zip(colour, other, strict=True))
    return r, g, b
