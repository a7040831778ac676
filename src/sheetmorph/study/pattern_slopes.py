"""Derivatives by the boundary of a smeared pattern: first by its corners, then by their motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from sheetmorph.design.boundary import Boundary
from sheetmorph.design.meshing import hinge_orientation
from sheetmorph.design.regions import Regions, hinge_face
from sheetmorph.design.smoothing import (
    SOFTNESS,
    SmoothPattern,
    blended_maximum,
    smooth_sign_slope,
)
from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.study.model import Problem
from sheetmorph.study.parameters import model_arrays

STEP = 1e-5
"""Of central differences of arrays by distances, in widths of the smoothing."""
JUMP = 1e-3
"""Corners that move farther than this for a small step, in sizes of the sheet, are others."""


@dataclass(frozen=True, eq=False)
class ByDistance:
    """Derivatives by the signed distances of a smeared pattern, P parts.

    Attributes:
        places: midpoints of the edges (published model) or centroids of the triangles [m], (N, 2).
        at_places: by their distances from each part, shape (P, N).
        nodes: plan of the nodes [m], shape (V, 2).
        at_nodes: by their distances from each part, shape (P, V).
    """

    places: Floats
    at_places: Floats
    nodes: Floats
    at_nodes: Floats


@dataclass(frozen=True, eq=False)
class PatternSlopes:
    """Derivatives by the corners of the drawn parts of a pattern.

    Attributes:
        boundaries: of the parts.
        by_distance: derivatives by distances, in the order of the parts.
        by_corner: derivatives by the corners of each boundary, shape (M, 2).
    """

    boundaries: Mapping[str, Boundary]
    by_distance: ByDistance
    by_corner: Mapping[str, Floats]

    @classmethod
    def of(cls, problem: Problem, fields: Mapping[str, Floats]) -> PatternSlopes:
        """Carry derivatives by the fields of the model on to the corners of the pattern."""
        smooth = problem.regions.smooth
        assert smooth is not None  # noqa: S101  the caller has made sure
        drawn = problem.design.layout.drawn
        boundaries = {name: Boundary.of(area) for name, area in drawn.items()}
        by_distance = _by_distance(problem, smooth, fields)
        by_corner = {}
        for row, (name, edge) in enumerate(boundaries.items()):
            count = len(edge.corners)
            found = np.zeros((count, 2))
            for points, weights in (
                (by_distance.places, by_distance.at_places[row]),
                (by_distance.nodes, by_distance.at_nodes[row]),
            ):
                used = np.flatnonzero(weights)
                if len(used):
                    found += edge.nearest(points[used]).onto_corners(weights[used], count)
            by_corner[name] = found
        return cls(boundaries, by_distance, by_corner)

    def along(self, ahead: Design, behind: Design, size: float) -> float:
        """Change of the function between two designs whose pattern differs a little.

        Args:
            ahead: a step further.
            behind: a step back.
            size: of the sheet [m].
        """
        total = 0.0
        for row, (name, edge) in enumerate(self.boundaries.items()):
            ends = [Boundary.of(one.layout.drawn[name]) for one in (ahead, behind)]
            if all(_same_corners(edge, end, size) for end in ends):
                moved = ends[0].corners - ends[1].corners
                total += float((self.by_corner[name] * moved).sum())
                continue
            by = self.by_distance
            for points, weights in ((by.places, by.at_places[row]), (by.nodes, by.at_nodes[row])):
                used = np.flatnonzero(weights)
                if len(used):
                    far, near = (end.distance(points[used]) for end in ends)
                    total += float(weights[used] @ (far - near))
        return total


def _same_corners(edge: Boundary, other: Boundary, size: float) -> bool:
    """Whether another boundary has the same corners in the same order, a little moved."""
    if other.corners.shape != edge.corners.shape or not np.array_equal(other.sides, edge.sides):
        return False
    return bool(np.abs(other.corners - edge.corners).max() < JUMP * size)


def _by_distance(
    problem: Problem, smooth: SmoothPattern, fields: Mapping[str, Floats]
) -> ByDistance:
    design, mesh = problem.design, problem.mesh
    places = "triangles" if design.laminate else "edges"
    distances: Floats = getattr(smooth, places)
    step = STEP * smooth.width

    def change(**ends: tuple[object, object]) -> dict[str, Floats]:
        """Slope of each array of the model between two values of a key of the pattern."""
        (key, pair), *_ = ends.items()
        ahead, behind = (
            model_arrays(design, mesh, _with(problem.regions, smooth, key, value), "pattern")
            for value in pair
        )
        return {name: ahead[name] - behind[name] for name in ahead if name in fields}

    at_places = np.zeros_like(distances)
    for row in range(len(distances)):
        moved = np.zeros_like(distances)
        moved[row] = step
        rates = change(**{places: (distances + moved, distances - moved)})
        at_places[row] = _at_places(mesh, fields, rates, design.laminate) / (2.0 * step)
    at_nodes = np.zeros_like(smooth.nodes)
    if smooth.inert.any():
        rates = change(farthest=(smooth.farthest + step, smooth.farthest - step))
        by_farthest = sum(float((fields[k] * rate).sum()) for k, rate in rates.items())
        away = np.where(smooth.inert[:, None], smooth.nodes, np.inf)
        _, weights = blended_maximum(away.min(axis=0), mesh.node_areas, smooth.width)
        columns = np.arange(away.shape[1])
        at_nodes[away.argmin(axis=0), columns] += by_farthest / (2.0 * step) * weights
    if not design.laminate:
        _add_sides(at_nodes, problem, smooth, fields["coupling"])
    points = mesh.triangle_centroids if design.laminate else mesh.edge_midpoints
    return ByDistance(points, at_places, mesh.nodes[:, :2], at_nodes)


def _with(region: Regions, smooth: SmoothPattern, key: str, value: object) -> Regions:
    return replace(region, smooth=replace(smooth, **{key: value}))  # type: ignore[arg-type]


def _at_places(
    mesh: SheetMesh, fields: Mapping[str, Floats], rates: Mapping[str, Floats], laminate: bool
) -> Floats:
    """Products of derivatives and rates, summed at each edge or triangle."""
    if laminate:
        return np.asarray(
            (fields["eigenstrain"] * rates["eigenstrain"]).sum(axis=1)
            + (fields["thickness"] * rates["thickness"]).sum(axis=0)
        )
    found = fields["eigenstrain"] * rates["eigenstrain"]
    found = found + fields["stretch_stiffness"] * rates["stretch_stiffness"]
    found[mesh.hinge_edges[:, 0]] += fields["bending_stiffness"] * rates["bending_stiffness"]
    return np.asarray(found)


def _add_sides(
    at_nodes: Floats, problem: Problem, smooth: SmoothPattern, by_coupling: Floats
) -> None:
    """Add what the sense of the hinges does, which turns with the distances of their nodes."""
    design, mesh = problem.design, problem.mesh
    if hinge_orientation(design, design.resolve_mesh_path()) != "away_from_pattern":
        return
    away, part = smooth.nodes.min(axis=0), smooth.nodes.argmin(axis=0)
    c, d = mesh.hinges[:, 2], mesh.hinges[:, 3]
    scale = SOFTNESS * smooth.width
    u = (away[c] - away[d]) / scale
    turning = np.flatnonzero(np.abs(u) < 1.0)
    size = design.published.coupling * hinge_face(mesh, problem.regions)[turning]
    rate = size * by_coupling[turning] * smooth_sign_slope(u[turning]) / scale
    np.add.at(at_nodes, (part[c[turning]], c[turning]), rate)
    np.add.at(at_nodes, (part[d[turning]], d[turning]), -rate)
