"""What a camera beside the sheet makes of a shape, and what of that can be undone.

A camera that looks down shows the far rim higher and the near rim lower than they are; one that
is near shows near parts larger than far ones. By how much depends on where the highest, lowest
and outermost points lie in depth, which a side view does not show. Here it is taken from a
sequence of shapes that resemble the sheet: what the camera would see of each of them is compared
with what it is. Only the difference of the two is used, at the height over width that was seen,
so that the pace and the end of the sequence do not enter.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.measure.edges import enclosed

STEEPEST = float(np.arcsin(0.25))
"""Elevation [rad] up to which it can be found from a flat sheet."""
CAP_RATIOS = np.concatenate([np.linspace(0.0, 0.2, 41), np.linspace(0.22, 1.0, 40)])
CIRCLE = 96
"""Points along a circle of a cap."""


@dataclass(frozen=True)
class SideCamera:
    """A camera beside the sheet, with a picture whose middle is on its axis.

    Attributes:
        elevation: by how much its axis points down from +y [rad]; x runs to the right.
        distance: from its lens to the middle of the sheet [m]; 0 for parallel views.
        offset: where the middle of what is seen lies from the middle of the picture, to the
            right and upward in the plane of the sheet [m].
    """

    elevation: float = 0.0
    distance: float = 0.0
    offset: tuple[float, float] = (0.0, 0.0)

    @property
    def plain(self) -> bool:
        """Whether it shows widths and heights as they are."""
        return self.elevation == 0.0 and self.distance == 0.0

    def project(self, positions: ArrayLike) -> Floats:
        """Places in the picture, to the right and upward [m in the plane of the sheet].

        Args:
            positions: points of each shape, shape (..., V, 3). The camera is at its distance
                from the middle of their extents.
        """
        x = np.asarray(positions, dtype=np.float64)
        middle = 0.5 * (x.max(axis=-2, keepdims=True) + x.min(axis=-2, keepdims=True))
        x = x - middle
        right, away = x[..., 0], x[..., 1]
        sine, cosine = np.sin(self.elevation), np.cos(self.elevation)
        flat = np.stack([right, x[..., 2] * cosine + away * sine], axis=-1)
        if self.distance == 0.0:
            return flat
        behind = away * cosine - x[..., 2] * sine
        shrink = self.distance / (self.distance + behind[..., None])
        # The middle of what is seen is to lie at the offset; that of the shape lies beside it.
        seen = (flat + self.offset) * shrink
        beside = 0.5 * (seen.max(axis=-2, keepdims=True) + seen.min(axis=-2, keepdims=True))
        return np.asarray((flat + (2.0 * np.array(self.offset) - beside)) * shrink)


@dataclass(frozen=True, eq=False)
class Shapes:
    """Shapes by which views are corrected, turned so that the camera looks along +y.

    Attributes:
        positions: points of every shape [m], shape (S, V, 3).
        outline: rim of the flat sheet [m], shape (N, 2).
    """

    positions: Floats
    outline: Floats

    @property
    def flat_width(self) -> float:
        """Width of the flat sheet [m]."""
        return float(np.ptp(self.outline[:, 0]))

    @property
    def flat_depth(self) -> float:
        """Depth over width of the flat sheet."""
        return float(np.ptp(self.outline[:, 1])) / self.flat_width


def shapes_of(positions: Floats, triangles: ArrayLike, azimuth: float = 0.0) -> Shapes:
    """The states of a run as a camera meets them.

    Args:
        positions: of the nodes in every state [m], shape (S, V, 3), the first one flat.
        triangles: nodes, shape (T, 3).
        azimuth: see `geometry.surface.side_view` [rad].
    """
    import shapely

    sine, cosine = np.sin(azimuth), np.cos(azimuth)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    turned = np.asarray(positions) @ turn
    whole = shapely.union_all(shapely.polygons(turned[0, np.asarray(triangles), :2]))
    parts = shapely.get_parts(whole)
    largest = parts[int(np.argmax(shapely.area(parts)))]
    rim = shapely.get_coordinates(shapely.get_exterior_ring(largest))[:-1]
    return Shapes(turned, rim)


@dataclass(frozen=True, eq=False)
class Correction:
    """What a camera sees of shapes, and what they are.

    Attributes:
        seen: height over width in the picture, rising, shape (S,).
        true: height over width of the shape, shape (S,).
        widening: width in the picture over width of the shape, shape (S,).
    """

    seen: Floats
    true: Floats
    widening: Floats

    def ratio(self, seen: ArrayLike) -> Floats:
        """True height over width of what is seen; the correction of the last shape beyond it."""
        value = np.asarray(seen, dtype=np.float64)
        return np.maximum(value - np.interp(value, self.seen, self.seen - self.true), 0.0)

    def width(self, seen: ArrayLike, width: ArrayLike) -> Floats:
        """True width, in the units of the width that is seen."""
        return np.asarray(width / np.interp(np.asarray(seen), self.seen, self.widening))


def correction(shapes: Shapes, camera: SideCamera) -> Correction:
    """By how much a camera errs on shapes."""
    tilted = np.ptp(camera.project(shapes.positions), axis=-2)
    level = np.ptp(shapes.positions[..., [0, 2]], axis=-2)
    seen = np.maximum.accumulate(tilted[:, 1] / tilted[:, 0])
    once = np.concatenate([[True], np.diff(seen) > 1e-9])
    true, widening = level[:, 1] / level[:, 0], tilted[:, 0] / level[:, 0]
    return Correction(seen[once], true[once], widening[once])


def corrected(
    seen: Floats, width: Floats, places: Floats, shapes: Shapes, camera: SideCamera
) -> tuple[Floats, Floats]:
    """h/d and d of level parallel views.

    Args:
        seen: height over width in the pictures, shape (F,).
        width: [px], shape (F,).
        places: where the sheet appears from the middle of the picture, to the right and
            upward [m], shape (F, 2); of no matter for parallel views.
        shapes: that resemble the sheet.
        camera: its offset is of no matter.

    Returns:
        h/d and d [px], shape (F,) each.
    """
    if camera.plain:
        return seen, width
    step = 0.01 * shapes.flat_width
    cells = np.zeros((len(seen), 2))
    if camera.distance > 0.0:
        cells = np.round(np.nan_to_num(places) / step)
    ratio, true_width = np.full(len(seen), np.nan), np.full(len(seen), np.nan)
    for cell in np.unique(cells, axis=0):
        here = (cells == cell).all(axis=1)
        x, y = cell * step
        table = correction(shapes, replace(camera, offset=(float(x), float(y))))
        ratio[here] = table.ratio(seen[here])
        true_width[here] = table.width(seen[here], width[here])
    return ratio, true_width


def caps(width: float = 1.0, depth: float = 1.0) -> Shapes:
    """Caps of a sphere with their rims above, h/d from 0 to 1.

    Args:
        width: d of each [m].
        depth: depth over width, by which the spheres are stretched along y.
    """
    turn = np.linspace(0.0, 2.0 * np.pi, CIRCLE, endpoint=False)
    circle = 0.5 * width * np.stack([np.cos(turn), depth * np.sin(turn)], axis=1)
    part = np.linspace(0.0, 1.0, 33)[:, None]
    states = np.empty((len(CAP_RATIOS), len(part), CIRCLE, 3))
    states[0] = np.concatenate([part[..., None] * circle, np.zeros((len(part), CIRCLE, 1))], axis=2)
    for state, ratio in zip(states[1:], CAP_RATIOS[1:], strict=True):
        # Up to h/d 0.5 the rim is as wide as what is seen, beyond it the sphere is.
        end = 2.0 * np.arctan(2.0 * ratio) if ratio <= 0.5 else np.arccos(1.0 - 2.0 * ratio)
        radius = 1.0 / np.sin(end) if ratio <= 0.5 else 1.0
        state[..., :2] = radius * np.sin(part * end)[..., None] * circle
        state[..., 2] = 0.5 * width * radius * (1.0 - np.cos(part * end))
    return Shapes(states.reshape(len(states), -1, 3), circle)


def elevation_of(
    area: float, width: float, shapes: Shapes, camera: SideCamera, thickness: float = 0.0
) -> float:
    """By how much the camera looks down [rad], from the area that a flat sheet covers.

    The area does not depend on single points of the outline as the height does.

    Args:
        area: in the picture, in squares of the unit of `width`.
        width: in the picture.
        shapes: with the outline of the flat sheet.
        camera: its distance and offset; its elevation is of no matter.
        thickness: of the flat sheet [m].

    Raises:
        InputError: the sheet is not flat, or seen at more than 14°.
    """
    from scipy.optimize import brentq

    flat = np.column_stack([shapes.outline, np.zeros(len(shapes.outline))])
    thin = thickness / shapes.flat_width

    def excess(angle: float) -> float:
        seen = replace(camera, elevation=angle).project(flat)
        covered = abs(enclosed(seen)) / float(np.ptp(seen[:, 0])) ** 2
        return covered + thin * float(np.cos(angle)) - area / width**2

    # A camera at its distance that sees the sheet below its axis looks down on it all the same.
    level = 0.0
    if camera.distance > 0.0:
        level = float(np.arctan2(camera.offset[1], camera.distance))
    if excess(level) >= 0.0:
        return level
    if excess(level + STEEPEST) <= 0.0:
        raise InputError(
            "the first frame does not show a flat sheet from the side, so the tilt of the camera "
            "cannot be found",
            key="--tilt",
            value=f"area over width squared {area / width**2:.3f}",
            allowed="degrees from 0 to 30, or another --start",
        )
    return float(brentq(excess, level, level + STEEPEST, xtol=1e-9))
