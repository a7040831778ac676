"""The picture of the structural similarity, seen from above."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.geometry.mesh import Floats
from sheetmorph.show import style
from sheetmorph.show.comparison_views import TOP_PANEL, Names
from sheetmorph.show.scene import Camera
from sheetmorph.show.style import Sheet

if TYPE_CHECKING:
    from sheetmorph.compare.comparison import Comparison
    from sheetmorph.compare.similarity import Ssim

WIDTH = 1000
HEAD, FOOT, GAP = 100, 56, 24
SSIM_MAP = "viridis"
LIMITS = (0.0, 1.0)
"""The same in all pictures, so that they can be compared."""

Mask = NDArray[np.bool_]


def write_ssim(
    comparison: Comparison, camera: Camera, scan: Floats, shape: Floats, names: Names, path: Path
) -> Path:
    """Write the mean of the local structural similarity along z as a PNG file (paper, Fig. 8).

    Args:
        comparison: what was found.
        camera: the view from above.
        scan: how much of each pixel of that view the scan covers, shape (h, w).
        shape: the same of the shape.
        names: what to call the two.
        path: of the file.

    Raises:
        OutputError: it cannot be written.
    """
    found = comparison.similarity
    width, height = TOP_PANEL
    inside = np.maximum(scan, shape)[..., None]
    near = near_surfaces(found, np.concatenate([comparison.scan_to_shape.points,
                                                comparison.shape_to_scan.points]))  # fmt: skip
    maps = (
        ("around the two surfaces", column_means(found.field, near)),
        ("over the whole height", found.field.mean(axis=2)),
    )
    caption = 34
    sheet = Sheet(WIDTH, HEAD + height + caption + 2 * FOOT)
    how = f"grid {found.grid}³, window {found.window}"
    sheet.title(f"Structural similarity {found.value:.3f}", names.subtitle(how))
    for k, (name, values) in enumerate(maps):
        x, y = 88 + k * (width + GAP), 2 * FOOT - 12
        colours = style.mapped(_at_pixels(values, found, camera), SSIM_MAP, LIMITS)
        blended = inside * colours + (1.0 - inside) * 255.0
        sheet.image(np.round(blended).astype(np.uint8), x, y)
        outline(sheet, scan, x, y, style.colour(style.SCAN), 2.0)
        outline(sheet, shape, x, y, style.INK, 1.4)
        _axes_in_millimetres(sheet, camera, (x, y), ylabel=k == 0)
        middle = x + 0.5 * width
        sheet.text(middle, y + height + 16, name, ha="center", va="center", fontweight="bold")
    bar = (float(88 + 2 * width + GAP + 14), 2 * FOOT + 30.0, 20.0, height - 120.0)
    sheet.colour_bar(bar, SSIM_MAP, LIMITS, LIMITS, "SSIM")
    sheet.foot("Mean of the local SSIM along z. Outlines: scan orange, shape black")
    return sheet.save(path)


def near_surfaces(found: Ssim, points: Floats) -> Mask:
    """Voxels whose window holds a piece of either surface, shape (N, N, N).

    Args:
        found: the local SSIM and its grid.
        points: samples of both surfaces [m], shape (n, 3).
    """
    from scipy.ndimage import maximum_filter

    spacing = np.where(np.asarray(found.spacing) > 0, found.spacing, 1.0)
    place = np.rint((points - found.origin) / spacing).astype(np.int64)
    place = np.clip(place, 0, found.field.shape[0] - 1)
    touched = np.zeros(found.field.shape, dtype=np.uint8)
    touched[tuple(place.T)] = 1
    return np.asarray(maximum_filter(touched, size=found.window) > 0)


def column_means(field: Floats, mask: Mask) -> Floats:
    """Means along z of the voxels of a mask, shape (N, N); of all where there are none."""
    count = mask.sum(axis=2)
    total = np.where(mask, field, 0.0).sum(axis=2)
    return np.asarray(np.where(count > 0, total / np.maximum(count, 1), field.mean(axis=2)))


def _at_pixels(values: Floats, found: Ssim, camera: Camera) -> Floats:
    """Values (N, N) on the grid, between its points, at the pixels of the view from above."""
    from scipy.ndimage import map_coordinates

    width, height = TOP_PANEL
    pixel = camera.extent / height
    x = camera.centre[0] + (np.arange(width) + 0.5 - width / 2) * pixel
    y = camera.centre[1] - (np.arange(height) + 0.5 - height / 2) * pixel
    rows, columns = np.meshgrid(
        (x - found.origin[0]) / (found.spacing[0] or 1.0),
        (y - found.origin[1]) / (found.spacing[1] or 1.0),
    )
    return np.asarray(map_coordinates(values, [rows, columns], order=1, mode="nearest"))


def _axes_in_millimetres(
    sheet: Sheet, camera: Camera, corner: tuple[int, int], *, ylabel: bool
) -> None:
    from matplotlib.ticker import MaxNLocator

    width, height = TOP_PANEL
    axes = sheet.inset(*corner, width, height)
    axes.set_facecolor("none")
    half = 0.5e3 * camera.extent
    x, y = 1e3 * camera.centre[:2]
    axes.set_xlim(x - half * width / height, x + half * width / height)
    axes.set_ylim(y - half, y + half)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    axes.set_xlabel("x  [mm]", labelpad=4)
    if ylabel:
        axes.set_ylabel("y  [mm]", labelpad=2)
    else:
        axes.tick_params(labelleft=False)


def outline(
    sheet: Sheet, cover: Floats, x: int, y: int, colour: str, thickness: float = 1.3
) -> None:
    """Draw the rim of a silhouette whose lower left corner is at a place [px]."""
    height, width = cover.shape
    if cover.min() > 0.5 or cover.max() < 0.5:
        return
    across, up = x + np.arange(width) + 0.5, y + height - np.arange(height) - 0.5
    sheet.axes.contour(across, up, cover, levels=[0.5], colors=[colour], linewidths=thickness)
