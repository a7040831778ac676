"""Checks of an outline and a pattern against the mesh size, before any meshing."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from shapely import Geometry, Polygon

    from sheetmorph.geometry.plan import Plan

MAX_MESH_NODES = 500_000
# In units of the wanted edge length:
THIN = 0.4  # parts narrower than this have no room for a good triangle
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
            f"the pattern reaches outside the outline near {place_name(at.x, at.y)}; "
            "shorten it or clip it to the outline"
        )
    return areas_only(pattern.intersection(outline))


def checked_lines(lines: Geometry | None, what: str) -> Geometry:
    """Lines without the points that an intersection may leave, or an InputError."""
    import shapely

    if lines is None or lines.is_empty:
        return shapely.MultiLineString()
    _check_geometry(
        lines,
        what,
        ("LineString", "MultiLineString", "LinearRing", "GeometryCollection"),
        "a line or lines",
    )
    if lines.geom_type == "LinearRing":
        lines = shapely.LineString(lines)
    parts = [part for part in shapely.get_parts(lines) if part.geom_type == "LineString"]
    return shapely.MultiLineString([part for part in parts if part.length > 0.0])


def check_grading(size: float, boundary_size: float | None, growth: float, plan: Plan) -> None:
    """Raise an InputError when edges cannot grow this way or there would be too many of them."""
    if boundary_size is None:
        return
    usable = _is_number(boundary_size) and size / 20 <= boundary_size * (1 + 1e-9)
    if not usable or boundary_size > size * (1 + 1e-9):
        known = _mm(boundary_size) if _is_number(boundary_size) else boundary_size
        raise InputError(
            "the edge length at the boundaries of the pattern does not suit the mesh size",
            value=known,
            allowed=f"{_mm(size / 20)} to {_mm(size)}",
        )
    if not (_is_number(growth) and 0.05 <= growth <= 1.0):
        raise InputError(
            "the growth of the edges with the distance from the pattern is not usable",
            value=growth,
            allowed="0.05 to 1",
        )
    # Integral of the density of nodes over strips on both sides of the lines, without overlap.
    strips = 2.0 * plan.marked_lines().length * (1.0 / boundary_size - 1.0 / size) / growth
    area = plan.outline.area
    most = area / boundary_size**2
    expected = min(strips + area / size**2, most) / math.sqrt(0.75)
    if expected > MAX_MESH_NODES:
        raise InputError(
            f"the mesh would have up to {expected:.3g} nodes",
            value=f"boundary size {_mm(boundary_size)}",
            allowed=f"at most {MAX_MESH_NODES} nodes; choose a larger boundary size or growth",
        )


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and math.isfinite(value)


def check_size(size: float, outline: Polygon) -> None:
    """Raise an InputError when a mesh of this size is impossible or far too large."""
    import shapely

    if not (_is_number(size) and size > 0.0):
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


class TooThinError(InputError):
    """A part too thin for the mesh, still in units of the edge length.

    Attributes:
        what: the part, and "is".
        place: where it is.
        width: how wide it is.
        unit: wanted edge length there.
    """

    def __init__(
        self, what: str, place: tuple[float, float], width: float, unit: float = 1.0
    ) -> None:
        super().__init__(f"{what} too thin for the mesh size")
        self.what, self.place, self.width, self.unit = what, place, width, unit

    def in_metres(self, size: float, origin: Floats) -> InputError:
        """The error for people, lengths in millimetres."""
        x, y = (float(origin[k]) + size * self.place[k] for k in (0, 1))
        width, local = size * self.width, size * self.unit
        return InputError(
            f"{self.what} only about {_mm(width)} wide near {place_name(x, y)}, "
            "too thin for the mesh",
            value=f"size {_mm(local)}",
            allowed=f"size ≤ {_mm(width / THIN)}",
        )


class TooCloseError(TooThinError):
    """Lines too close to each other for the mesh, still in units of the edge length."""

    def in_metres(self, size: float, origin: Floats) -> InputError:
        """The error for people, lengths in millimetres."""
        x, y = (float(origin[k]) + size * self.place[k] for k in (0, 1))
        return InputError(
            f"{self.what} run or end too close to each other or to a boundary near "
            f"{place_name(x, y)}; join them, move them apart or choose a smaller size",
            value=f"size {_mm(size * self.unit)}",
            allowed=f"at least {_mm(size * self.width)} apart, or touching",
        )


def _check_geometry(
    shape: Geometry, what: str, kinds: tuple[str, ...], wanted: str = "a polygon"
) -> None:
    import numpy as np
    import shapely

    if not isinstance(shape, shapely.Geometry) or (
        shape.geom_type not in kinds and not shape.is_empty
    ):
        kind = getattr(shape, "geom_type", type(shape).__name__)
        raise InputError(f"the {what} must be {wanted}", value=kind, allowed=", ".join(kinds))
    if not np.isfinite(shapely.get_coordinates(shape)).all():
        raise InputError(f"the {what} has a coordinate that is not a finite number")
    if not shape.is_valid:
        reason = shapely.is_valid_reason(shape)
        raise InputError(f"the {what} is not a valid polygon: {reason} (coordinates in m)")


def areas_only(shape: Geometry) -> Geometry:
    """A shape without the points and lines that an intersection may leave."""
    import shapely

    parts = [part for part in shapely.get_parts(shape) if part.geom_type == "Polygon"]
    return shapely.unary_union(parts) if parts else shapely.Polygon()


def _mm(length: float) -> str:
    return f"{length * 1e3:.3g} mm"


def place_name(x: float, y: float) -> str:
    """A place [m] for people."""
    return f"({x * 1e3:.4g}, {y * 1e3:.4g}) mm"
