"""The rotations and mirror lines that flat shapes have in common."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.triangulate import Indices

if TYPE_CHECKING:
    from shapely import Geometry

MAX_ORDER = 60
CIRCLE_ORDER = 12  # order that stands for a sheet which any rotation maps to itself
# A circle of 240 sides leaves its arc by 3e-5 of its diagonal; shapes drawn alike differ by more.
TOLERANCE = 2e-4
NO_WIDTH = 1e-7  # of the diagonal
SAMPLES = 101.37  # points along the diagonal; odd, so that no drawn length is a multiple
HARMONICS = 8  # multiples of the order in which mirror lines are looked for
POWERS = (0, 1, 2, 3)  # powers of the radius that weigh a boundary
FAINT = 1e-6  # relative size below which a moment is rounding
NEAT = math.pi / 720  # an axis closer than `NEARLY` [rad] to a multiple of this lies on it:
NEARLY = 1e-5  # coordinates rounded to a millionth of the sheet move it by as much


@dataclass(frozen=True)
class Symmetry:
    """A group of rotations and reflections of the plane about one point.

    Attributes:
        centre: the fixed point [m].
        order: number of rotations; they turn by multiples of 2π/order.
        mirror: direction of a mirror line through the centre [rad], at least 0 and below
            π/order; the others follow at every π/order. None without mirror lines.
    """

    centre: tuple[float, float]
    order: int
    mirror: float | None

    @property
    def elements(self) -> int:
        """Number of rotations and reflections, the identity included."""
        return self.order * (1 if self.mirror is None else 2)

    @property
    def trivial(self) -> bool:
        """Whether the identity is all there is."""
        return self.elements == 1

    def matrices(self) -> Floats:
        """The rotations by 2πk/order, then the reflections at mirror + πk/order, shape (G, 2, 2).

        They act on positions relative to the centre.
        """
        turn = 2.0 * np.pi * np.arange(self.order) / self.order
        c, s = cosine_sine(turn)
        rotations = np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], 1)
        if self.mirror is None:
            return rotations
        c, s = cosine_sine(2.0 * self.mirror + turn)
        reflections = np.stack([np.stack([c, s], -1), np.stack([s, -c], -1)], 1)
        return np.concatenate([rotations, reflections])

    def images(self, points: Floats) -> Floats:
        """Where every element of the group takes points.

        Args:
            points: positions [m], shape (N, 2) or (N, 3); z stays.

        Returns:
            Positions [m], shape (G, N, 2) or (G, N, 3).
        """
        moved = np.repeat(points[None], self.elements, axis=0)
        centre = np.array(self.centre)
        moved[..., :2] = centre + (points[:, :2] - centre) @ self.matrices().transpose(0, 2, 1)
        return moved

    def __str__(self) -> str:
        parts = []
        if self.order > 1:
            parts.append(f"rotations by {360 / self.order:.4g}°")
        if self.mirror is not None:
            lines = "a mirror line" if self.order == 1 else f"{self.order} mirror lines"
            parts.append(f"{lines} (one at {math.degrees(self.mirror):.4g}°)")
        return " and ".join(parts) or "no symmetry"


def cosine_sine(angle: Floats) -> tuple[Floats, Floats]:
    """Cosine and sine; exactly zero at multiples of a right angle."""
    c, s = np.cos(angle), np.sin(angle)
    return np.where(np.abs(c) < 1e-15, 0.0, c), np.where(np.abs(s) < 1e-15, 0.0, s)


def find_symmetry(shapes: Sequence[Geometry], tolerance: float | None = None) -> Symmetry:
    """The largest group of rotations and reflections that maps every shape to itself.

    A shape maps to itself when no point of its moved boundary is farther than `tolerance`
    from its boundary. This Hausdorff distance bounds how far a mesh of the group is off the
    drawing anywhere, and it sees slits and notches, which have no area. Rotations are tried
    by order. A mirror line at angle α makes the moments ∮ rᵖ exp(imθ) ds real multiples of
    exp(imα), so the moments give candidates for α.

    Args:
        shapes: outline first, then the regions of the pattern and the slits; polygons and
            lines [m], empty ones allowed.
        tolerance: [m]; by default 2e-4 of the diagonal of the bounding box.

    Returns:
        The group. Its centre is the centroid of the outline. Sheets which every rotation
        maps to themselves get order 12; orders above 60 are not looked for.

    Raises:
        InputError: the outline encloses no area.
    """
    import shapely

    if not len(shapes) or not shapely.area(shapes[0]) > 0.0:
        raise InputError("the outline is empty: it encloses no area")
    middle = shapely.centroid(shapes[0])
    centre = np.array([middle.x, middle.y])
    curves, reach = _curves(shapes, centre, tolerance)
    # Only a circle is mapped to itself by turns of a 53rd and of a 59th.
    if all(_fits(curves, _rotation(order), reach) for order in (53, 59)):
        order, mirror = CIRCLE_ORDER, 0.0
        if not _fits(curves, _reflection(mirror), reach):
            return Symmetry(_pair(centre), order, None)
        return Symmetry(_pair(centre), order, mirror)
    orders = range(MAX_ORDER, 1, -1)
    order = next((n for n in orders if _fits(curves, _rotation(n), reach)), 1)
    return Symmetry(_pair(centre), order, _mirror(curves, order, reach))


def has_symmetry(
    shapes: Sequence[Geometry], symmetry: Symmetry, tolerance: float | None = None
) -> bool:
    """Whether a group maps every shape to itself, see `find_symmetry`."""
    curves, reach = _curves(shapes, np.array(symmetry.centre), tolerance)
    return all(_fits(curves, matrix, reach) for matrix in symmetry.matrices())


def _curves(
    shapes: Sequence[Geometry], centre: Floats, tolerance: float | None
) -> tuple[list[_Curve], float]:
    """The boundaries about a centre and the tolerance, in units of the diagonal of the shapes."""
    import shapely

    x0, y0, x1, y1 = shapely.total_bounds(np.array(shapes))
    diagonal = math.hypot(x1 - x0, y1 - y0)
    curves = [
        _Curve.of(shapely.transform(shape, lambda xy: (xy - centre) / diagonal))
        for shape in shapes
        if not shape.is_empty
    ]
    return curves, TOLERANCE if tolerance is None else tolerance / diagonal


def node_images(nodes: Floats, symmetry: Symmetry, tolerance: float) -> Indices:
    """Number of the node to which every element of a group takes each node.

    Args:
        nodes: positions [m], shape (V, 2) or (V, 3).
        tolerance: how far an image may be from a node [m].

    Returns:
        Node indices, shape (G, V), in the order of `Symmetry.matrices`. Where nodes coincide
        (slits), the first of them.

    Raises:
        InputError: a node has no image within the tolerance.
    """
    plane = np.asarray(nodes)[:, :2]
    distance, found = cKDTree(plane).query(symmetry.images(plane))
    if distance.max() > tolerance:
        worst = int(distance.max(axis=0).argmax())
        x, y = 1e3 * plane[worst]
        raise InputError(
            f"the mesh has not {symmetry}: node {worst} at ({x:.4g}, {y:.4g}) mm has no image"
        )
    return np.asarray(found, dtype=np.intp)


@dataclass(frozen=True, eq=False)
class _Curve:
    """The boundary of a shape, in units of the diagonal about the centre.

    Attributes:
        line: the boundary; a line is its own.
        points: vertices and points between them, shape (N, 2).
        places: middles of the pieces between them, as complex numbers, shape (M,).
        lengths: lengths of the pieces, shape (M,).
    """

    line: Geometry
    points: Floats
    places: np.ndarray[tuple[int], np.dtype[np.complex128]]
    lengths: Floats

    @classmethod
    def of(cls, shape: Geometry) -> _Curve:
        import shapely

        # What rounding leaves of differences of shapes has an area, but no width.
        parts = [p for p in shapely.get_parts(shape) if not 0.0 < p.area < NO_WIDTH * p.length]
        rims = [part.boundary if shapely.get_dimensions(part) == 2 else part for part in parts]
        line = shapely.segmentize(shapely.union_all(rims), 1.0 / SAMPLES)
        shapely.prepare(line)
        points, owner = shapely.get_coordinates(shapely.get_parts(line), return_index=True)
        along = np.flatnonzero(owner[1:] == owner[:-1])
        z = points[:, 0] + 1j * points[:, 1]
        return cls(line, points, 0.5 * (z[along] + z[along + 1]), np.abs(z[along + 1] - z[along]))


def _rotation(order: int) -> Floats:
    return np.asarray(Symmetry((0.0, 0.0), order, None).matrices()[1])


def _reflection(angle: float) -> Floats:
    return np.asarray(Symmetry((0.0, 0.0), 1, angle).matrices()[1])


def _fits(curves: list[_Curve], matrix: Floats, tolerance: float) -> bool:
    """Whether a map takes every curve to itself.

    It is enough that a curve lands on itself: a map that keeps lengths then fills it.
    """
    import shapely

    return all(
        bool(shapely.dwithin(curve.line, shapely.points(curve.points @ matrix.T), tolerance).all())
        for curve in curves
    )


def _misfit(curves: list[_Curve], matrix: Floats) -> float:
    """Largest distance of a moved curve from itself."""
    import shapely

    return max(
        float(shapely.distance(curve.line, shapely.points(curve.points @ matrix.T)).max())
        for curve in curves
    )


def _mirror(curves: list[_Curve], order: int, tolerance: float) -> float | None:
    """Direction of the mirror line in [0, π/order) that fits best, None without one."""
    moments = []
    for curve in curves:
        radius, phase = np.abs(curve.places), np.exp(1j * np.angle(curve.places))
        for power in POWERS:
            weight = curve.lengths * radius**power
            for m in range(order, HARMONICS * order + 1, order):
                moment = (weight * phase**m).sum() / weight.sum()
                moments.append((abs(moment), m, float(np.angle(moment))))
    moments.sort(key=lambda item: (-item[0], item[1]))
    for size, m, angle in moments[:12]:
        if size < FAINT:
            break
        step = np.pi / m
        tried = [_neat((angle / m + k * step) % (np.pi / order)) for k in range(m // order)]
        fitting = [a for a in tried if _fits(curves, _reflection(a), tolerance)]
        if fitting:
            best = min(fitting, key=lambda a: _misfit(curves, _reflection(a)))
            return best if best < np.pi / order - NEARLY else 0.0
    return None


def _neat(angle: float) -> float:
    """The multiple of a quarter of a degree next to an angle that is one but for rounding."""
    near = round(angle / NEAT) * NEAT
    return near if abs(near - angle) < NEARLY else angle


def _pair(point: Floats) -> tuple[float, float]:
    return float(point[0]), float(point[1])
