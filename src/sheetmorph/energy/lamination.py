"""Classical lamination theory with large eigenstrains: from layers to the energy of triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sheetmorph.energy.laminate_patch import Patch
from sheetmorph.energy.shape_measures import ShapeMeasures
from sheetmorph.geometry.mesh import Floats, SheetMesh


@dataclass(frozen=True, eq=False)
class Layup:
    """A stack of n layers, from the bottom up.

    Attributes:
        thicknesses: before actuation [m], shape (n,); or (n, T), where layers differ from
            triangle to triangle of the sheet.
        young_moduli: [Pa], shape (n,).
        poisson_ratios: shape (n,).
        eigenstrain_factors: by which each layer takes the eigenstrain of its place, 0 where it
            is inert, shape (n,).
        anchors: True for the layers whose common mid-plane is the reference surface, shape
            (n,); all, if none is.
    """

    thicknesses: Floats
    young_moduli: Floats
    poisson_ratios: Floats
    eigenstrain_factors: Floats
    anchors: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Rest:
    """The energy ½ (p − p̄)ᵀ M (p − p̄) + w of each triangle at one actuation.

    Attributes:
        ramp: fraction of the actuation.
        stiffness: M, shape (T, 6, 6); its units go with those of p, [m²] and [m].
        natural: p̄, the measures of the triangle left to itself, shape (T, 6).
        floor: w, what the layers hold even then, for they do not fit each other [J],
            shape (T,).
    """

    ramp: float
    stiffness: Floats
    natural: Floats
    floor: Floats


@dataclass(frozen=True, eq=False)
class Lamination:
    """The layers of every triangle and what they would be if left alone.

    A layer left alone takes the stretch F = I + t f e, with the eigenstrain tensor e of its
    triangle (engineering strain, l/l0 − 1) and its factor f, so the metric Fᵀ F. Its elastic
    law is Saint Venant–Kirchhoff's in plane stress, taken in that natural state, where its
    thickness is h/det F if it keeps its volume and h if not. Every layer has the strain

        E(z) = ½ (a − Fᵀ F) − z (b − F b̄ F)

    at the height z above the reference surface, with the first and second fundamental forms a
    and b of the sheet and b̄ of the sheet before. So the energy is a quadratic form in (a, b) with
    the stiffnesses A = ∫ C dz, B = ∫ C z dz, D = ∫ C z² dz of the lamination theory.

    Attributes:
        measures: how a and b follow from p.
        cells: index of the layup of each triangle, shape (T,).
        layups: the stacks of layers that occur.
        eigenstrains: (e11, e22, e12) at full actuation in the triangle's frame, shape (T, 3).
        thickening: True where a layer keeps its volume.
    """

    measures: ShapeMeasures
    cells: NDArray[np.intp]
    layups: tuple[Layup, ...]
    eigenstrains: Floats
    thickening: bool

    @classmethod
    def specimen(cls, mesh: SheetMesh, patch: Patch, rng: np.random.Generator) -> Lamination:
        """Two stacks of two layers with random values, on a sheet that is bent at rest."""
        count = len(mesh.triangles)
        layups = tuple(
            Layup(
                rng.uniform(0.01, 0.05, 2),
                rng.uniform(1.0, 4.0, 2),
                rng.uniform(0.1, 0.45, 2),
                np.array([1.0, rng.uniform(-0.5, 0.5)]),
                np.array([True, anchor]),
            )
            for anchor in (True, False)
        )
        frames = np.broadcast_to(np.eye(3)[:2], (count, 2, 3))
        measures = ShapeMeasures.of(mesh.nodes, patch, frames)
        return cls(
            measures,
            rng.integers(0, 2, count),
            layups,
            rng.uniform(-0.4, 0.1, (count, 3)) * [1.0, 1.0, 0.5],
            True,
        )

    def rest_at(self, ramp: float) -> Rest:
        """M, p̄ and w at a fraction of the actuation."""
        count = len(self.cells)
        stiffness, natural = np.empty((count, 6, 6)), np.empty((count, 6))
        floor = np.empty(count)
        for index, layup in enumerate(self.layups):
            here = np.flatnonzero(self.cells == index)
            if len(here):
                found = self._cell_rest(here, layup, ramp)
                stiffness[here], natural[here], floor[here] = found
        return Rest(ramp, stiffness, natural, floor)

    def _cell_rest(
        self, here: NDArray[np.intp], layup: Layup, ramp: float
    ) -> tuple[Floats, Floats, Floats]:
        """M, p̄ and w of the triangles of one cell."""
        section = self.section(here, layup, ramp)
        rest = np.linalg.solve(section.stiffness, section.resultants[:, :, None])[:, :, 0]
        maps = self.measures.strain_maps[here]
        area = self.measures.areas[here]
        stiffness = area[:, None, None] * (maps.transpose(0, 2, 1) @ section.stiffness @ maps)
        stiffness = 0.5 * (stiffness + stiffness.transpose(0, 2, 1))
        natural = (self.measures.strain_inverses[here] @ rest[:, :, None])[:, :, 0]
        floor = section.constant - 0.5 * np.einsum("ti,ti->t", rest, section.resultants)
        return stiffness, natural, area * floor

    def section(self, here: NDArray[np.intp], layup: Layup, ramp: float) -> Section:
        """The integrals over the thickness at the triangles `here`, which have this layup."""
        eigen = ramp * self.eigenstrains[here]
        bent = self.measures.reference_curvatures[here]
        stretches = [_stretch(factor * eigen) for factor in layup.eigenstrain_factors]
        given = layup.thicknesses
        flat = given[:, None] if given.ndim == 1 else given[:, here]
        heights = flat / np.array(
            [determinant(f) if self.thickening else np.ones(len(here)) for f in stretches]
        )
        tops = np.cumsum(heights, axis=0)
        anchors = np.flatnonzero(layup.anchors) if layup.anchors.any() else np.arange(len(tops))
        first, last = anchors[0], anchors[-1]
        middle = 0.5 * (tops[first] - heights[first] + tops[last])
        tops = tops - middle
        stiffness = np.zeros((len(here), 6, 6))
        resultants, constant = np.zeros((len(here), 6)), np.zeros(len(here))
        for k, stretch in enumerate(stretches):
            modulus = moduli(stretch, layup.young_moduli[k], layup.poisson_ratios[k])
            top, bottom = tops[k], tops[k] - heights[k]
            weight = determinant(stretch)
            i0 = weight * (top - bottom)
            i1 = weight * (top**2 - bottom**2) / 2.0
            i2 = weight * (top**3 - bottom**3) / 3.0
            a, b, d = (i[:, None, None] * modulus for i in (i0, i1, i2))
            stiffness[:, :3, :3] += a
            stiffness[:, :3, 3:] += b
            stiffness[:, 3:, :3] += b
            stiffness[:, 3:, 3:] += d
            free, bend = half_metric(stretch), _pulled(stretch, bent)
            layer = np.concatenate(
                [times(a, free) + times(b, bend), times(b, free) + times(d, bend)], axis=1
            )
            resultants += layer
            constant += 0.5 * np.einsum("ti,ti->t", layer, np.concatenate([free, bend], axis=1))
        return Section(stiffness, resultants, constant)


@dataclass(frozen=True, eq=False)
class Section:
    """Integrals over the thickness, for the strains (½ a, −b) as (11, 22, 2·12) each.

    Attributes:
        stiffness: [[A, B], [B, D]] per reference area, shape (n, 6, 6) [N/m, N, N·m].
        resultants: what the layers would need to be held at zero of these strains,
            shape (n, 6) [N/m, N].
        constant: energy per area there [J/m²], shape (n,).
    """

    stiffness: Floats
    resultants: Floats
    constant: Floats


def _stretch(eigen: Floats) -> Floats:
    """(F11, F22, F12) of F = I + e, shape (n, 3)."""
    return np.asarray(eigen + np.array([1.0, 1.0, 0.0]))


def determinant(stretch: Floats) -> Floats:
    """det F, shape (n,)."""
    return np.asarray(stretch[:, 0] * stretch[:, 1] - stretch[:, 2] ** 2)


def half_metric(stretch: Floats) -> Floats:
    """½ F² as (11, 22, 2·12)."""
    f, g, s = stretch.T
    return np.stack([0.5 * (f * f + s * s), 0.5 * (g * g + s * s), s * (f + g)], axis=1)


def _pulled(stretch: Floats, tensor: Floats) -> Floats:
    """F t F as (11, 22, 2·12), of a tensor so given."""
    return times(congruence(stretch), tensor)


def congruence(f: Floats) -> Floats:
    """The map t → f t f for symmetric f on tensors (11, 22, 2·12), shape (n, 3, 3)."""
    a, b, s = f.T
    rows = [
        [a * a, s * s, a * s],
        [s * s, b * b, b * s],
        [2 * a * s, 2 * b * s, a * b + s * s],
    ]
    return np.stack([np.stack(row, axis=1) for row in rows], axis=1)


def moduli(stretch: Floats, young: float, poisson: float) -> Floats:
    """Plane-stress moduli of the natural state, in the reference frame, shape (n, 3, 3)."""
    plain = (
        young
        / (1.0 - poisson**2)
        * np.array([[1.0, poisson, 0.0], [poisson, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - poisson)]])
    )
    f, g, s = stretch.T
    inverse = np.stack([g, f, -s], axis=1) / determinant(stretch)[:, None]
    change = congruence(inverse)
    return np.asarray(change.transpose(0, 2, 1) @ plain @ change)


def times(matrices: Floats, vectors: Floats) -> Floats:
    """Products of n matrices with a vector each."""
    return np.asarray((matrices @ vectors[:, :, None])[:, :, 0])
