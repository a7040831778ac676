"""Derivatives by the boundary of a smeared pattern: first by its corners, then by their motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.design.actuation import smooth_share_slopes, whole_strain
from sheetmorph.design.boundary import Boundary
from sheetmorph.design.layout import joined
from sheetmorph.design.meshing import hinge_orientation
from sheetmorph.design.regions import hinge_face
from sheetmorph.design.smoothing import (
    SOFTNESS,
    SmoothPattern,
    farthest_from,
    smooth_boundaries,
    smooth_sign_slope,
)
from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats
from sheetmorph.study.model import Problem
from sheetmorph.study.shape_slopes import ShapeSlopes, followed

if TYPE_CHECKING:
    from shapely import MultiPolygon

    from sheetmorph.design.piece import Piece

NEGLIGIBLE = 1e-13
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
    """Derivatives by the corners of the drawn parts of a pattern, and by those of its shapes.

    Attributes:
        design: the design.
        boundaries: of the parts; of all inert ones together under `TOGETHER` if they are several.
        by_corner: derivatives by the corners of each, shape (M, 2).
        shapes: derivatives by the corners of the shapes from which the parts are drawn.
        width: of the smoothing [m].
        felt: what they come from.
    """

    design: Design
    boundaries: Mapping[str, Boundary]
    by_corner: Mapping[str, Floats]
    shapes: ShapeSlopes
    width: float
    felt: tuple[_Felt, ...]

    @classmethod
    def of(
        cls, problem: Problem, fields: Mapping[str, Floats], by_mass: Floats | None
    ) -> PatternSlopes:
        """Carry derivatives by the fields of the model on to the corners of the pattern.

        Args:
            problem: the problem.
            fields: derivatives by the fields of the model, those by the layers among them.
            by_mass: by the masses of the triangles [1/kg], shape (T,); None where nothing weighs.
        """
        smooth = problem.regions.smooth
        assert smooth is not None  # noqa: S101  the caller has made sure
        design = problem.design
        boundaries, whole = _boundaries(design, design.layout.drawn)
        felt = _felt(problem, smooth, whole, fields, by_mass)
        by_corner = {name: np.zeros_like(edge.corners) for name, edge in boundaries.items()}
        for one in felt:
            by_corner[one.name] += boundaries[one.name].onto_corners(
                one.points, one.by_share, one.by_away, smooth.width
            )
        members = {name: _members(design, name) for name in boundaries}
        shapes = ShapeSlopes.of(design, boundaries, by_corner, members)
        return cls(design, boundaries, by_corner, shapes, smooth.width, felt)

    def by_number(self, shape: int, ahead: Piece, behind: Piece, step: float) -> float:
        """Derivative by a number of one shape.

        Its corners alone are looked at. Where one of them comes or goes, or the shape touches
        another so that corners of the part do, the whole pattern is drawn anew.

        Args:
            shape: index of the shape of the pattern.
            ahead: the same with the number larger by the step.
            behind: smaller by it.
            step: in the unit of the number.
        """
        found = self.shapes.by_number(shape, ahead, behind, step)
        return self._towards(shape, ahead) / step if found is None else found

    def _towards(self, shape: int, ahead: Piece) -> float:
        """Change of the function, to first order, as one shape becomes another.

        Corners are followed where both boundaries have the same ones; where a corner comes or
        goes, indicators and distances are computed anew.
        """
        regions = list(self.shapes.regions)
        regions[shape] = ahead.region(self.design.outline_polygon())
        boundaries, _ = _boundaries(self.design, joined(self.design.pattern, regions))
        total = 0.0
        for name, edge in self.boundaries.items():
            far = boundaries[name]
            corners = followed(edge.corners, far.corners, self.shapes.jump)
            if corners is not None:
                total += float((self.by_corner[name] * (corners - edge.corners)).sum())
                continue
            total += sum(
                _change(one, far, edge, self.width) for one in self.felt if one.name == name
            )
        return total


def _boundaries(
    design: Design, drawn: Mapping[str, MultiPolygon]
) -> tuple[dict[str, Boundary], str]:
    """The boundaries of the parts, and the name of that of all inert ones together."""
    parts, whole = smooth_boundaries(design, drawn)
    for name, edge in parts.items():
        if edge is whole:
            return {**parts}, name
    return {**parts, TOGETHER: whole}, TOGETHER


def _members(design: Design, name: str) -> Sequence[int]:
    """Indices of the shapes that make a boundary."""
    inert = {layer.where for layer in design.layers if layer.role == "inert"}
    parts = {piece.part for piece in design.pattern}
    wanted = ((parts & inert) or parts) if name == TOGETHER else {name}
    return [index for index, piece in enumerate(design.pattern) if piece.part in wanted]


def _change(felt: _Felt, far: Boundary, near: Boundary, width: float) -> float:
    """Change of the function from one boundary to another, by what is felt of them."""
    shared, apart = np.flatnonzero(felt.by_share), np.flatnonzero(felt.by_away)
    share = far.share(felt.points[shared], width) - near.share(felt.points[shared], width)
    away = far.away(felt.points[apart], width) - near.away(felt.points[apart], width)
    return float(felt.by_share[shared] @ share + felt.by_away[apart] @ away)


def _felt(
    problem: Problem,
    smooth: SmoothPattern,
    whole: str,
    fields: Mapping[str, Floats],
    by_mass: Floats | None,
) -> tuple[_Felt, ...]:
    """Derivatives by indicators and distances of every part, at edges, triangles and nodes.

    Args:
        problem: the problem.
        smooth: its pattern.
        whole: name of the boundary of all inert parts together.
        fields: derivatives by the fields of the model.
        by_mass: by the masses of the triangles.
    """
    design, mesh = problem.design, problem.mesh
    places = {
        "edges": mesh.edge_midpoints,
        "triangles": mesh.triangle_centroids,
        "nodes": np.ascontiguousarray(mesh.nodes[:, :2]),
    }
    by_share: dict[tuple[str, str], Floats] = {}
    by_away: dict[tuple[str, str], Floats] = {}

    def add(name: str, where: str, share: Floats | float, away: Floats | float = 0.0) -> None:
        for found, more in ((by_share, share), (by_away, away)):
            before = found.setdefault((name, where), np.zeros(len(places[where])))
            found[name, where] = before + more

    own = "triangles" if design.laminate else "edges"
    cover = smooth.triangles if design.laminate else smooth.edges
    for index, layer in enumerate(design.layers):
        if layer.where in smooth.names:
            add(layer.where, own, fields["thickness"][index] * layer.thickness)
            if by_mass is not None:
                areal = layer.density * layer.thickness
                add(layer.where, "triangles", by_mass * mesh.triangle_areas * areal)

    by_strain = fields["eigenstrain"]
    if design.laminate:
        by_strain = (by_strain * whole_strain(design, mesh)).sum(axis=1)
    else:
        by_strain = by_strain * design.eps_pre
    covered, away, farthest = smooth_share_slopes(design, smooth, cover)
    add(whole, own, by_strain * covered, by_strain * away)
    total = float(by_strain @ farthest)
    _, weights = farthest_from(smooth.nodes, smooth.edges, mesh, smooth.width)
    weights[weights < NEGLIGIBLE] = 0.0
    at_nodes, at_edges = np.split(total * weights, [len(mesh.nodes)])
    if not design.laminate:
        at_nodes = at_nodes + _by_side(problem, smooth, fields["coupling"])
    for where, one, slope in (
        ("nodes", smooth.nodes, at_nodes),
        ("edges", smooth.edges, at_edges),
    ):
        add(whole, where, -2.0 * slope * one.away, slope * (1.0 - 2.0 * one.covered))
    return tuple(
        _Felt(name, places[where], share, by_away[name, where])
        for (name, where), share in by_share.items()
    )


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
