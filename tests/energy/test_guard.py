"""The guard against collapsing triangles."""

from __future__ import annotations

import numpy as np
import pytest

import sheetmorph as sm
from sheetmorph.energy.guard import TriangleGuard, qualities, qualities_by_sides
from sheetmorph.energy.stretch import EdgeStretch
from sheetmorph.energy.total import Total
from sheetmorph.geometry.mesh import SheetMesh
from sheetmorph.geometry.topology import build_mesh
from sheetmorph.solve.constraints import HeldDofs, rigid_motion_pins
from sheetmorph.solve.linear import make_solver
from sheetmorph.solve.minimise import NewtonOptions, Outcome, minimise
from sheetmorph.solve.system import System

EQUAL = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, np.sqrt(0.75), 0.0]])
ONE = np.array([[0, 1, 2]])


def one_triangle(height: float) -> np.ndarray:
    return EQUAL * [1.0, height, 1.0]


def test_quality() -> None:
    assert qualities(EQUAL, ONE)[0] == pytest.approx(1.0, abs=1e-15)
    assert qualities(7.0 * EQUAL, ONE)[0] == pytest.approx(1.0, abs=1e-15)
    assert qualities(one_triangle(0.0), ONE)[0] == 0.0
    flat = one_triangle(0.3)
    squares = np.array([[np.sum((flat[i] - flat[j]) ** 2) for i, j in ((0, 1), (1, 2), (2, 0))]])
    assert qualities_by_sides(squares) == pytest.approx(qualities(flat, ONE), rel=1e-12)
    assert qualities_by_sides(np.array([[9.0, 1.0, 1.0]]))[0] == 0.0  # sides 3, 1, 1: none


def test_it_is_felt_below_its_limit_alone() -> None:
    guard = TriangleGuard(ONE.astype(np.int32), np.array([0.3]), np.array([2.0]))
    total = Total.of([guard], 3, 0)
    above, below = one_triangle(0.35), one_triangle(0.15)
    assert qualities(above, ONE)[0] > 0.3 > qualities(below, ONE)[0]
    energy, gradient, hessian = total.evaluate(above.ravel(), 2)
    assert energy == 0.0 and not gradient.any() and not hessian.any()
    energy, gradient, _ = total.evaluate(below.ravel(), 1)
    assert energy > 0.0
    assert gradient.reshape(3, 3)[2, 1] < 0.0  # the corner is pushed away from its side
    assert total.evaluate(one_triangle(0.0).ravel(), 0)[0] == np.inf


def test_no_step_turns_a_triangle_over() -> None:
    guard = TriangleGuard(ONE.astype(np.int32), np.array([0.3]), np.array([2.0]))
    down = np.zeros((3, 3))
    down[2, 1] = -2.0 * EQUAL[2, 1]
    part = guard.reach(EQUAL, down)
    assert 0.0 < part < 0.5
    assert guard.reach(EQUAL, 0.1 * down) == 1.0


def test_springs_that_fit_no_triangle_have_an_equilibrium() -> None:
    """Natural lengths 1, 0.2, 0.2: alone they pull the triangle into a line and beyond."""
    mesh = build_mesh(EQUAL, ONE)
    shrunk = np.array([0.0 if set(edge) == {0, 1} else -0.8 for edge in mesh.edges.tolist()])
    springs = EdgeStretch(mesh.edges, mesh.edge_lengths, np.ones(3), shrunk)
    guard = TriangleGuard.of(mesh, np.ones(1))
    total = Total.of([springs, guard], 3, 0).at(1.0, 0.0)
    held = HeldDofs.of(total.pattern, rigid_motion_pins(mesh.nodes))
    system = System(total, held, make_solver(total.pattern, "auto", 1))
    found = minimise(system, mesh.nodes.ravel(), NewtonOptions(1e-10))
    assert found.outcome is Outcome.CONVERGED
    quality = qualities(found.x.reshape(3, 3), ONE)[0]
    assert 0.03 < quality < 0.3
    assert guard.held_open(found.x.reshape(3, 3)).tolist() == [0]


def test_the_usual_designs_do_not_feel_it(small_result: sm.Result, small_mesh: SheetMesh) -> None:
    assert small_result.summary["energy_J"]["guard"] == 0.0
    assert small_result.summary["detail"] == ""


def test_its_convex_part_is_positive(small_mesh: SheetMesh) -> None:
    total = Total.of([TriangleGuard.specimen(small_mesh, np.random.default_rng(0))], 42, 0)
    x = small_mesh.nodes + 1e-3 * np.random.default_rng(1).standard_normal((42, 3))
    exact, convex = (
        np.linalg.eigvalsh(total.pattern.full(total.evaluate(x.ravel(), order)[2]).toarray())
        for order in (2, 3)
    )
    assert convex[0] > -1e-10 * convex[-1]
    assert exact[0] < -1e-3 * convex[-1]
