"""Derivatives through the numbers of table and self-contact, which follow from the design."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sheetmorph.design.actuation import edge_eigenstrain, thermal_strain
from sheetmorph.design.laminate import force_scale
from sheetmorph.design.loads import gravity_forces
from sheetmorph.design.regions import Regions
from sheetmorph.design.spec import Design
from sheetmorph.energy.self_contact import Shield
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.study.model import Problem
from sheetmorph.study.surroundings import Surroundings, shields_of, table_of

STEP = 1e-5
"""Of central differences, relative; of places and directions in ranges of the barrier."""

OF_TABLE, OF_SHIELD = 6, 3
"""How many numbers a table and a shield have."""


@dataclass(frozen=True)
class Scales:
    """What the barriers take from the whole sheet.

    Attributes:
        weight: of the sheet [N].
        force: see `ModelParts.force_scale` [N].
        least: eigenstrain of an edge, shape (1,).
    """

    weight: float
    force: float
    least: float

    @classmethod
    def of(cls, design: Design, mesh: SheetMesh, region: Regions) -> Scales:
        """Those of a design."""
        weights = gravity_forces(design, mesh, region)
        least = 0.0
        if design.contact.self_contact:
            least = float(thermal_strain(design, mesh, region).min())
        weight = float(np.linalg.norm(weights.sum(axis=0)))
        return cls(weight, force_scale(design, mesh, region), least)


@dataclass(frozen=True, eq=False)
class ContactSlopes:
    """How a function feels the barriers at a state.

    Attributes:
        problem: the problem.
        by_number: derivatives by the numbers of table and shields, see `numbers`.
        scales: of the design.
    """

    problem: Problem
    by_number: Floats
    scales: Scales

    @classmethod
    def of(cls, problem: Problem, x: Floats, adjoint: Floats) -> ContactSlopes | None:
        """−λᵀ ∂g/∂c for every number c of table and shields; None where nothing touches.

        Args:
            problem: the problem.
            x: the state, shape (n,).
            adjoint: λ, shape (n,).
        """
        around = problem.surroundings
        here, along = problem.positions(x), problem.positions(adjoint)
        resting = around.table is not None and bool(around.table.forces(here).any())
        if around.contact is not None:
            resting = resting or bool(np.isfinite(around.contact.rooms(here)).any())
        if not resting:
            return None
        scales = Scales.of(problem.design, problem.mesh, problem.regions)
        middle = numbers(problem.design, problem.mesh, scales)
        found = np.zeros(len(middle))
        for index, step in enumerate(_steps(around, middle, problem.mesh.size)):
            if step > 0.0:
                moved = np.zeros(len(middle))
                moved[index] = step
                ends = [_forces(around, middle + s * moved, here) for s in (1.0, -1.0)]
                found[index] = -float((along * (ends[0] - ends[1])).sum()) / (2.0 * step)
        return cls(problem, found, scales)

    def towards(self, ahead: tuple[Design, Regions], behind: tuple[Design, Regions]) -> float:
        """Change of the function, to first order, from one design to another through contact.

        Args:
            ahead: a design, and what lies where in it.
            behind: the other.
        """
        mesh = self.problem.mesh
        first, last = (
            numbers(design, mesh, Scales.of(design, mesh, region))
            for design, region in (ahead, behind)
        )
        return float(self.by_number @ (first - last))

    def by_scale(self, name: str) -> float:
        """Derivative by a scale alone.

        Args:
            name: a field of `Scales`.
        """
        design, mesh = self.problem.design, self.problem.mesh
        value = float(getattr(self.scales, name))
        step = STEP * abs(value)
        if step == 0.0:
            return 0.0
        ends = [
            numbers(design, mesh, replace(self.scales, **{name: value + s})) for s in (step, -step)
        ]
        return float(self.by_number @ (ends[0] - ends[1])) / (2.0 * step)

    def onto_fields(self, fields: dict[str, Floats]) -> dict[str, Floats]:
        """Fields with what a place does as the most rigid one, or the one that shrinks most."""
        problem, found = self.problem, dict(fields)
        if not problem.design.laminate:
            rigid = int(problem.model.bending_stiffness.argmax())
            found["bending_stiffness"] = fields["bending_stiffness"].copy()
            by_force = self.by_scale("force") / problem.mesh.mean_edge_length
            found["bending_stiffness"][rigid] += by_force
        by_least = self.by_scale("least")
        if by_least:
            edge = int(problem.thermal_strain.argmin())
            found["eigenstrain"] = fields["eigenstrain"] + by_least * self._strain_of(edge)
        return found

    def _strain_of(self, edge: int) -> Floats:
        """Derivative of the eigenstrain of an edge by that of all edges, or of all triangles."""
        mesh = self.problem.mesh
        if not self.problem.design.laminate:
            found = np.zeros(len(mesh.edges))
            found[edge] = 1.0
            return found
        found = np.zeros((len(mesh.triangles), 3))
        beside = np.flatnonzero((mesh.triangle_edges == edge).any(axis=1))
        for place in ((int(t), k) for t in beside for k in range(3)):
            one = np.zeros_like(found)
            one[place] = 1.0
            found[place] = edge_eigenstrain(mesh, one)[edge]
        return found


def numbers(design: Design, mesh: SheetMesh, scales: Scales) -> Floats:
    """Offset [m], range [m], stiffness [N/m] and normal of the table, gap, range and force [N]
    of every shield, one after the other; those that the design has.
    """
    found: list[float] = []
    table = table_of(design, mesh, scales.weight, scales.force)
    if table is not None:
        found += [table.offset, table.range, table.stiffness, *table.up.tolist()]
    for shield in shields_of(design, mesh, np.array([scales.least]), scales.force):
        found += [shield.gap, shield.range, shield.force]
    return np.array(found)


def _steps(around: Surroundings, middle: Floats, size: float) -> Floats:
    """Steps of the differences, 0 where a number stays; see `numbers`."""
    steps = STEP * np.abs(middle)
    start = 0
    if around.table is not None:
        steps[0] = STEP * around.table.range
        steps[3:OF_TABLE] = STEP * around.table.range / size
        start = OF_TABLE
    steps[start::OF_SHIELD] = np.where(
        middle[start::OF_SHIELD] > 0.0, STEP * middle[start + 1 :: OF_SHIELD], 0.0
    )
    return steps


def _forces(around: Surroundings, values: Floats, here: Floats) -> Floats:
    """Gradient of the barriers with other numbers at given positions [N], shape (V, 3)."""
    found, start = np.zeros_like(here), 0
    if around.table is not None:
        offset, reach, stiffness = values[:3].tolist()
        table = replace(
            around.table,
            offset=offset,
            range=reach,
            stiffness=stiffness,
            up=np.ascontiguousarray(values[3:OF_TABLE]),
        )
        found -= table.forces(here)[:, None] * table.up / (table.up @ table.up)
        start = OF_TABLE
    if around.contact is not None:
        shields = [
            Shield(*values[k : k + OF_SHIELD].tolist())
            for k in range(start, len(values), OF_SHIELD)
        ]
        around.contact.with_shields(shields).add(here, 1, found)
    return found
