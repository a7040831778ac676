"""A sheet as the paper computed it with Abaqus: tied shells of Mooney and Rivlin's solid.

Zhang, Alon, Jawed, *Emergent morphogenesis via planar fabrication enabled by a reduced model of
composites*, section on finite elements and Appendix B: one layer of S3R shells for each layer of
the sheet, contacting faces tied, C1 = C2 = G/4, D1 = 2/K, a field of thermal strain, and an
explicit step.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.design.sections import Layer
from sheetmorph.geometry.mesh import Floats
from sheetmorph.twin.sheet import SAME, Sheet
from sheetmorph.twin.solid import Ids

PER_STRAIN = 1000.0
"""Temperature of the unit of strain: −300 is a shrinkage of 30 %."""
ITEMS = 16
FRAMES = 20
SLOW = 10.0
"""Duration of the actuation, in periods of the slowest bending of the film."""


@dataclass(frozen=True)
class MooneyRivlin:
    """Constants of W = C1 (Ī1 − 3) + C2 (Ī2 − 3) + (J − 1)²/D1.

    Attributes:
        c1: [Pa].
        c2: [Pa].
        d1: [1/Pa].
    """

    c1: float
    c2: float
    d1: float

    @classmethod
    def of(cls, young: float, poisson: float) -> MooneyRivlin:
        """Those that agree with Hooke's law at small strain, with C1 = C2 (Appendix B)."""
        shear = young / (2.0 * (1.0 + poisson))
        bulk = young / (3.0 * (1.0 - 2.0 * poisson))
        return cls(shear / 4.0, shear / 4.0, 2.0 / bulk)


@dataclass(frozen=True, eq=False)
class _Shell:
    """One layer as a shell.

    Attributes:
        name: of its sets.
        layer: of the design.
        height: of its middle [m].
        nodes: of the plan, where it lies, increasing, shape (n,).
        triangles: of the plan, where it lies, shape (m,).
        first_node: number of its first node.
        first_element: number of its first element.
    """

    name: str
    layer: Layer
    height: float
    nodes: Ids
    triangles: Ids
    first_node: int
    first_element: int

    def number(self, nodes: Ids) -> Ids:
        """Numbers in the deck of nodes of the plan."""
        return np.asarray(self.first_node + np.searchsorted(self.nodes, nodes))


def abaqus_deck(sheet: Sheet) -> Iterator[str]:
    """The text of the deck in pieces, in SI units.

    The thermal strain is the engineering strain L/L0 − 1: Abaqus takes αΔθ for it in
    hyperelastic materials. It is given at the nodes, the mean of that of their triangles.

    Raises:
        InputError: a layer lies at several heights, shrinks more one way than the other, or
            the sheet has clamped edges or loads.
    """
    if len(sheet.clamped) or sheet.applied.any():
        raise InputError(
            "the Abaqus deck has neither clamped edges nor loads; only supports by nodes",
            key="supports",
        )
    shells = _shells(sheet)
    strain = _nodal_strain(sheet)
    period = SLOW * _slowest(sheet)
    yield "*HEADING\n"
    yield f"{sheet.name}: tied shells, Mooney-Rivlin, explicit. Units: m, kg, s, N, Pa\n"
    yield "*NODE, NSET=ALL\n"
    for shell in shells:
        points = sheet.mesh.nodes[shell.nodes]
        for index, (x, y, _) in enumerate(points, shell.first_node):
            yield f"{index}, {x:.10g}, {y:.10g}, {shell.height:.10g}\n"
    for shell in shells:
        yield f"** {shell.layer.name}, {1e3 * shell.layer.thickness:.6g} mm\n"
        yield f"*NSET, NSET=N_{shell.name}, GENERATE\n"
        yield f"{shell.first_node}, {shell.first_node + len(shell.nodes) - 1}, 1\n"
        yield f"*ELEMENT, TYPE=S3R, ELSET=E_{shell.name}\n"
        corners = shell.number(sheet.mesh.triangles[shell.triangles].astype(np.int64))
        for index, (a, b, c) in enumerate(corners, shell.first_element):
            yield f"{index}, {a}, {b}, {c}\n"
        yield f"*SHELL SECTION, ELSET=E_{shell.name}, MATERIAL={shell.name}\n"
        yield f"{shell.layer.thickness:.10g}, 5\n"
    for shell, factor in zip(shells, _factors(sheet, shells), strict=True):
        yield from _material(shell, factor, sheet)
    yield from _ties(sheet, shells)
    film = shells[_lowest_whole(sheet)]
    yield "*INITIAL CONDITIONS, TYPE=TEMPERATURE\n"
    for shell in shells:
        yield f"N_{shell.name}, 0.\n"
    yield f"*AMPLITUDE, NAME=ACTUATE, DEFINITION=SMOOTH STEP\n0., 0., {0.8 * period:.6g}, 1.\n"
    yield (
        "*AMPLITUDE, NAME=PERTURB, DEFINITION=SMOOTH STEP\n"
        f"0., 0., {0.05 * period:.6g}, 1., {0.6 * period:.6g}, 1., {0.8 * period:.6g}, 0.\n"
    )
    yield "*BOUNDARY\n"
    for node, axis in np.argwhere(sheet.held):
        yield f"{film.number(node)}, {axis + 1}, {axis + 1}\n"
    yield f"*STEP, NLGEOM=YES\n*DYNAMIC, EXPLICIT\n, {period:.6g}\n*BULK VISCOSITY\n0.06, 1.2\n"
    yield "*TEMPERATURE, AMPLITUDE=ACTUATE\n"
    for shell, factor in zip(shells, _factors(sheet, shells), strict=True):
        if factor:
            for node, number in zip(shell.nodes, shell.number(shell.nodes), strict=True):
                yield f"{number}, {PER_STRAIN * strain[node]:.8g}\n"
    loaded = np.argwhere(sheet.forces != 0.0)
    if len(loaded):
        yield "*CLOAD, AMPLITUDE=PERTURB\n"
    for node, axis in loaded:
        yield f"{film.number(node)}, {axis + 1}, {sheet.forces[node, axis]:.8g}\n"
    yield f"*OUTPUT, FIELD, NUMBER INTERVAL={FRAMES}\n*NODE OUTPUT\nU\n*ELEMENT OUTPUT\nLE, S\n"
    yield "*OUTPUT, HISTORY\n*ENERGY OUTPUT\nALLKE, ALLSE, ALLIE\n*END STEP\n"


def _shells(sheet: Sheet) -> list[_Shell]:
    found: list[_Shell] = []
    first_node = first_element = 1
    for index, layer in enumerate(sheet.layers):
        cells = [
            (cell, slab.middle)
            for cell, slabs in enumerate(sheet.slabs)
            for slab in slabs
            if slab.layer == index
        ]
        here = np.isin(sheet.triangle_cell, [cell for cell, _ in cells])
        heights = [middle for cell, middle in cells if (sheet.triangle_cell == cell).any()]
        if not heights:
            raise InputError("lies on no triangle of the mesh", key=f"layers[{index}]")
        if np.ptp(heights) > SAME * sheet.mesh.size:
            raise InputError(
                "lies at several heights, one of them on another layer of the pattern; the "
                "Abaqus deck has one flat shell for each layer",
                key=f"layers[{index}]",
                value=layer.name,
            )
        triangles = np.flatnonzero(here).astype(np.int64)
        nodes = np.unique(sheet.mesh.triangles[triangles]).astype(np.int64)
        name = f"L{index + 1}_" + re.sub(r"[^A-Z0-9]+", "_", layer.name.upper())[:30].strip("_")
        found.append(_Shell(name, layer, heights[0], nodes, triangles, first_node, first_element))
        first_node += len(nodes)
        first_element += len(triangles)
    return found


def _factors(sheet: Sheet, shells: list[_Shell]) -> Floats:
    return sheet.factors[: len(shells)]


def _lowest_whole(sheet: Sheet) -> int:
    """Index of the layer that bears supports and loads: the lowest that lies everywhere."""
    common = set.intersection(*({slab.layer for slab in slabs} for slabs in sheet.slabs))
    return min(common)


def _nodal_strain(sheet: Sheet) -> Floats:
    """Mean strain of the triangles around each node, by area, shape (V,).

    Raises:
        InputError: it is not the same in all directions.
    """
    e11, e22, e12 = sheet.eigenstrain.T
    if max(np.abs(e11 - e22).max(), np.abs(e12).max()) > SAME:
        raise InputError(
            "the Abaqus deck shrinks layers alike in all directions", key="actuation.transverse"
        )
    weights = np.repeat(sheet.mesh.triangle_areas, 3)
    places, count = sheet.mesh.triangles.ravel(), len(sheet.mesh.nodes)
    sums = np.bincount(places, weights=weights * np.repeat(e11, 3), minlength=count)
    return np.asarray(sums / np.bincount(places, weights=weights, minlength=count))


def _slowest(sheet: Sheet) -> float:
    """Period of the slowest bending of a strip of the first layer as long as the sheet [s]."""
    layer = sheet.layers[_lowest_whole(sheet)]
    h, length = layer.thickness, sheet.mesh.size
    rigidity = layer.young_modulus * h**3 / (12.0 * (1.0 - layer.poisson_ratio**2))
    # Free at both ends: (k L)² = 22.37 of the first mode.
    return float(2.0 * np.pi * length**2 / 22.37 * np.sqrt(layer.density * h / rigidity))


def _material(shell: _Shell, factor: float, sheet: Sheet) -> Iterator[str]:
    made = MooneyRivlin.of(shell.layer.young_modulus, shell.layer.poisson_ratio)
    damping = 4.0 * np.pi / _slowest(sheet)
    yield f"*MATERIAL, NAME={shell.name}\n*DENSITY\n{shell.layer.density:.10g}\n"
    yield f"*DAMPING, ALPHA={damping:.6g}\n"
    yield f"*HYPERELASTIC, MOONEY-RIVLIN\n{made.c1:.10g}, {made.c2:.10g}, {made.d1:.10g}\n"
    yield f"*EXPANSION, ZERO=0.\n{factor / PER_STRAIN:.10g}\n"


def _ties(sheet: Sheet, shells: list[_Shell]) -> Iterator[str]:
    """Faces and the ties between layers that touch; the upper one follows."""
    pairs = sorted(
        {(low.layer, high.layer) for slabs in sheet.slabs for low, high in pairwise(slabs)}
    )
    for low, high in pairs:
        below, above = shells[low], shells[high]
        tie = f"T{low + 1}_{high + 1}"
        gap = 0.5 * (below.layer.thickness + above.layer.thickness)
        yield f"*SURFACE, NAME={tie}_BELOW, TYPE=ELEMENT\nE_{below.name}, SPOS\n"
        yield f"*SURFACE, NAME={tie}_ABOVE, TYPE=ELEMENT\nE_{above.name}, SNEG\n"
        yield f"*TIE, NAME={tie}, ADJUST=NO, POSITION TOLERANCE={1.1 * gap:.6g}\n"
        yield f"{tie}_ABOVE, {tie}_BELOW\n"
