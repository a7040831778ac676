"""The mesh of a design, and which way its hinges run."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.core.units import scale_of
from sheetmorph.design.distance import signed_distance
from sheetmorph.design.layout import place
from sheetmorph.design.regions import hinge_face
from sheetmorph.geometry.mesh import Floats, SheetMesh

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

    from sheetmorph.design.regions import Regions
    from sheetmorph.design.spec import Design

AREA_TOLERANCE = 0.05
SPECK = 0.1
"""Pieces of the pattern smaller than the square of this times the mesh size may get lost."""
_TIE = 1e-6


def build_mesh(design: Design) -> SheetMesh:
    """The reference mesh of a design, see `Design.build_mesh`."""
    path = design.resolve_mesh_path()
    if path is None:
        try:
            mesh = _remembered(_Wanted(design, _what_decides(design)))
        except InputError as error:
            key = {None: "mesh.size", "slits": "outline.slits"}.get(error.key, error.key)
            raise InputError(
                error.message, file=design.file, key=key, value=error.value, allowed=error.allowed
            ) from None
        if design.spec.mesh.pattern_smoothing is None:
            _check_follows(design, mesh)
    else:
        from sheetmorph.geometry.files import read_mesh

        source = design.spec.mesh
        mesh = read_mesh(path, scale_of(source.unit, "length"), curved=source.curved)
        _check_fits(design, mesh)
    smeared = design.spec.mesh.pattern_smoothing is not None
    if hinge_orientation(design, path) == "away_from_pattern" and not smeared:
        mesh = mesh.with_hinges_reversed(farther_side(mesh, design.pattern_polygon()) < 0)
    return mesh


@dataclass(frozen=True)
class _Wanted:
    """A design, equal to all others that want the same mesh."""

    design: Design = field(compare=False)
    decides: tuple[object, ...]


def _what_decides(design: Design) -> tuple[object, ...]:
    """All that `_make` reads, to the last bit; the symmetry follows from the shapes."""
    layout, source = design.layout, design.spec.mesh
    parts = [] if source.pattern_smoothing else list(layout.parts.values())
    shapes = tuple(shape.wkb for shape in (layout.sheet, layout.slits, *parts))
    return shapes, source.size, source.boundary_size, source.growth, source.symmetry


@lru_cache(maxsize=4)
def _remembered(wanted: _Wanted) -> SheetMesh:
    """The same mesh for designs that differ in their layers or actuation alone, as in a sweep."""
    return _make(wanted.design)


def _make(design: Design) -> SheetMesh:
    """A mesh of the plan, with the symmetry of the design where that is wanted.

    It does not follow a pattern with a smeared boundary, so that it stays when the pattern moves.
    """
    from sheetmorph.geometry.generate import generate_mesh
    from sheetmorph.geometry.symmetric_mesh import symmetric_mesh

    source, layout = design.spec.mesh, design.layout
    assert source.size is not None  # noqa: S101  the schema wants a size or a file
    parts = [] if source.pattern_smoothing else list(layout.parts.values())
    slits = None if layout.slits.is_empty else layout.slits
    size, near, growth = source.size, source.boundary_size, source.growth
    kind = source.symmetry
    if kind == "none" or (kind == "auto" and design.symmetry.trivial):
        return generate_mesh(
            layout.sheet, parts, size, slits=slits, boundary_size=near, growth=growth
        )
    return symmetric_mesh(
        layout.sheet,
        parts,
        size,
        design.symmetry,
        slits=slits,
        boundary_size=near,
        growth=growth,
        wanted="full" if kind == "auto" else kind,
    )


def _check_follows(design: Design, mesh: SheetMesh) -> None:
    """Refuse a mesh in which a piece of the pattern has no triangle."""
    import shapely

    size = design.spec.mesh.boundary_size or design.spec.mesh.size or 0.0
    centres = shapely.points(mesh.triangle_centroids)
    for name, part in design.layout.parts.items():
        pieces = shapely.get_parts(part)
        hit, _ = shapely.STRtree(centres).query(pieces, predicate="contains")
        lost = np.setdiff1d(np.flatnonzero(shapely.area(pieces) > (SPECK * size) ** 2), hit)
        if len(lost):
            at, area = pieces[lost[0]].representative_point(), pieces[lost[0]].area
            more = f" ({len(lost)} such pieces)" if len(lost) > 1 else ""
            raise InputError(
                f"is too coarse for the part {name}: a piece of {1e6 * area:.3g} mm² near "
                f"{place(at.x, at.y)} has no triangle{more}",
                file=design.file,
                key="mesh.size",
                value=f"{1e3 * size:g} mm",
                allowed=f"≤ {1e3 * np.sqrt(area):.2g} mm, or mesh.boundary_size as small as that",
            )


def hinge_orientation(design: Design, path: Path | None) -> str:
    """ "file_order" or "away_from_pattern": as the design says, or by where the mesh is from.

    The default is "file_order" for files that list their edges, and "away_from_pattern"
    for all other meshes, whose edges have no order but that of the numbering.
    """
    given = design.published.hinge_orientation
    if given is not None:
        return given
    return "file_order" if path is not None and _lists_edges(path) else "away_from_pattern"


def farther_side(mesh: SheetMesh, pattern: BaseGeometry) -> NDArray[np.int8]:
    """Which of the nodes c and d of each hinge lies farther from the pattern, shape (H,).

    1 for c, -1 for d, 0 where both lie equally far (to a millionth of the size of the sheet).
    Distance is signed: it is negative within the pattern. Without a pattern, it is that from
    the middle of the sheet. Only positions enter, so no numbering of nodes, no order of edges,
    and no turn or mirror image of the drawing changes the outcome.
    """
    plane = mesh.nodes[:, :2]
    if pattern.is_empty:
        middle = mesh.triangle_areas @ mesh.triangle_centroids / mesh.triangle_areas.sum()
        away = np.linalg.norm(plane - middle, axis=1)
    else:
        away = signed_distance(pattern, plane)
    difference = away[mesh.hinges[:, 2]] - away[mesh.hinges[:, 3]]
    difference[np.abs(difference) <= _TIE * mesh.size] = 0.0
    return np.asarray(np.sign(difference), dtype=np.int8)


def hinge_coupling(design: Design, mesh: SheetMesh, region: Regions) -> Floats:
    """Coupling of each hinge of the published model, beta·l0, shape (H,).

    It is `published.coupling` with the sign of the face on which the inert layers lie, see
    `hinge_face`, but zero where hinges run away from the pattern and both sides of a hinge lie
    equally far from it: such a hinge has no preferred side, and any sign would come from the
    numbering. Where the boundary is smeared the sign turns smoothly.
    """
    coupling = design.published.coupling * hinge_face(mesh, region)
    if region.smooth is not None:
        away = hinge_orientation(design, design.resolve_mesh_path()) == "away_from_pattern"
        return np.asarray(coupling * (region.smooth.hinge_side(mesh) if away else 1.0))
    if hinge_orientation(design, design.resolve_mesh_path()) == "away_from_pattern":
        coupling[farther_side(mesh, design.pattern_polygon()) == 0] = 0.0
    return np.asarray(coupling, dtype=np.float64)


def _lists_edges(path: Path) -> bool:
    if path.suffix.lower() != ".txt":
        return False
    with path.open("rb") as stream:
        return any(line.strip().lower().startswith(b"*edges") for line in stream)


def _check_fits(design: Design, mesh: SheetMesh) -> None:
    """Refuse a mesh of another size or place than the outline: mostly a wrong unit."""
    import shapely

    sheet = design.outline_polygon()
    area = float(mesh.triangle_areas @ mesh.triangle_normals[:, 2])  # in the plan
    bounds = np.concatenate([mesh.nodes[:, :2].min(axis=0), mesh.nodes[:, :2].max(axis=0)])
    shift = float(np.abs(bounds - np.array(sheet.bounds)).max())
    extent = float(np.ptp(np.array(shapely.get_coordinates(sheet)), axis=0).max())
    if abs(area - sheet.area) > AREA_TOLERANCE * sheet.area or shift > AREA_TOLERANCE * extent:
        x0, y0, x1, y1 = (1e3 * float(bound) for bound in bounds)
        u0, v0, u1, v1 = (1e3 * bound for bound in sheet.bounds)
        raise InputError(
            f"the mesh does not fit the outline: it spans x {x0:.4g} to {x1:.4g} mm, "
            f"y {y0:.4g} to {y1:.4g} mm and the outline x {u0:.4g} to {u1:.4g} mm, "
            f"y {v0:.4g} to {v1:.4g} mm; check mesh.unit and the outline",
            file=design.file,
            key="mesh",
        )
