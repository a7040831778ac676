"""Conformal maps against those that are known, and surfaces that have none."""

from __future__ import annotations

import numpy as np
import pytest

from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import InputError
from sheetmorph.geometry import structured
from sheetmorph.inverse import surfaces
from sheetmorph.inverse.flatten import flatten


def test_a_hemisphere_becomes_its_stereographic_image() -> None:
    flat = flatten(surfaces.bowl(0.5))
    r = np.linalg.norm(flat.plan, axis=1)
    # From the pole, with R = 1/2: ds = dr / (1 + (r/2R)²), 1 in the middle and 1/2 on the rim.
    assert r.max() == pytest.approx(1.0, rel=0.03)
    assert flat.factor == pytest.approx(1.0 / (1.0 + r**2), abs=0.02)
    assert not flat.developable


def test_angles_stay() -> None:
    flat = flatten(surfaces.saddle(0.4))

    def corner_angles(points: np.ndarray) -> np.ndarray:
        a, b, c = (points[flat.surface.triangles[:, k]] for k in range(3))
        u, v = b - a, c - a
        lengths = np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1)
        return np.degrees(np.arccos((u * v).sum(axis=1) / lengths))

    assert corner_angles(flat.plan) == pytest.approx(corner_angles(flat.surface.points), abs=3.0)
    assert flat.factor.max() == 1.0
    middle = np.linalg.norm(flat.plan, axis=1).argmin()
    rim_low = flat.factor[flat.rim].min()
    assert flat.factor[middle] < rim_low  # a saddle shrinks in its middle


def test_a_cylinder_is_developable() -> None:
    flat = flatten(surfaces.cylinder(0.3))
    assert flat.developable
    assert np.ptp(flat.plan, axis=0).max() == pytest.approx(
        0.5 * (0.25 + 0.09) / 0.3 * 4 * np.arctan(0.6), rel=0.02
    )


def test_triangles_keep_their_side_and_the_rim_runs_counter_clockwise() -> None:
    flat = flatten(surfaces.dome(0.3))
    a, b, c = (flat.plan[flat.surface.triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    assert (u[:, 0] * v[:, 1] > u[:, 1] * v[:, 0]).all()
    x, y = flat.plan[flat.rim].T
    assert 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)) > 0.0


def test_rings_and_closed_surfaces_are_refused() -> None:
    sheet = structured.disc(1.0, 8)
    inner = np.linalg.norm(sheet.triangle_centroids, axis=1) > 0.4
    ring = Surface(sheet.nodes, sheet.triangles[inner].astype(np.int64))
    with pytest.raises(InputError, match="2 rims"):
        flatten(ring)
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    closed = Surface(corners, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]))
    with pytest.raises(InputError, match="no rim"):
        flatten(closed)
