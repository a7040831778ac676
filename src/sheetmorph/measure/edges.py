"""Edges between pixels: where a blurred sheet ends, with or without a line along its rim.

Across an edge a picture shows the sheet and what lies behind it, both blurred. Half of the way
between their grey levels is the edge of a sheet of even brightness only: a thin line along the
rim, darker or lighter than the sheet, is blurred as well and moves that level outward or inward.
Here a model of the whole profile is fitted instead: a step, a brightness that changes inward,
and, where the profile needs it, a thin line on the edge.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, median_filter
from scipy.special import ndtr

from sheetmorph.geometry.mesh import Floats
from sheetmorph.measure.frames import opencv

Pixels = NDArray[np.float32]

BLURS = (1.0, 1.2, 1.45, 1.75, 2.1, 2.5, 3.0, 3.6, 4.3)
"""Standard deviations of the blur that are tried [px]."""
POINTS = 150
"""Points of an outline from which the blur is found."""
LINE_GAIN = 20.0
"""Variances of the noise by which a line must better a profile to be believed."""
LINE_SHARE = 0.02
"""Share of the variance of a profile by which a line must better it."""
LINE_WIDTH = 0.5
"""Width over blur of a line on the edge."""
ROUNDS = 3
"""Times that an outline is blurred again, to see by how much the blur rounds it off."""
MEDIAN = 11
"""Points of the outline over which the median of displacements is taken."""
SMOOTHING = 2.0
"""Pixels along the outline over which displacements are averaged."""
STEP, LINE = (0, 1, 2), (0, 1, 2, 3)


def refined(difference: Pixels, outline: Floats, blur: float, noise: float) -> Floats:
    """Move an outline of pixels to the edge of the sheet.

    Each point moves along its normal to the edge of the profile there. A blur also rounds off
    corners and tips; by how much is seen by blurring the outline once more, and taken off. That
    is left out for a sheet thinner than four times the blur, whose two edges are one.

    Args:
        difference: picture less what is behind the sheet [grey levels], shape (R, C, colours).
        outline: pixels along the rim, x and y, shape (N, 2).
        blur: standard deviation of the blur of the difference [px].
        noise: standard deviation of the noise of the difference [grey levels].

    Returns:
        Points of the edge, in coordinates where pixels have their centres at integers, (N, 2).
    """
    points, normals = _smooth(outline)
    steps, shifts = _grid(blur)
    profiles = _sampled(difference, points, normals, steps)
    plain, poor, weight = _edges(profiles, steps, shifts, blur, STEP)
    lined, good, _ = _edges(profiles, steps, shifts, blur, LINE)
    spread = len(steps) * profiles.var(axis=0).sum(axis=1)
    # Faint stretches of the rim say little about where it is: they follow what is beside them.
    weight = weight + 1e-3 * weight.mean() + 1e-9
    gain = _around((poor - good) / noise**2)
    line = (gain > LINE_GAIN) & (_around(poor - good) > LINE_SHARE * _around(spread))
    seen = median_filter(np.where(line, lined, plain), MEDIAN, mode="wrap")
    seen = _averaged(seen, weight)
    edge = points + seen[:, None] * normals
    if mean_thickness(edge) < 4.0 * blur:
        return edge
    corner = np.floor(edge.min(axis=0)) - np.ceil(5.0 * blur) - 4.0
    columns, rows = (np.ceil(np.ptp(edge, axis=0)) + 2.0 * np.ceil(5.0 * blur) + 8.0).astype(int)
    moved = seen
    for _ in range(ROUNDS):
        cover = _cover(points + moved[:, None] * normals - corner, rows, columns, blur)
        again = _sampled(cover[..., None], points - corner, normals, steps)
        shown = _averaged(_edges(again, steps, shifts, blur, STEP)[0], weight)
        moved = np.clip(moved + seen - shown, seen - blur, seen + 2.0 * blur)
    return np.asarray(points + moved[:, None] * normals)


def blur_of(difference: Pixels, outline: Floats) -> Floats:
    """How badly each of `BLURS` explains the edges of a picture, shape (blurs,).

    The median over the outline of what is left of the profiles without a line. A line that is
    there makes the blur come out up to an eighth too small.
    """
    points, normals = _smooth(outline)
    some = slice(None, None, max(1, len(outline) // POINTS))
    reach = np.ceil(3.0 * BLURS[-1])
    steps, shifts = np.arange(-reach, reach + 0.5), np.arange(-6.0, 4.1, 0.5)
    profiles = _sampled(difference, points[some], normals[some], steps)
    left = [_edges(profiles, steps, shifts, blur, STEP)[1] for blur in BLURS]
    return np.median(left, axis=1)


def best_blur(misfits: Floats) -> float:
    """The blur [px] of a film from `blur_of` some of its pictures, shape (pictures, blurs)."""
    total = np.asarray(misfits).sum(axis=0)
    k = int(np.clip(total.argmin(), 1, len(BLURS) - 2))
    near = np.log(BLURS[k - 1 : k + 2])
    a, b, _ = np.polyfit(near, total[k - 1 : k + 2], 2)
    best = -b / (2.0 * a) if a > 0.0 else near[1]
    return float(np.exp(np.clip(best, near[0], near[2])))


def enclosed(outline: Floats) -> float:
    """Area inside a closed line, positive where x to y turns the way the line runs."""
    x, y = outline.T
    return float(0.5 * (x * np.roll(y, -1) - np.roll(x, -1) * y).sum())


def mean_thickness(outline: Floats) -> float:
    """Twice the area over the length of a closed line: the thickness of a thin one."""
    length = np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1).sum()
    return float(2.0 * abs(enclosed(outline)) / max(length, 1e-9))


def _smooth(outline: Floats) -> tuple[Floats, Floats]:
    """The outline without the steps of its pixels, and its outward normals, (N, 2) each."""
    points = gaussian_filter1d(outline, 3.0, axis=0, mode="wrap")
    along = np.roll(points, -2, axis=0) - np.roll(points, 2, axis=0)
    normals = np.stack([along[:, 1], -along[:, 0]], axis=1)
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-9)[:, None]
    return points, normals if enclosed(outline) > 0.0 else -normals


def _around(values: Floats) -> Floats:
    return np.asarray(gaussian_filter1d(values, 2.0 * SMOOTHING, mode="wrap"))


def _averaged(values: Floats, weight: Floats) -> Floats:
    total = gaussian_filter1d(weight, SMOOTHING, mode="wrap")
    return np.asarray(gaussian_filter1d(values * weight, SMOOTHING, mode="wrap") / total)


def _grid(blur: float) -> tuple[Floats, Floats]:
    """Where profiles are sampled, outward, and where their edge is looked for [px]."""
    steps = np.arange(-np.ceil(4.0 * blur + 1.0), np.ceil(3.5 * blur + 1.0) + 0.5)
    return steps, np.arange(-2.5 * blur - 0.5, 1.5 * blur + 0.5, 0.25)


def _sampled(picture: Pixels, points: Floats, normals: Floats, steps: Floats) -> Floats:
    """Profiles across the outline, shape (steps, N, colours)."""
    cv2: Any = opencv()
    places = points[None, :, :] + steps[:, None, None] * normals[None, :, :]
    x, y = places.astype(np.float32).transpose(2, 0, 1)
    rows = 16_384  # remap takes pictures below 32768 px a side
    parts = [
        cv2.remap(
            picture,
            np.ascontiguousarray(x[:, k : k + rows]),
            np.ascontiguousarray(y[:, k : k + rows]),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )
        for k in range(0, len(points), rows)
    ]
    found = np.concatenate(parts, axis=1).astype(np.float64)
    return found.reshape(len(steps), len(points), -1)


def _edges(
    profiles: Floats, steps: Floats, shifts: Floats, blur: float, terms: tuple[int, ...]
) -> tuple[Floats, Floats, Floats]:
    """The shift that explains each profile best, what is left, and how sharply it is found.

    The model is linear but for the place of the edge: for each place on a grid what is left is
    the profile less its projection on the terms; the best place lies on a parabola.

    Returns:
        Shifts [px], sums of squares, and the bend of these, shape (N,) each.
    """
    count = profiles.shape[1]
    flat = profiles.reshape(len(steps), -1)
    total = np.einsum("snc,snc->n", profiles, profiles)
    left = np.empty((len(shifts), count))
    for k, shift in enumerate(shifts):
        basis = np.linalg.qr(_terms((shift - steps) / blur)[:, terms])[0]
        part = (basis.T @ flat).reshape(len(terms), count, -1)
        left[k] = total - np.einsum("tnc,tnc->n", part, part)
    best = np.clip(left.argmin(axis=0), 1, len(shifts) - 2)
    row = np.arange(count)
    before, at, after = left[best - 1, row], left[best, row], left[best + 1, row]
    bend = np.maximum(before - 2.0 * at + after, 1e-12)
    move = np.clip(0.5 * (before - after) / bend, -1.0, 1.0)
    return shifts[best] + move * (shifts[1] - shifts[0]), at, bend


def _terms(inward: Floats) -> Floats:
    """Constant, blurred step, blurred slope and blurred line on the edge, shape (steps, 4)."""
    step = ndtr(inward)
    slope = inward * step + np.exp(-0.5 * inward**2) / np.sqrt(2.0 * np.pi)
    line = step - ndtr(inward - LINE_WIDTH)
    return np.stack([np.ones_like(inward), step, slope, line], axis=1)


def _cover(outline: Floats, rows: int, columns: int, blur: float) -> Pixels:
    """How much of each pixel an outline covers, blurred."""
    cv2: Any = opencv()
    fine = 4 if rows * columns < 1_000_000 else 2
    drawn = np.zeros((rows * fine, columns * fine), dtype=np.uint8)
    corners = np.round(((outline + 0.5) * fine - 0.5) * 16.0).astype(np.int32)
    cv2.fillPoly(drawn, [corners], 255, cv2.LINE_8, 4)
    cover = cv2.resize(drawn, (int(columns), int(rows)), interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.GaussianBlur(cover.astype(np.float32), (0, 0), blur))
