"""Which parts of the pattern lie where: cells of the plan, and the parts of a mesh in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.design.distance import contains, distance_to_boundary
from sheetmorph.design.laminate import LayerStack, film_stack, stack_of
from sheetmorph.design.smoothing import SmoothPattern, smooth_pattern
from sheetmorph.geometry.mesh import Floats, SheetMesh

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

    from sheetmorph.design.spec import Design

Bools = NDArray[np.bool_]

TOLERANCE = 1e-9
"""Width of a cell's boundary, as a fraction of the size of the sheet."""
MAX_CELLS = 500


@dataclass(frozen=True, eq=False)
class Cell:
    """Where the same parts of the pattern lie one on the other.

    Attributes:
        parts: their names, in the order of the design; empty for the film alone.
        area: the plan [m], as drawn: it may reach past the rim of the sheet.
        stack: the layers there.
    """

    parts: tuple[str, ...]
    area: BaseGeometry
    stack: LayerStack


@dataclass(frozen=True, eq=False)
class Regions:
    """In which cell each part of a mesh lies.

    On the boundary between cells, an edge or node belongs to the stiffer one: that with the
    larger flexural rigidity. The boundary of the pattern so belongs to the pattern.

    Attributes:
        cells: the film first, then the others from the least to the most rigid.
        edge_cell: index of the cell of each edge, by its midpoint, shape (E,).
        triangle_cell: of each triangle, by its centroid, shape (T,).
        hinge_cell: of each hinge, by its edge, shape (H,).
        node_cell: of each node, by its position, shape (V,).
        smooth: the same with a smeared boundary; None where it is sharp.
    """

    cells: tuple[Cell, ...]
    edge_cell: NDArray[np.intp]
    triangle_cell: NDArray[np.intp]
    hinge_cell: NDArray[np.intp]
    node_cell: NDArray[np.intp]
    smooth: SmoothPattern | None = None

    @cached_property
    def edge_in_pattern(self) -> Bools:
        """Edges in any part of the pattern, its boundary included, shape (E,)."""
        return np.asarray(self.edge_cell > 0)

    @cached_property
    def triangle_in_pattern(self) -> Bools:
        """Triangles in any part of the pattern, shape (T,)."""
        return np.asarray(self.triangle_cell > 0)

    @cached_property
    def node_in_pattern(self) -> Bools:
        """Nodes in any part of the pattern, its boundary included, shape (V,)."""
        return np.asarray(self.node_cell > 0)


def regions(design: Design, mesh: SheetMesh) -> Regions:
    """Sort the parts of a mesh of the design into the cells of its plan."""
    return replace(classify(mesh, cells(design)), smooth=smooth_pattern(design, mesh))


def cells(design: Design) -> tuple[Cell, ...]:
    """The cells of a design's plan: the film, then the others by their flexural rigidity."""
    import shapely

    film = Cell((), shapely.Polygon(), film_stack(design))
    laid = [
        Cell(parts, area, stack_of(design, parts))
        for parts, area in overlay(design.layout.drawn).items()
    ]
    return film, *sorted(laid, key=lambda cell: cell.stack.flexural_rigidity)


def overlay(drawn: Mapping[str, BaseGeometry]) -> dict[tuple[str, ...], BaseGeometry]:
    """Divide the plan into areas that do not overlap, by which parts cover them.

    Raises:
        InputError: more than `MAX_CELLS` different combinations of parts.
    """
    import shapely

    from sheetmorph.core.errors import InputError

    found: dict[tuple[str, ...], BaseGeometry] = {}
    for name, area in drawn.items():
        rest, split = area, {}
        for parts, cell in found.items():
            common = _areas(shapely.intersection(cell, area))
            if common.is_empty:
                split[parts] = cell
                continue
            split[(*parts, name)] = common
            alone = _areas(shapely.difference(cell, area))
            if not alone.is_empty:
                split[parts] = alone
            rest = shapely.difference(rest, cell)
        rest = _areas(rest)
        if not rest.is_empty:
            split[(name,)] = rest
        found = split
        if len(found) > MAX_CELLS:
            raise InputError(
                "the parts of the pattern overlap in too many ways",
                key="pattern",
                allowed=f"≤ {MAX_CELLS} combinations",
            )
    return found


def classify(mesh: SheetMesh, cells: Sequence[Cell]) -> Regions:
    """Sort the parts of a mesh into cells, the last one that holds them.

    Args:
        mesh: the reference mesh.
        cells: the film first; cells that come later win on common boundaries.
    """
    width = TOLERANCE * mesh.size

    def locate(points: Floats) -> NDArray[np.intp]:
        found = np.zeros(len(points), dtype=np.intp)
        for index, cell in enumerate(cells[1:], 1):
            found[contains(cell.area, points, width)] = index
        return found

    edges = locate(mesh.edge_midpoints)
    return Regions(
        cells=tuple(cells),
        edge_cell=edges,
        triangle_cell=locate(mesh.triangle_centroids),
        hinge_cell=edges[mesh.hinge_edges[:, 0]],
        node_cell=locate(mesh.nodes[:, :2]),
    )


def hinge_face(mesh: SheetMesh, region: Regions) -> NDArray[np.int8]:
    """On which face of the film the inert layers at or next to each hinge lie, shape (H,).

    1 for the top, −1 for the bottom, 0 where they balance. A hinge in the film takes the face
    of the nearest cell of the pattern, and 0 where cells of different faces are equally near
    (to a millionth of the size of the sheet). A sheet turned over so gets the mirrored shape.
    Without a pattern all are 1.
    """
    faces = np.array([cell.stack.face for cell in region.cells], dtype=np.int8)
    if len(faces) == 1:
        return np.ones(len(mesh.hinges), dtype=np.int8)
    found = faces[region.hinge_cell]
    alone = np.flatnonzero(region.hinge_cell == 0)
    kinds = np.unique(faces[1:])
    if len(kinds) == 1:
        found[alone] = kinds[0]
        return found
    points = mesh.edge_midpoints[mesh.hinge_edges[alone, 0]]
    away = np.full((len(kinds), len(alone)), np.inf)
    for cell, face in zip(region.cells[1:], faces[1:], strict=True):
        row = np.searchsorted(kinds, face)
        away[row] = np.minimum(away[row], distance_to_boundary(cell.area, points))
    nearest = np.sort(away, axis=0)
    tied = nearest[1] - nearest[0] <= 1e-6 * mesh.size
    found[alone] = np.where(tied, 0, kinds[away.argmin(axis=0)])
    return found


def _areas(shape: BaseGeometry) -> BaseGeometry:
    """A shape without the points and lines that an overlay may leave."""
    import shapely

    parts = [
        part
        for part in shapely.get_parts(shape)
        if isinstance(part, shapely.Polygon) and part.area > 1e-14
    ]
    return shapely.MultiPolygon(parts)
