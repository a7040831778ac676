"""How good a mesh is, in numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sheetmorph.geometry.mesh import SheetMesh


@dataclass(frozen=True)
class MeshQuality:
    """Counts, angles and edge lengths of a mesh.

    Attributes:
        nodes, edges, triangles: counts.
        min_angle: smallest angle of the mesh [deg].
        mean_min_angle: mean over the triangles of their smallest angle [deg]; 60 is ideal.
        min_edge, mean_edge, max_edge: edge lengths [m].
    """

    nodes: int
    edges: int
    triangles: int
    min_angle: float
    mean_min_angle: float
    min_edge: float
    mean_edge: float
    max_edge: float

    def __str__(self) -> str:
        return (
            f"{self.nodes} nodes, {self.edges} edges, {self.triangles} triangles; smallest angle "
            f"{self.min_angle:.1f}°, mean {self.mean_min_angle:.1f}°; edges "
            f"{self.min_edge * 1e3:.3g} to {self.max_edge * 1e3:.3g} mm, "
            f"mean {self.mean_edge * 1e3:.4g} mm"
        )


def mesh_quality(mesh: SheetMesh) -> MeshQuality:
    """Measure a mesh."""
    angles = np.degrees(mesh.minimum_angles)
    lengths = mesh.edge_lengths
    return MeshQuality(
        *mesh.counts,
        min_angle=float(angles.min()),
        mean_min_angle=float(angles.mean()),
        min_edge=float(lengths.min()),
        mean_edge=float(lengths.mean()),
        max_edge=float(lengths.max()),
    )
