"""A surface laid flat by a map that keeps angles: the sheet, and how much it must shrink where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sheetmorph.compare.reduce import reduced
from sheetmorph.compare.surface import Indices, Surface
from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats

MOST_TRIANGLES = 6000
_LARGEST = 0.98
"""Of the area, the share that must shrink and not grow; the rest are corners and noise."""
_NEARLY_FLAT = 0.02


@dataclass(frozen=True, eq=False)
class Flattened:
    """A surface and its conformal image in the plane.

    Attributes:
        surface: of one piece with one rim [m].
        plan: where its points lie in the plane [m], about the origin, shape (V, 2).
        factor: lengths on the surface over those in the plane, at most 1, shape (V,).
        rim: points of the rim, counter-clockwise in the plane, shape (R,).
    """

    surface: Surface
    plan: Floats
    factor: Floats
    rim: Indices

    @property
    def strain(self) -> Floats:
        """By which a sheet must shrink at the points, shape (V,)."""
        return np.asarray(self.factor - 1.0)

    @property
    def developable(self) -> bool:
        """Whether next to no shrinkage tells the surface from a flat sheet."""
        return bool(np.ptp(self.factor) < _NEARLY_FLAT)


def flatten(target: Surface) -> Flattened:
    """Lay a surface flat, conformally, with a free rim.

    Shrinkage that is the same in all directions changes lengths, not angles. So a sheet that
    shrinks by the factor of a conformal map has the metric of the surface (as in van Rees, Vouga
    and Mahadevan 2017). Of all such maps this is the one whose rim is spread the most, the
    spectral one of Mullen, Tong, Alliez and Desbrun (2008). The plane is scaled such that the
    sheet grows nowhere.

    Args:
        target: the surface [m].

    Raises:
        InputError: it is of several pieces, closed, or has more than one rim.
    """
    import igl

    surface, _ = reduced(target, MOST_TRIANGLES)
    surface = surface.part(np.ones(len(surface.triangles), dtype=bool))
    rim = _rim(surface)
    points = surface.points / surface.size
    ends = _far_apart(points[rim])
    pins = np.ascontiguousarray(rim[ends])
    plan, energy = igl.lscm(points, surface.triangles, pins, np.array([[0.0, 0.0], [1.0, 0.0]]))
    plan = _spread(energy, np.asarray(plan), rim)
    if _signed_area(plan, surface.triangles) < 0.0:
        plan = plan * np.array([1.0, -1.0])
    plan = _turned(plan)
    areas = _areas(plan, surface.triangles)
    if not (areas > 0.0).all():
        bad = float(surface.areas[areas <= 0.0].sum() / surface.area)
        if bad > 0.01:
            raise InputError(
                "the target folds over when it is laid flat; the free family needs less"
            )
    ratio = surface.areas / np.maximum(areas, 1e-12 * areas.max())
    share = np.repeat(surface.areas / 3.0, 3)
    corners = surface.triangles.ravel()
    weight = np.bincount(corners, share, len(points))
    factor = np.bincount(corners, share * np.repeat(np.sqrt(ratio), 3), len(points)) / weight
    order = np.argsort(factor)
    reached = np.cumsum(weight[order]) / weight.sum()
    largest = float(factor[order][np.searchsorted(reached, _LARGEST)])
    loop = rim if _loop_area(plan[rim]) > 0.0 else rim[::-1]
    return Flattened(surface, largest * plan, np.minimum(factor / largest, 1.0), loop)


def _rim(surface: Surface) -> Indices:
    import igl

    loops = igl.boundary_loop_all(surface.triangles)
    edges = np.sort(
        np.concatenate([surface.triangles[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))]), axis=1
    )
    euler = len(surface.points) - len(np.unique(edges, axis=0)) + len(surface.triangles)
    if len(loops) != 1 or euler != 1:
        rims = "no rim" if not loops else f"{len(loops)} rims"
        raise InputError(
            f"the target has {rims}; the family free needs one piece of surface with one rim, "
            "such as a bowl",
            key="TARGET",
        )
    return np.asarray(loops[0], dtype=np.int64)


def _far_apart(points: Floats) -> list[int]:
    """Two points that are about as far apart as any."""
    first = int(np.linalg.norm(points - points.mean(axis=0), axis=1).argmax())
    return [first, int(np.linalg.norm(points - points[first], axis=1).argmax())]


def _spread(energy: object, plan: Floats, rim: Indices) -> Floats:
    """Minimise the conformal energy over all maps whose rim has a given spread, from a first one.

    Inverse iterations on the energy, in which the rim alone has mass.
    """
    from scipy.sparse import csc_array, identity
    from scipy.sparse.linalg import splu

    count = len(plan)
    matrix = csc_array(energy)
    shift = 1e-9 * float(np.abs(matrix.diagonal()).mean())
    solve = splu(csc_array(matrix + shift * identity(2 * count))).solve
    on_rim = np.zeros(count)
    on_rim[rim] = 1.0
    x = plan.T.copy()
    for _ in range(30):
        x -= (x @ on_rim / on_rim.sum())[:, None]
        x *= 1.0 / np.sqrt((x**2 @ on_rim).sum())
        before = x
        x = solve((x * on_rim).ravel()).reshape(2, count)
        unit = x / np.sqrt((x**2 @ on_rim).sum())
        if float(np.abs(unit - before).max()) < 1e-7:
            break
    x -= (x @ on_rim / on_rim.sum())[:, None]
    return np.ascontiguousarray((x / np.abs(x).max()).T)


def _turned(plan: Floats) -> Floats:
    """About the origin, its long axis along x."""
    middle = plan - 0.5 * (plan.max(axis=0) + plan.min(axis=0))
    axes = np.linalg.eigh(middle.T @ middle)[1][:, ::-1]
    axes[:, 1] *= np.sign(np.linalg.det(axes))
    turned = middle @ axes
    return np.asarray(turned - 0.5 * (turned.max(axis=0) + turned.min(axis=0)))


def _areas(plan: Floats, triangles: Indices) -> Floats:
    a, b, c = (plan[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    return np.asarray(0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]))


def _signed_area(plan: Floats, triangles: Indices) -> float:
    return float(_areas(plan, triangles).sum())


def _loop_area(loop: Floats) -> float:
    x, y = loop.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
