"""What the supports hold, and the small load that chooses the branch."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.design.laminate import film_stack
from sheetmorph.design.regions import Regions
from sheetmorph.design.rigid import free_motions, told
from sheetmorph.design.selection import Bools, in_box, of_indices, on_plane, rim_between
from sheetmorph.design.support_tables import (
    AXES,
    BoxSupport,
    FreeSupport,
    HoldingSupport,
    NodeSupport,
    SymmetrySupport,
)
from sheetmorph.geometry.mesh import Floats, Ints, SheetMesh

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design

Holding = BoxSupport | NodeSupport | SymmetrySupport

DEFAULT_LOAD = 0.1
"""Total force of a perturbation that names none, in units of the film's D over half the size.

It deflects a sheet of film by about half a percent of its size: enough to choose a branch.
"""


def held_nodes(design: Design, mesh: SheetMesh, region: Regions) -> NDArray[np.intp]:
    """Indices of the nodes that the supports hold, sorted; empty for a free sheet.

    A node is held when any of its components is.

    Raises:
        InputError: as for `held_components`.
    """
    return np.flatnonzero(held_components(design, mesh, region).any(axis=1))


def held_components(design: Design, mesh: SheetMesh, region: Regions) -> Bools:
    """Which coordinates of the nodes keep their value, shape (V, 3); none for a free sheet.

    Boxes include their faces; "in the pattern" is by the position of the node.

    Raises:
        InputError: a support holds no node, or all of them together leave a rigid motion.
    """
    held = np.zeros((len(mesh.nodes), 3), dtype=np.bool_)
    for index, support in enumerate(design.supports):
        if isinstance(support, FreeSupport):
            continue
        key = f"supports[{index}]"
        chosen = _chosen(support, mesh, region, key)
        axes = (support.plane,) if isinstance(support, SymmetrySupport) else support.hold
        for axis in axes:
            held[chosen, AXES.index(axis)] = True
    if not design.is_free:
        _check_rigid(design, mesh, region, held)
    return held


def directed_edges(design: Design, mesh: SheetMesh, region: Regions) -> tuple[Ints, Floats]:
    """Edges of the rim whose surface normal has a prescribed direction; K of them.

    Returns:
        Indices of the edges, increasing, shape (K,), and unit conormals in the reference
        state, shape (K, 3): the surface normal stays perpendicular to them. Of a clamped edge
        it lies in the plane of the edge's triangle, perpendicular to the edge, and points away
        from the triangle; of an edge in a plane of symmetry it is the normal of that plane,
        away from the sheet. An edge that is clamped is not counted as one of symmetry.

    Raises:
        InputError: a support that clamps no edge, or as for `held_components`.
    """
    outward = _conormals(mesh)
    conormal: dict[int, Floats] = {}
    for index, support in enumerate(design.supports):
        if isinstance(support, HoldingSupport) and support.clamp:
            chosen = _chosen(support, mesh, region, f"supports[{index}]")
            rim = rim_between(mesh, chosen)
            if not len(rim):
                raise InputError(
                    "clamps no edge: both nodes of an edge of the rim must be held",
                    key=f"supports[{index}].clamp",
                )
            conormal |= {int(place): outward[place] for place in rim}
    for index, support in enumerate(design.supports):
        if isinstance(support, SymmetrySupport):
            axis = AXES.index(support.plane)
            chosen = _chosen(support, mesh, region, f"supports[{index}]")
            for place in rim_between(mesh, chosen).tolist():
                normal = np.zeros(3)
                normal[axis] = 1.0 if outward[place, axis] > 0 else -1.0
                conormal.setdefault(place, normal)
    places = sorted(conormal, key=lambda place: int(mesh.rim_edges[place]))
    found = np.array([conormal[place] for place in places]).reshape(-1, 3)
    return mesh.rim_edges[np.array(places, dtype=np.intp)], found


def _chosen(support: Holding, mesh: SheetMesh, region: Regions, key: str) -> Bools:
    """The nodes that a support holds, shape (V,)."""
    if isinstance(support, BoxSupport):
        chosen = in_box(mesh, support.x, support.y, support.z)
        if support.kind == "pattern_in_box":
            chosen &= region.node_in_pattern
    elif isinstance(support, NodeSupport):
        chosen = of_indices(mesh, support.nodes, f"{key}.nodes")
    else:
        chosen = on_plane(mesh, AXES.index(support.plane), support.at)
    if not chosen.any():
        raise InputError("holds no node of the mesh", key=key)
    return chosen


def _conormals(mesh: SheetMesh) -> Floats:
    """Unit vectors outward from the edges of the rim in the planes of their triangles, (B, 3)."""
    ends = mesh.nodes[mesh.edges[mesh.rim_edges]]
    along = ends[:, 1] - ends[:, 0]
    along /= np.linalg.norm(along, axis=1)[:, None]
    away = ends[:, 0] - mesh.nodes[mesh.triangles[mesh.rim_triangles]].mean(axis=1)
    away -= (away * along).sum(axis=1)[:, None] * along
    return np.asarray(away / np.linalg.norm(away, axis=1)[:, None])


def _check_rigid(design: Design, mesh: SheetMesh, region: Regions, held: Bools) -> None:
    """Refuse supports that leave the sheet a rigid motion."""
    edges, _ = directed_edges(design, mesh, region)
    turns = np.diff(mesh.nodes[mesh.edges[edges]], axis=1)[:, 0]
    turns /= np.linalg.norm(turns, axis=1)[:, None]
    shifts, spins = free_motions(mesh.nodes, held, turns, mesh.size)
    if not len(shifts):
        return
    points = mesh.nodes[held.any(axis=1)]
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    line = " on one line" if len(points) < 3 or spread[1] < 1e-6 * mesh.size else ""
    motion = told(shifts, spins, mesh.nodes.mean(axis=0), mesh.size)
    raise InputError(
        f"the supports hold {len(points)} nodes{line}, so the sheet can still {motion}",
        key="supports",
        allowed="supports that leave no rigid motion, such as 3 nodes that do not lie on one "
        "line, or a free sheet",
    )


def perturbation_forces(design: Design, mesh: SheetMesh) -> Floats:
    """Forces of the full perturbation on the nodes [N], shape (V, 3).

    "uniform" with `force_per_node` gives every node the same force; with `total_force`
    each has its share by area. "bowl" grows with the squared distance from the middle
    after the parts that would move a rigid sheet are taken out, so that it has neither net
    force nor moment; "up" lifts the rim. Its mean absolute force is `force_per_node`, or
    its sum of absolute forces `total_force`.
    """
    options, count = design.perturbation, len(mesh.nodes)
    sign = 1.0 if options.direction == "up" else -1.0
    total = options.total_force
    if total is None:
        per_node = options.force_per_node
        rigidity = film_stack(design).flexural_rigidity
        default = DEFAULT_LOAD * rigidity / (0.5 * mesh.size)
        total = default if per_node is None else per_node * count
    forces = np.zeros((count, 3))
    if options.shape == "bowl":
        shape = _bowl(mesh)
        forces[:, 2] = shape * (sign * total / np.abs(shape).sum())
    elif options.force_per_node is not None:
        forces[:, 2] = sign * options.force_per_node
    else:
        areas = mesh.node_areas
        forces[:, 2] = sign * total * areas / areas.sum()
    return forces


def _bowl(mesh: SheetMesh) -> Floats:
    """Node areas times (r² less its best fit by a plane): no net force, no net moment."""
    areas = mesh.node_areas
    plane = (mesh.nodes[:, :2] - areas @ mesh.nodes[:, :2] / areas.sum()) / mesh.size
    rigid = np.column_stack([np.ones(len(plane)), plane])
    squared = (plane**2).sum(axis=1)
    weights = rigid * areas[:, None]
    fit = np.linalg.solve(weights.T @ rigid, weights.T @ squared)
    return np.asarray(areas * (squared - rigid @ fit))
