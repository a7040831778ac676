"""Which states of a run are taken, and where they belong on the plan."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from test_frd import block
from twin_designs import FILM

import sheetmorph as sm
from sheetmorph.twin.frd import Displacements
from sheetmorph.twin.sheet import Sheet
from sheetmorph.twin.solid import extrude
from sheetmorph.twin.solve import positions_of, whole_steps


def test_whole_steps_that_converged_are_taken(tmp_path: Path) -> None:
    path = tmp_path / "twin.frd"
    times = [1.0, 1.5, 2.0, 3.0, 3.0]
    path.write_text("".join(block(time, [(1, float(k), 0, 0)]) for k, time in enumerate(times)))
    # The third step was given up: its best guess is in the file, but is no equilibrium.
    found = whole_steps(path, (1.0, 1.5, 2.0), 5)
    assert {step: state.values[0, 0] for step, state in found.items()} == {0: 0.0, 1: 2.0}
    assert whole_steps(path, (), 5) == {}
    assert whole_steps(tmp_path / "none.frd", (1.0,), 5) == {}


def test_displacements_in_any_order_find_their_nodes() -> None:
    sheet = Sheet.of(sm.Design.from_toml(FILM))
    solid = extrude(sheet)
    order = np.random.default_rng(5).permutation(len(solid.nodes))
    values = 1e3 * solid.nodes[order] * [0.1, -0.2, 0.0] + [0.0, 0.0, 3.0]
    found = positions_of(sheet, solid, Displacements(1.0, order + 1, values))
    wanted = sheet.mesh.nodes * [1.1, 0.8, 1.0] + [0.0, 0.0, 3e-3]
    np.testing.assert_allclose(found, wanted, atol=1e-15)
