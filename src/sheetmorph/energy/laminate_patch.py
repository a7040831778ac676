"""Triangles with what lies beyond their sides, and the directors on the sides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sheetmorph.geometry.mesh import Floats, Ints, SheetMesh
from sheetmorph.geometry.surface import dihedral_angles


@dataclass(frozen=True, eq=False)
class Patch:
    """The triangles of a mesh, each with its sides; side i lies opposite corner i.

    The director of an edge is the surface normal at its middle, and its turn ψ an unknown, times
    a length so that it is of the same kind as the coordinates. It is measured from the normal of
    the triangle on the left of the edge, whose energy so has no need to know what lies beyond;
    from the normal of the triangle on the right the director turns by θ − ψ, θ the dihedral
    angle. On a sheet that is bent at rest, ψ = 0 is the middle between both normals there.
    Measured from the middle between both present normals it would be the same, but each
    triangle would be tied to all three nodes beyond its sides, and the Hessian would be denser.

    Attributes:
        stencil: corners 0, 1, 2 and the nodes beyond the sides 0, 1, 2, shape (T, 6); the own
            corner where none is needed.
        directors: degrees of freedom of the directors of the sides, shape (T, 3).
        share: 1 on the right of a hinge and with a flap, where the angle of the director has
            the dihedral angle in it; 0 on the left of a hinge and on a free rim, shape (T, 3).
        turn: what a director's unknown turns, per length [1/m], shape (T, 3): positive on the
            left and on the rim, negative on the right, 0 with a flap.
        lean: angle of the director at ψ = 0, but for the dihedral angle, shape (T, 3): half the
            dihedral angle at rest on the left, minus that on the right, 0 elsewhere [rad].
        flap: vector from the middle of a side to its flap [m], shape (T, 3, 3): beyond a rim
            whose surface normal is prescribed the surface goes on along it.
        held: scalar unknowns without effect, of flaps and of filling up, shape (S,); S is the
            number of edges, filled up to a multiple of 3.
    """

    stencil: Ints
    directors: Ints
    share: Floats
    turn: Floats
    lean: Floats
    flap: Floats
    held: NDArray[np.bool_]

    @classmethod
    def of(
        cls,
        mesh: SheetMesh,
        director_length: float,
        flapped_edges: Ints | None = None,
        conormals: Floats | None = None,
    ) -> Patch:
        """The patch of a mesh.

        Args:
            mesh: the reference mesh.
            director_length: unit of the directors' unknowns [m].
            flapped_edges: edges on the rim whose surface normal is prescribed, shape (K,).
            conormals: unit vectors in which the surface goes on beyond them, shape (K, 3).
        """
        count, edge_count = len(mesh.nodes), len(mesh.edges)
        edges = mesh.triangle_edges[:, [1, 2, 0]]  # by the corner they lie opposite
        hinge_of = np.full(edge_count, -1, dtype=np.int64)
        hinge_of[mesh.hinge_edges[:, 0]] = np.arange(len(mesh.hinges))
        hinge = hinge_of[edges]
        inner = hinge >= 0
        pair = mesh.hinges[:, 2:][hinge] if len(mesh.hinges) else np.zeros((*edges.shape, 2), int)
        right = inner & (pair[:, :, 1] == mesh.triangles)
        share = np.where(right, 1.0, 0.0)
        turn = np.where(right, -1.0, 1.0) / director_length
        half = np.append(0.5 * dihedral_angles(mesh.nodes, mesh.hinges), 0.0)
        lean = np.where(right, -half[hinge], half[hinge])  # hinge −1 is the rim
        flap = np.zeros((*edges.shape, 3))
        held = np.ones(-(-edge_count // 3) * 3, dtype=np.bool_)
        held[:edge_count] = False
        if flapped_edges is not None and conormals is not None and len(flapped_edges):
            number = np.full(edge_count, -1, dtype=np.int64)
            number[flapped_edges] = np.arange(len(flapped_edges))
            flapped = (number[edges] >= 0) & ~inner
            share[flapped], turn[flapped] = 1.0, 0.0
            rows = number[edges[flapped]]
            flap[flapped] = conormals[rows] * mesh.edge_lengths[flapped_edges[rows], None]
            held[flapped_edges] = True
        beyond = np.where(right, pair[:, :, 0], mesh.triangles)
        stencil = np.concatenate([mesh.triangles, beyond], axis=1)
        return cls(
            stencil=np.ascontiguousarray(stencil, dtype=np.int32),
            directors=np.ascontiguousarray(3 * count + edges, dtype=np.int32),
            share=np.ascontiguousarray(share),
            lean=np.ascontiguousarray(lean),
            turn=np.ascontiguousarray(turn),
            flap=flap,
            held=held,
        )

    @property
    def scalar_count(self) -> int:
        """Number of scalar unknowns S."""
        return len(self.held)
