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
from numpy.typing import NDArray

from sheetmorph.core.errors import ComputationError
from sheetmorph.energy.hinge import CoupledHinge
from sheetmorph.energy.loads import NodalLoad
from sheetmorph.energy.stretch import EdgeStretch
from sheetmorph.energy.total import Total
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.geometry.topology import build_mesh
from sheetmorph.solve.constraints import HeldDofs
from sheetmorph.solve.linear import make_solver
from sheetmorph.solve.minimise import Minimum, NewtonOptions, minimise
from sheetmorph.solve.system import System

MODULUS, THICKNESS = 1e6, 0.3e-3
"""Y [Pa] and h [m] of the strips."""


def strip(columns: int, rows: int, l0: float) -> SheetMesh:
    """Rows of equilateral triangles of side l0 along x, centred on y = 0."""
    starts = np.cumsum([0] + [columns + 1 - j % 2 for j in range(rows + 1)])
    points, triangles = [], []
    for j in range(rows + 1):
        odd = j % 2
        x = (np.arange(columns + 1 - odd) + 0.5 * odd) * l0
        points.append(np.column_stack([x, np.full(len(x), (j - rows / 2) * l0 * np.sqrt(0.75))]))
    for j in range(rows):
        long, short = (j, j + 1) if j % 2 == 0 else (j + 1, j)
        a = starts[long] + np.arange(columns)
        b = starts[short] + np.arange(columns)
        pointing = np.column_stack([a, a + 1, b])
        between = np.column_stack([a[1:], b[1:], b[:-1]])
        both = np.concatenate([pointing, between])
        triangles.append(both if j % 2 == 0 else both[:, [0, 2, 1]])
    return build_mesh(np.concatenate(points), np.concatenate(triangles))


def pulled(rows: int, strain: float) -> tuple[float, float]:
    """Membrane stiffness [N/m] and Poisson's ratio of a strip pulled along x by a strain."""
    l0 = 0.02 / rows
    mesh = strip(2 * rows, rows, l0)
    x = mesh.nodes[:, 0]
    length = float(np.ptp(x))
    held = np.zeros((len(x), 3), dtype=bool)
    # Rollers on the two sides: zig-zag ends are held along x where they are.
    held[(x < 0.6 * l0) | (x > length - 0.6 * l0), 0] = True
    held[:, 2] = True
    held[np.argmin(np.abs(mesh.nodes - [length / 2, 0, 0]).sum(axis=1)), 1] = True
    stretch = np.sqrt(3) / 2 * MODULUS * THICKNESS * l0**2
    found = _solve(mesh, held, stretch, 0.0, None, mesh.nodes * [1 + strain, 1, 1], 1e-12)
    moved = found.x.reshape(-1, 3)
    middle = np.abs(x - length / 2) < length / 4
    across = np.polyfit(mesh.nodes[middle, 1], moved[middle, 1], 1)[0] - 1
    area = float(mesh.triangle_areas.sum())
    return 2 * found.energy / (strain**2 * area), float(-across / strain)


def cantilever(rows: int, load: float, thickness: float) -> tuple[float, float]:
    """Deflection and shortening of the tip over the length of a cantilever under an end load.

    It is half of a strip held in its middle and loaded at both ends, free to curve across.

    Args:
        rows: rows of triangles across.
        load: P L²/(E I).
        thickness: [m].
    """
    width = 0.01
    l0 = width / rows / np.sqrt(0.75)
    columns = 2 * round(8 * width / l0)
    mesh = strip(columns, rows, l0)
    x, y = mesh.nodes[:, 0], mesh.nodes[:, 1]
    length = columns * l0 / 2
    rigidity = MODULUS * thickness**3 / 12
    unit = load * (8 / 9) * rigidity * width / length**2
    near, far = x < 0.1 * l0, x > 2 * length - 0.1 * l0
    tips = near | far
    force = np.zeros_like(mesh.nodes)
    force[tips, 2] = 2 * unit / tips.sum()
    held = np.zeros((len(x), 3), dtype=bool)
    middle = int(np.argmin(np.abs(mesh.nodes - [length, 0, 0]).sum(axis=1)))
    held[middle] = True
    # Stops the strip from turning about y, without a force by symmetry.
    held[np.argmin(np.abs(mesh.nodes - [length - l0, 0, 0]).sum(axis=1)), 2] = True
    held[np.abs(y) < 0.1 * l0, 1] = True  # the mirror plane y = 0
    stretch = np.sqrt(3) / 2 * MODULUS * thickness * l0**2
    bend = 2 / np.sqrt(3) * rigidity
    found = _solve(mesh, held, stretch, bend, force, mesh.nodes, 1e-5 * unit)
    moved = found.x.reshape(-1, 3)
    apart = moved[far, 0].mean() - moved[near, 0].mean()
    return (
        float((moved[tips, 2].mean() - moved[middle, 2]) / length),
        float((2 * length - apart) / (2 * length)),
    )


def _solve(
    mesh: SheetMesh,
    held: NDArray[np.bool_],
    stretch: float,
    bend: float,
    force: Floats | None,
    start: Floats,
    tolerance: float,
) -> Minimum:
    """The equilibrium of uniform edges and hinges without coupling.

    Raises:
        ComputationError: there is none near the start.
    """
    edges, hinges = len(mesh.edges), len(mesh.hinges)
    total = Total.of(
        [
            EdgeStretch(mesh.edges, mesh.edge_lengths, np.full(edges, stretch), np.zeros(edges)),
            CoupledHinge(
                mesh.hinges,
                mesh.edge_lengths[mesh.hinge_edges[:, 1:]],
                np.full(hinges, bend),
                np.zeros(hinges),
                np.zeros(hinges),
            ),
            NodalLoad(
                np.arange(len(mesh.nodes), dtype=np.int32)[:, None],
                np.zeros_like(mesh.nodes) if force is None else force,
                mesh.nodes,
            ),
        ],
        len(mesh.nodes),
    ).at(1.0, 1.0)
    system = System(total, HeldDofs.of(total.pattern, held.ravel()), make_solver(total.pattern))
    found = minimise(system, start.ravel().copy(), NewtonOptions(tolerance, max_iterations=200))
    if found.outcome != "converged":
        raise ComputationError(f"the strip found no equilibrium ({found.outcome})")
    return found
