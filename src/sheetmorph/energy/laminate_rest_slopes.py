"""How the work of layered triangles along a motion changes with the sheet before actuation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sheetmorph.energy.laminate_patch import Patch
from sheetmorph.energy.lamination_slopes import LayerSlopes
from sheetmorph.energy.shape_measures import measures_at, strain_maps
from sheetmorph.geometry import surface
from sheetmorph.geometry.mesh import Floats, SheetMesh

STEP = 1e-5
"""Of central differences, in mean edge lengths."""


@dataclass(frozen=True, eq=False)
class Motion:
    """A state and a motion from it, as the triangles see them.

    Attributes:
        measures: p of the state, shape (T, 6).
        change: of p along the motion, shape (T, 6).
        altitudes: upon the sides of each triangle [m], shape (T, 3).
        altitude_change: along the motion [m], shape (T, 3).
    """

    measures: Floats
    change: Floats
    altitudes: Floats
    altitude_change: Floats

    @classmethod
    def of(cls, patch: Patch, x: Floats, motion: Floats) -> Motion:
        """Differentiate the measures along a motion.

        Args:
            patch: the triangles.
            x: degrees of freedom in rows of three [m].
            motion: their changes.
        """
        corners = patch.stencil[:, :3]
        largest = float(np.abs(motion).max())
        h = STEP * float(np.ptp(x)) / largest if largest else 1.0

        def slope(of: tuple[Floats, Floats]) -> Floats:
            return np.asarray((of[0] - of[1]) / (2.0 * h))

        ahead, behind = x + h * motion, x - h * motion
        return cls(
            measures=measures_at(x, patch),
            change=slope((measures_at(ahead, patch), measures_at(behind, patch))),
            altitudes=altitudes(x[corners]),
            altitude_change=slope((altitudes(ahead[corners]), altitudes(behind[corners]))),
        )


def altitudes(corners: Floats) -> Floats:
    """Altitudes of triangles upon the sides opposite their corners [m], shape (T, 3)."""
    sides = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
    double = np.linalg.norm(np.cross(sides[:, 1], sides[:, 2]), axis=1)
    return np.asarray(double[:, None] / np.linalg.norm(sides, axis=2))


def rest_slopes(mesh: SheetMesh, patch: Patch, motion: Motion, layers: LayerSlopes) -> Floats:
    """By the positions of the nodes before actuation, shape (V, 3) [N].

    Layers and free strains stay with the triangles, in their frames; the directions of clamped
    rims stay as they are.

    Args:
        mesh: the sheet before.
        patch: its triangles.
        motion: the state, and the motion along which the energy does the work.
        layers: sections of the layers.
    """
    corners = mesh.nodes[mesh.triangles]
    leans = measures_at(mesh.nodes, patch)[:, 3:] / (2.0 * altitudes(corners))
    found = np.zeros_like(mesh.nodes)
    h = STEP * mesh.mean_edge_length
    flat = mesh.flat
    for node in range(3):
        for axis in range(2 if flat else 3):
            works = []
            for step in (h, -h):
                moved = corners.copy()
                moved[:, node, axis] += step
                works.append(_work(moved, mesh, leans, motion, layers))
            np.add.at(found[:, axis], mesh.triangles[:, node], (works[0] - works[1]) / (2.0 * h))
    if len(mesh.hinges):
        found += _through_angles(mesh, patch, corners, motion, layers, leans)
    return found


def _frames(corners: Floats, mesh: SheetMesh) -> Floats:
    if mesh.flat:
        return mesh.triangle_frames
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return surface.frames_of(normals / np.linalg.norm(normals, axis=1)[:, None])


def _work(
    corners: Floats, mesh: SheetMesh, leans: Floats, motion: Motion, layers: LayerSlopes
) -> Floats:
    """Work of every triangle with these corners before actuation [J], shape (T,)."""
    maps, areas = strain_maps(corners, _frames(corners, mesh))
    bent = _times(maps[:, 3:, 3:], 2.0 * altitudes(corners) * leans)
    stress = _times(layers.stiffness, _times(maps, motion.measures))
    stress = stress - layers.resultants - _times(layers.bending, bent)
    return np.asarray(areas * (_times(maps, motion.change) * stress).sum(axis=1))


def _through_angles(
    mesh: SheetMesh,
    patch: Patch,
    corners: Floats,
    motion: Motion,
    layers: LayerSlopes,
    leans: Floats,
) -> Floats:
    """By the dihedral angles before actuation, carried on to the nodes, shape (V, 3)."""
    maps, areas = strain_maps(corners, mesh.triangle_frames)
    heights = altitudes(corners)
    strain, change = _times(maps, motion.measures), _times(maps, motion.change)
    bent = _times(maps[:, 3:, 3:], 2.0 * heights * leans)
    stress = _times(layers.stiffness, strain) - layers.resultants - _times(layers.bending, bent)
    pull = _times(layers.stiffness, change)
    hinge_of = np.full(len(mesh.edges), -1, dtype=np.int64)
    hinge_of[mesh.hinge_edges[:, 0]] = np.arange(len(mesh.hinges))
    hinge = hinge_of[mesh.triangle_edges[:, [1, 2, 0]]]
    by_angle = np.zeros(len(mesh.hinges))
    for side in range(3):
        column = maps[:, :, 3 + side]
        director = 2.0 * motion.altitude_change[:, side] * (column * stress).sum(axis=1)
        director += 2.0 * motion.altitudes[:, side] * (column * pull).sum(axis=1)
        curve = _times(layers.bending, column[:, 3:])
        natural = -2.0 * heights[:, side] * (change * curve).sum(axis=1)
        sign = np.where(patch.share[:, side] == 1.0, -1.0, 1.0)
        inner = hinge[:, side] >= 0
        np.add.at(
            by_angle,
            hinge[inner, side],
            (0.5 * areas * (sign * director + natural))[inner],
        )
    count = len(mesh.hinges)
    own = np.arange(4 * count).reshape(count, 4)
    points = mesh.nodes[mesh.hinges].reshape(-1, 3)
    h = STEP * mesh.mean_edge_length
    found = np.zeros_like(mesh.nodes)
    for node in range(4):
        for axis in (2,) if mesh.flat else (0, 1, 2):
            angles = []
            for step in (h, -h):
                moved = points.copy()
                moved[node::4, axis] += step
                angles.append(surface.dihedral_angles(moved, own))
            slope = (angles[0] - angles[1]) / (2.0 * h)
            np.add.at(found[:, axis], mesh.hinges[:, node], by_angle * slope)
    return found


def _times(matrices: Floats, vectors: Floats) -> Floats:
    return np.asarray((matrices @ vectors[:, :, None])[:, :, 0])
