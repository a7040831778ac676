"""Distance from the pattern, and the strain that each edge and triangle wants."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.design.distance import distance_to_boundary
from sheetmorph.design.radial import load_radial
from sheetmorph.design.strain_field import load_field
from sheetmorph.design.strain_table import LEAST, MOST
from sheetmorph.geometry.mesh import Floats, SheetMesh

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

    from sheetmorph.design.regions import Regions
    from sheetmorph.design.smoothing import Cover, SmoothPattern
    from sheetmorph.design.spec import Design

NO_DIRECTION = 1e-9
"""Length of a unit vector, lifted onto the surface, below which it gives no direction."""


def covered_cells(design: Design, region: Regions) -> NDArray[np.bool_]:
    """In which cells of the plan an inert layer of the pattern lies, shape (cells,)."""
    inert = {layer.where for layer in design.layers if layer.role == "inert"}
    return np.array([not inert.isdisjoint(cell.parts) for cell in region.cells], dtype=np.bool_)


def covered_area(design: Design) -> BaseGeometry:
    """The union of the parts of the pattern with an inert layer, within the sheet [m]."""
    import shapely

    inert = {layer.where for layer in design.layers if layer.role == "inert"}
    parts = design.layout.parts
    if inert.issuperset(parts):
        return design.pattern_polygon()
    return shapely.union_all([area for name, area in parts.items() if name in inert])


def edge_distance(design: Design, mesh: SheetMesh, region: Regions) -> tuple[Floats, float]:
    """Distance of each edge's midpoint from the pattern, and the greatest distance.

    The pattern is where its inert layers lie. With `distance = "bilayer_edges"` it is
    measured to the nearest midpoint of an edge in the pattern, and the greatest is that of an
    edge. With "pattern_boundary" it is measured to the boundary of the pattern, and the
    greatest is taken over the nodes too, so that neither depends on the mesh. With a smeared
    boundary both are blended.

    Returns:
        Distances [m], shape (E,), zero in the pattern, and d_max [m].

    Raises:
        InputError: the design has no pattern, or no edge of the mesh lies in it, or all do.
    """
    if region.smooth is not None:
        return np.maximum(region.smooth.edges.signed, 0.0), region.smooth.farthest
    covered = covered_cells(design, region)
    inside = covered[region.edge_cell]
    distances = np.zeros(len(mesh.edges))
    if not inside.any():
        raise InputError(
            "no edge of the mesh has its midpoint in the pattern; make the mesh finer or the "
            "pattern wider",
            key="mesh",
        )
    if inside.all():
        raise InputError("the pattern covers every edge of the mesh, so nothing can shrink")
    distances[~inside] = _distance(design, mesh, inside, mesh.edge_midpoints[~inside])
    farthest = float(distances.max())
    if design.actuation.distance == "bilayer_edges":
        return distances, farthest
    nodes = mesh.nodes[~covered[region.node_cell], :2]
    beyond = distance_to_boundary(covered_area(design), nodes).max() if len(nodes) else 0.0
    return distances, float(max(farthest, beyond))


def _distance(design: Design, mesh: SheetMesh, inside: NDArray[np.bool_], points: Floats) -> Floats:
    """Distance of points outside the pattern from it [m], by the measure of the design."""
    if design.actuation.distance == "bilayer_edges":
        from scipy.spatial import cKDTree

        return np.asarray(cKDTree(mesh.edge_midpoints[inside]).query(points)[0])
    return distance_to_boundary(covered_area(design), points)


def profile(fraction: Floats, kind: str, gamma: float | None = None) -> Floats:
    """Share of the full strain at a fraction of the greatest distance from the pattern.

    (1 − exp(−γ s)) / (1 − exp(−γ)), from 0 at s = 0 to 1 at s = 1; γ → 0 is linear, γ → ∞
    a step. Accurate for every γ ≥ 0.

    Args:
        fraction: s = d/d_max, 0 to 1, any shape.
        kind: "linear", "exponential" or "step".
        gamma: of the exponential profile.
    """
    s = np.asarray(fraction, dtype=np.float64)
    if kind == "step":
        return np.where(s > 0, 1.0, 0.0)
    if kind == "linear" or not gamma or gamma < 1e-17:
        return s.copy()
    return np.asarray(np.expm1(-gamma * s) / np.expm1(-gamma))


def thermal_strain(design: Design, mesh: SheetMesh, region: Regions) -> Floats:
    """Eigenstrain of the edges at full actuation, shape (E,).

    Published model: zero in the pattern, and outside it the free strain `design.eps_pre`
    times the profile; without a pattern the whole sheet has the free strain. Laminate model, and
    a field: that of the triangles beside each edge, see `triangle_eigenstrain`.

    Raises:
        InputError: as for `edge_distance` and `triangle_eigenstrain`.
    """
    if design.laminate or design.actuation.profile == "field":
        return edge_eigenstrain(mesh, triangle_eigenstrain(design, mesh, region))
    if not design.pattern:
        return np.full(len(mesh.edges), design.eps_pre)
    if region.smooth is not None:
        return np.asarray(
            design.eps_pre * _smooth_share(design, region.smooth, region.smooth.edges)
        )
    distances, farthest = edge_distance(design, mesh, region)
    share = profile(distances / farthest, design.actuation.profile, design.actuation.gamma)
    return np.where(region.edge_in_pattern, 0.0, design.eps_pre * share)


def triangle_share(design: Design, mesh: SheetMesh, region: Regions) -> Floats:
    """Share of the free strain that active layers have at each triangle's centroid, (T,).

    1 with a profile that does not depend on the pattern, where no inert layer lies in a part
    of it, and without actuation. Else u + (1 − u) s, with u = `under_pattern` and s the
    profile at the distance from the inert parts, 0 inside them.

    Raises:
        InputError: as for `edge_distance`.
    """
    options = design.actuation
    covered = covered_cells(design, region)
    if options.whole_sheet or not covered.any() or design.eps_pre == 0.0:
        return np.ones(len(mesh.triangles))
    if region.smooth is not None:
        share = _smooth_share(design, region.smooth, region.smooth.triangles)
        return np.asarray(options.under_pattern + (1.0 - options.under_pattern) * share)
    inside = covered[region.triangle_cell]
    _, farthest = edge_distance(design, mesh, region)
    points = mesh.triangle_centroids[~inside]
    distances = _distance(design, mesh, covered[region.edge_cell], points)
    share = np.zeros(len(mesh.triangles))
    share[~inside] = profile(np.minimum(distances / farthest, 1.0), options.profile, options.gamma)
    return np.asarray(options.under_pattern + (1.0 - options.under_pattern) * share)


def _smooth_share(design: Design, smooth: SmoothPattern, cover: Cover) -> Floats:
    """The profile of the blended distance where no inert part covers the sheet, shape (N,)."""
    options = design.actuation
    share = profile(cover.away / smooth.farthest, options.profile, options.gamma)
    return np.asarray((1.0 - cover.covered) * share)


def smooth_share_slopes(
    design: Design, smooth: SmoothPattern, cover: Cover
) -> tuple[Floats, Floats, Floats]:
    """Derivatives of the share of the free strain at places that a smeared pattern covers.

    Returns:
        By the indicator `covered`, by the distance `away` [1/m] and by the greatest distance
        [1/m], shape (N,) each; all zero where the share does not depend on the pattern.
    """
    options = design.actuation
    inert = any(layer.role == "inert" for layer in design.layers)
    if options.whole_sheet or (design.laminate and not inert):
        none = np.zeros(len(cover.covered))
        return none, none, none
    factor = 1.0 - options.under_pattern
    s = cover.away / smooth.farthest
    slope = factor * (1.0 - cover.covered) * _profile_slope(s, options.profile, options.gamma)
    return (
        -factor * profile(s, options.profile, options.gamma),
        slope / smooth.farthest,
        -slope * s / smooth.farthest,
    )


def _profile_slope(fraction: Floats, kind: str, gamma: float | None) -> Floats:
    """Derivative of `profile` by the fraction."""
    if kind == "step":
        return np.zeros_like(fraction)
    if kind == "linear" or not gamma or gamma < 1e-17:
        return np.ones_like(fraction)
    return np.asarray(-gamma * np.exp(-gamma * fraction) / np.expm1(-gamma))


def triangle_eigenstrain(design: Design, mesh: SheetMesh, region: Regions) -> Floats:
    """Free strain of an active layer at full actuation, shape (T, 3).

    The engineering strain tensor (e11, e22, e12) at the centroids, in the axes of
    `SheetMesh.triangle_frames`: those of the plan where the sheet is flat. It is that of a
    layer with `eigenstrain_factor = 1`. Main directions are drawn in the plan and lifted onto
    the surface, along z; where that leaves none, as at the very centre of a radial one, both
    directions have the mean strain.

    Raises:
        InputError: as for `edge_distance`; a table that does not reach a triangle; a strain
            of some layer that is out of range.
    """
    options = design.actuation
    if options.profile == "radial":
        radius = np.linalg.norm(mesh.triangle_centroids - options.centre, axis=1)
        radial, hoop = load_radial(design).at(radius)
        along, across = design.eps_pre * radial, design.eps_pre * hoop
    elif options.profile == "field":
        along = design.eps_pre * load_field(design).at(mesh.triangle_centroids[:, :2])
        across = along
    else:
        along = design.eps_pre * triangle_share(design, mesh, region)
        across = options.transverse * along
    _check_strains(design, along, across)
    return _tensors(design, mesh, along, across)


def whole_strain(design: Design, mesh: SheetMesh) -> Floats:
    """Free strain of triangles whose share of it is 1, as `triangle_eigenstrain`, shape (T, 3)."""
    along = np.full(len(mesh.triangles), design.eps_pre)
    return _tensors(design, mesh, along, design.actuation.transverse * along)


def _tensors(design: Design, mesh: SheetMesh, along: Floats, across: Floats) -> Floats:
    """(e11, e22, e12) of strains along and across the main directions, shape (T, 3)."""
    mean, half = 0.5 * (along + across), 0.5 * (along - across)
    c, s = _main_directions(design, mesh).T
    # With the angle a of the main direction: cos 2a = c² − s², sin 2a = 2 c s.
    return np.column_stack(
        [mean + half * (c * c - s * s), mean - half * (c * c - s * s), half * (2 * c * s)]
    )


def edge_eigenstrain(mesh: SheetMesh, triangle_strain: Floats) -> Floats:
    """Strain along the edges, the mean of that of the triangles beside each, shape (E,).

    Args:
        mesh: the reference mesh.
        triangle_strain: (e11, e22, e12) in `mesh.triangle_frames`, shape (T, 3).
    """
    ends = mesh.nodes[mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]]]
    sides = ends[:, :, 1] - ends[:, :, 0]
    t = np.einsum("tka,tia->tki", sides, mesh.triangle_frames)
    t /= np.linalg.norm(t, axis=2)[:, :, None]
    e11, e22, e12 = (triangle_strain[:, None, k] for k in range(3))
    along = t[..., 0] ** 2 * e11 + t[..., 1] ** 2 * e22 + 2.0 * t[..., 0] * t[..., 1] * e12
    places, count = mesh.triangle_edges.ravel(), len(mesh.edges)
    sums = np.bincount(places, weights=along.ravel(), minlength=count)
    return np.asarray(sums / np.bincount(places, minlength=count), dtype=np.float64)


def _main_directions(design: Design, mesh: SheetMesh) -> Floats:
    """Unit main direction of each triangle in its frame, zero where there is none, (T, 2)."""
    options = design.actuation
    plan = np.zeros((len(mesh.triangles), 3))
    if options.profile == "radial" or options.direction == "radial":
        arms = mesh.triangle_centroids - options.centre
        lengths = np.linalg.norm(arms, axis=1)
        apart = lengths > NO_DIRECTION * mesh.size
        plan[apart, :2] = arms[apart] / lengths[apart, None]
    else:
        plan[:, :2] = np.cos(options.direction), np.sin(options.direction)
    # Tangent above the drawn line, times n_z: it stays well defined where the sheet is steep.
    normals = mesh.triangle_normals
    lifted = plan * normals[:, 2:]
    lifted[:, 2] = -(plan * normals).sum(axis=1)
    local = np.einsum("ta,tia->ti", lifted, mesh.triangle_frames)
    lengths = np.linalg.norm(local, axis=1)
    found = lengths > NO_DIRECTION
    local[found] /= lengths[found, None]
    local[~found] = 0.0
    return np.asarray(local)


def _check_strains(design: Design, *strains: Floats) -> None:
    """Refuse a strain by which a layer would vanish, or grow beyond all use."""
    low = min(float(values.min()) for values in strains)
    high = max(float(values.max()) for values in strains)
    for index, layer in enumerate(design.layers):
        if layer.role != "active":
            continue
        ends = sorted((layer.eigenstrain_factor * low, layer.eigenstrain_factor * high))
        if ends[0] <= LEAST or ends[1] > MOST:
            wrong = ends[0] if ends[0] <= LEAST else ends[1]
            raise InputError(
                f"a free strain of {layer.name} is out of range; make actuation.eps_pre, "
                "actuation.transverse or the factor smaller",
                key=f"layers[{index}].eigenstrain_factor",
                value=float(f"{wrong:.4g}"),
                allowed=f"above {LEAST:g} to {MOST:g}",
            )
