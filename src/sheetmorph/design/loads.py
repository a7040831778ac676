"""Forces of the loads on the nodes of a mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.design.layout import place
from sheetmorph.design.load_tables import AreaLoad, LineLoad, PointLoad
from sheetmorph.design.masses import node_masses
from sheetmorph.design.selection import in_box, of_indices, rim_between
from sheetmorph.geometry.mesh import Floats, SheetMesh

if TYPE_CHECKING:
    from sheetmorph.design.load_tables import Load
    from sheetmorph.design.regions import Regions
    from sheetmorph.design.spec import Design

BALANCE = 1e-9
"""Net force and moment of loads on a free sheet, as a fraction of their size."""


def load_forces(design: Design, mesh: SheetMesh, region: Regions) -> Floats:
    """Forces of all loads at their full size on the nodes [N], shape (V, 3).

    Forces along edges and on areas are shared as the displacement is interpolated: half by
    each node of an edge, a third by each of a triangle. They are of the reference sheet, and
    keep their direction.

    Raises:
        InputError: no node or edge where a load acts, or loads on a free sheet that do not
            balance.
    """
    forces = np.zeros((len(mesh.nodes), 3))
    for index, load in enumerate(design.loads):
        forces += force_of(load, mesh, region, f"loads[{index}]")
    if design.loads and design.is_free:
        _check_balance(forces, mesh)
    return forces


def force_of(load: Load, mesh: SheetMesh, region: Regions, key: str) -> Floats:
    """Forces of one load at its full size on the nodes [N], shape (V, 3).

    Args:
        load: the load.
        mesh: the mesh.
        region: what lies where.
        key: of its table, for messages.

    Raises:
        InputError: no node or edge where it acts.
    """
    if isinstance(load, PointLoad):
        forces = np.zeros((len(mesh.nodes), 3))
        forces[_node(load, mesh, key)] = load.force
        return forces
    if isinstance(load, LineLoad):
        return _along_edges(load, mesh, key)
    if isinstance(load, AreaLoad):
        return np.asarray(mesh.node_areas[:, None] * np.array(load.force_per_area))
    return _weights(mesh, region, load.gravity, load.direction)


def gravity_forces(design: Design, mesh: SheetMesh, region: Regions) -> Floats:
    """Weights of the nodes by the table `gravity` [N], shape (V, 3); zero without it.

    A third of the mass of each triangle, density times thickness times area of its layers
    before actuation, goes to each of its corners. Actuation moves mass but makes none, so the
    weights stay what they are.
    """
    gravity = design.gravity
    if gravity is None:
        return np.zeros((len(mesh.nodes), 3))
    return _weights(mesh, region, gravity.magnitude, gravity.down)


def _weights(
    mesh: SheetMesh, region: Regions, gravity: float, direction: tuple[float, ...]
) -> Floats:
    shares = node_masses(mesh, region)
    unit = np.array(direction) / np.linalg.norm(direction)
    return np.asarray(gravity * shares[:, None] * unit)


def _node(load: PointLoad, mesh: SheetMesh, key: str) -> int:
    """The node that bears a point load."""
    if load.node is not None:
        return int(np.flatnonzero(of_indices(mesh, (load.node,), f"{key}.node"))[0])
    assert load.at is not None  # noqa: S101  the schema wants one of the two
    point = np.array(load.at)
    away = np.linalg.norm(mesh.nodes[:, : len(point)] - point, axis=1)
    nearest = int(away.argmin())
    reach = float(mesh.edge_lengths.max())
    if away[nearest] > reach:
        raise InputError(
            f"no node of the mesh is within {1e3 * reach:.3g} mm, an edge, of this place",
            key=f"{key}.at",
            value=place(*load.at[:2]),
        )
    twins = np.flatnonzero(away <= away[nearest] + 1e-9 * mesh.size)
    if len(twins) > 1:
        raise InputError(
            "several nodes of the mesh are nearest to this place, as at a slit; name one by node",
            key=f"{key}.at",
            value=place(*load.at[:2]),
            allowed=", ".join(map(str, twins[:10].tolist())),
        )
    return nearest


def _along_edges(load: LineLoad, mesh: SheetMesh, key: str) -> Floats:
    if load.nodes is not None:
        chosen = of_indices(mesh, load.nodes, f"{key}.nodes")
    else:
        chosen = in_box(mesh, load.x, load.y, load.z)
    edges = mesh.rim_edges[rim_between(mesh, chosen)]
    if not len(edges):
        raise InputError("acts on no edge of the rim", key=key)
    halves = np.repeat(0.5 * mesh.edge_lengths[edges], 2)
    shares = np.bincount(mesh.edges[edges].ravel(), halves, minlength=len(mesh.nodes))
    return np.asarray(shares[:, None] * np.array(load.force_per_length))


def _check_balance(forces: Floats, mesh: SheetMesh) -> None:
    size = np.abs(forces).sum()
    arms = mesh.nodes - mesh.nodes.mean(axis=0)
    net, moment = forces.sum(axis=0), np.cross(arms, forces).sum(axis=0)
    for what, value, unit, scale in (
        ("force", net, "N", size),
        ("moment", moment, "N·m", size * mesh.size),
    ):
        if np.abs(value).max() > BALANCE * scale:
            rest = ", ".join(f"{part:.3g}" for part in value)
            raise InputError(
                f"the sheet is free, and the loads have a net {what} of ({rest}) {unit}",
                key="loads",
                allowed="loads that balance, or a [[supports]] table",
            )
