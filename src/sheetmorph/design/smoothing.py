"""A pattern whose boundary is smeared, so that everything varies smoothly when it moves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import reduce
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.design.boundary import Boundary
from sheetmorph.design.sections import EVERYWHERE
from sheetmorph.geometry.mesh import Floats, SheetMesh

if TYPE_CHECKING:
    from shapely import MultiPolygon

    from sheetmorph.design.spec import Design

SOFTNESS = 0.25
"""Ranges over which a sign turns and a maximum is blended, in widths of the smoothing."""


@dataclass(frozen=True, eq=False)
class Cover:
    """How the pattern covers N places.

    Attributes:
        parts: indicator χ of each part, see `Boundary.share`, shape (P, N).
        covered: that of all inert parts together, shape (N,).
        away: blended distance from their boundary, see `Boundary.away` [m], shape (N,); zero at
            the triangles in the published model, whose free strains do not lie there.
    """

    parts: Floats
    covered: Floats
    away: Floats

    @property
    def signed(self) -> Floats:
        """Distance from the inert parts, negative in them [m], shape (N,)."""
        return np.asarray((1.0 - 2.0 * self.covered) * self.away)


@dataclass(frozen=True, eq=False)
class SmoothPattern:
    """How smeared parts of a pattern cover a mesh.

    Layers taper off with the indicator: at any place a layer of a part is χ times as thick.

    Attributes:
        width: over which χ goes from 0 to 1 [m].
        names: of the P parts.
        edges: at the midpoints of the edges.
        triangles: at the centroids of the triangles.
        nodes: at the nodes.
        farthest: greatest distance of nodes and edges from the inert parts [m], blended.
        areal_masses: of the triangles, with layers that taper off [kg/m²], shape (T,).
    """

    width: float
    names: tuple[str, ...]
    edges: Cover
    triangles: Cover
    nodes: Cover
    farthest: float
    areal_masses: Floats

    def with_layers(self, design: Design) -> SmoothPattern:
        """The same pattern with the layers of another design."""
        shares = self.layer_shares(design, self.triangles)
        areal = np.array([layer.density * layer.thickness for layer in design.layers])
        return replace(self, areal_masses=areal @ shares)

    def layer_shares(self, design: Design, cover: Cover) -> Floats:
        """By which each layer's thickness is multiplied at N places, shape (layers, N)."""
        shares = dict(zip(self.names, cover.parts, strict=True))
        ones = np.ones(len(cover.covered))
        return np.stack(
            [ones if layer.where == EVERYWHERE else shares[layer.where] for layer in design.layers]
        )

    def hinge_side(self, mesh: SheetMesh) -> Floats:
        """In [−1, 1]: 1 where node c of a hinge lies farther from the pattern than d, (H,)."""
        away = self.nodes.signed
        return smooth_sign(
            (away[mesh.hinges[:, 2]] - away[mesh.hinges[:, 3]]) / (SOFTNESS * self.width)
        )


def smooth_boundaries(
    design: Design, drawn: Mapping[str, MultiPolygon] | None = None
) -> tuple[Mapping[str, Boundary], Boundary]:
    """The boundaries of the parts of a pattern as drawn, and that of the inert ones together.

    Without an inert part the latter is that of all parts; nothing depends on it then.

    Args:
        design: the design.
        drawn: parts to take in the place of the design's own.
    """
    drawn = design.layout.drawn if drawn is None else drawn
    parts = {name: Boundary.of(area) for name, area in drawn.items()}
    inert = {layer.where for layer in design.layers if layer.role == "inert"}
    names = [name for name in drawn if name in inert] or list(drawn)
    if len(names) == 1:
        return parts, parts[names[0]]
    return parts, Boundary.of(reduce(lambda a, b: a | b, (drawn[name] for name in names)))


def smooth_pattern(design: Design, mesh: SheetMesh) -> SmoothPattern | None:
    """The smeared pattern of a design on a mesh; None where its boundary is sharp.

    Raises:
        InputError: the inert parts cover the whole sheet.
    """
    width = design.spec.mesh.pattern_smoothing
    if width is None:
        return None
    parts, whole = smooth_boundaries(design)

    def cover(points: Floats, strained: bool = True) -> Cover:
        plane = np.ascontiguousarray(points[:, :2])
        rows = {name: edge.share(plane, width) for name, edge in parts.items()}
        alike = [name for name, edge in parts.items() if edge is whole]
        covered = rows[alike[0]] if alike else whole.share(plane, width)
        away = whole.away(plane, width) if strained else np.zeros(len(plane))
        return Cover(np.stack(list(rows.values())), covered, away)

    nodes, edges = cover(mesh.nodes), cover(mesh.edge_midpoints)
    farthest, _ = farthest_from(nodes, edges, mesh, width)
    if farthest <= 0.0:
        raise InputError("the pattern covers the whole mesh, so nothing can shrink")
    found = SmoothPattern(
        width=width,
        names=tuple(parts),
        edges=edges,
        triangles=cover(mesh.triangle_centroids, design.laminate),
        nodes=nodes,
        farthest=farthest,
        areal_masses=np.zeros(len(mesh.triangles)),
    )
    return found.with_layers(design)


def farthest_from(
    nodes: Cover, edges: Cover, mesh: SheetMesh, width: float
) -> tuple[float, Floats]:
    """The greatest distance from the inert parts [m], and its derivatives.

    Returns:
        The distance, and its derivatives by the signed distances of nodes, then edges, (V + E,).
    """
    return blended_maximum(
        np.concatenate([nodes.signed, edges.signed]),
        np.concatenate([mesh.node_areas, mesh.edge_areas]),
        width,
    )


def smooth_sign(u: Floats) -> Floats:
    """From −1 at u ≤ −1 to 1 at u ≥ 1, a polynomial of degree five between."""
    u = np.clip(u, -1.0, 1.0)
    return np.asarray(u * (15.0 - u * u * (10.0 - 3.0 * u * u)) / 8.0)


def smooth_sign_slope(u: Floats) -> Floats:
    """Derivative of `smooth_sign`."""
    u = np.clip(u, -1.0, 1.0)
    return np.asarray(15.0 / 8.0 * (1.0 - u * u) ** 2)


def blended_maximum(values: Floats, areas: Floats, width: float) -> tuple[float, Floats]:
    """k ln Σ (a/w²) exp(v/k) with k = w/4 [m], which goes to max v with w → 0.

    Args:
        values: v [m], shape (N,).
        areas: a, of the places [m²], shape (N,).
        width: w [m].

    Returns:
        The maximum [m], and its derivative by each value, shape (N,).
    """
    scale = SOFTNESS * width
    top = float(values.max())
    parts = areas / width**2 * np.exp((values - top) / scale)
    whole = float(parts.sum())
    return top + scale * float(np.log(whole)), np.asarray(parts / whole)
