"""Pictures of the flat sheet that are laid on the deformed one: regions and outlines.

The pattern is drawn from its exact outline, so its rim is sharp on any mesh.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.show.scene import Image

if TYPE_CHECKING:
    from PIL.Image import Image as PillowImage
    from PIL.ImageDraw import ImageDraw
    from shapely.geometry.base import BaseGeometry

    from sheetmorph.show.cells import PaintedCell

SIDE = 800
"""Pixels along the longer side of a texture."""
_FINE = 2
_MARGIN = 0.01

REGIONS, UNDER_REGIONS, OUTLINE, PLAIN = range(4)
"""Indices of the textures that `textures` makes."""


class Patch:
    """The rectangle of the plane that the textures cover.

    Args:
        mesh: the flat sheet.
    """

    def __init__(self, mesh: SheetMesh) -> None:
        low, high = mesh.nodes[:, :2].min(axis=0), mesh.nodes[:, :2].max(axis=0)
        margin = _MARGIN * float((high - low).max())
        self.low = low - margin
        self.span = high - low + 2 * margin
        scale = SIDE / float(self.span.max())
        self.size = (
            max(2, int(np.ceil(self.span[0] * scale))),
            max(2, int(np.ceil(self.span[1] * scale))),
        )

    def uv(self, points: Floats) -> Floats:
        """Places of points (N, ≥ 2) [m] in the texture, 0 to 1 from the lower left, (N, 2)."""
        return np.asarray((points[:, :2] - self.low) / self.span)

    def pixels(self, points: Floats) -> list[tuple[float, float]]:
        """Places of points (N, ≥ 2) [m] in the finely drawn texture."""
        uv = self.uv(points)
        x, y = uv[:, 0] * self.size[0] * _FINE, (1.0 - uv[:, 1]) * self.size[1] * _FINE
        return list(zip(x.tolist(), y.tolist(), strict=True))


def textures(
    mesh: SheetMesh, triangle_cell: NDArray[np.intp], cells: Sequence[PaintedCell]
) -> tuple[Floats, tuple[Image, ...]]:
    """Textures of a sheet.

    Args:
        mesh: the flat sheet.
        triangle_cell: index of the cell in which each triangle lies, shape (T,).
        cells: what to paint, the film first; a cell without area is painted triangle by
            triangle.

    Returns:
        The places of the nodes in the textures, shape (V, 2), and the textures: the cells
        seen from above, the same from below, only their outlines, and plain white.
    """
    from PIL import Image as Pillow
    from PIL import ImageDraw

    patch = Patch(mesh)
    size = (patch.size[0] * _FINE, patch.size[1] * _FINE)
    images = []
    for side, ink in (("colour", (40, 52, 64)), ("under", (105, 120, 134)), ("", (20, 20, 20))):
        paper = getattr(cells[0], side) if side else (255, 255, 255)
        picture = Pillow.new("RGB", size, paper)
        pen = ImageDraw.Draw(picture)
        for index, cell in enumerate(cells):
            if index == 0 or not side:
                continue
            if cell.area.is_empty:
                for corners in mesh.nodes[mesh.triangles[triangle_cell == index]]:
                    pen.polygon(patch.pixels(corners), fill=getattr(cell, side))
            else:
                picture.paste(getattr(cell, side), mask=_mask(patch, size, cell.area))
        rings = [ring for cell in cells[1:] for ring, _ in rings_of(cell.area)]
        _outline(pen, patch, mesh, rings, ink)
        images.append(np.asarray(picture.reduce(_FINE)))
    plain = np.full((2, 2, 3), 255, dtype=np.uint8)
    return patch.uv(mesh.nodes), (*images, plain)


def _mask(patch: Patch, size: tuple[int, int], area: BaseGeometry) -> PillowImage:
    """White where an area lies, its holes left black."""
    from PIL import Image as Pillow
    from PIL import ImageDraw

    mask = Pillow.new("L", size, 0)
    pen = ImageDraw.Draw(mask)
    for ring, hole in rings_of(area):
        pen.polygon(patch.pixels(ring), fill=0 if hole else 255)
    return mask


def _outline(
    pen: ImageDraw,
    patch: Patch,
    mesh: SheetMesh,
    rings: list[Floats],
    ink: tuple[int, int, int],
) -> None:
    for ring in rings:
        pen.line(patch.pixels(ring), fill=ink, width=3 * _FINE, joint="curve")
    interior = np.zeros(len(mesh.edges), dtype=bool)
    interior[mesh.hinge_edges[:, 0]] = True
    for ends in mesh.nodes[mesh.edges[~interior]]:
        pen.line(patch.pixels(ends), fill=ink, width=5 * _FINE)


def rings_of(pattern: Any) -> list[tuple[Floats, bool]]:
    """Rings of a polygon or several, each with whether it is a hole.

    What lies within a ring comes after it.
    """
    import shapely

    if pattern is None or pattern.is_empty:
        return []
    parts = [part for part in getattr(pattern, "geoms", [pattern]) if part.geom_type == "Polygon"]
    rings = []
    for part in sorted(parts, key=lambda part: -shapely.Polygon(part.exterior).area):
        rings.append((np.asarray(part.exterior.coords), False))
        rings.extend((np.asarray(hole.coords), True) for hole in part.interiors)
    return rings
