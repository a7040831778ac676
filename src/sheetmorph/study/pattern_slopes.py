"""Derivatives by the boundary of a smeared pattern: first by its corners, then by their motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.design.boundary import Boundary
from sheetmorph.design.layout import joined
from sheetmorph.design.meshing import hinge_orientation
from sheetmorph.design.regions import Regions, hinge_face
from sheetmorph.design.smoothing import (
    SOFTNESS,
    Cover,
    SmoothPattern,
    farthest_from,
    smooth_boundaries,
    smooth_sign_slope,
)
from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.study.model import Problem
from sheetmorph.study.parameters import model_arrays

if TYPE_CHECKING:
    from shapely import MultiPolygon
    from shapely.geometry.base import BaseGeometry

STEP = 1e-5
"""Of central differences of arrays, in indicators and in widths of the smoothing."""
JUMP = 1e-3
"""Corners that move farther than this for a small step, in widths of the sheet, are others."""
NEGLIGIBLE = 1e-15
"""Shares of the greatest distance that are left out."""
TOGETHER = "*"
"""Name of all inert parts together, where there are several."""


@dataclass(frozen=True, eq=False)
class _Felt:
    """How a function feels a boundary at N places.

    Attributes:
        name: of the boundary.
        points: the places [m], shape (N, 2).
        by_share: derivatives by its indicator there, shape (N,).
        by_away: by the distance from it, shape (N,).
    """

    name: str
    points: Floats
    by_share: Floats
    by_away: Floats


@dataclass(frozen=True, eq=False)
class PatternSlopes:
    """Derivatives by the corners of the drawn parts of a pattern.

    Attributes:
        boundaries: of the parts; of all inert ones together under `TOGETHER` if they are several.
        by_corner: derivatives by the corners of each, shape (M, 2).
        design: the design.
        regions: of the shapes that make the pattern.
        width: of the smoothing [m].
        felt: what they come from.
    """

    design: Design
    regions: Sequence[BaseGeometry]
    boundaries: Mapping[str, Boundary]
    by_corner: Mapping[str, Floats]
    width: float
    felt: tuple[_Felt, ...]

    @classmethod
    def of(cls, problem: Problem, fields: Mapping[str, Floats]) -> PatternSlopes:
        """Carry derivatives by the fields of the model on to the corners of the pattern."""
        smooth = problem.regions.smooth
        assert smooth is not None  # noqa: S101  the caller has made sure
        design = problem.design
        sheet = design.outline_polygon()
        boundaries = _boundaries(design, design.layout.drawn)
        felt = _felt(problem, smooth, fields)
        by_corner = {name: np.zeros_like(edge.corners) for name, edge in boundaries.items()}
        for one in felt:
            by_corner[one.name] += boundaries[one.name].onto_corners(
                one.points, one.by_share, one.by_away, smooth.width
            )
        regions = [piece.region(sheet) for piece in design.pattern]
        return cls(design, regions, boundaries, by_corner, smooth.width, felt)

    def towards(self, ahead: Design, shape: int) -> float:
        """Change of the function, to first order, to a design that differs a little in one shape.

        Corners are followed where both boundaries have the same ones; where a corner comes or
        goes, indicators and distances are computed anew.

        Args:
            ahead: the other design.
            shape: index of the shape of the pattern that differs.
        """
        sheet = self.design.outline_polygon()
        regions = list(self.regions)
        regions[shape] = ahead.pattern[shape].region(sheet)
        boundaries = _boundaries(ahead, joined(ahead.pattern, regions))
        reach = JUMP * float(np.ptp(np.array(sheet.bounds).reshape(2, 2), axis=0).max())
        total = 0.0
        for name, edge in self.boundaries.items():
            far = boundaries[name]
            if _same_corners(edge, far, reach):
                total += float((self.by_corner[name] * (far.corners - edge.corners)).sum())
                continue
            total += sum(
                _change(one, far, edge, self.width) for one in self.felt if one.name == name
            )
        return total


def _boundaries(design: Design, drawn: Mapping[str, MultiPolygon]) -> dict[str, Boundary]:
    parts, whole = smooth_boundaries(design, drawn)
    alone = any(edge is whole for edge in parts.values())
    return {**parts} if alone else {**parts, TOGETHER: whole}


def _same_corners(edge: Boundary, other: Boundary, reach: float) -> bool:
    """Whether another boundary has the same corners in the same order, moved by less than this."""
    if other.corners.shape != edge.corners.shape or not np.array_equal(other.sides, edge.sides):
        return False
    return bool(np.abs(other.corners - edge.corners).max() < reach)


def _change(felt: _Felt, far: Boundary, near: Boundary, width: float) -> float:
    """Change of the function from one boundary to another, by what is felt of them."""
    shared, apart = np.flatnonzero(felt.by_share), np.flatnonzero(felt.by_away)
    share = far.share(felt.points[shared], width) - near.share(felt.points[shared], width)
    away = far.away(felt.points[apart], width) - near.away(felt.points[apart], width)
    return float(felt.by_share[shared] @ share + felt.by_away[apart] @ away)


def _felt(
    problem: Problem, smooth: SmoothPattern, fields: Mapping[str, Floats]
) -> tuple[_Felt, ...]:
    """Derivatives by indicators and distances of every part, at elements and nodes."""
    design, mesh = problem.design, problem.mesh
    key = "triangles" if design.laminate else "edges"
    cover = smooth.triangles if design.laminate else smooth.edges
    points = mesh.triangle_centroids if design.laminate else mesh.edge_midpoints

    def rates(ahead: Regions, behind: Regions, step: float) -> dict[str, Floats]:
        """Slopes of the arrays of the model."""
        ends = [model_arrays(design, mesh, one, "pattern") for one in (ahead, behind)]
        return {k: (ends[0][k] - ends[1][k]) / (2.0 * step) for k in ends[0] if k in fields}

    def by(cover_ahead: Cover, cover_behind: Cover, step: float) -> Floats:
        """Derivative at each element by what differs between two covers."""
        ahead = _with(problem.regions, smooth, key, cover_ahead)
        behind = _with(problem.regions, smooth, key, cover_behind)
        return _at_places(mesh, fields, rates(ahead, behind, step), design.laminate)

    none = np.zeros(len(points))
    found = []
    for row, name in enumerate(smooth.names):
        moved = np.zeros_like(cover.parts)
        moved[row] = STEP
        slope = by(
            replace(cover, parts=cover.parts + moved),
            replace(cover, parts=cover.parts - moved),
            STEP,
        )
        found.append(_Felt(name, points, slope, none))
    whole = _name_of_whole(design)
    by_covered = by(
        replace(cover, covered=cover.covered + STEP),
        replace(cover, covered=cover.covered - STEP),
        STEP,
    )
    step = STEP * smooth.width
    by_away = by(
        replace(cover, away=cover.away + step), replace(cover, away=cover.away - step), step
    )
    found.append(_Felt(whole, points, by_covered, by_away))
    ends = [_with(problem.regions, smooth, "farthest", smooth.farthest + s) for s in (step, -step)]
    farthest = rates(ends[0], ends[1], step)
    total = sum(float((fields[k] * rate).sum()) for k, rate in farthest.items())
    _, weights = farthest_from(smooth.nodes, smooth.edges, mesh, smooth.width)
    weights[weights < NEGLIGIBLE] = 0.0
    at_nodes, at_edges = np.split(total * weights, [len(mesh.nodes)])
    if not design.laminate:
        at_nodes = at_nodes + _by_side(problem, smooth, fields["coupling"])
    for plane, one, slope in (
        (mesh.nodes[:, :2].copy(), smooth.nodes, at_nodes),
        (mesh.edge_midpoints, smooth.edges, at_edges),
    ):
        found.append(
            _Felt(whole, plane, -2.0 * slope * one.away, slope * (1.0 - 2.0 * one.covered))
        )
    return tuple(found)


def _name_of_whole(design: Design) -> str:
    parts, whole = smooth_boundaries(design)
    return next((name for name, edge in parts.items() if edge is whole), TOGETHER)


def _with(region: Regions, smooth: SmoothPattern, key: str, value: Cover | float) -> Regions:
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


def _by_side(problem: Problem, smooth: SmoothPattern, by_coupling: Floats) -> Floats:
    """By the signed distances of the nodes, which turn the sense of hinges, shape (V,)."""
    design, mesh = problem.design, problem.mesh
    found = np.zeros(len(mesh.nodes))
    if hinge_orientation(design, design.resolve_mesh_path()) != "away_from_pattern":
        return found
    signed, scale = smooth.nodes.signed, SOFTNESS * smooth.width
    c, d = mesh.hinges[:, 2], mesh.hinges[:, 3]
    full = design.published.coupling * hinge_face(mesh, problem.regions)
    rate = full * by_coupling * smooth_sign_slope((signed[c] - signed[d]) / scale) / scale
    np.add.at(found, c, rate)
    np.add.at(found, d, -rate)
    return found
