"""The pose of a scan on a shape that has changed a little: a local search from a known pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.surface import Indices, Surface
from sheetmorph.geometry.mesh import Floats

MAX_ITERATIONS = 40
CONVERGED = 1e-7
"""Relative fall of the mean squared distance that is not worth another step."""

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
    def corners(cls, surface: Surface) -> Points:
        """Every corner, with a third of the area of its triangles.

        Where a scanner errs from point to point, these are all that it has measured; points
        between them would only repeat it.
        """
        corners = surface.triangles.ravel()
        share = np.bincount(corners, np.repeat(surface.areas, 3), len(surface.points))
        used = surface.used
        return cls(surface.points[used], share[used] / share.sum())

    @classmethod
    def on_triangles(cls, surface: Surface, count: int) -> Points:
        """Equal parts of every triangle, at least `count` in all.

        They lie at the same place of their triangles whatever the surface's shape, so that
        what is summed over them is a smooth function of that shape.
        """
        points = on_parts(surface.points, surface.triangles, count)
        each = len(points) // len(surface.triangles)
        return cls(points, np.tile(surface.areas / surface.area, each) / each)


def on_parts(values: Floats, triangles: Indices, count: int) -> Floats:
    """What is given at the corners, at the points of `Points.on_triangles`.

    Args:
        values: at the corners, shape (V, 3).
        triangles: shape (T, 3).
        count: see there.

    Returns:
        Linear within each triangle, shape (n, 3).
    """
    parts = max(1, int(np.ceil(np.sqrt(count / len(triangles)))))
    up = [(i + 1 / 3, j + 1 / 3) for i in range(parts) for j in range(parts - i)]
    down = [(i + 2 / 3, j + 2 / 3) for i in range(parts) for j in range(parts - i - 1)]
    places = np.array(up + down) / parts
    shares = np.column_stack([1.0 - places.sum(axis=1), places])
    return np.asarray(np.einsum("pk,tkd->ptd", shares, values[triangles]).reshape(-1, 3))


@dataclass(frozen=True, eq=False)
class Fit:
    """A scan laid on a shape, measured at n points of the scan and m of the shape (or none).

    Attributes:
        pose: from the scan to the shape.
        rms: root mean square of the distances both ways [m], as `symmetric_rms`.
        distance: of the points, those of the scan first [m], shape (n + m,).
        direction: unit vectors; a shift of the scan along them adds to the distance, one of
            the shape takes from it, shape (n + m, 3).
        moving: where the scan is touched [m], shape (n + m, 3).
        triangle: of the shape, nearest to each point of the scan, shape (n,).
        foot: the nearest points themselves [m], shape (n, 3).
        weights: of the distances in the mean square, shape (n + m,); they add up to 1.
        signed: distances of the scan's points from the shape [m], positive on the side of
            the shape's normals, shape (n,).
    """

    pose: Similarity
    rms: float
    distance: Floats
    direction: Floats
    moving: Floats
    triangle: Indices
    foot: Floats
    weights: Floats
    signed: Floats

    @property
    def rms_in_scan(self) -> float:
        """The rms in the scan's own unit of length."""
        return self.rms / self.pose.scale

    def by_pose(self, *, fixed_scale: bool) -> tuple[Floats, Floats, float]:
        """How the distances, in the scan's unit, change with the pose.

        Returns:
            Derivatives by rotations (in shares of a length), shifts and, unless it is held, the
            logarithm of the scale (in shares of that length), times the present scale, shape
            (n + m, 6 or 7); the centre of the rotations [m], and the length [m].
        """
        centre = self.weights @ self.moving
        arms = self.moving - centre
        length = float(np.sqrt(self.weights @ (arms**2).sum(axis=1)))
        columns = [np.cross(arms, self.direction) / length, self.direction]
        if not fixed_scale:
            stretched = np.einsum("nd,nd->n", arms, self.direction)
            columns.append((stretched - self.distance)[:, None] / length)
        return np.concatenate(columns, axis=1), centre, length


def repose(
    scan: Surface,
    on_scan: Points,
    shape: Surface,
    on_shape: Points | None,
    pose: Similarity,
    *,
    fixed_scale: bool,
) -> Fit:
    """The pose near a given one with the least distance, in the scan's own unit.

    Levenberg-Marquardt steps on the distances themselves: their derivative by the pose is
    the direction to the nearest point, exactly, on rims as well as inside.

    Args:
        scan: the scan, in its own unit.
        on_scan: points that stand for it.
        shape: the shape [m].
        on_shape: points that stand for it; None measures from the scan to the shape alone.
        pose: where to begin, scan to shape.
        fixed_scale: True to keep the scale of the pose.
    """
    current = _measure(scan, on_scan, shape, on_shape, pose)
    damping = 1e-6
    for _ in range(MAX_ITERATIONS):
        step, promised = _step(current, damping, fixed_scale)
        if promised <= CONVERGED * current.rms**2:
            break
        trial = _measure(scan, on_scan, shape, on_shape, step.after(current.pose))
        if trial.rms_in_scan <= current.rms_in_scan:
            current, damping = trial, max(damping / 10, 1e-9)
        else:
            damping *= 30
            if damping > 1e3:
                break
    return current


def _measure(
    scan: Surface, on_scan: Points, shape: Surface, on_shape: Points | None, pose: Similarity
) -> Fit:
    there = pose.apply(on_scan.points)
    near = shape.nearest(there)
    normals = shape.normals[near.triangle]
    small = _TOUCHING * shape.size
    direction = _directions(there - near.point, near.distance, normals, small)
    side = np.where(np.einsum("nd,nd->n", direction, normals) < 0, -1.0, 1.0)
    distance, moving, weights = near.distance, there, on_scan.weights
    if on_shape is not None:
        back = scan.nearest(pose.inverse().apply(on_shape.points))
        touched, away = pose.apply(back.point), pose.scale * back.distance
        facing = pose.turn(scan.normals[back.triangle])
        other = _directions(touched - on_shape.points, away, facing, small)
        direction = np.concatenate([direction, other])
        distance = np.concatenate([distance, away])
        moving = np.concatenate([moving, touched])
        weights = 0.5 * np.concatenate([weights, on_shape.weights])
    return Fit(
        pose=pose,
        rms=float(np.sqrt(weights @ distance**2)),
        distance=distance,
        direction=direction,
        moving=moving,
        triangle=near.triangle,
        foot=near.point,
        weights=weights,
        signed=side * near.distance,
    )


def _directions(offsets: Floats, distances: Floats, normals: Floats, small: float) -> Floats:
    far = distances > small
    unit = offsets / np.where(far, distances, 1.0)[:, None]
    return np.where(far[:, None], unit, normals)


def _step(now: Fit, damping: float, fixed_scale: bool) -> tuple[Similarity, float]:
    """A small similarity, to be done after the present pose; how much of the square it takes."""
    from scipy.spatial.transform import Rotation

    jacobian, centre, length = now.by_pose(fixed_scale=fixed_scale)
    normal = jacobian.T @ (jacobian * now.weights[:, None])
    gradient = jacobian.T @ (now.weights * now.distance)
    # A shape of revolution may be turned without cost: the floor keeps that from blowing up.
    diagonal = np.maximum(np.diag(normal), 1e-9)
    change = -np.linalg.solve(normal + np.diag(damping * diagonal + 1e-12), gradient)
    rotation = Rotation.from_rotvec(np.clip(change[:3] / length, -0.5, 0.5)).as_matrix()
    scale = 1.0 if fixed_scale else float(np.exp(np.clip(change[6] / length, -0.3, 0.3)))
    shift = centre + change[3:6] - scale * (rotation @ centre)
    return Similarity(scale, rotation, shift), -float(gradient @ change)
