"""What is around the sheet of a design: its weight, the table, and the sheet itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sheetmorph.design.laminate import film_stack
from sheetmorph.design.loads import gravity_forces
from sheetmorph.design.regions import Regions
from sheetmorph.design.spec import Design
from sheetmorph.design.surroundings import DOWN
from sheetmorph.energy.loads import Weight
from sheetmorph.energy.self_contact import SelfContact, Shield
from sheetmorph.energy.table import TableContact
from sheetmorph.energy.term import Term
from sheetmorph.geometry.mesh import Floats, SheetMesh

RANGE = 0.2
"""Range of contact that a design does not give, in thicknesses of the film."""

START = 0.9
"""Height of the sheet above the least one at the beginning, in ranges."""

GUARD = 0.1
"""Range of the barrier that keeps neighbours from crossing, in altitudes of shrunk triangles."""

BEARERS = 3
"""Nodes that bear the whole weight at half the range of the table's barrier."""


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Weight, table, and the contact of the sheet with itself.

    Attributes:
        weights: of the nodes [N], shape (V, 3); zero without gravity.
        table: None where there is none.
        contact: of the sheet with itself; None where it may pass through itself.
        gap: least distance of two middle surfaces [m]; half of it from the table.
    """

    weights: Floats
    table: TableContact | None
    contact: SelfContact | None
    gap: float

    @property
    def terms(self) -> list[Term]:
        """The energy terms of what is there."""
        nodes = np.arange(len(self.weights), dtype=np.int32)[:, None]
        found: list[Term] = []
        if self.weights.any():
            found.append(Weight(nodes, self.weights, np.zeros_like(self.weights)))
        if self.table is not None:
            found.append(self.table)
        return found

    def numbers(self, positions: Floats) -> dict[str, Any]:
        """Numbers of a state for its summary; none where nothing is around the sheet.

        Args:
            positions: of the nodes [m], shape (V, 3).
        """
        found: dict[str, Any] = {}
        if self.weights.any():
            found["weight_N"] = float(np.linalg.norm(self.weights.sum(axis=0)))
        if self.table is not None:
            forces = self.table.forces(positions)
            found["table"] = {
                "reaction_N": float(forces.sum()),
                "nodes_in_contact": int((forces > 0.0).sum()),
                "lowest_m": float(self.table.heights(positions).min() + 0.5 * self.gap),
                "gap_m": 0.5 * self.gap,
                "range_m": self.table.range,
            }
        if self.contact is not None:
            found["self_contact"] = [
                {
                    "gap_m": shield.gap,
                    "range_m": shield.range,
                    "touches": bool(np.isfinite(room)),
                    "room_m": room if np.isfinite(room) else None,
                }
                for shield, room in zip(
                    self.contact.shields, self.contact.rooms(positions), strict=True
                )
            ]
        return found


def surroundings_of(
    design: Design, mesh: SheetMesh, region: Regions, eigenstrain: Floats, force_scale: float
) -> Surroundings:
    """What is around the sheet.

    Args:
        design: the design.
        mesh: its mesh.
        region: what lies in its pattern.
        eigenstrain: of the edges at full actuation, shape (E,).
        force_scale: of the model [N], see `ModelParts`; measure of contact without weight.
    """
    weights = gravity_forces(design, mesh, region)
    weight = float(np.linalg.norm(weights.sum(axis=0)))
    shields = shields_of(design, mesh, eigenstrain, force_scale)
    return Surroundings(
        weights,
        table_of(design, mesh, weight, force_scale),
        SelfContact(mesh, shields, max(1, design.solver.threads)) if shields else None,
        _gap(design),
    )


def table_of(
    design: Design, mesh: SheetMesh, weight: float, force_scale: float
) -> TableContact | None:
    """The table of a design; None where it has none.

    Args:
        design: the design.
        mesh: its mesh.
        weight: of the sheet [N].
        force_scale: see `surroundings_of`.
    """
    if not design.contact.table:
        return None
    down = DOWN["as_drawn"] if design.gravity is None else design.gravity.down
    up, reach = -np.array(down) / np.linalg.norm(down), _range(design)
    lowest = float((mesh.nodes @ up).min())
    return TableContact.of(
        len(mesh.nodes),
        up,
        lowest - design.contact.table_distance - START * reach,
        reach,
        weight / BEARERS if weight > 0.0 else force_scale,
    )


def shields_of(
    design: Design, mesh: SheetMesh, eigenstrain: Floats, force_scale: float
) -> tuple[Shield, ...]:
    """The barriers between parts of the sheet; none where it may pass through itself.

    Args:
        design: the design.
        mesh: its mesh.
        eigenstrain: of the edges at full actuation, shape (E,).
        force_scale: see `surroundings_of`.
    """
    if not design.contact.self_contact:
        return ()
    gap, reach = _gap(design), _range(design)
    left = 1.0 + float(min(eigenstrain.min(initial=0.0), 0.0))
    guard = Shield(0.0, GUARD * left * _least_altitude(mesh), force_scale)
    if gap <= 0.0:
        return (guard,)
    apart = (gap + reach) / left + 2.0 * float(mesh.edge_lengths.max())
    return guard, Shield(gap, reach, force_scale, apart)


def _gap(design: Design) -> float:
    given = design.contact.gap
    return film_stack(design).thickness if given is None else given


def _range(design: Design) -> float:
    given = design.contact.range
    return RANGE * film_stack(design).thickness if given is None else given


def _least_altitude(mesh: SheetMesh) -> float:
    longest = mesh.edge_lengths[mesh.triangle_edges].max(axis=1)
    return float((2.0 * mesh.triangle_areas / longest).min())
