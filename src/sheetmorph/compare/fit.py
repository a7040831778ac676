"""The pose with the least squared distance both ways, found downhill from a given one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.surface import Samples, Surface
from sheetmorph.geometry.mesh import Floats

# Every point of a scan has to lie on the shape. The way back keeps the scan from shrinking
# into a corner of the shape, but a scan may have holes, whose points are far from it. Scans
# with known poses chose the weight: docs/comparing.md, benchmarks/pose_weight.py.
WAY_BACK = 0.5
HOLE = 3.0  # times the scan's own misfit; what of the shape is farther is not in the scan
LESS = 0.95  # the scan's misfit has to fall by this factor for another round without holes
LARGEST_CHANGE = 0.1  # of the scale's logarithm, in one round without holes
CONVERGED = 1e-7  # a step that moves no point by more than this share of the size ends it
NO_GAIN = 1e-6  # and so does one that changes the sum of squares by less than this share


@dataclass(frozen=True, eq=False)
class Pair:
    """Two surfaces with points spread over both.

    Attributes:
        scan: what is moved.
        shape: what it is moved onto.
        scan_samples: points of the scan.
        shape_samples: points of the shape.
        scale: held at this value when given.
        far: from the shape to the scan, what is longer than this [m] counts by its length
            and not by its square (Huber 1964): a hole of the scan pulls, but not more the
            deeper it is.
        way_back: weight of the way from the shape to the scan; the other's is 1.
    """

    scan: Surface
    shape: Surface
    scan_samples: Samples
    shape_samples: Samples
    scale: float | None
    far: float = np.inf
    way_back: float = WAY_BACK

    @classmethod
    def of(
        cls, scan: Surface, shape: Surface, count: int, scale: float | None, seed: int = 0
    ) -> Pair:
        """A pair with `count` points on each surface."""
        return cls(scan, shape, scan.sample(count, seed), shape.sample(count, seed + 1), scale)


@dataclass(frozen=True, eq=False)
class Fit:
    """A pose and what it leaves.

    Attributes:
        pose: scan to shape.
        misfit: root mean square distance both ways [m], weighted by `Pair.way_back`.
        iterations: steps that were tried.
    """

    pose: Similarity
    misfit: float
    iterations: int


@dataclass(frozen=True, eq=False)
class _Rows:
    """Residuals and their slopes in (stretch, turn, shift), weighted."""

    cost: float
    hessian: Floats
    gradient: Floats
    centre: Floats


def refine(pair: Pair, start: Similarity, most: int = 60, gain: float = NO_GAIN) -> Fit:
    """Gauss and Newton's method with Levenberg and Marquardt's damping, on the distances.

    Args:
        pair: the surfaces and their points.
        start: where to begin; with `pair.scale` given, its scale is used as it is.
        most: steps to try at most.
        gain: share of the sum of squares that a step must change for another one.
    """
    pose, rows = start, _rows(pair, start)
    damping, tried = 1e-3, 0
    free = np.arange(7) if pair.scale is None else np.arange(1, 7)
    while tried < most and rows.cost > 0.0:
        tried += 1
        hessian = rows.hessian[np.ix_(free, free)]
        step = np.zeros(7)
        # The stretch and turn are in units of the shape's size: one measure for all seven.
        damped = hessian + damping * np.trace(hessian) / len(free) * np.eye(len(free))
        step[free] = -np.linalg.lstsq(damped, rows.gradient[free], rcond=None)[0]
        moved = _stepped(pose, step, rows.centre, pair.shape.size)
        after = _rows(pair, moved)
        small = np.abs(step).max() < CONVERGED * pair.shape.size
        small = small or abs(after.cost - rows.cost) < gain * rows.cost
        if after.cost <= rows.cost:
            pose, rows, damping = moved, after, max(damping * 0.2, 1e-9)
        else:
            damping *= 5.0
        if small:
            break
    return Fit(pose, _misfit(pair, rows), tried)


def without_holes(pair: Pair, fit: Fit, rounds: int = 12) -> Fit:
    """The fit again, with less regard to parts of the shape that the scan does not show.

    What is farther from the scan than `HOLE` times the scan's own misfit is taken for a
    hole, until that misfit falls no more. The one that is told stays that of all points.
    """
    points, size = pair.scan_samples.points, pair.shape.size
    own = np.inf
    for _ in range(rounds):
        last, own = own, _rms(pair.shape.nearest(fit.pose.apply(points)).distance)
        if own < 1e-9 * size or own > LESS * last:
            break
        again = refine(replace(pair, far=HOLE * own), fit.pose)
        if abs(np.log(again.pose.scale / fit.pose.scale)) > LARGEST_CHANGE:
            break
        fit = Fit(
            again.pose, _misfit(pair, _rows(pair, again.pose)), fit.iterations + again.iterations
        )
    return fit


def _misfit(pair: Pair, rows: _Rows) -> float:
    return float(np.sqrt(rows.cost / (1.0 + pair.way_back)))


def _rms(values: Floats) -> float:
    return float(np.sqrt((values**2).mean()))


def _stepped(pose: Similarity, step: Floats, centre: Floats, size: float) -> Similarity:
    """The pose stretched, turned and shifted about a centre; all of the step in metres."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_rotvec(step[1:4] / size).as_matrix()
    stretch = float(np.exp(np.clip(step[0] / size, -0.3, 0.3)))
    shift = centre + step[4:] - stretch * (turn @ centre)
    return Similarity(stretch, turn, shift).after(pose)


def _rows(pair: Pair, pose: Similarity) -> _Rows:
    """Normal equations of the distances at a pose."""
    shape, scan, size = pair.shape, pair.scan, pair.shape.size
    forth = pose.apply(pair.scan_samples.points)
    centre = forth.mean(axis=0)
    there = shape.nearest(forth)
    cost, hessian, gradient = _normal_equations(
        forth, forth - there.point, shape.normals[there.triangle], centre, size, np.inf
    )
    back = pair.shape_samples.points
    here = scan.nearest(pose.inverse().apply(back))
    touched = pose.apply(here.point)
    more = _normal_equations(
        touched, touched - back, pose.turn(scan.normals[here.triangle]), centre, size, pair.far
    )
    return _Rows(
        cost + pair.way_back * more[0],
        hessian + pair.way_back * more[1],
        gradient + pair.way_back * more[2],
        centre,
    )


def _normal_equations(
    moving: Floats, gap: Floats, normals: Floats, centre: Floats, size: float, far: float
) -> tuple[float, Floats, Floats]:
    """Mean squared length of the gaps, with its Gauss–Newton matrix and half its slope.

    Off a plane the distance changes along the normal alone; off a rim it changes along the
    gap and along what of the normal is square to it, but not along the rim. Both are the
    exact second derivatives of half the squared distance to a plane and to a line.
    """
    length = np.linalg.norm(gap, axis=1)
    apart = length > 1e-12 * size
    along = np.where(apart[:, None], gap / np.where(apart, length, 1.0)[:, None], normals)
    aside = normals - (normals * along).sum(axis=1)[:, None] * along
    arm = (moving - centre) / size
    weights = np.minimum(1.0, far / np.maximum(length, np.finfo(float).tiny))
    slopes = []
    for direction in (along, aside):
        stretch = (arm * direction).sum(axis=1)[:, None]
        slopes.append(np.hstack([stretch, np.cross(arm, direction), direction]))
    count = len(moving)
    weighted = [slope * weights[:, None] for slope in slopes]
    hessian = (weighted[0].T @ slopes[0] + weighted[1].T @ slopes[1]) / count
    near = weights * length  # the length, or `far` where that is less
    return float(near @ (2.0 * length - near)) / count, hessian, weighted[0].T @ length / count
