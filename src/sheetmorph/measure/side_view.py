"""From an outline seen from the side to h and d: scale, level, extents."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats

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


def extents(outline: Floats, roll: float, grain: float = 0.0) -> tuple[float, float]:
    """Width along the level direction and height across it [px].

    Args:
        outline: shape (N, 2).
        roll: angle of the level direction in the picture [rad].
        grain: see `silhouette.Silhouette` [px].
    """
    along = outline @ [np.cos(roll), np.sin(roll)]
    across = outline @ [-np.sin(roll), np.cos(roll)]
    return float(np.ptp(along)) + grain, float(np.ptp(across)) + grain


def place_of(outline: Floats, roll: float, columns: int, rows: int) -> tuple[float, float]:
    """Where the middle of an outline lies from the middle of the picture [px].

    Returns:
        Along the level direction to the right, and across it upward.
    """
    away = outline - [0.5 * (columns - 1), 0.5 * (rows - 1)]
    along = away @ [np.cos(roll), np.sin(roll)]
    across = away @ [-np.sin(roll), np.cos(roll)]
    return 0.5 * float(along.max() + along.min()), -0.5 * float(across.max() + across.min())


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
