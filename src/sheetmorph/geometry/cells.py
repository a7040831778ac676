"""The cells into which regions divide a sheet, without parts too thin for the mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sheetmorph.geometry.features import THIN, TooThinError, areas_only
from sheetmorph.geometry.plan import Plan
from sheetmorph.geometry.sizing import SizeField, UniformSize

if TYPE_CHECKING:
    from shapely import Geometry

# In units of the wanted edge length:
SPECK = 1.0  # thin parts with more area than this are an error, smaller ones are absorbed
BLUR = 0.01  # offsetting a polyline and back moves it by less than this
COINCIDENT = 0.05  # boundaries of different regions closer than this become one
PRECISE = 1e-9  # grid on which cells are cut


def resolved(plan: Plan, size: SizeField) -> Plan:
    """The plan without parts and gaps too thin for the mesh; lengths in edge lengths.

    The regions divide the sheet into cells. Parts of a cell thinner than `THIN` go to the
    cell beside them: first those of the film, then those of the regions. Only specks are
    treated so, and slivers between nearly coincident boundaries of different regions.
    Specks at a locked line stay: beyond it they go on, and both sides must keep their
    junctions.

    Returns:
        The plan, its regions replaced by one disjoint region per cell.

    Raises:
        InputError: a thin part or gap is larger than a speck, or a hole of the outline
            or a neck of the sheet is too thin to mesh.
    """
    import shapely

    outline = plan.outline
    for ring in outline.interiors:
        _check_room(shapely.Polygon(ring), 0.0, "a hole of the outline is", size)
    _check_room(outline, SPECK, "the sheet is", size)
    regions = [region for region in plan.regions if not region.is_empty]
    if len(regions) == 1:
        return plan.with_regions((_one_resolved(plan, regions[0], size.finest),))
    for region in regions:
        _check_thin(region, SPECK, "the pattern is", size.finest)
        film = areas_only(shapely.difference(outline, region, grid_size=PRECISE))
        _check_thin(film, SPECK, "the film beside the pattern is", size.finest)
    return plan.with_regions(_cells_resolved(plan, regions, size.finest))


def _one_resolved(plan: Plan, pattern: Geometry, unit: float) -> Geometry:
    import shapely

    film = areas_only(shapely.difference(plan.outline, pattern, grid_size=PRECISE))
    gaps = _check_thin(film, SPECK, "the film beside the pattern is", unit)
    gaps = _away_from(gaps, plan.locked)
    if not gaps.is_empty:
        film = _without(film, gaps, unit)
        pattern = areas_only(shapely.difference(plan.outline, film, grid_size=PRECISE))
    slivers = _check_thin(pattern, SPECK, "the pattern is", unit)
    slivers = _away_from(slivers, plan.locked)
    return pattern if slivers.is_empty else _without(pattern, slivers, unit)


def _cells_resolved(plan: Plan, regions: list[Geometry], unit: float) -> tuple[Geometry, ...]:
    """Disjoint cells within the regions, the film left out."""
    import shapely

    cells = [plan.outline]  # the first one becomes the film
    for region in regions:
        inside = [shapely.intersection(cell, region, grid_size=PRECISE) for cell in cells]
        cells = [shapely.difference(cell, region, grid_size=PRECISE) for cell in cells]
        cells += inside
    cells = [areas_only(cell) for cell in cells]
    film, rest = cells[0], [cell for cell in cells[1:] if cell.area > PRECISE]
    cells = [film, *rest]
    for k in range(len(cells)):
        what = "a part between the boundaries of the pattern is" if k else "the film is"
        thin = _check_thin(cells[k], SPECK, what, unit, COINCIDENT)
        for part in shapely.get_parts(_away_from(thin, plan.locked)):
            if part.is_empty:
                continue
            cut = part.buffer(1.1 * BLUR * unit, join_style="mitre")
            near = cut.buffer(2.0 * BLUR * unit)
            contact = [
                -1.0 if other == k else shapely.area(shapely.intersection(cell, near))
                for other, cell in enumerate(cells)
            ]
            best = max(range(len(cells)), key=contact.__getitem__)
            if contact[best] <= 0.0:
                continue
            moved = shapely.intersection(cells[k], cut, grid_size=PRECISE)
            cells[k] = areas_only(shapely.difference(cells[k], cut, grid_size=PRECISE))
            joined = shapely.union_all([cells[best], moved], grid_size=PRECISE)
            cells[best] = areas_only(joined)
    return tuple(cell for cell in cells[1:] if not cell.is_empty)


def _away_from(parts: Geometry, lines: Geometry) -> Geometry:
    import shapely

    pieces = shapely.get_parts(parts)
    return shapely.unary_union(pieces[~shapely.dwithin(pieces, lines, 2.0 * BLUR)])


def _without(shape: Geometry, thin: Geometry, unit: float) -> Geometry:
    import shapely

    cut = thin.buffer(1.1 * BLUR * unit, join_style="mitre")
    return areas_only(shapely.difference(shape, cut, grid_size=PRECISE))


def _check_room(shape: Geometry, limit: float, what: str, size: SizeField) -> None:
    """Check the thin parts of a shape, each with the edge length wanted there."""
    import shapely

    if isinstance(size, UniformSize):
        _check_thin(shape, limit, what, size.finest)
        return
    for part in thin_parts(shape, size.coarsest):
        # Edges are shortest at one of its vertices or where a marked line passes.
        unit = float(size.at(shapely.get_coordinates(shapely.segmentize(part, 0.5))).min())
        close = shape.intersection(part.buffer(2.0 * size.coarsest))
        _check_thin(close, limit, what, unit)


def _check_thin(
    shape: Geometry, limit: float, what: str, unit: float, coincident: float = 0.0
) -> Geometry:
    """Thin parts of a shape; an error above `limit` area unless they are hardly there at all."""
    import shapely

    parts = thin_parts(shape, unit)
    for part in parts:
        if part.area > limit * unit**2:
            if coincident and part.buffer(-0.5 * coincident * unit).is_empty:
                continue
            at = part.representative_point()
            raise TooThinError(what, (at.x, at.y), 2.0 * part.area / part.length, unit)
    return shapely.unary_union(parts) if parts else shapely.Polygon()


def thin_parts(shape: Geometry, unit: float) -> list[Geometry]:
    """Parts of a shape that a disc of diameter `THIN` units cannot reach."""
    import shapely

    options = {"join_style": "mitre", "mitre_limit": 10.0}
    reach = 0.5 * THIN * unit
    opened = shape.buffer(-reach, **options).buffer(reach, **options)
    blurred = opened.buffer(BLUR * unit, join_style="mitre")
    thin = shapely.difference(shape, blurred, grid_size=PRECISE)
    return [part for part in shapely.get_parts(thin) if part.area > 1e-10]
