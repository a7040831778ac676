"""What the renderer shall draw of a comparison: both surfaces, and each of them alone."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.geometry.mesh import Floats
from sheetmorph.show import scene, style
from sheetmorph.show.scene import Camera, Colours, Image, Job, View

if TYPE_CHECKING:
    from sheetmorph.compare.comparison import Comparison
    from sheetmorph.compare.surface import Indices, Surface

SIDES = ("front", "right", "from above", "back", "left", "from below")
"""The panels of the overlay, row by row."""
PANEL = (320, 300)
MAP_PANEL = (410, 340)
MAP_AZIMUTHS = (-62.0, 118.0)
TOP_PANEL = (390, 390)

DRAWN = 60_000
"""Triangles of a scan that are drawn; pictures of this size show no more."""

LIMIT_STEPS = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)


@dataclass(frozen=True)
class Names:
    """What the two sides of a comparison are called.

    Attributes:
        shape: the computed shape, such as the name of its design.
        scan: the measured one, such as the name of its file.
    """

    shape: str
    scan: str

    def subtitle(self, *more: str) -> str:
        """The grey line below a title."""
        names = f"{style.shortened(self.shape, 34)} and {style.shortened(self.scan, 34)}"
        return "  ·  ".join([names, *more])


@dataclass(frozen=True, eq=False)
class Views:
    """All that is drawn in space of a comparison.

    Attributes:
        both: scan and shape in one scene, seen from `SIDES`.
        scan: the scan alone from `SIDES`, then its distance map from two directions, then
            its silhouette from above.
        shape: the shape alone, likewise.
        limit: distance [m] at the ends of the colour map.
    """

    both: Job
    scan: Job
    shape: Job
    limit: float


def views_of(comparison: Comparison) -> Views:
    """Decide what to draw of a comparison."""
    from sheetmorph.compare.reduce import reduced

    scan, _cell = reduced(comparison.scan, DRAWN)
    shape = comparison.shape
    everything = np.concatenate([scan.points, shape.points])
    on_scan = distance_from_shape(shape, scan.points)
    on_shape = distance_to_scan(shape, scan)
    limit = round_limit(float(np.percentile(np.abs(comparison.scan_to_shape.distance), 95)))
    panels = _panel_cameras(everything)
    maps = _map_cameras(everything)
    top = top_camera(everything)

    def alone(surface: Surface, rgb: tuple[int, int, int], signed: Floats) -> Job:
        points, plain = surface.points, _plain(len(surface.points), rgb)
        painted = style.mapped(1e3 * signed, style.STRAIN_MAP, (-1e3 * limit, 1e3 * limit))
        sides = [View(points, plain, (0, 0), camera, PANEL) for camera in panels]
        mapped = [
            View(points, painted, (0, 0), camera, MAP_PANEL, scene.FIELD_LIGHT) for camera in maps
        ]
        silhouette = View(points, plain, (0, 0), top, TOP_PANEL)
        return _job(surface.triangles, points, (*sides, *mapped, silhouette))

    colours = np.concatenate(
        [_plain(len(scan.points), style.SCAN), _plain(len(shape.points), style.SHAPE)]
    )
    triangles = np.concatenate([scan.triangles, shape.triangles + len(scan.points)])
    together = tuple(View(everything, colours, (0, 0), camera, PANEL) for camera in panels)
    return Views(
        _job(triangles, everything, together),
        alone(scan, style.SCAN, on_scan),
        alone(shape, style.SHAPE, on_shape),
        limit,
    )


def distance_from_shape(shape: Surface, points: Floats) -> Floats:
    """How far points lie above the shape [m], shape (N,); negative below its upper side."""
    found = shape.nearest(points)
    above = ((points - found.point) * shape.normals[found.triangle]).sum(axis=1)
    return np.asarray(np.where(above < 0, -found.distance, found.distance))


def distance_to_scan(shape: Surface, scan: Surface) -> Floats:
    """How far the scan lies above the nodes of the shape [m], shape (V,).

    The upper side is that of the shape, whichever way the scan is oriented.
    """
    found = scan.nearest(shape.points)
    normals = scene.node_normals(shape.points, shape.triangles.astype(np.int32))
    above = ((found.point - shape.points) * normals).sum(axis=1)
    return np.asarray(np.where(above < 0, -found.distance, found.distance))


def round_limit(distance: float) -> float:
    """The end of a colour map: a round length [m] that is not below the distance."""
    if distance <= 1e-9:
        return 1e-6
    power = 10.0 ** np.floor(np.log10(distance))
    return float(power * min(step for step in LIMIT_STEPS if step * power >= 0.999 * distance))


def silhouette(image: Image) -> Floats:
    """How much of each pixel the surface covers, roughly; 0 to 1, shape (height, width)."""
    ink = 255.0 - image.min(axis=2).astype(np.float64)
    return np.asarray(np.clip(ink / 60.0, 0.0, 1.0))


def see_through(both: Image, scan: Image, opacity: float) -> Image:
    """The scene with the shape as if it were glass.

    Where the shape is in front, the picture of the scan alone says what lies behind it.
    """
    mixed = opacity * both.astype(np.float64) + (1.0 - opacity) * scan.astype(np.float64)
    return np.asarray(np.round(mixed), dtype=np.uint8)


def top_camera(points: Floats) -> Camera:
    """The parallel view from above of `TOP_PANEL`."""
    return scene.from_above().fitted(points, TOP_PANEL, 0.06)


def _panel_cameras(points: Floats) -> list[Camera]:
    """Parallel views in the order of `SIDES`, all of one scale."""
    x, y, z = np.eye(3)
    directions = [(x, z, -y), (y, z, x), (x, y, z), (-x, z, y), (-y, z, -x), (x, -y, -z)]
    fitted = [
        Camera(np.zeros(3), right, up, toward, 1.0, 0.0).fitted(points, PANEL, 0.05)
        for right, up, toward in directions
    ]
    extent = max(camera.extent for camera in fitted)
    return [replace(camera, extent=extent) for camera in fitted]


def _map_cameras(points: Floats) -> list[Camera]:
    fitted = [
        scene.perspective(azimuth, 24.0).fitted(points, MAP_PANEL, 0.04) for azimuth in MAP_AZIMUTHS
    ]
    extent = max(camera.extent for camera in fitted)
    return [replace(camera, extent=extent) for camera in fitted]


def _plain(count: int, rgb: tuple[int, int, int]) -> Colours:
    return np.tile(np.array(rgb, dtype=np.uint8), (count, 1))


def _job(triangles: Indices, points: Floats, views: tuple[View, ...]) -> Job:
    white = np.full((2, 2, 3), 255, dtype=np.uint8)
    return Job(np.asarray(triangles, dtype=np.int32), np.zeros((len(points), 2)), (white,), views)
