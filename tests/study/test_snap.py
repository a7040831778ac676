"""The snap of a bistable disc, against growing dead forces."""

from __future__ import annotations

import numpy as np
import pytest

from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.proofs.bilayer_disc import RADIUS, DiscSheet
from sheetmorph.proofs.sheets import nearest_node
from sheetmorph.solve.arclength import pushed
from sheetmorph.solve.minimise import NewtonOptions, minimise
from sheetmorph.study.snap import poke

DOWN = np.array([0.0, 0.0, -2.0])
NATURAL = 2.0


@pytest.fixture(scope="module")
def sheet() -> DiscSheet:
    """A quarter of a disc that has two shapes, rolled along x or along y."""
    return DiscSheet.of(6, NATURAL, lens=False, quarter=True)


@pytest.fixture(scope="module")
def rolled(sheet: DiscSheet) -> Floats:
    return sheet.settled(NATURAL, sheet.saddled(sheet.problem.start))


def ends(sheet: DiscSheet, x: Floats) -> tuple[float, float]:
    """Heights of the rim on the axes x and y."""
    nodes, z = sheet.problem.mesh, sheet.problem.positions(x)[:, 2]
    along, across = (nearest_node(nodes, place) for place in ((RADIUS, 0, 0), (0, RADIUS, 0)))
    return float(z[along]), float(z[across])


def test_the_snap_of_the_disc(sheet: DiscSheet, rolled: Floats) -> None:
    node = nearest_node(sheet.problem.mesh, (RADIUS, 0, 0))
    found = poke(sheet.problem, rolled, node, DOWN, system=sheet.system)
    assert found.snap_force is not None and found.off is not None and found.under is not None
    before, after = ends(sheet, rolled), ends(sheet, found.off)
    assert before[0] > 3 * before[1]
    # It stays in the other shape, which is the same about the other axis.
    np.testing.assert_allclose(after, before[::-1], rtol=1e-2)
    assert (np.diff(found.displacement) > 0).all()

    # A force that grows in steps: the shape holds below the snap force and gives way above.
    force = np.zeros_like(rolled)
    force[3 * node + 2] = -1.0
    loading = pushed(sheet.system.at(1.0, 0.0), force)
    options = NewtonOptions(sheet.problem.residual_tolerance, max_iterations=300)
    for part, snaps in ((0.99, False), (1.01, True)):
        x = rolled
        for share in np.linspace(0.1, 1.0, 10):
            x = minimise(loading(part * share * found.snap_force), x, options).x
        high, low = ends(sheet, x)
        assert (high < low) == snaps


def test_a_poke_that_does_not_snap(sheet: DiscSheet) -> None:
    flat = sheet.settled(0.5, sheet.problem.start)
    found = poke(
        sheet.problem,
        flat,
        nearest_node(sheet.problem.mesh, (RADIUS, 0, 0)),
        DOWN,
        ramp=0.5 / NATURAL,
        reach=2e-4,
        system=sheet.system,
    )
    assert found.snap_force is None and found.off is None
    assert found.displacement[-1] > 2e-4
    first = found.curve.points[1]
    assert found.curve.points[-1].parameter > first.parameter > 0.0


def test_pokes_that_cannot_be(sheet: DiscSheet, rolled: Floats) -> None:
    problem = sheet.problem
    with pytest.raises(InputError, match="no such node"):
        poke(problem, rolled, 10_000, DOWN)
    with pytest.raises(InputError, match="needs a direction"):
        poke(problem, rolled, 0, np.zeros(3))
    with pytest.raises(InputError, match="is held"):
        poke(problem, rolled, nearest_node(problem.mesh, (0, 0, 0)), DOWN)
    node = nearest_node(problem.mesh, (RADIUS, 0, 0))
    with pytest.raises(ComputationError, match="only a shape in stable"):
        poke(problem, problem.start, node, DOWN, ramp=1.0)
