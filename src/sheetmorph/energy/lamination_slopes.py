"""How the work of layered triangles along a motion changes with what their layers are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sheetmorph.energy.lamination import congruence, determinant, half_metric, moduli, times
from sheetmorph.geometry.mesh import Floats

STEP = 1e-5
"""Of central differences in strains and in Poisson's ratios."""


@dataclass(frozen=True, eq=False)
class Layers:
    """L layers on T triangles, from the bottom up.

    Attributes:
        thicknesses: before actuation [m], shape (L, T); 0 where there is no such layer.
        young_moduli: [Pa], shape (L,).
        poisson_ratios: shape (L,).
        factors: by which each layer takes the eigenstrain of its place, shape (L,).
        active: layers whose factor is not 0 by their nature, shape (L,).
        anchors: layers whose common mid-plane is the reference surface, shape (L,).
        thickening: True where a layer keeps its volume.
    """

    thicknesses: Floats
    young_moduli: Floats
    poisson_ratios: Floats
    factors: Floats
    active: NDArray[np.bool_]
    anchors: NDArray[np.bool_]
    thickening: bool


@dataclass(frozen=True, eq=False)
class LayerSlopes:
    """Derivatives of the work of every triangle [J] along a motion.

    Attributes:
        eigenstrain: by (e11, e22, e12), shape (T, 3).
        thickness: by the thickness of each layer [N], shape (L, T).
        young_modulus: [m³], shape (L, T).
        poisson_ratio: shape (L, T).
        eigenstrain_factor: shape (L, T).
        stiffness: [[A, B], [B, D]] per reference area, shape (T, 6, 6).
        resultants: per area what holds the layers at zero strain on a flat sheet, shape (T, 6).
        bending: by the curvatures at rest, of the resultants, shape (T, 6, 3).
    """

    eigenstrain: Floats
    thickness: Floats
    young_modulus: Floats
    poisson_ratio: Floats
    eigenstrain_factor: Floats
    stiffness: Floats
    resultants: Floats
    bending: Floats


def layer_slopes(
    layers: Layers, eigenstrains: Floats, curvatures: Floats, strain: Floats, change: Floats
) -> LayerSlopes:
    """The work is Σ ∫ (ε' + z κ')ᵀ C (ε + z κ − free strain) dz per area, layer by layer.

    Args:
        layers: the layers.
        eigenstrains: (e11, e22, e12) at the actuation of the state, shape (T, 3).
        curvatures: −b of the sheet at rest [1/m], shape (T, 3).
        strain: (½ a, −b) of the state, as (11, 22, 2·12) each, shape (T, 6).
        change: of these along the motion, shape (T, 6).

    Returns:
        Per reference area.
    """
    count, places = layers.thicknesses.shape

    def free(k: int, eigen: Floats, poisson: float) -> _Free:
        return _Free.of(eigen, layers.young_moduli[k], poisson, curvatures, layers.thickening)

    own = [
        free(k, layers.factors[k] * eigenstrains, layers.poisson_ratios[k]) for k in range(count)
    ]
    heights = np.stack([layers.thicknesses[k] / own[k].shrink for k in range(count)])
    tops = np.cumsum(heights, axis=0)
    anchors = np.flatnonzero(layers.anchors)
    first, last = anchors[0], anchors[-1]
    tops = tops - 0.5 * (tops[first] - heights[first] + tops[last])
    bottoms = tops - heights
    powers = [_powers(bottoms[k], tops[k]) for k in range(count)]
    works = [one.work(strain, change) for one in own]  # coefficients of 1, z, z²
    above = np.stack([_at(w, z) for w, z in zip(works, tops, strict=True)])
    below = np.stack([_at(w, z) for w, z in zip(works, bottoms, strict=True)])
    by_height = _by_height(above, below, int(first), int(last))

    eigenstrain = np.zeros_like(eigenstrains)
    factor = np.zeros((count, places))
    poisson = np.empty((count, places))
    for k in range(count):

        def total(one: _Free, k: int = k) -> Floats:
            direct = (one.work(strain, change) * powers[k]).sum(axis=0)
            return np.asarray(direct + by_height[k] * (layers.thicknesses[k] / one.shrink))

        eigen, ratio = layers.factors[k] * eigenstrains, layers.poisson_ratios[k]
        ends = [total(free(k, eigen, ratio + step)) for step in (STEP, -STEP)]
        poisson[k] = (ends[0] - ends[1]) / (2.0 * STEP)
        if not layers.active[k]:
            continue
        for component in range(3):
            moved = np.zeros(3)
            moved[component] = STEP
            ends = [total(free(k, eigen + step, ratio)) for step in (moved, -moved)]
            slope = (ends[0] - ends[1]) / (2.0 * STEP)
            eigenstrain[:, component] += layers.factors[k] * slope
            factor[k] += slope * eigenstrains[:, component]
    shrink = np.stack([one.shrink for one in own])
    stiffness, resultants, bending = _section(own, powers)
    return LayerSlopes(
        eigenstrain=eigenstrain,
        thickness=by_height / shrink,
        young_modulus=np.stack(
            [
                (w * p).sum(axis=0) / y
                for w, p, y in zip(works, powers, layers.young_moduli, strict=True)
            ]
        ),
        poisson_ratio=poisson,
        eigenstrain_factor=factor,
        stiffness=stiffness,
        resultants=resultants,
        bending=bending,
    )


@dataclass(frozen=True, eq=False)
class _Free:
    """A layer left alone, of T triangles.

    Attributes:
        moduli: of its natural state, per reference area, shape (T, 3, 3).
        free: ½ F², shape (T, 3).
        pulled: from curvatures at rest to those left alone, shape (T, 3, 3).
        bend: these curvatures, shape (T, 3).
        shrink: thickness before over after, shape (T,).
    """

    moduli: Floats
    free: Floats
    pulled: Floats
    bend: Floats
    shrink: Floats

    @classmethod
    def of(
        cls, eigen: Floats, young: float, poisson: float, curvatures: Floats, thickening: bool
    ) -> _Free:
        stretch = eigen + np.array([1.0, 1.0, 0.0])
        area, pulled = determinant(stretch), congruence(stretch)
        return cls(
            area[:, None, None] * moduli(stretch, young, poisson),
            half_metric(stretch),
            pulled,
            times(pulled, curvatures),
            area if thickening else np.ones_like(area),
        )

    def work(self, strain: Floats, change: Floats) -> Floats:
        """Coefficients of 1, z and z² of the work per volume, shape (3, T)."""
        plane = times(self.moduli, strain[:, :3] - self.free)
        bent = times(self.moduli, strain[:, 3:] - self.bend)
        flat, turned = change[:, :3], change[:, 3:]
        return np.stack(
            [
                (flat * plane).sum(axis=1),
                (flat * bent).sum(axis=1) + (turned * plane).sum(axis=1),
                (turned * bent).sum(axis=1),
            ]
        )


def _powers(bottom: Floats, top: Floats) -> Floats:
    """∫ 1, z, z² dz, shape (3, T)."""
    return np.stack([(top**n - bottom**n) / n for n in (1, 2, 3)])


def _at(work: Floats, z: Floats) -> Floats:
    return np.asarray(work[0] + z * (work[1] + z * work[2]))


def _by_height(above: Floats, below: Floats, first: int, last: int) -> Floats:
    """By the present height of each layer, which lifts what lies above it, shape (L, T).

    Args:
        above: work per volume at the top of each layer, shape (L, T).
        below: at its bottom.
        first: lowest layer that carries the reference surface.
        last: highest one.
    """
    tops = np.cumsum(above[::-1], axis=0)[::-1]
    bottoms = np.cumsum(below[::-1], axis=0)[::-1] - below
    found = tops - bottoms
    lift = (above - below).sum(axis=0)
    for k in range(len(above)):
        found[k] -= 0.5 * ((first > k) + (last >= k)) * lift
    return np.asarray(found)


def _section(own: list[_Free], powers: list[Floats]) -> tuple[Floats, Floats, Floats]:
    """Stiffness, resultants on a flat sheet and their slopes by its curvatures, all layers."""
    places = len(own[0].free)
    stiffness, resultants = np.zeros((places, 6, 6)), np.zeros((places, 6))
    bending = np.zeros((places, 6, 3))
    for one, power in zip(own, powers, strict=True):
        a, b, d = (i[:, None, None] * one.moduli for i in power)
        stiffness[:, :3, :3] += a
        stiffness[:, :3, 3:] += b
        stiffness[:, 3:, :3] += b
        stiffness[:, 3:, 3:] += d
        resultants[:, :3] += times(a, one.free)
        resultants[:, 3:] += times(b, one.free)
        bending[:, :3] += b @ one.pulled
        bending[:, 3:] += d @ one.pulled
    return stiffness, resultants, bending
