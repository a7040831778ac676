"""Held degrees of freedom, pins of a free sheet, and rigid alignment."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation
from toys import dense_pattern

from sheetmorph.solve.constraints import HeldDofs, align_to_reference, rigid_motion_pins


def test_held_rows_become_a_multiple_of_the_identity() -> None:
    pattern = dense_pattern(5)
    rng = np.random.default_rng(0)
    a = rng.standard_normal((5, 5))
    a = a @ a.T
    held = np.array([False, True, False, False, True])
    data = HeldDofs.of(pattern, held).reduce(a[np.triu_indices(5)])
    reduced = pattern.full(data).toarray()
    free = ~held
    np.testing.assert_array_equal(reduced[np.ix_(free, free)], a[np.ix_(free, free)])
    assert (reduced[np.ix_(free, held)] == 0).all()
    corner = reduced[np.ix_(held, held)]
    assert corner[0, 0] == corner[1, 1] > 0
    assert corner[0, 1] == 0


def test_pins_stop_exactly_the_rigid_motions() -> None:
    nodes = np.random.default_rng(1).uniform(-1, 1, (30, 3)) * [1, 1, 0]
    held = rigid_motion_pins(nodes)
    assert held.sum() == 6
    motions = []
    for axis in np.eye(3):
        motions.append(np.tile(axis, (30, 1)).ravel())
        motions.append(np.cross(axis, nodes).ravel())
    values = np.linalg.svd(np.array(motions)[:, held], compute_uv=False)
    assert values[-1] > 0.1


def test_alignment_undoes_a_rigid_motion_and_never_mirrors() -> None:
    rng = np.random.default_rng(2)
    flat = rng.uniform(-1, 1, (40, 3)) * [1, 1, 0]
    shape = flat + [0, 0, 1] * (flat[:, :1] ** 2)
    turn = Rotation.from_rotvec([0.3, 2.0, -0.4])
    aligned = align_to_reference(np.array([flat, shape]), flat)
    moved = align_to_reference(np.array([turn.apply(flat) + 3.0, turn.apply(shape) - 1.0]), flat)
    np.testing.assert_allclose(moved, aligned, atol=1e-12)
    np.testing.assert_allclose(aligned[0], flat, atol=1e-12)
    mirrored = shape * [1, 1, -1]
    up = align_to_reference(np.array([shape, mirrored]), flat)
    np.testing.assert_allclose(up[1, :, 2], -up[0, :, 2], atol=1e-9)
