"""The energy terms that exist. The tests walk this table: a new term adds one line."""

from __future__ import annotations

from sheetmorph.energy.fold import FoldGuard
from sheetmorph.energy.guard import TriangleGuard
from sheetmorph.energy.hinge import CoupledHinge
from sheetmorph.energy.laminate import LaminateShell
from sheetmorph.energy.loads import AppliedLoad, NodalLoad, Weight
from sheetmorph.energy.stretch import EdgeStretch
from sheetmorph.energy.table import TableContact
from sheetmorph.energy.term import Term

TERMS: dict[str, type[Term]] = {
    EdgeStretch.name: EdgeStretch,
    CoupledHinge.name: CoupledHinge,
    LaminateShell.name: LaminateShell,
    NodalLoad.name: NodalLoad,
    AppliedLoad.name: AppliedLoad,
    Weight.name: Weight,
    TableContact.name: TableContact,
    TriangleGuard.name: TriangleGuard,
    FoldGuard.name: FoldGuard,
}
"""Name of the term → its class."""
