"""Distance from the pattern, and the strain each edge wants."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.design.distance import distance_to_boundary
from sheetmorph.geometry.mesh import Floats, SheetMesh

if TYPE_CHECKING:
    from sheetmorph.design.regions import Regions
    from sheetmorph.design.spec import Design


def edge_distance(design: Design, mesh: SheetMesh, region: Regions) -> tuple[Floats, float]:
    """Distance of each edge's midpoint from the pattern, and the greatest distance.

    With `distance = "bilayer_edges"` it is measured to the nearest midpoint of an edge in
    the pattern, and the greatest is that of an edge. With "pattern_boundary" it is
    measured to the boundary of the pattern, and the greatest is taken over the nodes too,
    so that neither depends on the mesh.

    Returns:
        Distances [m], shape (E,), zero in the pattern, and d_max [m].

    Raises:
        InputError: the design has no pattern, or no edge of the mesh lies in it, or all do.
    """
    inside = region.edge_in_pattern
    distances = np.zeros(len(mesh.edges))
    if not inside.any():
        raise InputError(
            "no edge of the mesh has its midpoint in the pattern; make the mesh finer or the "
            "pattern wider",
            key="mesh",
        )
    if inside.all():
        raise InputError("the pattern covers every edge of the mesh, so nothing can shrink")
    outside = mesh.edge_midpoints[~inside]
    if design.actuation.distance == "bilayer_edges":
        from scipy.spatial import cKDTree

        distances[~inside] = cKDTree(mesh.edge_midpoints[inside]).query(outside)[0]
        return distances, float(distances.max())
    pattern = design.pattern_polygon()
    distances[~inside] = distance_to_boundary(pattern, outside)
    nodes = mesh.nodes[~region.node_in_pattern, :2]
    farthest = distance_to_boundary(pattern, nodes).max() if len(nodes) else 0.0
    return distances, float(max(distances.max(), farthest))


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

    Zero in the pattern, and outside it the free strain `design.eps_pre` times the
    profile. Without a pattern the whole sheet has the free strain.

    Raises:
        InputError: as for `edge_distance`.
    """
    if not design.pattern:
        return np.full(len(mesh.edges), design.eps_pre)
    distances, farthest = edge_distance(design, mesh, region)
    share = profile(distances / farthest, design.actuation.profile, design.actuation.gamma)
    return np.where(region.edge_in_pattern, 0.0, design.eps_pre * share)
