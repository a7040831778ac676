"""Strips of equilateral triangles, for which the published stiffnesses have closed forms.

An infinite equilateral lattice of springs k = K/l0² has the plane Young's modulus
(2/√3) k and Poisson's ratio 1/3, so that K = (√3/2) Y h l0² gives Y h (Seung, Nelson 1988).
For a surface of curvature M the dihedral angle at an edge is l0/(2√3) (3 M_nn − M_tt); the
mean of ½ k_b θ² over the three directions is ½ D (tr M)² − D (1 − ν) det M with
D = (√3/2) k_b and ν = −1/3. A narrow strip, free to curve across, then bends with
EI = D (1 − ν²) w = (8/9) D w.
"""

from __future__ import annotations

import numpy as np

from sheetmorph.energy.hinge import CoupledHinge
from sheetmorph.energy.loads import NodalLoad
from sheetmorph.energy.stretch import EdgeStretch
from sheetmorph.energy.total import Total
from sheetmorph.geometry.mesh import SheetMesh
from sheetmorph.geometry.topology import build_mesh
from sheetmorph.solve.constraints import HeldDofs
from sheetmorph.solve.linear import make_solver
from sheetmorph.solve.minimise import Minimum, NewtonOptions, minimise
from sheetmorph.solve.system import System


def strip(columns: int, rows: int, l0: float) -> SheetMesh:
    """Rows of equilateral triangles along x, centred on y = 0."""
    points, index = [], {}
    for j in range(rows + 1):
        for i in range(columns + 1 - j % 2):
            index[i, j] = len(points)
            points.append(((i + 0.5 * (j % 2)) * l0, (j - rows / 2) * l0 * np.sqrt(0.75)))
    triangles = []
    for j in range(rows):
        low, high = (j, j + 1) if j % 2 == 0 else (j + 1, j)
        for i in range(columns):
            up = [index[i, low], index[i + 1, low], index[i, high]]
            triangles.append(up if j % 2 == 0 else [up[0], up[2], up[1]])
        for i in range(columns - 1):
            down = [index[i + 1, low], index[i + 1, high], index[i, high]]
            triangles.append(down if j % 2 == 0 else [down[0], down[2], down[1]])
    return build_mesh(points, triangles)


def system_of(
    mesh: SheetMesh,
    held: np.ndarray,
    *,
    stretch: float,
    bend: float,
    force: np.ndarray | None = None,
) -> System:
    """Uniform edges of stiffness K and hinges of stiffness k_b, without coupling."""
    count = len(mesh.hinges)
    total = Total.of(
        [
            EdgeStretch(
                mesh.edges,
                mesh.edge_lengths,
                np.full(len(mesh.edges), stretch),
                np.zeros(len(mesh.edges)),
            ),
            CoupledHinge(
                mesh.hinges,
                mesh.edge_lengths[mesh.hinge_edges[:, 1:]],
                np.full(count, bend),
                np.zeros(count),
                np.zeros(count),
            ),
            NodalLoad(
                np.arange(len(mesh.nodes), dtype=np.int32)[:, None],
                np.zeros_like(mesh.nodes) if force is None else force,
                mesh.nodes,
            ),
        ],
        len(mesh.nodes),
    ).at(1.0, 1.0)
    return System(total, HeldDofs.of(total.pattern, held.ravel()), make_solver(total.pattern))


def solve(system: System, x: np.ndarray, tolerance: float) -> Minimum:
    """The minimum from x, which must be found."""
    found = minimise(system, x.ravel(), NewtonOptions(tolerance, max_iterations=200))
    assert found.outcome == "converged", (found, tolerance)
    return found
