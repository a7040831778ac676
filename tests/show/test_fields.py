"""Averages onto triangles and nodes, choice of states, smooth motion."""

import numpy as np
import pytest

from sheetmorph.show import fields


def test_averages_keep_a_constant(dome_result):
    mesh = dome_result.mesh
    assert np.allclose(fields.edges_to_triangles(mesh, np.full(len(mesh.edges), 2.5)), 2.5)
    assert np.allclose(fields.edges_to_nodes(mesh, np.full(len(mesh.edges), 2.5)), 2.5)
    assert np.allclose(fields.hinges_to_nodes(mesh, np.full(len(mesh.hinges), 2.5)), 2.5)


def test_triangle_averages_take_their_own_edges(dome_result):
    mesh = dome_result.mesh
    values = np.random.default_rng(1).normal(size=len(mesh.edges))
    lookup = {tuple(sorted(e)): v for e, v in zip(mesh.edges.tolist(), values, strict=True)}
    means = fields.edges_to_triangles(mesh, values)
    for triangle, mean in zip(mesh.triangles.tolist(), means, strict=True):
        a, b, c = sorted(triangle)
        assert mean == pytest.approx((lookup[a, b] + lookup[b, c] + lookup[a, c]) / 3)


def test_states_of_the_overview():
    ramp = np.linspace(0, 1, 11)
    assert fields.pick_states(ramp, np.zeros(11), 4) == [0, 3, 7, 10]
    assert fields.pick_states(np.zeros(1), np.zeros(1), 4) == [0]
    assert fields.pick_states(np.array([0.0, 1.0]), np.zeros(2), 4) == [0, 1]
    removed = np.concatenate([ramp, np.ones(5)])
    load = np.concatenate([np.ones(11), np.linspace(0.8, 0, 5)])
    assert fields.pick_states(removed, load, 4)[-1] == 15


def test_motion_passes_through_the_states_without_overshoot():
    ramp = np.array([0.0, 0.1, 0.15, 0.5, 1.0])
    positions = np.zeros((5, 2, 3))
    positions[:, 0, 2] = [0.0, 0.0, 5.0, 5.0, 6.0]  # the sheet snaps
    moved, actuation = fields.motion(positions, ramp, np.zeros(5), -0.4 * ramp, 41)
    assert moved.shape == (41, 2, 3)
    assert np.allclose(moved[0], positions[0])
    assert np.allclose(moved[-1], positions[-1])
    assert np.all(np.diff(moved[:, 0, 2]) >= -1e-12)
    assert np.allclose(actuation, np.linspace(0, -0.4, 41))


def test_motion_shows_the_load_being_removed():
    ramp, load = np.array([0.0, 1.0, 1.0, 1.0]), np.array([1.0, 1.0, 0.5, 0.0])
    positions = np.arange(4.0)[:, None, None] * np.ones((1, 1, 3))
    moved, actuation = fields.motion(positions, ramp, load, -ramp, 12)
    assert moved[-1, 0, 0] == pytest.approx(3.0)
    assert moved[-2, 0, 0] == pytest.approx(1.0)
    assert actuation[-2:] == pytest.approx([-1.0, -1.0])


def test_ranges_of_colours():
    assert fields.angle_limits(np.zeros(4)) == (0.0, fields.MIN_ANGLE_RANGE)
    assert fields.strain_limits(np.array([-0.3, 0.1])) == (-0.3, 0.3)
    assert fields.shown_range(np.array([-0.3, 0.1]), (-0.3, 0.3)) == (-0.3, 0.1)
    low, high = fields.shown_range(np.zeros(3), (-1.0, 1.0))
    assert high - low == pytest.approx(0.2)
