"""Regular meshes of simple sheets, for tests and proofs: rectangles, discs, rings, spheres.

All but the disc are grids of nu × nv cells, each cut into two triangles. The node of column i and
row j has the index j (nu + 1) + i, so that supports and loads may name it.
"""

from __future__ import annotations

import math
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.geometry.topology import build_mesh

Pattern = Literal["right", "alternating"]
"""How cells are cut: all along the same diagonal, or in turns, as in a union jack."""

MAX_IRREGULAR = 0.24  # beyond, triangles may turn over


def rectangle(
    width: float,
    height: float,
    nx: int,
    ny: int,
    pattern: Pattern = "right",
    *,
    centre: tuple[float, float] = (0.0, 0.0),
    irregular: float = 0.0,
    seed: int = 0,
) -> SheetMesh:
    """A rectangle of nx × ny cells; i counts along x, j along y.

    Args:
        width, height: [m].
        nx, ny: numbers of cells.
        pattern: how cells are cut.
        centre: of the rectangle [m].
        irregular: nodes are moved at random by up to this fraction of a cell, along x and
            along y; those of the rim stay on it, corners where they are. 0 to 0.24.
        seed: of the random numbers.

    Raises:
        InputError: a number of cells below 1, or an argument out of range.
    """
    _positive(width=width, height=height)
    _fraction(irregular)
    triangles = _cells(nx, ny, pattern)
    i, j = _indices(nx, ny)
    shift = np.random.default_rng(seed).uniform(-irregular, irregular, (2, len(i)))
    x = np.where((i > 0) & (i < nx), i + shift[0], i) / nx - 0.5
    y = np.where((j > 0) & (j < ny), j + shift[1], j) / ny - 0.5
    nodes = np.column_stack([centre[0] + width * x, centre[1] + height * y])
    return build_mesh(nodes, triangles)


def disc(
    radius: float, rings: int, *, quarter: bool = False, irregular: float = 0.0, seed: int = 0
) -> SheetMesh:
    """A disc about the origin, of rings around a node in the middle; ring k has 6 k nodes.

    Nodes count from the middle outward, in each ring counter-clockwise from the x axis. The mesh
    has the symmetry of a regular hexagon.

    Args:
        radius: [m].
        rings: number of rings.
        quarter: only the quarter between the x and the y axis, for sheets cut at planes of
            symmetry; ring k has 2 k + 1 nodes.
        irregular: nodes are moved at random by up to this fraction of the distance of the rings,
            along and around; those of the rim and the axes stay on them, the middle where it is.
            0 to 0.24.
        seed: of the random numbers.

    Raises:
        InputError: fewer than one ring, or an argument out of range.
    """
    _positive(radius=radius)
    _fraction(irregular)
    if rings < 1:
        raise InputError("a disc needs rings", key="rings", value=rings, allowed="≥ 1")
    # Sectors with k edges on ring k, each of this angle; a quarter is not closed.
    sectors, angle = (2, math.pi / 4.0) if quarter else (6, math.pi / 3.0)
    counts = [sectors * k + quarter for k in range(1, rings + 1)]
    first = np.cumsum([1, *counts])
    ring = np.repeat(np.arange(1, rings + 1), counts)
    place = np.arange(1, first[-1]) - first[ring - 1]
    shift = np.random.default_rng(seed).uniform(-irregular, irregular, (2, len(ring)))
    ends = quarter & ((place == 0) | (place == sectors * ring))
    r = np.where(ring < rings, ring + shift[0], ring) / rings
    t = (place + np.where(ends, 0.0, shift[1])) * angle / ring
    nodes = np.column_stack([np.append(0.0, r * np.cos(t)), np.append(0.0, r * np.sin(t))])
    triangles = []
    for k in range(1, rings + 1):
        outer, inner = first[k - 1], first[k - 2] if k > 1 else 0
        sector, step = np.divmod(np.arange(sectors * k), k)
        on = sector * k + step
        ahead = on + 1 if quarter else (on + 1) % counts[k - 1]
        below = sector * (k - 1) + step
        after = below + 1
        if not quarter and k > 1:
            below, after = below % counts[k - 2], after % counts[k - 2]
        elif k == 1:
            below = after = np.zeros_like(on)
        triangles.append(np.column_stack([outer + on, outer + ahead, inner + below]))
        between = step < k - 1
        triangles.append(np.column_stack([inner + below, outer + ahead, inner + after])[between])
    return build_mesh(radius * nodes, np.concatenate(triangles))


def ring_sector(
    inner: float,
    outer: float,
    nr: int,
    nt: int,
    pattern: Pattern = "right",
    *,
    start: float = 0.0,
    end: float = 2.0 * math.pi,
) -> SheetMesh:
    """A sector of a flat ring about the origin; i counts outward, j counter-clockwise.

    A whole ring is slit along its start: rows 0 and nt lie at the same place.

    Args:
        inner, outer: radii [m].
        nr, nt: numbers of cells along and around.
        pattern: how cells are cut.
        start, end: angles from the x axis [rad], by no more than a turn apart.

    Raises:
        InputError: a number of cells below 1, or an argument out of range.
    """
    _positive(inner=inner, outer=outer - inner)
    _turn("end", start, end, 2.0 * math.pi)
    i, j = _indices(nr, nt)
    r, t = inner + (outer - inner) * i / nr, start + (end - start) * j / nt
    return build_mesh(np.column_stack([r * np.cos(t), r * np.sin(t)]), _cells(nr, nt, pattern))


def sphere_sector(
    radius: float,
    polar: tuple[float, float],
    azimuth: tuple[float, float],
    n_polar: int,
    n_azimuth: int,
    pattern: Pattern = "right",
) -> SheetMesh:
    """A sector of the upper half of a sphere about the origin, curved.

    i counts along the polar angle, from the top down, j counter-clockwise; normals point
    outward.

    Args:
        radius: [m].
        polar: first and last angle from the z axis [rad], 0 < first < last ≤ π/2.
        azimuth: first and last angle from the x axis [rad], by no more than a turn apart.
        n_polar, n_azimuth: numbers of cells.
        pattern: how cells are cut.

    Raises:
        InputError: a number of cells below 1, or an argument out of range.
    """
    _positive(radius=radius, polar=polar[0])
    _turn("polar", *polar, 0.5 * math.pi - polar[0])
    _turn("azimuth", *azimuth, 2.0 * math.pi)
    i, j = _indices(n_polar, n_azimuth)
    t = polar[0] + (polar[1] - polar[0]) * i / n_polar
    p = azimuth[0] + (azimuth[1] - azimuth[0]) * j / n_azimuth
    nodes = np.column_stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)])
    return build_mesh(radius * nodes, _cells(n_polar, n_azimuth, pattern), curved=True)


def _indices(nu: int, nv: int) -> tuple[Floats, Floats]:
    """Column and row of each node, shape ((nu + 1)(nv + 1),) each."""
    j, i = np.divmod(np.arange((nu + 1) * (nv + 1), dtype=np.float64), nu + 1)
    return i, j


def _cells(nu: int, nv: int, pattern: Pattern) -> NDArray[np.intp]:
    """Triangles of a grid, counter-clockwise where columns and rows are right-handed."""
    if pattern not in get_args(Pattern):
        raise InputError(
            "no such pattern", key="pattern", value=pattern, allowed=", ".join(get_args(Pattern))
        )
    if min(nu, nv) < 1:
        raise InputError("a mesh needs cells", value=(nu, nv), allowed="≥ 1")
    i, j = (part.ravel() for part in np.meshgrid(np.arange(nu), np.arange(nv)))
    a = j * (nu + 1) + i
    b, c, d = a + 1, a + nu + 2, a + nu + 1
    rising = ((i + j) % 2 == 0)[:, None] | (pattern == "right")
    first = np.where(rising, np.column_stack([a, b, c]), np.column_stack([a, b, d]))
    second = np.where(rising, np.column_stack([a, c, d]), np.column_stack([b, c, d]))
    return np.concatenate([first, second])


def _positive(**values: float) -> None:
    for key, value in values.items():
        if not (math.isfinite(value) and value > 0.0):
            raise InputError("is out of range", key=key, value=value, allowed="> 0")


def _fraction(irregular: float) -> None:
    if not 0.0 <= irregular <= MAX_IRREGULAR:
        raise InputError(
            "is out of range", key="irregular", value=irregular, allowed=f"0 to {MAX_IRREGULAR}"
        )


def _turn(key: str, start: float, end: float, most: float) -> None:
    if not 0.0 < end - start <= most * (1.0 + 1e-12):
        raise InputError(
            "is out of range", key=key, value=end - start, allowed=f"above 0 to {most:.6g} rad"
        )
