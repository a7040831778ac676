"""A pattern whose boundary is smeared, so that everything varies smoothly when it moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.design.boundary import Boundary
from sheetmorph.design.sections import EVERYWHERE
from sheetmorph.geometry.mesh import Floats, SheetMesh

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design

SOFTNESS = 0.25
"""Widths, as fractions of the smoothing, over which a sign turns and a maximum is blended."""


@dataclass(frozen=True, eq=False)
class SmoothPattern:
    """Signed distances from the parts of a pattern, and what follows from them smoothly.

    A part has the indicator χ(d) of the signed distance d from its boundary as drawn: 1 at
    d ≤ −w/2, 0 at d ≥ w/2, a polynomial of degree five between, twice continuously differentiable.
    Layers taper off with it: at any place a layer of the part is χ times as thick.

    Attributes:
        width: w [m].
        names: of the P parts.
        inert: True for parts with an inert layer, shape (P,).
        edges: signed distances of the midpoints of the edges [m], shape (P, E).
        triangles: of the centroids of the triangles, shape (P, T).
        nodes: of the nodes, shape (P, V).
        farthest: greatest distance of a node from the inert parts [m], blended.
    """

    width: float
    names: tuple[str, ...]
    inert: NDArray[np.bool_]
    edges: Floats
    triangles: Floats
    nodes: Floats
    farthest: float

    def share(self, distances: Floats) -> Floats:
        """χ at signed distances [m] of any shape."""
        return smooth_step(0.5 - distances / self.width)

    def nearest(self, distances: Floats) -> Floats:
        """Signed distance from the union of the inert parts [m], shape (N,).

        Args:
            distances: from each part [m], shape (P, N).
        """
        return np.asarray(distances[self.inert].min(axis=0))

    def free(self, distances: Floats) -> tuple[Floats, Floats]:
        """Share that no inert part covers, and fraction of the greatest distance, (N,) each.

        The distance in the fraction is ∫ (1 − χ) dd: zero within the parts, d outside them.

        Args:
            distances: from each part [m], shape (P, N).
        """
        away = self.nearest(distances)
        return 1.0 - self.share(away), smooth_distance(away, self.width) / self.farthest

    def layer_shares(self, design: Design, distances: Floats) -> Floats:
        """By which each layer's thickness is multiplied at N places, shape (layers, N).

        Args:
            design: the design.
            distances: from each part [m], shape (P, N).
        """
        shares = dict(zip(self.names, self.share(distances), strict=True))
        ones = np.ones(distances.shape[1])
        return np.stack(
            [ones if layer.where == EVERYWHERE else shares[layer.where] for layer in design.layers]
        )

    def hinge_side(self, mesh: SheetMesh) -> Floats:
        """In (−1, 1): 1 where node c of a hinge lies farther from the pattern than d, (H,)."""
        away = self.nodes.min(axis=0)
        return smooth_sign(
            (away[mesh.hinges[:, 2]] - away[mesh.hinges[:, 3]]) / (SOFTNESS * self.width)
        )


def smooth_pattern(design: Design, mesh: SheetMesh) -> SmoothPattern | None:
    """The smeared pattern of a design on a mesh; None where its boundary is sharp.

    Raises:
        InputError: the inert parts cover the whole sheet.
    """
    width = design.spec.mesh.pattern_smoothing
    if width is None:
        return None
    drawn = design.layout.drawn
    boundaries = [Boundary.of(area) for area in drawn.values()]
    inert = {layer.where for layer in design.layers if layer.role == "inert"}
    covers = np.array([name in inert for name in drawn], dtype=np.bool_)
    nodes = np.stack([edge.distance(mesh.nodes[:, :2]) for edge in boundaries])
    farthest = 1.0
    if covers.any():
        farthest, _ = blended_maximum(nodes[covers].min(axis=0), mesh.node_areas, width)
        if farthest <= 0.0:
            raise InputError("the pattern covers the whole mesh, so nothing can shrink")
    return SmoothPattern(
        width=width,
        names=tuple(drawn),
        inert=covers,
        edges=np.stack([edge.distance(mesh.edge_midpoints) for edge in boundaries]),
        triangles=np.stack([edge.distance(mesh.triangle_centroids) for edge in boundaries]),
        nodes=nodes,
        farthest=farthest,
    )


def smooth_step(u: Floats) -> Floats:
    """10 u³ − 15 u⁴ + 6 u⁵ between u = 0 and 1, constant beyond."""
    u = np.clip(u, 0.0, 1.0)
    return np.asarray(u**3 * (10.0 - u * (15.0 - 6.0 * u)))


def smooth_sign(u: Floats) -> Floats:
    """From −1 at u ≤ −1 to 1 at u ≥ 1, by `smooth_step`."""
    return np.asarray(2.0 * smooth_step(0.5 * (u + 1.0)) - 1.0)


def smooth_sign_slope(u: Floats) -> Floats:
    """Derivative of `smooth_sign`."""
    v = np.clip(0.5 * (u + 1.0), 0.0, 1.0)
    return np.asarray(30.0 * (v * (1.0 - v)) ** 2)


def smooth_distance(distance: Floats, width: float) -> Floats:
    """∫ (1 − χ) dd [m]: 0 at d ≤ −w/2, d at d ≥ w/2."""
    v = np.clip(distance / width + 0.5, 0.0, 1.0)
    bent = width * v**4 * (2.5 - v * (3.0 - v))
    return np.asarray(np.where(distance > 0.5 * width, distance, bent))


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
