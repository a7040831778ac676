"""From an outline seen from the side to h and d: scale, level, and a camera that looks down."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.surface import side_view

Line = tuple[float, float, float, float]

FLAT = 0.25
"""Height over width of an outline up to which it can be a flat sheet seen at an angle."""
JUMP = 0.12
"""Change of h or d against the frames before and after, as a part of d, that is no motion."""


@dataclass(frozen=True)
class Reference:
    """A known length in the picture.

    Attributes:
        length: how long it is [m].
        line: its ends x0, y0, x1, y1 [px].
    """

    length: float
    line: Line

    def metre_per_pixel(self, columns: int, rows: int) -> float:
        """The scale of pictures of this size [m/px].

        Raises:
            InputError: an end lies outside of the picture, or the ends are one point.
        """
        x0, y0, x1, y1 = self.line
        text = ",".join(f"{v:g}" for v in self.line)
        if not all(0 <= x <= columns and 0 <= y <= rows for x, y in ((x0, y0), (x1, y1))):
            raise InputError(
                "the ends of the known length must lie in the picture",
                key="--reference",
                value=text,
                allowed=f"x within 0 and {columns}, y within 0 and {rows}",
            )
        pixels = float(np.hypot(x1 - x0, y1 - y0))
        if pixels < 2.0:
            raise InputError(
                "the two ends of the known length are one point",
                key="--reference",
                value=text,
                allowed="ends that are 2 px apart at least",
            )
        if not (self.length > 0.0 and np.isfinite(self.length)):
            raise InputError(
                "the known length must be above zero", key="--reference", value=self.length
            )
        return self.length / pixels


@dataclass(frozen=True, eq=False)
class TiltShape:
    """What a camera that looks down sees of a known sequence of shapes.

    A side view from above shows the far rim higher and the near rim lower than they are: the
    height seen is h·cos α + e·sin α, where e is the depth between the highest and the lowest
    point seen. A side view cannot show e; here it is taken from shapes that resemble the sheet.

    Attributes:
        seen: height over width in the picture, rising, shape (S,).
        true: height over width of the shape, shape (S,).
        depth: depth over width of the flat sheet.
    """

    seen: Floats
    true: Floats
    depth: float

    def ratio(self, seen: ArrayLike) -> Floats:
        """True height over width of what is seen; the correction of the last shape beyond it."""
        value = np.asarray(seen, dtype=np.float64)
        return np.maximum(value - np.interp(value, self.seen, self.seen - self.true), 0.0)


def tilt_shape(positions: Floats, elevation: float, azimuth: float = 0.0) -> TiltShape:
    """What a camera sees of the states of a run.

    Args:
        positions: node positions of every state [m], shape (S, V, 3), the first one flat.
        elevation: by how much the camera looks down [rad].
        azimuth: see `geometry.surface.side_view` [rad].
    """
    tilted, level = side_view(positions, azimuth, elevation), side_view(positions, azimuth)
    depth = side_view(positions[0], azimuth + 0.5 * np.pi)[0] / level[0, 0]
    seen = np.maximum.accumulate(tilted[:, 1] / tilted[:, 0])
    once = np.concatenate([[True], np.diff(seen) > 1e-9])
    return TiltShape(seen[once], (level[:, 1] / level[:, 0])[once], float(depth))


def cap_ratio(seen: ArrayLike, elevation: float) -> Floats:
    """Height over width of a spherical cap from its height over width seen from above.

    For a cap of height h on a rim of diameter d and radius R = (d²/4 + h²)/2h, the height seen
    is R(1 − cos α) + h cos α + (d/2) sin α: far rim above, the sphere below. Solved for h. The
    same holds for a dome that lies on its rim.

    Returns:
        h/d, shape (...); 0 where no more is seen than a flat disc shows, sin α. Such a cap may
        have any h/d up to tan(α/2)/2.
    """
    value = np.asarray(seen, dtype=np.float64)
    sine, cosine = np.sin(elevation), np.cos(elevation)
    a = 0.5 * (1.0 + cosine)
    b = 0.5 * sine - value
    c = 0.125 * (1.0 - cosine)
    with np.errstate(invalid="ignore"):
        ratio = (-b + np.sqrt(np.maximum(b * b - 4.0 * a * c, 0.0))) / (2.0 * a)
        return np.asarray(np.where(value <= sine * (1.0 + 1e-9), 0.0 * value, ratio))


def level_of(outline: Floats) -> float | None:
    """Angle of the long axis of a flat outline in the picture [rad], None where it is not flat.

    Args:
        outline: x to the right and y downward [px], shape (N, 2).
    """
    spread, axes = np.linalg.eigh(_moments(outline))
    if spread[0] > (FLAT**2) * spread[1]:
        return None
    along = axes[:, 1] * (1.0 if axes[0, 1] >= 0.0 else -1.0)
    return float(np.arctan2(along[1], along[0]))


def _moments(outline: Floats) -> Floats:
    """Second moments of the area in an outline, of the outline itself where it is a line."""
    centred = outline - outline.mean(axis=0)
    x, y = centred.T
    u, v = np.roll(x, -1), np.roll(y, -1)
    cross = x * v - u * y
    area = 0.5 * cross.sum()
    if abs(area) < len(outline):  # thinner than two pixels
        return np.asarray(np.cov(centred.T))
    mean = np.array([((x + u) * cross).sum(), ((y + v) * cross).sum()]) / (6.0 * area)
    xx = ((x * x + x * u + u * u) * cross).sum() / (12.0 * area)
    yy = ((y * y + y * v + v * v) * cross).sum() / (12.0 * area)
    xy = ((x * v + 2.0 * x * y + 2.0 * u * v + u * y) * cross).sum() / (24.0 * area)
    return np.array([[xx, xy], [xy, yy]]) - np.outer(mean, mean)


def angle_of(line: Line) -> float:
    """Angle of a line in the picture [rad], from −π/2 to π/2.

    Raises:
        InputError: its ends are one point.
    """
    x0, y0, x1, y1 = line
    if np.hypot(x1 - x0, y1 - y0) < 2.0:
        raise InputError("the two ends of the level line are one point", key="--roll")
    sign = 1.0 if x1 >= x0 else -1.0
    return float(np.arctan2(sign * (y1 - y0), sign * (x1 - x0)))


def extents(outline: Floats, roll: float) -> tuple[float, float]:
    """Width along the level direction and height across it [px].

    Args:
        outline: centres of pixels, shape (N, 2).
        roll: angle of the level direction in the picture [rad].
    """
    along = outline @ [np.cos(roll), np.sin(roll)]
    across = outline @ [-np.sin(roll), np.cos(roll)]
    return float(np.ptp(along)) + 1.0, float(np.ptp(across)) + 1.0  # a pixel is 1 px wide


def elevation_of(ratio: float, depth: float = 1.0, thickness: float = 0.0) -> float:
    """By how much the camera looks down [rad], from a flat sheet's height over width.

    Args:
        ratio: height over width seen of the flat sheet, sin α · depth + cos α · thickness.
        depth: its depth over its width; 1 for a round one.
        thickness: its thickness over its width.

    Raises:
        InputError: the sheet is not flat, or seen at more than 14°.
    """
    total = float(np.hypot(depth, thickness))
    sine = np.sin(np.arcsin(min(ratio / total, 1.0)) - np.arctan2(thickness, depth))
    if sine >= FLAT:
        raise InputError(
            "the first frame does not show a flat sheet from the side, so the tilt of the camera "
            "cannot be found",
            key="--tilt",
            value=f"h/d {ratio:.3f}",
            allowed="degrees from 0 to 30, or another --start",
        )
    return float(np.arcsin(max(sine, 0.0)))


def jumps(height: Floats, width: Floats) -> NDArray[np.bool_]:
    """Frames whose h or d differs from its neighbours' median: a hand, a glare, a lost piece.

    Args:
        height, width: of every frame, NaN where nothing was found, shape (F,).
    """
    found = np.flatnonzero(np.isfinite(width))
    result = np.zeros(len(width), dtype=bool)
    if len(found) < 3:
        return result
    scale = float(np.median(width[found]))
    for values in (height[found], width[found]):
        around = np.lib.stride_tricks.sliding_window_view(np.pad(values, 2, mode="edge"), 5)
        result[found] |= abs(values - np.median(around, axis=1)) > JUMP * scale
    return result
