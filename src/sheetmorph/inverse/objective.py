"""The squared distance between a sheet and a target as a smooth function of the sheet's nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sheetmorph.compare.align import best_pose
from sheetmorph.compare.fit import Pair, refine
from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.surface import Samples, Surface
from sheetmorph.geometry.mesh import Floats, Ints
from sheetmorph.inverse.misfit import POINTS, QUICK


@dataclass(frozen=True, eq=False)
class Apart:
    """How far a sheet is from a target in the pose that brings them closest.

    Attributes:
        square: mean of the mean squared distances both ways, over the size of the target squared.
        slope: derivative of it by the node positions [1/m], shape (V, 3).
        pose: of the target.
    """

    square: float
    slope: Floats
    pose: Similarity


def apart(
    target: Surface, positions: Floats, triangles: Ints, near: Similarity | None = None
) -> Apart:
    """Measure the squared distance both ways, and differentiate it.

    Where a point's nearest point and the pose are, the distance is least: so neither needs a
    derivative of its own (Danskin 1967), and what is left are the offsets themselves.

    Args:
        target: [m].
        positions: of the nodes [m], shape (V, 3).
        triangles: shape (T, 3).
        near: a pose of the target to begin with; all are tried when None.
    """
    shape = Surface(positions, triangles.astype(np.int64))
    pose = best_pose(target, shape, 1.0, 0, QUICK) if near is None else near
    samples = target.sample(POINTS)
    nodes = Samples(positions, np.zeros(len(positions), dtype=np.int64))
    fit = refine(Pair(target, shape, samples, nodes, 1.0, way_back=1.0), pose, gain=1e-9)
    there = fit.pose.apply(samples.points)
    forth = shape.nearest(there)
    back = fit.pose.apply(target.nearest(fit.pose.inverse().apply(positions)).point)
    slope = (positions - back) / len(positions)
    corners = shape.triangles[forth.triangle]
    shares = _shares(forth.point, positions[corners])
    pull = (forth.point - there) / len(there)
    np.add.at(slope, corners, shares[:, :, None] * pull[:, None, :])
    size = target.size
    return Apart(fit.misfit**2 / size**2, slope / size**2, fit.pose)


def _shares(points: Floats, corners: Floats) -> Floats:
    """Shares of the corners of triangles in points on them, shape (n, 3).

    Args:
        points: shape (n, 3).
        corners: shape (n, 3, 3).
    """
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    u, v, w = b - a, c - a, points - a
    uu, uv, vv = ((p * q).sum(axis=1) for p, q in ((u, u), (u, v), (v, v)))
    wu, wv = (w * u).sum(axis=1), (w * v).sum(axis=1)
    denominator = np.maximum(uu * vv - uv**2, np.finfo(float).tiny)
    second = (vv * wu - uv * wv) / denominator
    third = (uu * wv - uv * wu) / denominator
    return np.stack([1.0 - second - third, second, third], axis=1)
