"""Checks of an outline and a pattern against the mesh size, before any meshing."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from shapely import Geometry, Polygon

MAX_MESH_NODES = 500_000
# In units of the wanted edge length:
THIN = 0.4  # parts narrower than this have no room for a good triangle
SPECK = 1.0  # thin parts with more area than this are an error, smaller ones are absorbed
BLUR = 0.01  # offsetting a polyline and back moves it by less than this
OVERHANG = 1e-3  # a pattern may reach this far outside the outline; it is clipped


def checked_outline(outline: Geometry) -> Polygon:
    """The outline as one valid polygon, or an InputError that says what is wrong."""
    _check_geometry(outline, "outline", ("Polygon",))
    if outline.is_empty or not outline.area > 0.0:
        raise InputError("the outline is empty: it encloses no area")
    return outline


def checked_pattern(pattern: Geometry, outline: Polygon, size: float) -> Geometry:
    """The pattern clipped to the outline, or an InputError that says what is wrong."""
    import shapely

    _check_geometry(pattern, "pattern", ("Polygon", "MultiPolygon"))
    if pattern.is_empty:
        return shapely.Polygon()
    outside = pattern.difference(outline.buffer(OVERHANG * size, join_style="mitre"))
    if not outside.is_empty:
        at = outside.representative_point()
        raise InputError(
            f"the pattern reaches outside the outline near {_place(at.x, at.y)}; "
            "shorten it or clip it to the outline"
        )
    return _areas_only(pattern.intersection(outline))


def check_size(size: float, outline: Polygon) -> None:
    """Raise an InputError when a mesh of this size is impossible or far too large."""
    import shapely

    if not (isinstance(size, (int, float)) and math.isfinite(size) and size > 0.0):
        raise InputError("the mesh size must be a positive length", value=size)
    expected = outline.area / (math.sqrt(0.75) * size**2)
    if expected > MAX_MESH_NODES:
        smallest = math.sqrt(outline.area / (math.sqrt(0.75) * MAX_MESH_NODES))
        raise InputError(
            f"the mesh would have about {expected:.3g} nodes",
            value=f"size {_mm(size)}",
            allowed=f"at most {MAX_MESH_NODES} nodes, size ≥ {_mm(smallest)}",
        )
    radius = shapely.maximum_inscribed_circle(outline, tolerance=0.05 * size)
    width = 2.0 * shapely.length(radius)
    if width < 0.9 * size:
        raise InputError(
            "the mesh size is too large for the outline",
            value=f"size {_mm(size)}",
            allowed=f"≤ {_mm(width)}, the widest circle that fits inside",
        )


def resolved(outline: Polygon, pattern: Geometry) -> Geometry:
    """The pattern without parts and gaps too thin for the mesh; lengths in edge lengths.

    Gaps (film between pattern and pattern or rim) thinner than `THIN` are filled, then
    parts of the pattern thinner than that are removed. Only specks are treated so.

    Raises:
        InputError: a thin part or gap is larger than a speck, or a hole of the outline
            or a neck of the sheet is too thin to mesh.
    """
    import shapely

    for ring in outline.interiors:
        _check_thin(shapely.Polygon(ring), 0.0, "a hole of the outline is")
    _check_thin(outline, SPECK, "the sheet is")
    if pattern.is_empty:
        return pattern
    film = _areas_only(shapely.difference(outline, pattern, grid_size=1e-9))
    gaps = _check_thin(film, SPECK, "the film beside the pattern is")
    if not gaps.is_empty:
        film = _without(film, gaps)
        pattern = _areas_only(shapely.difference(outline, film, grid_size=1e-9))
    slivers = _check_thin(pattern, SPECK, "the pattern is")
    if not slivers.is_empty:
        pattern = _without(pattern, slivers)
    return pattern


def _without(shape: Geometry, thin: Geometry) -> Geometry:
    import shapely

    cut = thin.buffer(1.1 * BLUR, join_style="mitre")
    return _areas_only(shapely.difference(shape, cut, grid_size=1e-9))


def _check_thin(shape: Geometry, limit: float, what: str) -> Geometry:
    """Parts of a shape that a disc of diameter `THIN` cannot reach; error above `limit` area."""
    import shapely

    options = {"join_style": "mitre", "mitre_limit": 10.0}
    opened = shape.buffer(-0.5 * THIN, **options).buffer(0.5 * THIN, **options)
    thin = shapely.difference(shape, opened.buffer(BLUR, join_style="mitre"), grid_size=1e-9)
    parts = [part for part in shapely.get_parts(thin) if part.area > 1e-10]
    for part in parts:
        if part.area > limit:
            at = part.representative_point()
            raise TooThinError(what, (at.x, at.y), 2.0 * part.area / part.length)
    return shapely.unary_union(parts) if parts else shapely.Polygon()


class TooThinError(InputError):
    """A part too thin for the mesh, still in units of the edge length."""

    def __init__(self, what: str, place: tuple[float, float], width: float) -> None:
        super().__init__(f"{what} too thin for the mesh size")
        self.what, self.place, self.width = what, place, width

    def in_metres(self, size: float, origin: Floats) -> InputError:
        """The error for people, lengths in millimetres."""
        x, y = (float(origin[k]) + size * self.place[k] for k in (0, 1))
        width = size * self.width
        return InputError(
            f"{self.what} only about {_mm(width)} wide near {_place(x, y)}, too thin for the mesh",
            value=f"size {_mm(size)}",
            allowed=f"size ≤ {_mm(width / THIN)}",
        )


def _check_geometry(shape: Geometry, what: str, kinds: tuple[str, ...]) -> None:
    import numpy as np
    import shapely

    if not isinstance(shape, shapely.Geometry) or (
        shape.geom_type not in kinds and not shape.is_empty
    ):
        kind = getattr(shape, "geom_type", type(shape).__name__)
        raise InputError(f"the {what} must be a polygon", value=kind, allowed=", ".join(kinds))
    if not np.isfinite(shapely.get_coordinates(shape)).all():
        raise InputError(f"the {what} has a coordinate that is not a finite number")
    if not shape.is_valid:
        reason = shapely.is_valid_reason(shape)
        raise InputError(f"the {what} is not a valid polygon: {reason} (coordinates in m)")


def _areas_only(shape: Geometry) -> Geometry:
    """A shape without the points and lines that an intersection may leave."""
    import shapely

    parts = [part for part in shapely.get_parts(shape) if part.geom_type == "Polygon"]
    return shapely.unary_union(parts) if parts else shapely.Polygon()


def _mm(length: float) -> str:
    return f"{length * 1e3:.3g} mm"


def _place(x: float, y: float) -> str:
    return f"({x * 1e3:.4g}, {y * 1e3:.4g}) mm"
