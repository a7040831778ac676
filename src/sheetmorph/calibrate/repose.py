"""The pose of a scan on a shape that has changed a little: a local search from a known pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.surface import Surface
from sheetmorph.geometry.mesh import Floats

MAX_ITERATIONS = 40
CONVERGED = 1e-7
"""Relative change of the mean squared distance at which the search ends."""

_TOUCHING = 1e-9  # share of the size below which the direction of a distance is the normal


@dataclass(frozen=True, eq=False)
class Points:
    """Points that stand for a surface.

    Attributes:
        points: shape (n, 3).
        weights: share of the area of each, shape (n,); they add up to 1.
    """

    points: Floats
    weights: Floats

    @classmethod
    def sampled(cls, surface: Surface, count: int, seed: int = 0) -> Points:
        """Points spread over the area by chance."""
        return cls(surface.sample(count, seed).points, np.full(count, 1.0 / count))

    @classmethod
    def on_triangles(cls, surface: Surface, count: int) -> Points:
        """Equal parts of every triangle, at least `count` in all.

        They lie at the same place of their triangles whatever the surface's shape, so that
        what is summed over them is a smooth function of that shape.
        """
        parts = max(1, int(np.ceil(np.sqrt(count / len(surface.triangles)))))
        up = [(i + 1 / 3, j + 1 / 3) for i in range(parts) for j in range(parts - i)]
        down = [(i + 2 / 3, j + 2 / 3) for i in range(parts) for j in range(parts - i - 1)]
        places = np.array(up + down) / parts
        shares = np.column_stack([1.0 - places.sum(axis=1), places])
        points = np.einsum("pk,tkd->ptd", shares, surface.points[surface.triangles])
        weights = np.tile(surface.areas / surface.area, len(shares)) / len(shares)
        return cls(points.reshape(-1, 3), weights)


@dataclass(frozen=True, eq=False)
class Fit:
    """A scan laid on a shape.

    Attributes:
        pose: from the scan to the shape.
        rms: root mean square of the distances both ways [m], as `symmetric_rms`.
        one_way: of scan to shape, and of shape to scan [m].
        signed: distances of the scan's points from the shape [m], positive on the side of
            the shape's normals, shape (n,).
    """

    pose: Similarity
    rms: float
    one_way: tuple[float, float]
    signed: Floats

    @property
    def rms_in_scan(self) -> float:
        """The rms in the scan's own unit of length."""
        return self.rms / self.pose.scale


def repose(
    scan: Surface,
    on_scan: Points,
    shape: Surface,
    on_shape: Points,
    pose: Similarity,
    *,
    fixed_scale: bool,
) -> Fit:
    """The pose near a given one with the least distance both ways.

    Levenberg-Marquardt steps on the distances themselves: their derivative by the pose is
    the direction to the nearest point, exactly, on rims as well as inside.

    Args:
        scan: the scan, in its own unit.
        on_scan: points that stand for it.
        shape: the shape [m].
        on_shape: points that stand for it.
        pose: where to begin, scan to shape.
        fixed_scale: True to keep the scale of the pose.
    """
    current = _measure(scan, on_scan, shape, on_shape, pose)
    damping = 1e-6
    for _ in range(MAX_ITERATIONS):
        step = _step(scan, on_scan, shape, on_shape, current, damping, fixed_scale)
        trial = _measure(scan, on_scan, shape, on_shape, step.after(current.pose))
        if trial.rms <= current.rms:
            done = current.rms**2 - trial.rms**2 <= CONVERGED * current.rms**2
            current, damping = trial, max(damping / 10, 1e-9)
            if done:
                break
        else:
            damping *= 30
            if damping > 1e3:
                break
    return Fit(current.pose, current.rms, current.one_way, current.signed)


@dataclass(frozen=True, eq=False)
class _Measured:
    pose: Similarity
    rms: float
    one_way: tuple[float, float]
    signed: Floats
    moving: Floats  # points that move with the pose, both ways
    direction: Floats  # in which a shift of them adds to their distance
    distance: Floats


def _measure(
    scan: Surface, on_scan: Points, shape: Surface, on_shape: Points, pose: Similarity
) -> _Measured:
    there = pose.apply(on_scan.points)
    to_shape = shape.nearest(there)
    back = scan.nearest(pose.inverse().apply(on_shape.points))
    touched = pose.apply(back.point)
    away = pose.scale * back.distance
    normals = shape.normals[to_shape.triangle]
    small = _TOUCHING * shape.size
    first = _directions(there - to_shape.point, to_shape.distance, normals, small)
    second = _directions(
        touched - on_shape.points, away, pose.turn(scan.normals[back.triangle]), small
    )
    forth_square = float(on_scan.weights @ to_shape.distance**2)
    back_square = float(on_shape.weights @ away**2)
    side = np.where(np.einsum("nd,nd->n", first, normals) < 0, -1.0, 1.0)
    return _Measured(
        pose=pose,
        rms=float(np.sqrt(0.5 * (forth_square + back_square))),
        one_way=(float(np.sqrt(forth_square)), float(np.sqrt(back_square))),
        signed=side * to_shape.distance,
        moving=np.concatenate([there, touched]),
        direction=np.concatenate([first, second]),
        distance=np.concatenate([to_shape.distance, away]),
    )


def _directions(offsets: Floats, distances: Floats, normals: Floats, small: float) -> Floats:
    far = distances > small
    unit = offsets / np.where(far, distances, 1.0)[:, None]
    return np.where(far[:, None], unit, normals)


def _step(
    scan: Surface,
    on_scan: Points,
    shape: Surface,
    on_shape: Points,
    now: _Measured,
    damping: float,
    fixed_scale: bool,
) -> Similarity:
    """A small similarity, to be done after the present pose."""
    from scipy.spatial.transform import Rotation

    weights = 0.5 * np.concatenate([on_scan.weights, on_shape.weights])
    centre = weights @ now.moving
    arms = now.moving - centre
    length = float(np.sqrt(weights @ (arms**2).sum(axis=1)))
    columns = [np.cross(arms, now.direction) / length, now.direction]
    if not fixed_scale:
        columns.append(np.einsum("nd,nd->n", arms, now.direction)[:, None] / length)
    jacobian = np.concatenate(columns, axis=1)
    normal = jacobian.T @ (jacobian * weights[:, None])
    gradient = jacobian.T @ (weights * now.distance)
    # A shape of revolution may be turned without cost: the floor keeps that from blowing up.
    diagonal = np.maximum(np.diag(normal), 1e-9)
    change = -np.linalg.solve(normal + np.diag(damping * diagonal + 1e-12), gradient)
    rotation = Rotation.from_rotvec(np.clip(change[:3] / length, -0.5, 0.5)).as_matrix()
    scale = 1.0 if fixed_scale else float(np.exp(np.clip(change[6] / length, -0.3, 0.3)))
    shift = centre + change[3:6] - scale * (rotation @ centre)
    return Similarity(scale, rotation, shift)
