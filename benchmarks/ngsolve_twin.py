"""A second finite-element witness: the twin of a free sheet by NGSolve, beside the shape.

    pip install ngsolve            # used by this script alone
    python benchmarks/ngsolve_twin.py examples/verify/strip.toml --steps 20

The body and the law are those of `sheetmorph verify --fe calculix`: one wedge for each layer and
triangle, and each layer's energy from its natural state. The code shares nothing with CalculiX:
the energy is written as it stands and derived by NGSolve, and displacements are quadratic in
full (18 functions on a wedge, not 15).
"""

from __future__ import annotations

import argparse
from time import perf_counter
from typing import Any

import numpy as np
from netgen.meshing import Element2D, Element3D, FaceDescriptor, MeshPoint, Pnt
from netgen.meshing import Mesh as NetgenMesh
from ngsolve import (
    L2,
    BilinearForm,
    CoefficientFunction,
    Det,
    Grad,
    GridFunction,
    Id,
    InnerProduct,
    Inv,
    Mesh,
    Parameter,
    Trace,
    Variation,
    VectorH1,
    dx,
)

import sheetmorph as sm
from sheetmorph.geometry.surface import aspect_ratio
from sheetmorph.solve.constraints import align_to_reference, rigid_motion_pins
from sheetmorph.twin.sheet import Sheet
from sheetmorph.twin.solid import Solid, extrude

MM = 1e3


def mesh_of(solid: Solid) -> tuple[Mesh, np.ndarray]:
    """Wedges of six corners [mm], and the corner of each node (−1 for none)."""
    corners = np.unique(solid.wedges[:, :6])
    place = np.full(len(solid.nodes), -1)
    place[corners] = np.arange(len(corners))
    made = NetgenMesh()
    points = [made.Add(MeshPoint(Pnt(*(MM * solid.nodes[node])))) for node in corners]
    made.SetMaterial(1, "sheet")
    for wedge in solid.wedges[:, :6]:
        made.Add(Element3D(1, [points[place[node]] for node in wedge]))
    made.Add(FaceDescriptor(surfnr=1, domin=1, bc=1))
    faces: dict[tuple[int, ...], list[list[int]]] = {}
    for wedge in solid.wedges[:, :6]:
        for face in ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)):
            nodes = [int(place[wedge[k]]) for k in face]
            faces.setdefault(tuple(sorted(nodes)), []).append(nodes)
    for found in faces.values():
        if len(found) == 1:
            made.Add(Element2D(1, [points[node] for node in found[0]]))
    return Mesh(made), place


def main() -> None:
    """Solve, align, and print how far the two are apart."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("design")
    parser.add_argument("--steps", type=int, default=20)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    chosen = parser.parse_args()
    values = dict(text.split("=", 1) for text in chosen.set)
    design = sm.Design.load(chosen.design, values)
    sheet = Sheet.of(design)
    if not sheet.free:
        raise SystemExit("for free sheets alone")
    began = perf_counter()
    positions, iterations, dofs = solve(sheet, chosen.steps)
    twin = perf_counter() - began
    stops = tuple(np.arange(1, chosen.steps) / chosen.steps)
    result = sm.simulate(design, stops=stops)
    own = result.positions[-1]
    moved = align_to_reference(positions[None], own)[0]
    apart = np.linalg.norm(moved - own, axis=1)
    areas = sheet.mesh.node_areas
    rms = np.sqrt(areas @ apart**2 / areas.sum())
    size = np.linalg.norm(np.ptp(own, axis=0))
    print(
        f"{design.name}: eps_pre {design.eps_pre:g}, {dofs} unknowns, {iterations} iterations\n"
        f"  RMS between nodes {1e3 * rms:.3f} mm ({100 * rms / size:.2f} % of "
        f"{1e3 * size:.1f} mm), largest {1e3 * apart.max():.3f} mm\n"
        f"  h/d {aspect_ratio(own):.4f} shape, {aspect_ratio(moved):.4f} NGSolve\n"
        f"  time {result.summary['seconds']['total']:.2f} s shape, {twin:.1f} s NGSolve"
    )


def solve(sheet: Sheet, steps: int) -> tuple[np.ndarray, int, int]:
    """Positions of the plan's nodes on the reference plane [m], iterations, unknowns."""
    solid = extrude(sheet)
    mesh, place = mesh_of(solid)
    space = VectorH1(mesh, order=2)
    constant = L2(mesh, order=0)

    def field(values: np.ndarray) -> GridFunction:
        made = GridFunction(constant)
        made.vec.FV().NumPy()[:] = values
        return made

    layers = [sheet.layers[k] for k in solid.layer]
    young = np.array([layer.young_modulus for layer in layers])
    poisson = np.array([layer.poisson_ratio for layer in layers])
    lame = field(young * poisson / ((1 + poisson) * (1 - 2 * poisson)))
    shear = field(young / (2 * (1 + poisson)))
    e11, e22, e12 = (
        field(sheet.factors[solid.layer] * sheet.eigenstrain[solid.triangle, k]) for k in range(3)
    )
    share = Parameter(0.0)
    a, b, c = 1 + share * e11, 1 + share * e22, share * e12
    up = 1 / (a * b - c * c) if sheet.thickening else CoefficientFunction(1.0)
    natural = CoefficientFunction((a, c, 0, c, b, 0, 0, 0, up), dims=(3, 3))
    u = space.TrialFunction()
    elastic = (Id(3) + Grad(u)) * Inv(natural)
    green = 0.5 * (elastic.trans * elastic - Id(3))
    energy = 0.5 * lame * Trace(green) ** 2 + shear * InnerProduct(green, green)
    form = BilinearForm(space, symmetric=True)
    form += Variation((Det(natural) * energy).Compile() * dx(bonus_intorder=2))
    # Pins and loads act on the corners below the plan's nodes, not half a film higher.
    below = np.array([_lowest(solid, node) for node in range(len(sheet.mesh.nodes))])
    per_axis = space.ndof // 3
    free = space.FreeDofs()
    for node, axis in np.argwhere(rigid_motion_pins(sheet.mesh.nodes).reshape(-1, 3)):
        free[int(axis * per_axis + place[below[node]])] = False
    load = GridFunction(space).vec.CreateVector()
    load[:] = 0.0
    for node, axis in np.argwhere(sheet.forces != 0.0):
        load[int(axis * per_axis + place[below[node]])] += 1e6 * sheet.forces[node, axis]
    shape = GridFunction(space)
    path = [(0.0, 1.0), *((k / steps, 1.0) for k in range(1, steps + 1)), (1.0, 0.0)]
    iterations = 0
    for ramp, part in path:
        share.Set(ramp)
        iterations += _newton(form, shape, part, load, free)
    at = MM * sheet.mesh.nodes
    moves = np.array([shape(mesh(*point)) for point in at])
    return sheet.mesh.nodes + moves / MM, iterations, space.ndof


def _lowest(solid: Solid, node: int) -> int:
    """The corner at the bottom of the column over a node of the plan."""
    column = np.flatnonzero(solid.column == node)
    return int(column[solid.nodes[column, 2].argmin()])


def _newton(form: BilinearForm, shape: GridFunction, part: float, load: Any, free: Any) -> int:
    """Newton's method with a backtracking search on the energy."""
    residual, step = shape.vec.CreateVector(), shape.vec.CreateVector()
    old = shape.vec.CreateVector()
    for iteration in range(1, 200):
        form.Apply(shape.vec, residual)
        residual.data -= part * load
        form.AssembleLinearization(shape.vec)
        step.data = form.mat.Inverse(free, inverse="sparsecholesky") * residual
        old.data = shape.vec
        before = form.Energy(shape.vec) - part * InnerProduct(load, shape.vec)
        fall = abs(InnerProduct(step, residual))
        size = 1.0
        while size > 1e-4:
            shape.vec.data = old - size * step
            after = form.Energy(shape.vec) - part * InnerProduct(load, shape.vec)
            if after <= before + 1e-9 * abs(before) or np.isclose(after, before, rtol=1e-9):
                break
            size *= 0.5
        if size == 1.0 and fall < 1e-12 * max(abs(before), 1e-6):
            return iteration
    raise SystemExit("NGSolve: no equilibrium in 200 iterations; take more steps")


if __name__ == "__main__":
    main()
