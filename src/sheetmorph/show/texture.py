"""Pictures of the flat sheet that are laid on the deformed one: regions and outlines.

The pattern is drawn from its exact outline, so its rim is sharp on any mesh.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.show.scene import Image
from sheetmorph.show.style import BILAYER, FILM, UNDER_BILAYER, UNDER_FILM

if TYPE_CHECKING:
    from PIL.ImageDraw import ImageDraw

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
    mesh: SheetMesh, in_pattern: NDArray[np.bool_], pattern: Any
) -> tuple[Floats, tuple[Image, ...]]:
    """Textures of a sheet.

    Args:
        mesh: the flat sheet.
        in_pattern: triangles in the pattern, shape (T,).
        pattern: the pattern as a polygon of shapely [m], or None or empty when only the
            triangles are known.

    Returns:
        The places of the nodes in the textures, shape (V, 2), and the textures: the two
        regions seen from above, the same from below, only the outline of the pattern, and
        plain white.
    """
    from PIL import Image as Pillow
    from PIL import ImageDraw

    patch = Patch(mesh)
    size = (patch.size[0] * _FINE, patch.size[1] * _FINE)
    rings = rings_of(pattern)
    images = []
    for film, bilayer in ((FILM, BILAYER), (UNDER_FILM, UNDER_BILAYER), (None, None)):
        picture = Pillow.new("RGB", size, film or (255, 255, 255))
        pen = ImageDraw.Draw(picture)
        if film and bilayer:
            for ring, hole in rings:
                pen.polygon(patch.pixels(ring), fill=film if hole else bilayer)
            if not rings:
                for corners in mesh.nodes[mesh.triangles[in_pattern]]:
                    pen.polygon(patch.pixels(corners), fill=bilayer)
        ink = (40, 52, 64) if film is FILM else (105, 120, 134) if film else (20, 20, 20)
        _outline(pen, patch, mesh, [ring for ring, _ in rings], ink)
        images.append(np.asarray(picture.reduce(_FINE)))
    plain = np.full((2, 2, 3), 255, dtype=np.uint8)
    return patch.uv(mesh.nodes), (*images, plain)


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
    """Rings of a polygon or several, each with whether it is a hole, shells first."""
    if pattern is None or pattern.is_empty:
        return []
    parts = [part for part in getattr(pattern, "geoms", [pattern]) if part.geom_type == "Polygon"]
    rings = []
    for part in sorted(parts, key=lambda part: -part.area):
        rings.append((np.asarray(part.exterior.coords), False))
        rings.extend((np.asarray(hole.coords), True) for hole in part.interiors)
    return rings
