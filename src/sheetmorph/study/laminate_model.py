"""The energy of the laminate model for a design on its mesh, and what it says of a state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sheetmorph.design.actuation import triangle_eigenstrain
from sheetmorph.design.laminate import LayerStack, force_scale
from sheetmorph.design.regions import Regions
from sheetmorph.design.sections import EVERYWHERE
from sheetmorph.design.spec import Design
from sheetmorph.design.supports import directed_edges
from sheetmorph.energy.fold import FoldGuard
from sheetmorph.energy.guard import TriangleGuard
from sheetmorph.energy.laminate import LaminateShell
from sheetmorph.energy.laminate_fields import energy_parts
from sheetmorph.energy.laminate_patch import Patch
from sheetmorph.energy.lamination import Lamination, Layup
from sheetmorph.energy.shape_measures import ShapeMeasures
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.study.parts import ModelParts


def laminate_shell(design: Design, mesh: SheetMesh, region: Regions) -> LaminateShell:
    """The layered triangles of a design.

    Raises:
        InputError: actuation, pattern and mesh do not fit together.
    """
    edges, conormals = directed_edges(design, mesh, region)
    patch = Patch.of(mesh, mesh.mean_edge_length, edges, conormals)
    measures = ShapeMeasures.of(mesh.nodes, patch, mesh.triangle_frames)
    cells, layups = _layups(design, region)
    lamination = Lamination(
        measures=measures,
        cells=cells,
        layups=layups,
        eigenstrains=triangle_eigenstrain(design, mesh, region),
        thickening=design.spec.laminate.thickening == "volume_conserved",
    )
    return LaminateShell.of(patch, lamination)


def _layups(design: Design, region: Regions) -> tuple[NDArray[np.intp], tuple[Layup, ...]]:
    """Which layup each triangle has, shape (T,), and the layups."""
    if region.smooth is None:
        layups = tuple(_layup(design, cell.parts, cell.stack) for cell in region.cells)
        return region.triangle_cell, layups
    whole = _layup(design, region.smooth.names, LayerStack.of(design.layers))
    shares = region.smooth.layer_shares(design, region.smooth.triangles)
    tapered = replace(whole, thicknesses=shares * whole.thicknesses[:, None])
    return np.zeros_like(region.triangle_cell), (tapered,)


def _layup(design: Design, parts: tuple[str, ...], stack: LayerStack) -> Layup:
    """The stack of a cell; its layers that lie everywhere carry the reference surface."""
    places = [layer.where for layer in design.layers if layer.where in (EVERYWHERE, *parts)]
    return Layup(
        stack.thicknesses,
        stack.young_moduli,
        stack.poisson_ratios,
        stack.eigenstrain_factors,
        np.array([place == EVERYWHERE for place in places], dtype=np.bool_),
    )


def laminate_parts(design: Design, mesh: SheetMesh, region: Regions) -> ModelParts:
    """Layered triangles with directors on their sides.

    Raises:
        InputError: as for `laminate_shell`.
    """
    shell = laminate_shell(design, mesh, region)
    membrane = max(cell.stack.membrane_stiffness for cell in region.cells)
    stiff = np.array([cell.stack.membrane_stiffness for cell in region.cells])
    natural = shell.at(1.0, 0.0).rest.natural
    guard = TriangleGuard.of(
        mesh, stiff[region.triangle_cell] * mesh.triangle_areas, natural[:, :3]
    )
    return ModelParts(
        terms=(shell, guard, FoldGuard.of(mesh, _hinge_stiffness(shell, mesh))),
        held_scalars=shell.patch.held,
        force_scale=force_scale(design, mesh, region),
        stretch_force=membrane * float(mesh.edge_lengths.max()),
        natural_lean=_natural_lean(natural),
    )


def _hinge_stiffness(shell: LaminateShell, mesh: SheetMesh) -> Floats:
    """What turning a hinge by 1 rad costs the stiffer of its triangles, twice [J], shape (H,)."""
    found = np.zeros(len(mesh.edges))
    for ramp in (0.0, 1.0):
        rest = shell.at(ramp, 0.0).rest
        stiff = (2.0 * _heights(rest.natural[:, :3])) ** 2
        stiff *= np.diagonal(rest.stiffness, axis1=1, axis2=2)[:, 3:]
        np.maximum.at(found, mesh.triangle_edges[:, [1, 2, 0]], stiff)
    return np.asarray(found[mesh.hinge_edges[:, 0]])


def _natural_lean(natural: Floats) -> float:
    """Largest |α| of natural shape measures (l², 2 h α), shape (T, 6) [rad]."""
    leans = natural[:, 3:] / (2.0 * _heights(natural[:, :3]))
    return float(np.abs(leans).max(initial=0.0))


def _heights(sides: Floats) -> Floats:
    """Altitudes of triangles by their squared sides, both of shape (T, 3) [m]."""
    sixteenth = sides.sum(axis=1) ** 2 - 2.0 * (sides**2).sum(axis=1)  # 16 area², by Heron
    return np.asarray(np.sqrt(np.maximum(sixteenth, 1e-300) / 4.0)[:, None] / np.sqrt(sides))


def energy_densities(
    shell: LaminateShell, positions: Floats, scalars: Floats, ramp: Floats
) -> tuple[Floats, Floats]:
    """Stretching and bending energy per area of the flat sheet [J/m²], shape (S, T) each.

    Args:
        shell: the layered triangles of the design.
        positions: of the states [m], shape (S, V, 3).
        scalars: their scalar unknowns [m], shape (S, n).
        ramp: their fractions of the actuation, shape (S,).
    """
    states = np.concatenate([positions.reshape(len(positions), -1), scalars], axis=1)
    parts = [energy_parts(shell.at(float(t), 0.0), x) for t, x in zip(ramp, states, strict=True)]
    areas = shell.lamination.measures.areas
    return np.array([s for s, _ in parts]) / areas, np.array([b for _, b in parts]) / areas
