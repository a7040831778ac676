"""Displacements at load steps against a published table, on several families of meshes."""

from __future__ import annotations

from collections.abc import Mapping

from sheetmorph.geometry.mesh import Floats
from sheetmorph.proofs.proof import Check, Curve, Plot

SOURCE = (
    "Sze, Liu, Lo, Popular benchmark problems for geometric nonlinear analysis of shells, Finite "
    "Elements in Analysis and Design 40, 2004"
)
LIMIT = 0.02
"""Largest relative error of a displacement."""

Displacements = Mapping[str, Floats]
"""Displacements [m] at every load step by what they are, such as "inner end"."""


def load_step_checks(
    loads: Floats,
    known: Displacements,
    found: Mapping[str, Displacements],
    quantity: str,
    digits: str = "g",
) -> list[Check]:
    """Every displacement at every load step, in every family of meshes.

    Args:
        loads: over the largest, shape (loads,).
        known: the table.
        found: the same displacements by the family of the mesh, such as "structured".
        quantity: of which place these are, such as "lift of the".
        digits: format of a load in texts.
    """
    return [
        Check(
            f"{family}-{place.split()[0]}-{load:{digits}}",
            f"{quantity} {place} at P = {load:{digits}} Pmax, {family}",
            float(value),
            float(own),
            LIMIT,
        )
        for family, moves in found.items()
        for place, values in known.items()
        for load, value, own in zip(loads, values, moves[place], strict=True)
    ]


def load_step_plot(
    name: str,
    title: str,
    axis: str,
    loads: Floats,
    known: Displacements,
    found: Mapping[str, Displacements],
) -> Plot:
    """The table as lines, what was found as marks; see `load_step_checks`.

    Args:
        name: of the file, without its ending.
        title: of the plot.
        axis: what is drawn along x, with its unit.
        loads, known, found: as for `load_step_checks`.
    """
    lines = [
        Curve(f"{place}, Sze et al.", values, loads, "line") for place, values in known.items()
    ]
    marks = [
        Curve(f"{place}, {family}", moves[place], loads)
        for family, moves in found.items()
        for place in known
    ]
    return Plot(name, title, axis, "P / Pmax", (*lines, *marks))
