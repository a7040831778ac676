"""Lines on and between the two rays that bound a sector of a sheet."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from shapely import Geometry, LineString, Polygon

# In lengths of the rays:
NEAR = 1e-7  # lines this close to a ray lie on it,
LONG = 1e-5  # when they are at least this long


def along(lines: Geometry, rays: list[LineString]) -> list[LineString]:
    """The parts of lines that lie on a ray, exactly there."""
    import shapely

    found = []
    for ray in rays:
        near = NEAR * ray.length
        vertices = shapely.points(shapely.get_coordinates(lines))
        known = shapely.line_locate_point(ray, vertices[shapely.dwithin(vertices, ray, near)])
        known = np.append(known, 0.0)
        for part in of_kind(lines.intersection(ray.buffer(near)), "LineString"):
            at = shapely.line_locate_point(ray, shapely.points(part.coords))
            ends = np.array([at.min(), at.max()])
            if np.ptp(ends) > LONG * ray.length:
                # A line that bends off leaves the ribbon a little after its vertex.
                gap = np.abs(known[:, None] - ends)
                ends = np.where(gap.min(axis=0) < 20 * near, known[gap.argmin(axis=0)], ends)
                found.append(shapely.LineString(shapely.line_interpolate_point(ray, ends)))
    return found


def on_each(parts: list[LineString], rays: list[LineString]) -> list[LineString]:
    """Different parts of rays, each on every ray."""
    import shapely

    spans: dict[tuple[int, int], Floats] = {}
    for part in parts:
        span = np.sort(np.linalg.norm(shapely.get_coordinates(part), axis=1))
        low, high = np.round(span / (LONG * rays[0].length)).astype(int).tolist()
        spans.setdefault((low, high), span)
    return [
        shapely.LineString(shapely.line_interpolate_point(ray, span))
        for ray in rays
        for span in spans.values()
    ]


def between(lines: Geometry, wedge: Polygon, rays: list[LineString]) -> list[LineString]:
    """The parts of lines inside a wedge and on no ray; those that reach a ray end exactly there."""
    import shapely

    near = NEAR * rays[0].length
    inside = lines.intersection(wedge.buffer(near))
    for ray in rays:
        inside = inside.difference(ray.buffer(near))
    parts = of_kind(inside, "LineString")
    for ray in rays:
        parts = [shapely.snap(part, _feet(part, ray, 3.0 * near), 3.0 * near) for part in parts]
    return [part for part in parts if part.length > LONG * rays[0].length]


def _feet(line: LineString, ray: LineString, near: float) -> Geometry:
    """The points of a ray next to those ends of a line that are close to it."""
    import shapely

    ends = shapely.points(shapely.get_coordinates(line)[[0, -1]])
    ends = ends[shapely.dwithin(ends, ray, near)]
    at = shapely.line_locate_point(ray, ends)
    return shapely.multipoints(shapely.line_interpolate_point(ray, at))


def faces_between(lines: Geometry, piece: Polygon) -> tuple[Geometry | None, list[Polygon]]:
    """The lines that leave a piece whole, and the faces between those that cut it, all but one.

    A slit from ray to ray cuts a sector but not the sheet; it is meshed as a boundary.
    """
    import shapely

    inside = of_kind(lines.intersection(piece.buffer(NEAR * piece.length)), "LineString")
    inside = [part for part in inside if part.length > LONG * piece.length]
    if not inside:
        return None, []
    noded = shapely.union_all([piece.boundary, *inside], grid_size=1e-9 * piece.length)
    faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(noded)))
    faces = faces[shapely.contains(piece, shapely.point_on_surface(faces))]
    if len(faces) < 2:
        return shapely.MultiLineString(inside), []
    near = NEAR * piece.length
    cuts = shapely.union_all(shapely.boundary(faces)).difference(piece.boundary.buffer(near))
    left = shapely.MultiLineString(inside).difference(cuts.buffer(2.0 * near))
    parts = [part for part in of_kind(left, "LineString") if part.length > LONG * piece.length]
    return (shapely.MultiLineString(parts) if parts else None), list(faces[:-1])


def of_kind(shape: Geometry, kind: str) -> list[Geometry]:
    """The parts of a shape of one kind, without what else an intersection may leave."""
    import shapely

    parts = shapely.get_parts(shape)
    return [part for part in parts if part.geom_type == kind and not part.is_empty]
