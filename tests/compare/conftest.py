"""Surfaces made for the tests of scans: sheets, thick sheets, floors, poses."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.typing import NDArray

from sheetmorph.compare.surface import Surface

Floats = NDArray[np.float64]


def _grid(shape: Callable[..., tuple[Floats, ...]], count: int = 60, half: float = 1.0) -> Surface:
    """The image of a square of (u, v), within ±half."""
    line = np.linspace(-half, half, count)
    u, v = (w.ravel() for w in np.meshgrid(line, line, indexing="ij"))
    i, j = (w.ravel() for w in np.meshgrid(*[np.arange(count - 1)] * 2, indexing="ij"))
    a = i * count + j
    first = np.stack([a, a + count, a + count + 1], axis=1)
    second = np.stack([a, a + count + 1, a + 1], axis=1)
    return Surface(np.stack(shape(u, v), axis=1), np.concatenate([first, second]))


def _bowl(depth: float = 0.5, count: int = 60) -> Surface:
    """A paraboloid over the unit disc that opens upwards."""
    square = _grid(lambda u, v: (u, v, depth * (u * u + v * v)), count)
    middle = square.points[square.triangles].mean(axis=1)
    return square.part((middle[:, :2] ** 2).sum(axis=1) < 1.0)


def _thick(sheet: Surface, thickness: float) -> Surface:
    """Both faces of a sheet, then its rim; the first face is the one of the sheet's normals."""
    count = len(sheet.points)
    normals = np.zeros_like(sheet.points)
    for k in range(3):
        np.add.at(normals, sheet.triangles[:, k], sheet.normals * sheet.areas[:, None])
    normals *= 0.5 * thickness / np.linalg.norm(normals, axis=1)[:, None]
    t = sheet.triangles
    halves = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    inverse, uses = np.unique(
        np.sort(halves, axis=1), axis=0, return_inverse=True, return_counts=True
    )[1:]
    a, b = halves[uses[inverse.ravel()] == 1].T
    rim = [np.stack([b, a, a + count], axis=1), np.stack([b, a + count, b + count], axis=1)]
    points = np.concatenate([sheet.points + normals, sheet.points - normals])
    return Surface(points, np.concatenate([t, t[:, ::-1] + count, *rim]))


def _joined(*surfaces: Surface) -> Surface:
    shifts = np.cumsum([0, *(len(s.points) for s in surfaces[:-1])])
    triangles = [s.triangles + shift for s, shift in zip(surfaces, shifts, strict=True)]
    return Surface(np.concatenate([s.points for s in surfaces]), np.concatenate(triangles))


def _posed(surface: Surface, seed: int, noise: float = 0.0, scale: float = 7.0) -> Surface:
    """Turned and shifted at random, in another unit, with rough points."""
    random = np.random.default_rng(seed)
    rough = surface.points + noise * random.normal(size=surface.points.shape)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    return Surface(scale * rough @ turn.T + random.normal(size=3), surface.triangles)


@pytest.fixture(scope="session")
def made() -> SimpleNamespace:
    """Makers of surfaces: grid, bowl, thick, joined, posed, flat (a floor at a height)."""

    def flat(height: float, half: float = 3.0, count: int = 50) -> Surface:
        return _grid(lambda u, v: (u, v, 0.0 * u + height), count, half)

    return SimpleNamespace(
        grid=_grid, bowl=_bowl, thick=_thick, joined=_joined, posed=_posed, flat=flat
    )
