"""Structural similarity of two surfaces through their distance fields."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from sheetmorph.compare.surface import Indices, Surface
from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats

MARGIN = 0.05  # the box grows on each side by this share of its width there
C1, C2 = 0.01**2, 0.03**2
SMALLEST_GRID, LARGEST_GRID = 4, 256
BLOCK = 4  # grid points along the side of a block, whose distances are found together


@dataclass(frozen=True, eq=False)
class Grid:
    """N³ points that fill a box.

    Attributes:
        count: N.
        origin: the lowest point, shape (3,) [m].
        spacing: distance of neighbours along each axis, shape (3,) [m].
    """

    count: int
    origin: Floats
    spacing: Floats

    @classmethod
    def around(cls, a: Surface, b: Surface, count: int) -> Grid:
        """A grid over the joint bounding box of two surfaces, grown by 5 % on each side.

        Where the box is flat it grows by 5 % of its longest side.

        Raises:
            InputError: no such grid.
        """
        check_window(count, 2)
        low = np.minimum(a.box[0], b.box[0])
        width = np.maximum(a.box[1], b.box[1]) - low
        grow = MARGIN * np.where(width > 1e-6 * width.max(), width, width.max())
        return cls(count, low - grow, (width + 2.0 * grow) / (count - 1))

    def distance(self, surface: Surface) -> Floats:
        """Distance from every grid point to a surface, shape (N, N, N) [m]."""
        index = self._order
        distance = np.empty(len(index))
        steps = np.stack(np.unravel_index(index, (self.count,) * 3), axis=1)
        distance[index] = surface.nearest(self.origin + self.spacing * steps).distance
        return distance.reshape((self.count,) * 3)

    @cached_property
    def _order(self) -> Indices:
        """The points block by block, shape (N³,): neighbours in space follow each other."""
        block = np.arange(self.count) // BLOCK
        blocks = int(block[-1]) + 1
        key = (block[:, None, None] * blocks + block[:, None]) * blocks + block
        return np.argsort(key.ravel(), kind="stable")


@dataclass(frozen=True, eq=False)
class Ssim:
    """Structural similarity of two surfaces; 1 when they are the same.

    Attributes:
        grid: points along each side of the box.
        window: width of the uniform window in grid points.
        value: mean of `field`.
        field: the local similarity, shape (N, N, N).
        origin: the lowest grid point, shape (3,) [m].
        spacing: distance of neighbours, shape (3,) [m].
    """

    grid: int
    window: int
    value: float
    field: Floats = field(repr=False)
    origin: Floats
    spacing: Floats

    def to_json(self) -> dict[str, float | int]:
        """Grid, window and value."""
        return {"grid": self.grid, "window": self.window, "ssim": self.value}


def check_window(grid: int, window: int) -> None:
    """Refuse a grid that is too coarse or too fine, and a window that does not fit into it.

    Raises:
        InputError: one of these.
    """
    if not SMALLEST_GRID <= grid <= LARGEST_GRID:
        raise InputError(
            "no such grid for the similarity",
            key="grid",
            value=grid,
            allowed=f"{SMALLEST_GRID} to {LARGEST_GRID}",
        )
    if not 2 <= window <= grid:
        raise InputError(
            "the window of the similarity must fit into its grid",
            key="window",
            value=window,
            allowed=f"2 to {grid}",
        )


def ssim(a: Surface, b: Surface, grid: int = 64, window: int = 10) -> Ssim:
    """Structural similarity (Wang et al. 2004, eq. 13) of two surfaces where they lie.

    The images are the distances to the nearest point of each surface, on a grid over the
    joint bounding box, each divided by its largest value. The window is uniform, means and
    variances are those of all its points (no correction for small samples), and beyond the
    box the fields are reflected, so that every grid point counts.

    Args:
        grid: N, points along each side of the box.
        window: width of the window in grid points.

    Raises:
        InputError: no such grid, or a window that does not fit into it.
    """
    check_window(grid, window)
    points = Grid.around(a, b, grid)
    return ssim_of_fields(points, points.distance(a), points.distance(b), window)


def ssim_of_fields(grid: Grid, a: Floats, b: Floats, window: int) -> Ssim:
    """Structural similarity of two distance fields on one grid; see `ssim`.

    Raises:
        InputError: the window does not fit into the grid.
    """
    check_window(grid.count, window)
    local = _local_ssim(a / a.max(), b / b.max(), window)
    return Ssim(grid.count, window, float(local.mean()), local, grid.origin, grid.spacing)


def _local_ssim(a: Floats, b: Floats, window: int) -> Floats:
    from scipy.ndimage import uniform_filter

    def mean(values: Floats) -> Floats:
        return np.asarray(uniform_filter(values, window, mode="reflect"))

    mean_a, mean_b = mean(a), mean(b)
    variance_a, variance_b = mean(a * a) - mean_a**2, mean(b * b) - mean_b**2
    covariance = mean(a * b) - mean_a * mean_b
    above = (2.0 * mean_a * mean_b + C1) * (2.0 * covariance + C2)
    below = (mean_a**2 + mean_b**2 + C1) * (variance_a + variance_b + C2)
    return np.asarray(above / below)
