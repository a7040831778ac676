"""Pictures of a comparison: overlay, distance map, structural similarity, histogram."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sheetmorph.show import style
from sheetmorph.show.comparison_ssim import outline, write_ssim
from sheetmorph.show.comparison_views import (
    MAP_PANEL,
    PANEL,
    SIDES,
    Names,
    Views,
    see_through,
    silhouette,
)
from sheetmorph.show.scene import Image
from sheetmorph.show.style import Sheet

if TYPE_CHECKING:
    from sheetmorph.compare.comparison import Comparison
    from sheetmorph.compare.distances import OneWay

WIDTH = 1000
HEAD, FOOT = 100, 56
OPACITY = 0.7
BINS = 48


@dataclass(frozen=True, eq=False)
class Images:
    """What the renderer made of the three jobs of `Views`, taken when it is needed."""

    both: Iterator[Image]
    scan: Iterator[Image]
    shape: Iterator[Image]


def write_pictures(
    comparison: Comparison, views: Views, images: Images, names: Names, folder: Path
) -> list[Path]:
    """Write the four pictures of a comparison as PNG files.

    Args:
        comparison: what was found.
        views: what was drawn of it.
        images: the answers of the renderer.
        names: what to call the two.
        folder: where to write.

    Raises:
        OutputError: a file cannot be written.
    """
    with style.style():
        histogram = _write_histogram(comparison, names, folder / "histogram.png")
        overlay = _write_overlay(comparison, views, images, names, folder / "overlay.png")
        distance = _write_distance(comparison, views, images, names, folder / "distance.png")
        top = views.scan.views[-1].camera
        covers = silhouette(next(images.scan)), silhouette(next(images.shape))
        similarity = write_ssim(comparison, top, *covers, names, folder / "ssim.png")
    return [overlay, distance, similarity, histogram]


def _write_overlay(
    comparison: Comparison, views: Views, images: Images, names: Names, path: Path
) -> Path:
    width, height = PANEL
    caption, gap = 34, 8
    rows = 2 * (height + caption + gap)
    sheet = Sheet(WIDTH, HEAD + rows + FOOT)
    sheet.title("Scan over shape", names.subtitle())
    for k, side in enumerate(SIDES):
        x = 20 + (k % 3) * width
        y = FOOT + (1 - k // 3) * (height + caption + gap)
        both, scan, shape = next(images.both), next(images.scan), next(images.shape)
        sheet.image(see_through(both, scan, OPACITY), x, y)
        outline(sheet, silhouette(scan), x, y, _darker(style.SCAN))
        outline(sheet, silhouette(shape), x, y, _darker(style.SHAPE))
        middle = x + 0.5 * width
        sheet.text(middle, y + height + 14, side, ha="center", va="center", fontweight="bold")
    camera = views.both.views[0].camera
    _legend(sheet, 28)
    _scale_bar(sheet, camera.extent / height, WIDTH - 28, 28)
    return sheet.save(path)


def _write_distance(
    comparison: Comparison, views: Views, images: Images, names: Names, path: Path
) -> Path:
    width, height = MAP_PANEL
    caption = 34
    sheet = Sheet(WIDTH, HEAD + 2 * (height + caption) + FOOT)
    sheet.title("Signed distance", names.subtitle())
    rows = ((images.scan, "on the scan"), (images.shape, "on the shape"))
    for row, (source, name) in enumerate(rows):
        y = FOOT + (1 - row) * (height + caption)
        for column in range(2):
            x = 16 + column * width
            sheet.image(next(source), x, y)
            seen = "" if column == 0 else ", seen from behind"
            place = (x + 0.5 * width, y + height + 14)
            sheet.text(*place, name + seen, ha="center", va="center", fontweight="bold")
    limit = 1e3 * views.limit
    bar = (16.0 + 2 * width + 24, FOOT + 150.0, 24.0, 400.0)
    sheet.colour_bar(bar, style.STRAIN_MAP, (-limit, limit), (-limit, limit), "mm")
    sheet.text(bar[0], bar[1] + bar[3] + 46, "scan above", va="bottom")
    sheet.text(bar[0], bar[1] - 20, "scan below", va="top")
    farthest = max(comparison.scan_to_shape.maximum, comparison.shape_to_scan.maximum)
    sheet.foot(
        "Red: the scan lies above the upper side of the shape; blue: below it. "
        f"Farthest: {style.millimetres(farthest)}"
        + ("; colours end earlier" if farthest > views.limit else "")
    )
    return sheet.save(path)


def _write_histogram(comparison: Comparison, names: Names, path: Path) -> Path:
    sheet = Sheet(WIDTH, 720)
    sheet.title("Distances", names.subtitle())
    ways = (
        ("from the scan to the shape", comparison.scan_to_shape, style.SCAN),
        ("from the shape to the scan", comparison.shape_to_scan, style.SHAPE),
    )
    reach = 1e3 * max(way.maximum for _name, way, _rgb in ways) or 1e-6
    edges = np.linspace(0.0, reach, BINS + 1)
    shares = [
        100.0 * np.histogram(1e3 * way.distance, edges)[0] / len(way.distance)
        for _name, way, _rgb in ways
    ]
    top = 1.12 * max(float(share.max()) for share in shares)
    for k, (name, way, rgb) in enumerate(ways):
        axes = sheet.inset(96, 96 + (1 - k) * 266, WIDTH - 96 - 40, 226)
        axes.stairs(shares[k], edges, fill=True, color=style.colour(rgb), alpha=0.75, lw=0)
        axes.set_xlim(0.0, 1.02 * reach)
        axes.set_ylim(0.0, top)
        axes.set_ylabel("% of the area", labelpad=8)
        axes.grid(color=style.FAINT, lw=0.6)
        axes.set_axisbelow(True)
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
        if k == 1:
            axes.set_xlabel("distance  [mm]", labelpad=6)
        else:
            axes.tick_params(labelbottom=False)
        _mark(axes, way)
        place = {
            "transform": axes.transAxes,
            "ha": "right",
            "va": "top",
            "backgroundcolor": "white",
        }
        axes.text(0.995, 0.99, name, None, fontweight="bold", **place)
        axes.legend(
            loc="upper right",
            bbox_to_anchor=(1.0, 0.9),
            borderpad=0.1,
            facecolor="white",
            edgecolor="none",
            framealpha=1.0,
        )
    return sheet.save(path)


def _mark(axes: Any, way: OneWay) -> None:
    for value, name, dashes in (
        (way.mean, "mean", (0, (1, 1.5))),
        (way.rms, "RMS", "solid"),
        (way.percentile_95, "95 %", (0, (5, 2))),
    ):
        axes.axvline(
            1e3 * value,
            color=style.INK,
            lw=1.8,
            ls=dashes,
            label=f"{name}  {style.millimetres(value)}",
        )
    axes.plot([1e3 * way.maximum], [0], "v", color=style.INK, ms=9, clip_on=False, zorder=4,
              label=f"farthest  {style.millimetres(way.maximum)}")  # fmt: skip


def _legend(sheet: Sheet, y: float) -> None:
    from matplotlib.patches import Rectangle

    x = 28.0
    for front, behind, text in (
        (style.SCAN, style.SCAN, "scan"),
        (style.SHAPE, (255, 255, 255), "shape, see-through"),
        (style.SHAPE, style.SCAN, "shape in front of scan"),
    ):
        pairs = zip(front, behind, strict=True)
        red, green, blue = (round(OPACITY * a + (1.0 - OPACITY) * b) for a, b in pairs)
        face, rim = style.colour((red, green, blue)), _darker(front)
        sheet.axes.add_patch(Rectangle((x, y - 9), 28, 18, facecolor=face, edgecolor=rim, lw=1.5))
        sheet.text(x + 38, y, text, va="center")
        x += 74 + 11 * len(text)


def _scale_bar(sheet: Sheet, pixel: float, right: float, y: float) -> None:
    """A length that ends at a place [px]; `pixel` is the length [m] of one of them."""
    length = style.round_length(1e3 * pixel * 200)
    left = right - 1e-3 * length / pixel
    sheet.axes.plot([left, right], [y, y], "-|", color=style.INK, lw=2, ms=9, mew=2)
    sheet.text(left - 12, y, f"{length:g} mm", ha="right", va="center")


def _darker(rgb: tuple[int, int, int]) -> str:
    red, green, blue = (int(0.6 * part) for part in rgb)
    return style.colour((red, green, blue))
