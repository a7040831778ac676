"""Which nodes the supports hold, and the small load that chooses the branch."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.design.laminate import film_stack
from sheetmorph.design.regions import TOLERANCE, Regions
from sheetmorph.design.sections import BoxSupport, NodeSupport
from sheetmorph.geometry.mesh import Floats, SheetMesh

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design

DEFAULT_LOAD = 0.1
"""Total force of a perturbation that names none, in units of the film's D over half the size.

It deflects a sheet of film by about half a percent of its size: enough to choose a branch.
"""


def held_nodes(design: Design, mesh: SheetMesh, region: Regions) -> NDArray[np.intp]:
    """Indices of the nodes that the supports hold, sorted; empty for a free sheet.

    Boxes include their edges; "in the pattern" is by the position of the node.

    Raises:
        InputError: a support holds no node, or all of them together hold fewer than three
            nodes that do not lie on one line.
    """
    held = np.zeros(len(mesh.nodes), dtype=np.bool_)
    width = TOLERANCE * mesh.size
    for index, support in enumerate(design.supports):
        chosen: NDArray[np.bool_] = np.zeros(len(held), dtype=np.bool_)
        if isinstance(support, BoxSupport):
            low = np.array([support.x[0], support.y[0]]) - width
            high = np.array([support.x[1], support.y[1]]) + width
            plane = mesh.nodes[:, :2]
            chosen = np.asarray(((plane >= low) & (plane <= high)).all(axis=1))
            if support.kind == "pattern_in_box":
                chosen &= region.node_in_pattern
        elif isinstance(support, NodeSupport):
            beyond = [node for node in support.nodes if node >= len(held)]
            if beyond:
                raise InputError(
                    "there is no such node in the mesh",
                    key=f"supports[{index}].nodes",
                    value=beyond[0],
                    allowed=f"0 to {len(held) - 1}",
                )
            chosen[list(support.nodes)] = True
        else:
            continue
        if not chosen.any():
            raise InputError("holds no node of the mesh", key=f"supports[{index}]")
        held |= chosen
    nodes = np.flatnonzero(held)
    if len(nodes):
        _check_spread(mesh.nodes[nodes, :2], mesh.size)
    return nodes


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


def _check_spread(points: Floats, size: float) -> None:
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if len(points) < 3 or spread[-1] < 1e-6 * size:
        raise InputError(
            f"the supports hold {len(points)} nodes on one line, so the sheet can still turn",
            key="supports",
            allowed="at least 3 nodes that do not lie on one line, or a free sheet",
        )
