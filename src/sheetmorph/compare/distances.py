"""How far two surfaces are apart where they lie: distances, normals and curvature."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from sheetmorph.compare.surface import Indices, Samples, Surface
from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.surface import triangle_areas, vertex_normals

SAMPLES = 20_000
SMOOTHING = 0.05  # length over which curvature is averaged, as a share of the size
SHORTEST = 0.5  # mean normals shorter than this are those of a fold, not of a curved sheet


@dataclass(frozen=True, eq=False)
class OneWay:
    """From points spread evenly over one surface to the nearest points of another.

    Attributes:
        points: shape (n, 3) [m].
        distance: not negative, shape (n,) [m].
        signed: the same, negative behind the target's normals, shape (n,) [m].
        normal_angle: angle between the two surfaces, whatever way their normals point,
            shape (n,) [rad], 0 to π/2.
        curvature_difference: mean curvature of the one less that of the other, seen from
            the same side, both averaged over `smoothing`, shape (n,) [1/m].
        smoothing: the length of that averaging [m].
        maximum: largest distance of these points and of all corners: the one-sided
            Hausdorff distance [m].
    """

    points: Floats
    distance: Floats
    signed: Floats
    normal_angle: Floats
    curvature_difference: Floats
    smoothing: float
    maximum: float

    @property
    def rms(self) -> float:
        """Root mean square distance [m]."""
        return _rms(self.distance)

    @property
    def mean(self) -> float:
        """Mean distance [m]."""
        return float(self.distance.mean())

    @cached_property
    def percentile_95(self) -> float:
        """Distance that 95 % of the area does not exceed [m]."""
        return float(np.percentile(self.distance, 95.0))

    @property
    def normal_rms(self) -> float:
        """Root mean square angle between the surfaces [rad]."""
        return _rms(self.normal_angle)

    @property
    def normal_mean(self) -> float:
        """Mean angle between the surfaces [rad]."""
        return float(self.normal_angle.mean())

    @property
    def curvature_rms(self) -> float:
        """Root mean square difference of the mean curvatures [1/m]."""
        return _rms(self.curvature_difference)


def distances(
    scan: Surface, shape: Surface, count: int = SAMPLES, seed: int = 0
) -> tuple[OneWay, OneWay]:
    """Distances from a scan to a shape, and back; neither is moved.

    Args:
        count: points on each of the two.
        seed: chooses them.
    """
    smoothing = SMOOTHING * shape.size
    scan_bent, shape_bent = bending(scan, smoothing), bending(shape, smoothing)
    return (
        _one_way(scan, shape, scan_bent, shape_bent, smoothing, scan.sample(count, seed)),
        _one_way(shape, scan, shape_bent, scan_bent, smoothing, shape.sample(count, seed + 1)),
    )


def symmetric_rms(a: Surface, b: Surface, count: int = 4000) -> float:
    """Root of the mean of the two mean squared distances, a to b and b to a [m]."""
    there = b.nearest(a.sample(count).points).distance
    back = a.nearest(b.sample(count).points).distance
    return float(np.sqrt(0.5 * ((there**2).mean() + (back**2).mean())))


@dataclass(frozen=True, eq=False)
class Bending:
    """Normals and mean curvature at the points of a surface, averaged over a length.

    Attributes:
        normals: not of unit length where the surface is rough, shape (V, 3).
        curvature: as seen from the side of the normals, shape (V,) [1/m]; positive on a
            dome.
    """

    normals: Floats
    curvature: Floats


def bending(surface: Surface, length: float) -> Bending:
    """Mean curvature averaged over a length, so that the roughness of a scan cancels out.

    The integrated curvature vectors of the cotangent Laplacian (Meyer et al. 2003, eq. 8)
    and the normals spread by one implicit step of heat flow with time length²/2, which
    stays on the surface: opposite faces of a thin sheet do not mix. The one-sided
    Laplacian of the rim is left out.
    """
    from scipy.sparse import diags_array
    from scipy.sparse.linalg import splu

    points, triangles = surface.points / length, surface.triangles
    laplacian, area = _laplacian(points, triangles)
    inner = np.ones(len(points))
    inner[surface.rim_edges] = 0.0
    pull = -0.5 * (laplacian @ points) * inner[:, None]
    push = vertex_normals(points, triangles) * area[:, None]
    # Where there is no area at all the equation still needs a solution: a trace of weight.
    floor = 1e-9 * float(area.mean())
    off_rim, all_over = (
        splu((diags_array(weight + floor) - 0.5 * laplacian).tocsc()).solve
        for weight in (area * inner, area)
    )
    # Averaging makes vectors shorter where they differ; the normals tell by how much.
    vectors, shorter = off_rim(pull) / length, off_rim(push * inner[:, None])
    square = np.maximum((shorter**2).sum(axis=1), SHORTEST**2)
    return Bending(all_over(push), (vectors * shorter).sum(axis=1) / square)


def _laplacian(points: Floats, triangles: Indices) -> tuple[Any, Floats]:
    """Cotangent Laplacian, negative semidefinite, and a third of the area around each point."""
    import igl

    thirds = np.repeat(triangle_areas(points, triangles) / 3.0, 3)
    area = np.bincount(triangles.ravel(), thirds, len(points))
    return igl.cotmatrix(points, triangles), np.asarray(area, dtype=np.float64)


def _one_way(
    source: Surface,
    target: Surface,
    source_bent: Bending,
    target_bent: Bending,
    smoothing: float,
    samples: Samples,
) -> OneWay:
    near = target.nearest(samples.points)
    gap = samples.points - near.point
    here, there = source.normals[samples.triangle], target.normals[near.triangle]
    cosine = np.abs((here * there).sum(axis=1))
    sine = np.linalg.norm(np.cross(here, there), axis=1)
    mine = _on(source, source_bent, samples.points, samples.triangle)
    other = _on(target, target_bent, near.point, near.triangle)
    side = np.where((mine[0] * other[0]).sum(axis=1) < 0.0, -1.0, 1.0)
    behind = (gap * other[0]).sum(axis=1) < 0.0
    corners = target.nearest(source.points[source.used]).distance
    return OneWay(
        samples.points,
        near.distance,
        np.where(behind, -near.distance, near.distance),
        np.arctan2(sine, cosine),
        mine[1] - side * other[1],
        smoothing,
        float(max(near.distance.max(), corners.max())),
    )


def _on(
    surface: Surface, bent: Bending, points: Floats, triangle: Indices
) -> tuple[Floats, Floats]:
    """Normals and curvature at points on triangles, between their corners."""
    corners = surface.triangles[triangle]
    a, b, c = (surface.points[corners[:, k]] for k in range(3))
    # Shares of the corners, as areas against them; far slivers fall back on the mean.
    normal = np.cross(b - a, c - a)
    square = (normal**2).sum(axis=1)
    sound = square > np.finfo(float).tiny
    shares = np.full((len(points), 3), 1.0 / 3.0)
    for k, (p, q) in enumerate(((b, c), (c, a), (a, b))):
        against = (np.cross(p - points, q - points) * normal).sum(axis=1)
        shares[sound, k] = against[sound] / square[sound]
    shares = np.clip(shares, 0.0, 1.0)
    normals = np.einsum("nk,nkd->nd", shares, bent.normals[corners])
    return normals, np.einsum("nk,nk->n", shares, bent.curvature[corners])


def _rms(values: Floats) -> float:
    return float(np.sqrt((values**2).mean()))
