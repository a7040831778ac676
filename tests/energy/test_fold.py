"""The guard against triangles that fold through each other."""

from __future__ import annotations

import numpy as np
import pytest

import sheetmorph as sm
from sheetmorph.energy.fold import FOLDED, FoldGuard
from sheetmorph.energy.guard import TriangleGuard
from sheetmorph.energy.hinge import CoupledHinge
from sheetmorph.energy.taylor import taylor_slopes
from sheetmorph.energy.total import Total
from sheetmorph.geometry.mesh import SheetMesh
from sheetmorph.geometry.surface import dihedral_angles
from sheetmorph.geometry.topology import build_mesh
from sheetmorph.solve.constraints import HeldDofs, rigid_motion_pins
from sheetmorph.solve.linear import make_solver
from sheetmorph.solve.minimise import NewtonOptions, Outcome, minimise
from sheetmorph.solve.system import System

NODES = np.array([[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.4, 0.9, 0.0], [0.6, -0.8, 0.0]])


@pytest.fixture(scope="module")
def hinge() -> SheetMesh:
    return build_mesh(NODES, np.array([[0, 1, 2], [1, 0, 3]]))


def turned(angle: float) -> np.ndarray:
    """The second triangle turned about the edge, by degrees."""
    x, along = NODES.copy(), NODES[1] / np.linalg.norm(NODES[1])
    foot = (x[3] @ along) * along
    radius = np.deg2rad(angle)
    x[3] = foot + np.cos(radius) * (x[3] - foot) + np.sin(radius) * np.cross(along, x[3] - foot)
    return x


def guard_of(mesh: SheetMesh) -> FoldGuard:
    return FoldGuard.of(mesh, np.array([0.2]))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_it_is_felt_beyond_its_limit_alone(hinge: SheetMesh, sign: float) -> None:
    guard, limit = guard_of(hinge), np.rad2deg(FOLDED)
    total = Total.of([guard], 4, 0)
    energy, gradient, hessian = total.evaluate(turned(sign * (limit - 0.01)).ravel(), 2)
    assert energy == 0.0 and not gradient.any() and not hessian.any()
    assert guard.idle(turned(sign * (limit - 0.01)))
    beyond = turned(sign * (limit + 10.0))
    assert not guard.idle(beyond) and guard.held_open(beyond).tolist() == [0]
    energy, gradient, _ = total.evaluate(beyond.ravel(), 1)
    farther = turned(sign * (limit + 10.1))
    assert energy > 0.0
    assert gradient @ (farther - beyond).ravel() > 0.0
    assert total.evaluate(turned(sign * 179.999).ravel(), 0)[0] > 10.0 * energy


@pytest.mark.parametrize("angle", [157.0, 175.0, -165.0, -179.0])
def test_derivatives(hinge: SheetMesh, angle: float) -> None:
    total = Total.of([guard_of(hinge)], 4, 0)
    rng = np.random.default_rng(1)
    x = turned(angle) + 1e-3 * rng.standard_normal(NODES.shape)
    # as far as the angle moves by a small part of its room up to 180°
    direction = (180.0 - abs(angle)) * 1e-2 * rng.standard_normal(x.size)
    slopes = taylor_slopes(total, x.ravel(), direction, np.geomspace(1e-2, 1e-3, 6))
    assert slopes.gradient == pytest.approx(2.0, abs=0.1)
    assert slopes.hessian == pytest.approx(3.0, abs=0.1)


def test_no_step_folds_past_flat(hinge: SheetMesh) -> None:
    guard, start = guard_of(hinge), turned(170.0)
    through = turned(195.0) - start
    part = guard.reach(start, through)
    assert 0.0 < part < 1.0
    angles = dihedral_angles(np.array([start, start + part * through]), hinge.hinges)
    assert angles[0, 0] * angles[1, 0] > 0.0
    assert guard.reach(start, turned(178.0) - start) == 1.0
    assert guard.reach(start, turned(60.0) - start) == 1.0


def test_a_hinge_that_wants_to_go_on_stops_before_flat(hinge: SheetMesh) -> None:
    """Its natural angle is 400°, a turn and more: alone it would go round."""
    eager = CoupledHinge(
        *(hinge.hinges, hinge.edge_lengths[hinge.hinge_edges[:, 1:]]),
        *(np.array([0.2]), np.array([1.0]), np.array([np.deg2rad(400.0)])),
    )
    triangles = TriangleGuard.of(hinge, np.ones(2))
    total = Total.of([eager, triangles, guard_of(hinge)], 4, 0).at(1.0, 0.0)
    held = HeldDofs.of(total.pattern, rigid_motion_pins(hinge.nodes))
    held = HeldDofs.of(total.pattern, held.held | (np.arange(12) < 9))
    system = System(total, held, make_solver(total.pattern, "auto", 1))
    found = minimise(system, turned(20.0).ravel(), NewtonOptions(1e-10))
    assert found.outcome is Outcome.CONVERGED
    assert 155.0 < np.rad2deg(abs(dihedral_angles(found.x.reshape(4, 3), hinge.hinges)[0])) < 180.0


def test_the_usual_designs_do_not_feel_it(small_result: sm.Result) -> None:
    assert small_result.summary["energy_J"]["fold"] == 0.0


def test_its_convex_part_is_positive(small_mesh: SheetMesh) -> None:
    total = Total.of([FoldGuard.specimen(small_mesh, np.random.default_rng(0))], 42, 0)
    x = small_mesh.nodes + 1e-3 * np.random.default_rng(1).standard_normal((42, 3))
    exact, convex = (
        np.linalg.eigvalsh(total.pattern.full(total.evaluate(x.ravel(), order)[2]).toarray())
        for order in (2, 3)
    )
    assert convex[0] > -1e-10 * convex[-1]
    assert exact[0] < -1e-3 * convex[-1]
