"""When two states are the same shape, up to the symmetry of the design."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import Delaunay, cKDTree

from sheetmorph.geometry.mesh import Floats
from sheetmorph.solve.constraints import align_to_reference
from sheetmorph.solve.system import System
from sheetmorph.study.model import Problem

MIRROR = "turned over"
"""Name of the map z → −z."""


@dataclass(frozen=True, eq=False)
class Image:
    """A map of the sheet that its design does not feel.

    Attributes:
        name: for people, "" for the identity.
        matrix: about the centre, shape (3, 3).
        at: values at the images of the nodes from values at the nodes, shape (V, V).
    """

    name: str
    matrix: Floats
    at: csr_array


@dataclass(frozen=True, eq=False)
class Sameness:
    """The maps of a design, and how far states may differ.

    Attributes:
        images: the maps, the identity first.
        centre: fixed point of the maps [m], shape (3,).
        size: of the sheet [m].
        free: True where shapes that differ by a rigid motion are the same.
    """

    images: tuple[Image, ...]
    centre: Floats
    size: float
    free: bool

    @classmethod
    def of(cls, problem: Problem, system: System) -> Sameness:
        """The rotations and mirror lines of the design, and z → −z where the model allows it."""
        symmetry, nodes = problem.design.symmetry, problem.mesh.nodes
        centre = np.array([*symmetry.centre, 0.0])
        signs = (1.0, -1.0) if may_turn_over(problem, system) else (1.0,)
        corners, images = Delaunay(nodes[:, :2]), []
        for sign in signs:
            for k, plane in enumerate(symmetry.matrices()):
                matrix = np.zeros((3, 3))
                matrix[:2, :2], matrix[2, 2] = plane, sign
                places = centre + (nodes - centre) @ matrix.T
                name = _name(k, symmetry.order, symmetry.mirror, sign)
                images.append(Image(name, matrix, _interpolation(corners, places)))
        size = float(np.linalg.norm(np.ptp(nodes, axis=0)))
        return cls(tuple(images), centre, size, not len(problem.held_nodes))

    def distance(self, first: Floats, second: Floats) -> tuple[float, str]:
        """How far two shapes are apart, and by which map they are nearest.

        Args:
            first: node positions [m], shape (V, 3).
            second: node positions [m], shape (V, 3).

        Returns:
            Root mean square distance of the nodes over the size of the sheet; the name of the
            map that takes the first nearest to the second.
        """
        found = []
        for image in self.images:
            moved = self.centre + (first - self.centre) @ image.matrix.T
            there = image.at @ second
            if self.free:
                moved = align_to_reference(moved[None], there)[0]
            found.append(float(np.sqrt(((moved - there) ** 2).sum(axis=1).mean())) / self.size)
        best = int(np.argmin(found))
        # The identity where it is as good but for rounding.
        best = 0 if found[0] <= found[best] + 1e-9 else best
        return found[best], self.images[best].name


def turned_over(problem: Problem, x: Floats) -> Floats:
    """A state with z and the turns of directors reversed, shape (n,)."""
    moved, size = x.copy(), problem.mesh.nodes.size
    moved[2:size:3] *= -1.0
    moved[size:] *= -1.0
    return moved


def may_turn_over(problem: Problem, system: System) -> bool:
    """Whether z → −z changes nothing: a test of the forces at a crumpled sheet."""
    nodes = problem.mesh.nodes
    if np.abs(nodes[:, 2]).max() > 0.0:
        return False
    noise = np.random.default_rng(0).uniform(-1.0, 1.0, problem.start.size)
    noise[system.held.held] = 0.0
    x = problem.start + 0.05 * float(problem.mesh.edge_lengths.min()) * noise
    here = system.at(1.0, 0.0)
    _, one = here.gradient(x)
    _, other = here.gradient(turned_over(problem, x))
    return bool(np.abs(turned_over(problem, one) - other).max() <= 1e-9 * np.abs(one).max())


def _name(k: int, order: int, mirror: float | None, sign: float) -> str:
    parts = []
    if k and k < order:
        parts.append(f"turned by {360.0 * k / order:g}°")
    if k >= order and mirror is not None:
        angle = np.degrees(mirror) + 180.0 * (k - order) / order
        parts.append(f"mirrored at the line at {angle:.4g}°")
    if sign < 0.0:
        parts.append(MIRROR)
    return ", ".join(parts)


def _interpolation(corners: Delaunay, places: Floats) -> csr_array:
    """Weights of the nodes at places on the flat sheet, those of the nearest node outside."""
    plane, wanted = corners.points, places[:, :2]
    count = len(plane)
    simplex = corners.find_simplex(wanted)
    inside = simplex >= 0
    transform = corners.transform[simplex]
    first = np.einsum("nij,nj->ni", transform[:, :2], wanted - transform[:, 2])
    weights = np.column_stack([first, 1.0 - first.sum(axis=1)])
    columns = corners.simplices[simplex].astype(np.intp)
    nearest = cKDTree(plane).query(wanted)[1]
    flat = ~inside | ~np.isfinite(weights).all(axis=1)
    weights[flat], columns[flat] = [1.0, 0.0, 0.0], nearest[flat, None]
    rows = np.repeat(np.arange(count), 3)
    return csr_array((weights.ravel(), (rows, columns.ravel())), shape=(count, count))
