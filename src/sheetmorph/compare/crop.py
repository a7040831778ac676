"""Cutting away what is not the sheet: the floor it stands on, all that is outside a box."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from sheetmorph.compare.topology import components
from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from sheetmorph.compare.surface import Surface

Mask = NDArray[np.bool_]
Box = tuple[float, float, float, float, float, float]

SAMPLES = 3000
PLANES = 200  # planes tried, twice: through one triangle and through three points
OUTLINE = 20_000  # points that an outline is drawn around, about
ALONG = np.cos(np.deg2rad(25.0))  # normals of a floor, with the roughness of a scan
THICKNESS = 0.01  # a floor's unevenness, at most, as a share of the scan's size
ONE_SIDED = 0.15  # area beyond a floor, at most, as a share of the floor's
SLAB = 0.15  # a floor that is a slab is no thicker than this share of the scan's size
STANDS_UP = 0.05  # what stands on a floor rises by this share of its own size at least
WIDER = {True: 1.3, False: 2.0}  # floor over footprint: when apart from the sheet, when joined
STEEP = np.deg2rad(30.0)  # slope with which a joined sheet leaves the floor, at least
LEAST = 0.02  # share of the area that must remain
ROUNDS = 3


@dataclass(frozen=True)
class CropOptions:
    """What to cut off a scan before it is compared.

    Attributes:
        floor: "auto" cuts off a flat floor where it is clear that it is one, "cut" also one
            that the sheet rises from gently, "none" none.
        box: keep only triangles whose centre is inside (x0, x1, y0, y1, z0, z1), in the
            unit of the scan's file; None keeps all.
        keep: "parts" drops pieces of less than 2 % of the largest one's area, "largest"
            all but the largest, "all" none.

    Raises:
        InputError: a box without volume, or another word than these.
    """

    floor: Literal["auto", "cut", "none"] = "auto"
    box: Box | None = None
    keep: Literal["parts", "largest", "all"] = "parts"

    def __post_init__(self) -> None:
        if self.floor not in ("auto", "cut", "none"):
            raise InputError(
                "no such choice", key="floor", value=self.floor, allowed="auto, cut, none"
            )
        if self.keep not in ("parts", "largest", "all"):
            raise InputError(
                "no such choice", key="keep", value=self.keep, allowed="parts, largest, all"
            )
        if self.box is None:
            return
        sound = len(self.box) == 6 and bool(np.isfinite(self.box).all())
        if not sound or any(self.box[k] >= self.box[k + 1] for k in (0, 2, 4)):
            raise InputError(
                "the box needs six numbers x0 x1 y0 y1 z0 z1 with x0 < x1, y0 < y1, z0 < z1",
                key="box",
                value=self.box,
            )


def inside_box(surface: Surface, box: Box, unit: float = 1.0) -> Mask:
    """Triangles whose centre is inside a box given in units of `unit` [m], shape (T,).

    Raises:
        InputError: there are none; says where the scan is.
    """
    centres = surface.points[surface.triangles].mean(axis=1) / unit
    limits = np.reshape(box, (3, 2))
    inside = ((centres >= limits[:, 0]) & (centres <= limits[:, 1])).all(axis=1)
    if not inside.any():
        low, high = surface.box / unit
        place = ", ".join(f"{a:.4g} to {b:.4g}" for a, b in zip(low, high, strict=True))
        raise InputError(
            "no triangle of the scan is inside the box", key="box", value=box, allowed=place
        )
    return np.asarray(inside)


def floor_of(surface: Surface, *, certain: bool = True, seed: int = 0) -> tuple[Mask, str | None]:
    """Triangles of a floor, and a hint when something flat may be one but is left.

    A floor is flat, everything else stands on one side of it, it reaches beyond the
    footprint of what stands on it, and that rises clearly above it. A floor that hangs
    together with the sheet must also meet it at an angle: a flat rim from which a sheet
    rises gently is part of the sheet. Both slabs and single faces are found.

    Args:
        surface: a scan.
        certain: False finds a floor, too, from which a joined sheet rises gently.
        seed: of the planes that are tried.

    Returns:
        Which triangles to drop, shape (T,), and the hint or None.
    """
    drop = np.zeros(len(surface.triangles), dtype=bool)
    piece = components(surface.triangles, len(surface.points))
    hint = None
    for turn in range(ROUNDS):
        left = np.flatnonzero(~drop)
        found, told = _one_floor(surface, left, piece, certain, seed + turn)
        if found is None:
            hint = hint or told
            break
        drop[left[found]] = True
    return drop, hint


def _one_floor(
    surface: Surface, left: NDArray[np.int64], piece: NDArray[np.int64], certain: bool, seed: int
) -> tuple[Mask | None, str | None]:
    centres = surface.points[surface.triangles[left]].mean(axis=1)
    normals, areas, pieces = surface.normals[left], surface.areas[left], piece[left]
    total = float(areas.sum())
    size = float(np.linalg.norm(np.ptp(centres, axis=0)))
    plane = _dominant_plane(centres, normals, areas, THICKNESS * size, seed)
    if plane is None:
        return None, None
    point, normal, tolerance = plane
    height = (centres - point) @ normal
    level = np.abs(normals @ normal) >= ALONG
    if areas @ (height > tolerance) < areas @ (height < -tolerance):
        height, normal = -height, -normal
    height -= _top_of_slab(height[level], areas[level], tolerance, SLAB * size)
    flat = (np.abs(height) <= tolerance) & level
    on_plane = float(areas[flat].sum())
    beyond = height < -tolerance
    # A piece that is nearly all floor goes as a whole; the pieces that stand on it are whole.
    share = np.bincount(pieces, areas * (flat | beyond)) / np.maximum(
        np.bincount(pieces, areas), 1e-300
    )
    apart = bool(np.bincount(pieces, areas * flat)[share > 0.9].sum() > 0.9 * on_plane)
    floor = (share > 0.9)[pieces] if apart else (height <= tolerance)
    rest = ~floor
    sunk = float(areas @ (beyond & ~floor))
    if areas @ rest < LEAST * total or sunk > ONE_SIDED * on_plane:
        return None, None
    along = np.linalg.svd(normal[None])[2][1:]
    footprint, ground = (_thinned(centres[mask]) @ along.T for mask in (rest, flat))
    covered, ratio = _cover(ground, footprint)
    rise = float(np.quantile(height[rest], 0.98))
    width = float(np.linalg.norm(np.ptp(footprint, axis=0)))
    if covered < 0.95 or rise < max(STANDS_UP * width, 3.0 * tolerance) or ratio < WIDER[True]:
        return None, None
    near = rest & (height < 4.0 * tolerance)
    slope = np.arccos(np.clip(np.abs(normals[near] @ normal), 0.0, 1.0))
    steep = not near.any() or float(np.average(slope, weights=areas[near])) >= STEEP
    if certain and (ratio < WIDER[apart] or not (apart or steep)):
        return None, (
            f"{on_plane / total:.0%} of the area is flat and may be a floor; it was left, since "
            'it may also be a flat part of the sheet; the choice "cut" or a box cuts it off.'
        )
    return floor, None


def _top_of_slab(height: Floats, areas: Floats, tolerance: float, deepest: float) -> float:
    """Height of a second level nearly as large as the one at zero; zero when there is none."""
    bins = np.arange(3.0 * tolerance, deepest + 2.0 * tolerance, tolerance)
    if len(bins) < 3:
        return 0.0
    amount = np.histogram(height, bins, weights=areas)[0]
    pairs = amount[1:] + amount[:-1]
    best = int(np.argmax(pairs))
    if pairs[best] < 0.6 * float(areas @ (np.abs(height) <= tolerance)):
        return 0.0
    inside = (height >= bins[best]) & (height <= bins[best + 2])
    return float(np.average(height[inside], weights=areas[inside]))


def _dominant_plane(
    centres: Floats, normals: Floats, areas: Floats, tolerance: float, seed: int
) -> tuple[Floats, Floats, float] | None:
    """Point, normal and unevenness of the plane with most area that bounds the rest."""
    random = np.random.default_rng(seed)
    drawn = random.choice(len(areas), SAMPLES, p=areas / areas.sum())
    points, directions = centres[drawn], normals[drawn]
    # Triples of near samples give steadier normals than single triangles of a noisy scan.
    tried = random.integers(0, SAMPLES, (PLANES, 3))
    a, b, c = (points[tried[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    single = directions[tried[:, 0]]
    from_points = normal / np.maximum(length, 1e-300)[:, None]
    normal = np.concatenate([single, from_points[length > 0.0]])
    origin = np.concatenate([a, a[length > 0.0]])
    height = points @ normal.T - (origin * normal).sum(axis=1)
    flat = (np.abs(height) <= tolerance) & (np.abs(directions @ normal.T) >= ALONG)
    above, below = (height > tolerance).sum(axis=0), (height < -tolerance).sum(axis=0)
    count = flat.sum(axis=0)
    score = count - np.minimum(above, below) / ONE_SIDED
    best = int(np.argmax(score))
    if count[best] < 0.1 * SAMPLES:
        return None
    inliers = points[flat[:, best]]
    point = inliers.mean(axis=0)
    for _ in range(3):
        axis = np.linalg.svd(inliers - point, full_matrices=False)[2][2]
        inliers = points[
            (np.abs((points - point) @ axis) <= tolerance) & (np.abs(directions @ axis) >= ALONG)
        ]
        if len(inliers) < 0.1 * SAMPLES:
            return None
        point = inliers.mean(axis=0)
    spread = 1.4826 * float(np.median(np.abs((inliers - point) @ axis)))
    return point, axis, float(np.clip(4.0 * spread, 0.2 * tolerance, tolerance))


def _thinned(points: Floats) -> Floats:
    return points[:: len(points) // OUTLINE + 1]


def _cover(floor: Floats, footprint: Floats) -> tuple[float, float]:
    """Share of a footprint inside the floor's outline, and how much larger that outline is."""
    import shapely

    outline = shapely.MultiPoint(floor).convex_hull
    stand = shapely.MultiPoint(footprint).convex_hull
    if not outline.area > 0.0 or not stand.area > 0.0:
        return 0.0, 0.0
    shapely.prepare(outline)
    inside = shapely.contains_xy(outline, footprint[:, 0], footprint[:, 1])
    return float(inside.mean()), float(outline.area / stand.area)
