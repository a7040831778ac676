"""The bottom of the misfit, by its residuals: where a search on one number no longer sees a slope.

Along a valley between two parameters the misfit of a noisy scan changes by parts in a million.
The residuals of all points together still tell the way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sheetmorph.calibrate.evaluations import Evaluations
from sheetmorph.calibrate.misfit import CurveTarget, Evaluation, ScanTarget, Task
from sheetmorph.calibrate.parameters import Parameter, with_parameters
from sheetmorph.calibrate.repose import on_parts
from sheetmorph.calibrate.search import shares
from sheetmorph.compare.surface import Indices, Surface
from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats

MAX_STEPS = 8
MAX_HALVINGS = 4
LONGEST = 0.1
"""Longest step, as a share of the bounds."""

SPAN = 1e-3
"""Half the distance over which shapes are differentiated, as a share of the bounds."""


@dataclass(frozen=True, eq=False)
class Response:
    """What a simulated design shows to the targets.

    Attributes:
        points: nodes of its final shape [m], shape (V, 3).
        triangles: shape (T, 3).
        curves: differences of h/d of each curve.
    """

    points: Floats
    triangles: Indices
    curves: tuple[Floats, ...]


def respond(task: Task, values: Sequence[float]) -> Response | None:
    """Simulate a candidate; None where it does not reach its end.

    Raises:
        KeyboardInterrupt: the simulation was interrupted.
    """
    try:
        result = task.run(with_parameters(task.design, task.parameters, values))
    except InputError:
        return None
    if result.status == "interrupted":
        raise KeyboardInterrupt
    if result.status != "completed":
        return None
    curves = [target.curve for target in task.targets if isinstance(target, CurveTarget)]
    return Response(
        result.positions[-1],
        result.mesh.triangles.astype(np.int64),
        tuple(curve.differences(result) for curve in curves),
    )


def polish(evaluations: Evaluations, start: Evaluation, tolerance: float) -> Evaluation | None:
    """Gauss-Newton steps on the residuals of all targets, the poses of the scans among them.

    Shapes are differentiated node by node between simulated neighbours; distances by the
    direction to the nearest point, which is exact; poses are eliminated (Golub and Pereyra
    1973). Steps stay within the bounds and are kept only where the misfit falls.

    Args:
        evaluations: what measures a candidate.
        start: near the optimum.
        tolerance: to what share of its bounds a parameter is found.

    Returns:
        The optimum; None where a neighbour could not be simulated, or has another mesh.
    """
    from scipy.optimize import lsq_linear

    parameters = evaluations.task.parameters
    best = start
    for _ in range(MAX_STEPS):
        place = shares(parameters, best)
        found = _normal_equations(evaluations, place)
        if found is None:
            return None
        root, right = found
        whole = lsq_linear(root, right, (-place, 1.0 - place), method="bvls").x
        whole *= min(1.0, LONGEST / max(float(np.abs(whole).max()), 1e-300))
        for halving in range(MAX_HALVINGS + 1):
            step = 0.5**halving * whole
            trial = evaluations(_values(parameters, place + step))
            if trial.misfit <= best.misfit or np.abs(step).max() <= 0.1 * tolerance:
                break
        if trial.misfit > best.misfit:
            return best
        best = trial
        if np.abs(step).max() <= 0.2 * tolerance:
            return best
    return best


def _normal_equations(evaluations: Evaluations, place: Floats) -> tuple[Floats, Floats] | None:
    """R and b with the Gauss-Newton step as the least squares solution of R s = b."""
    task = evaluations.task
    moved = []
    for index in range(len(place)):
        for sign in (-1.0, 1.0):
            point = place.copy()
            point[index] = np.clip(point[index] + sign * SPAN, 0.0, 1.0)
            moved.append(point)
    points = [place, *moved]
    found = evaluations.apply(respond, [_values(task.parameters, point) for point in points])
    known = [one for one in found if one is not None]
    if len(known) < len(points):
        return None
    base = known[0]
    if any(not np.array_equal(base.triangles, one.triangles) for one in known[1:]):
        return None
    pairs = list(zip(known[1::2], known[2::2], strict=True))
    spans = [float((high - low).max()) for low, high in zip(moved[::2], moved[1::2], strict=True)]
    size = len(place)
    matrix, gradient = np.zeros((size, size)), np.zeros(size)
    curve = 0
    for target in task.targets:
        if isinstance(target, ScanTarget):
            rates = [(b.points - a.points) / s for (a, b), s in zip(pairs, spans, strict=True)]
            part = _of_scan(target, base, rates)
        else:
            slopes = [
                (b.curves[curve] - a.curves[curve]) / s
                for (a, b), s in zip(pairs, spans, strict=True)
            ]
            part = _of_curve(target, base.curves[curve], slopes)
            curve += 1
        matrix += target.weight * part[0]
        gradient += target.weight * part[1]
    # A parameter without any effect must not blow up: the floor leaves it where it is.
    floor = 1e-12 * max(float(np.trace(matrix)), 1e-300)
    root = np.linalg.cholesky(matrix + floor * np.eye(size)).T
    return np.asarray(root), np.asarray(np.linalg.solve(root.T, -gradient))


def _of_curve(
    target: CurveTarget, differences: Floats, slopes: list[Floats]
) -> tuple[Floats, Floats]:
    """Matrix and gradient of half the squared misfit of a curve."""
    jacobian = np.column_stack(slopes) / target.curve.size
    weighted = jacobian * target.curve.weights[:, None]
    return jacobian.T @ weighted, weighted.T @ (differences / target.curve.size)


def _of_scan(target: ScanTarget, base: Response, rates: list[Floats]) -> tuple[Floats, Floats]:
    """Matrix and gradient of half the squared misfit of a scan, its pose eliminated."""
    shape = Surface(base.points, base.triangles)
    fit = target.lay_on(shape)
    back = target.on(shape)
    corners = shape.triangles[fit.triangle]
    inside = _barycentric(shape.points[corners], fit.foot)
    columns = []
    for rate in rates:
        ends = np.einsum("nk,nkd->nd", inside, rate[corners])
        if back is not None:
            ends = np.concatenate([ends, on_parts(rate, shape.triangles, len(back.points))])
        columns.append(-np.einsum("nd,nd->n", ends, fit.direction))
    posed, _, _ = fit.by_pose(fixed_scale=target.fixed_scale)
    unit = fit.pose.scale * target.surface.size
    jacobian = np.column_stack([*columns, posed]) / unit
    weighted = jacobian * fit.weights[:, None]
    matrix, gradient = jacobian.T @ weighted, weighted.T @ (fit.distance / unit)
    size = len(rates)
    # The floor as in `repose`: a shape of revolution may be turned without cost.
    across = matrix[size:, size:] + 1e-9 * np.eye(len(matrix) - size) * np.trace(
        matrix[size:, size:]
    )
    without = np.linalg.solve(across, np.column_stack([matrix[size:, :size], gradient[size:]]))
    reduced = matrix[:size, :size] - matrix[:size, size:] @ without[:, :-1]
    return 0.5 * (reduced + reduced.T), gradient[:size] - matrix[:size, size:] @ without[:, -1]


def _barycentric(corners: Floats, points: Floats) -> Floats:
    """Shares of the corners of triangles, shape (n, 3, 3), in points on them, shape (n, 3)."""
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    w = points - corners[:, 0]
    uu, uv, vv = (np.einsum("nd,nd->n", a, b) for a, b in ((u, u), (u, v), (v, v)))
    wu, wv = (np.einsum("nd,nd->n", w, a) for a in (u, v))
    area = uu * vv - uv * uv
    second, third = (vv * wu - uv * wv) / area, (uu * wv - uv * wu) / area
    return np.stack([1.0 - second - third, second, third], axis=1)


def _values(parameters: Sequence[Parameter], place: Floats) -> list[float]:
    return [p.from_share(float(s)) for p, s in zip(parameters, place, strict=True)]
