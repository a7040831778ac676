"""A sheet as an input deck of CalculiX."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.twin.natural import natural_metric, natural_strain, pulled_back_stiffness
from sheetmorph.twin.sheet import Sheet
from sheetmorph.twin.solid import Ids, Solid

Law = Literal["natural", "expansion"]

POINTS = 9
"""Integration points of a wedge of 15 nodes."""
MOST_LINES = 4_000_000
ROW = 16
LENGTH, FORCE = 1e-3, 1e-6
"""Units of the deck [m], [N]: millimetres and micronewtons, so that pressures are in pascals.

CalculiX takes forces below 1e-6 of its unit for zero; in newtons that is too much for films.
"""
CONTROLS = """*CONTROLS, PARAMETERS=TIME INCREMENTATION
25,30,40,60,40,4,,5
*CONTROLS, PARAMETERS=FIELD
1e-5,1e-3,,,1e-5,1e-12,1e-3,1e-12
"""


@dataclass(frozen=True)
class DeckOptions:
    """How the deck drives the sheet.

    Attributes:
        law: "natural" gives every layer its natural state, as the laminate model does;
            "expansion" is the usual deck, isotropic with `*EXPANSION`.
        steps: equal steps of the actuation.
    """

    law: Law = "natural"
    steps: int = 20


@dataclass(frozen=True, eq=False)
class Deck:
    """Lines of a deck and what its steps mean.

    Attributes:
        text: the deck, in pieces.
        ramp: fraction of the actuation at the end of each step, shape (S,).
        load: fraction of the perturbation at the end of each step, shape (S,).
    """

    text: Iterable[str]
    ramp: Floats
    load: Floats


def write_deck(sheet: Sheet, solid: Solid, options: DeckOptions) -> Deck:
    """The deck of a sheet: load it a little, actuate it, take the load away.

    Each step takes one unit of the solver's time, so that the time of a result says how far
    it is.

    Raises:
        InputError: it would have more than `MOST_LINES` lines of strains.
    """
    actuate = np.arange(1, options.steps + 1) / options.steps
    fade = 1.0 - np.arange(1, sheet.fading_steps + 1) / sheet.fading_steps
    ramp = np.concatenate([[0.0], actuate, np.ones(len(fade))])
    load = np.concatenate([[1.0], np.ones(options.steps), fade])
    groups = _Groups.of(sheet, solid)
    lines = options.steps * POINTS * int(groups.moves.sum())
    if options.law == "natural" and lines > MOST_LINES:
        raise InputError(
            f"the deck would have {lines} lines of strains",
            key="mesh.size",
            allowed=f"≤ {MOST_LINES} lines: a larger mesh.size, or fewer steps",
        )
    text = _deck(sheet, solid, groups, options, ramp, load)
    return Deck(text, ramp, load)


@dataclass(frozen=True, eq=False)
class _Groups:
    """Wedges of one material: one layer, and one strain.

    Attributes:
        group: of each wedge, shape (W,).
        layer: layer of each group, shape (G,).
        eigenstrain: of each group at full actuation, shape (G, 3).
        moves: wedges with a strain, shape (W,).
    """

    group: Ids
    layer: Ids
    eigenstrain: Floats
    moves: Ids

    @classmethod
    def of(cls, sheet: Sheet, solid: Solid) -> _Groups:
        strain = sheet.factors[solid.layer][:, None] * sheet.eigenstrain[solid.triangle]
        table = np.column_stack([solid.layer, np.round(strain, 12)])
        kinds, group = np.unique(table, axis=0, return_inverse=True)
        moves = np.abs(strain).max(axis=1) > 0.0
        return cls(group.ravel(), kinds[:, 0].astype(np.int64), kinds[:, 1:], moves)


def _deck(
    sheet: Sheet,
    solid: Solid,
    groups: _Groups,
    options: DeckOptions,
    ramp: Floats,
    load: Floats,
) -> Iterator[str]:
    yield f"** {sheet.name}: {len(solid.wedges)} wedges, law: {options.law}\n"
    yield "** units: mm, µN, Pa; the temperature is the fraction of the actuation\n"
    yield "*NODE, NSET=ALL\n"
    yield from (
        f"{index},{x:.12g},{y:.12g},{z:.12g}\n"
        for index, (x, y, z) in enumerate(solid.nodes / LENGTH, 1)
    )
    for group, layer in enumerate(groups.layer):
        members = np.flatnonzero(groups.group == group)
        yield f"** {sheet.layers[layer].name}\n"
        yield f"*ELEMENT, TYPE=C3D15, ELSET=G{group + 1}\n"
        for wedge in members:
            yield from rows([int(wedge) + 1, *(solid.wedges[wedge] + 1)])
    yield "*NSET, NSET=SURFACE\n"
    yield from rows(solid.surface + 1)
    strains = groups.eigenstrain
    for group, layer in enumerate(groups.layer):
        yield from _material(group, sheet, int(layer), strains[group], options, ramp)
    yield "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL,0.\n"
    moving = np.flatnonzero(groups.moves)
    if options.law == "natural" and len(moving):
        yield "*INITIAL CONDITIONS, TYPE=PLASTIC STRAIN\n"
        yield from (
            f"{wedge + 1},{point},0.,0.,0.,0.,0.,0.\n"
            for wedge in moving
            for point in range(1, POINTS + 1)
        )
    yield from _supports(sheet, solid)
    reached = np.zeros((len(strains), 6))
    for step, (share, force) in enumerate(zip(ramp, load, strict=True)):
        yield f"** step {step + 1}: actuation {share:.6g}, load {force:.6g}\n"
        yield "*STEP, NLGEOM, INC=1000\n*STATIC\n1.,1.,1e-4,1.\n"
        yield CONTROLS
        yield f"*TEMPERATURE\nALL,{share:.12g}\n"
        if options.law == "natural" and step and share > ramp[step - 1]:
            wanted = natural_strain(natural_metric(share * strains, sheet.thickening))
            yield "*INITIAL STRAIN INCREASE\n"
            more = [",".join(f"{part:.12g}" for part in row) for row in wanted - reached]
            reached = wanted
            for wedge in moving:
                tail = more[groups.group[wedge]]
                yield "".join(f"{wedge + 1},{point},{tail}\n" for point in range(1, POINTS + 1))
        yield from _loads(sheet, solid, share, force)
        yield "*NODE FILE, NSET=SURFACE\nU\n*END STEP\n"


def _material(
    group: int, sheet: Sheet, layer: int, strain: Floats, options: DeckOptions, ramp: Floats
) -> Iterator[str]:
    made = sheet.layers[layer]
    name = f"M{group + 1}"
    yield f"*MATERIAL, NAME={name}\n"
    if options.law == "expansion":
        yield f"*ELASTIC\n{made.young_modulus:.12g},{made.poisson_ratio:.12g}\n"
        if np.abs(strain).max() > 0.0:
            if strain[2] or strain[0] != strain[1]:
                yield "*EXPANSION, TYPE=ANISO, ZERO=0.\n"
                yield f"{strain[0]:.12g},{strain[1]:.12g},0.,{strain[2]:.12g},0.,0.\n"
            else:
                yield f"*EXPANSION, ZERO=0.\n{strain[0]:.12g}\n"
    else:
        shares = np.unique(ramp) if np.abs(strain).max() > 0.0 else np.zeros(1)
        constants = pulled_back_stiffness(
            natural_metric(shares[:, None] * strain, sheet.thickening),
            made.young_modulus,
            made.poisson_ratio,
        )
        yield "*ELASTIC, TYPE=ANISO\n"
        for share, row in zip(shares, constants, strict=True):
            values = [f"{value:.12g}" for value in [*row, share]]
            for part in (values[:8], values[8:16], values[16:]):
                yield ",".join(part) + "\n"
    yield f"*SOLID SECTION, ELSET=G{group + 1}, MATERIAL={name}\n"


def _supports(sheet: Sheet, solid: Solid) -> Iterator[str]:
    held = {(int(solid.surface[node]), int(axis)) for node, axis in np.argwhere(sheet.held)}
    for edge, axis in zip(sheet.clamped, sheet.clamped_axis, strict=True):
        columns = [*sheet.mesh.edges[edge], len(sheet.mesh.nodes) + edge]
        for node in np.flatnonzero(np.isin(solid.column, columns)):
            held.add((int(node), int(axis)))
    yield "*BOUNDARY\n"
    yield from (f"{node + 1},{axis + 1},{axis + 1}\n" for node, axis in sorted(held))


def _loads(sheet: Sheet, solid: Solid, share: float, fraction: float) -> Iterator[str]:
    forces = (fraction * sheet.forces + share * sheet.applied) / FORCE
    loaded = np.argwhere((sheet.forces != 0.0) | (sheet.applied != 0.0))
    if len(loaded):
        yield "*CLOAD\n"
    for node, axis in loaded:
        yield f"{solid.surface[node] + 1},{axis + 1},{forces[node, axis]:.12g}\n"


def rows(values: Sequence[int] | Ids) -> Iterator[str]:
    """Numbers by `ROW` on a line; a comma at the end says that the list goes on."""
    for begin in range(0, len(values), ROW):
        text = ",".join(str(value) for value in values[begin : begin + ROW])
        yield text + (",\n" if begin + ROW < len(values) else "\n")
