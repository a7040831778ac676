"""The triangle mesh of a sheet, frozen."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class SheetMesh:
    """An oriented, manifold triangle mesh with its edges and hinges; flat unless said otherwise.

    Build one with `sheetmorph.geometry.topology.build_mesh`, which checks it.

    Attributes:
        nodes: reference positions [m], shape (V, 3); z = 0 for a flat sheet.
        triangles: node indices, shape (T, 3), counter-clockwise seen from +z; those of a curved
            sheet may be vertical.
        edges: node indices, shape (E, 2); the order of the two nodes carries the
            orientation of the published coupling.
        hinges: nodes (a, b, c, d) of every edge that two triangles share, shape (H, 4):
            the edge runs a→b, c lies on its left (triangle abc), d on its right (adb).
            In the order of `edges`.
        hinge_edges: indices into `edges` of (ab, ac, ad, bc, bd), shape (H, 5).
    """

    nodes: Floats
    triangles: Ints
    edges: Ints
    hinges: Ints
    hinge_edges: Ints

    @property
    def counts(self) -> tuple[int, int, int]:
        """Numbers of nodes, edges and triangles."""
        return len(self.nodes), len(self.edges), len(self.triangles)

    @cached_property
    def flat(self) -> bool:
        """True for a flat sheet, False for a curved one."""
        return not self.nodes[:, 2].any()

    @cached_property
    def edge_lengths(self) -> Floats:
        """Reference edge lengths [m], shape (E,)."""
        ends = self.nodes[self.edges]
        return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))

    @cached_property
    def triangle_edges(self) -> Ints:
        """Indices into `edges` of the sides 01, 12, 20 of each triangle, shape (T, 3)."""
        count = len(self.nodes)
        low, high = np.sort(self.edges, axis=1).astype(np.int64).T
        keys = low * count + high
        order = np.argsort(keys)
        sides = np.sort(self.triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2).astype(np.int64)
        wanted = sides[:, :, 0] * count + sides[:, :, 1]
        return order[np.searchsorted(keys[order], wanted)].astype(np.int32)

    @cached_property
    def rim_edges(self) -> Ints:
        """Indices of the edges that one triangle alone has, slits included, shape (B,)."""
        beside = np.bincount(self.triangle_edges.ravel(), minlength=len(self.edges))
        return np.flatnonzero(beside == 1).astype(np.int32)

    @cached_property
    def rim_triangles(self) -> Ints:
        """The triangle of each edge of the rim, shape (B,)."""
        triangle = np.zeros(len(self.edges), dtype=np.int32)
        triangle[self.triangle_edges] = np.arange(len(self.triangles), dtype=np.int32)[:, None]
        return np.asarray(triangle[self.rim_edges])

    @cached_property
    def edge_areas(self) -> Floats:
        """A third of the area of the triangles beside each edge [m²], shape (E,)."""
        thirds = np.repeat(self.triangle_areas / 3.0, 3)
        sums = np.bincount(self.triangle_edges.ravel(), weights=thirds, minlength=len(self.edges))
        return np.asarray(sums, dtype=np.float64)

    @cached_property
    def edge_midpoints(self) -> Floats:
        """Reference midpoints of the edges in the plan [m], shape (E, 2)."""
        return np.asarray(self.nodes[self.edges, :2].mean(axis=1))

    @cached_property
    def triangle_centroids(self) -> Floats:
        """Reference centroids of the triangles in the plan [m], shape (T, 2)."""
        return np.asarray(self.nodes[self.triangles, :2].mean(axis=1))

    @cached_property
    def triangle_areas(self) -> Floats:
        """Reference areas of the triangles [m²], shape (T,)."""
        if not self.flat:
            from sheetmorph.geometry.surface import triangle_areas

            return triangle_areas(self.nodes, self.triangles)
        a, b, c = (self.nodes[self.triangles[:, k], :2] for k in range(3))
        u, v = b - a, c - a
        return np.asarray(0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]))

    @cached_property
    def triangle_normals(self) -> Floats:
        """Unit normals of the triangles, shape (T, 3)."""
        from sheetmorph.geometry.surface import triangle_normals

        return triangle_normals(self.nodes, self.triangles)

    @cached_property
    def triangle_frames(self) -> Floats:
        """Two unit vectors in the plane of each triangle, shape (T, 2, 3).

        The first is the projection of the x axis into that plane, normalised, the second the
        normal times the first: the axes of the plan where the sheet is flat. In a triangle
        that faces x, where the projection vanishes, the first is that of the z axis.
        """
        from sheetmorph.geometry.surface import frames_of

        return frames_of(self.triangle_normals)

    @cached_property
    def node_areas(self) -> Floats:
        """A third of the area of the triangles around each node [m²], shape (V,)."""
        shares = np.repeat(self.triangle_areas / 3.0, 3)
        return np.asarray(
            np.bincount(self.triangles.ravel(), weights=shares, minlength=len(self.nodes)),
            dtype=np.float64,
        )

    @cached_property
    def minimum_angles(self) -> Floats:
        """Smallest angle of each triangle [rad], shape (T,)."""
        from sheetmorph.geometry.surface import smallest_angles

        return smallest_angles(self.nodes, self.triangles)

    @property
    def mean_edge_length(self) -> float:
        """Mean reference edge length [m]."""
        return float(self.edge_lengths.mean())

    @property
    def size(self) -> float:
        """Diagonal of the bounding box [m]."""
        return float(np.linalg.norm(np.ptp(self.nodes, axis=0)))

    def with_hinges_reversed(self, reverse: NDArray[np.bool_]) -> SheetMesh:
        """The same mesh with the edges of the chosen hinges run the other way.

        Args:
            reverse: shape (H,), True where a→b shall become b→a.
        """
        hinges = self.hinges.copy()
        hinges[reverse] = hinges[reverse][:, [1, 0, 3, 2]]
        hinge_edges = self.hinge_edges.copy()
        hinge_edges[reverse] = hinge_edges[reverse][:, [0, 4, 3, 2, 1]]
        edges = self.edges.copy()
        edges[hinge_edges[:, 0]] = hinges[:, :2]
        return replace(self, edges=edges, hinges=hinges, hinge_edges=hinge_edges)
