"""Triangles with what lies beyond their sides, and the directors on the sides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sheetmorph.energy.laminate_kernel import FLAP, FREE
from sheetmorph.geometry.mesh import Floats, Ints, SheetMesh


@dataclass(frozen=True, eq=False)
class Patch:
    """The triangles of a mesh, each with its sides; side i lies opposite corner i.

    The director of a side is the surface normal at its middle; its turn φ about the side,
    out of the middle between the normals of the two triangles, is an unknown, times a length
    so that it is of the same kind as the coordinates.

    Attributes:
        stencil: corners 0, 1, 2 and the nodes beyond the sides 0, 1, 2, shape (T, 6); the own
            corner where there is none.
        directors: degrees of freedom of the directors of the sides, shape (T, 3).
        share: of the dihedral angle that goes to the director, shape (T, 3): 1/2 between two
            triangles, 0 on a free rim, 1 where the normal is prescribed by a flap.
        turn: what a director's unknown turns, per length [1/m], shape (T, 3): the sides of one
            edge have opposite signs; 0 with a flap.
        flap: vector from the middle of a side to its flap [m], shape (T, 3, 3).
        held: scalar unknowns without effect, of flaps and of filling up, shape (S,); S is the
            number of edges, filled up to a multiple of 3.
    """

    stencil: Ints
    directors: Ints
    share: Floats
    turn: Floats
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
        left = inner & (pair[:, :, 0] == mesh.triangles)
        beyond = np.where(left, pair[:, :, 1], pair[:, :, 0])
        share = np.where(inner, 0.5, FREE)
        turn = np.where(inner & ~left, -1.0, 1.0) / director_length
        flap = np.zeros((*edges.shape, 3))
        held = np.ones(-(-edge_count // 3) * 3, dtype=np.bool_)
        held[:edge_count] = False
        if flapped_edges is not None and conormals is not None and len(flapped_edges):
            number = np.full(edge_count, -1, dtype=np.int64)
            number[flapped_edges] = np.arange(len(flapped_edges))
            flapped = (number[edges] >= 0) & ~inner
            share[flapped], turn[flapped] = FLAP, 0.0
            rows = number[edges[flapped]]
            flap[flapped] = conormals[rows] * mesh.edge_lengths[flapped_edges[rows], None]
            held[flapped_edges] = True
        stencil = np.concatenate([mesh.triangles, np.where(inner, beyond, mesh.triangles)], axis=1)
        return cls(
            stencil=np.ascontiguousarray(stencil, dtype=np.int32),
            directors=np.ascontiguousarray(3 * count + edges, dtype=np.int32),
            share=np.ascontiguousarray(share),
            turn=np.ascontiguousarray(turn),
            flap=flap,
            held=held,
        )

    @property
    def scalar_count(self) -> int:
        """Number of scalar unknowns S."""
        return len(self.held)
