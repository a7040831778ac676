"""Contact of the sheet with itself: a barrier between all parts that are no neighbours."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from scipy.spatial import cKDTree

from sheetmorph.core.errors import InputError
from sheetmorph.core.sparse import Growth
from sheetmorph.geometry.mesh import Floats, SheetMesh

INSTALL = 'pip install "sheetmorph[contact]"'

KEPT = 0.9
"""Part of their distance by which two parts may near each other in one step."""

STALE = 4, 2000
"""Pairs of nodes in the pattern, over those that touch, and beside them, before it begins anew."""


@dataclass(frozen=True)
class Shield:
    """A barrier between parts of the sheet, from a least distance on.

    Attributes:
        gap: least distance of two parts [m].
        range: over which the barrier rises, beyond the gap [m].
        force: between two nodes halfway through the range [N].
        apart: nodes that were closer than this before actuation do not meet [m].
    """

    gap: float
    range: float
    force: float
    apart: float = 0.0


class SelfContact:
    """The clamped log barrier of incremental potential contact, by `ipctk`.

    κ b(d² − g², 2 g r + r²) with b(y, ŷ) = −(y − ŷ)² ln(y/ŷ) for every pair of a node and a
    triangle, and of two edges, whose distance d is below g + r and that share no node; smoothed
    where edges are parallel. Steps are limited by continuous collision detection, so that no
    pair ever comes to the distance g or passes it.

    The pairs change with the state, and with them the pattern of the Hessian: its entries go
    into `growth`.

    References: Li et al., Incremental potential contact, ACM Transactions on Graphics 39, 2020;
    Li, Kaufman, Jiang, Codimensional incremental potential contact, 40, 2021 (thickness,
    additive collision detection).

    Attributes:
        growth: where the entries of the Hessian go.
        shields: the barriers, which add up.
    """

    name = "self_contact"

    def __init__(self, mesh: SheetMesh, shields: Sequence[Shield], threads: int = 1) -> None:
        """Set up the barriers of a mesh.

        Args:
            mesh: the sheet before actuation.
            shields: the barriers.
            threads: of the library, in the whole process.

        Raises:
            InputError: the library is not installed, or parts of the sheet are too close to each
                other before actuation.
        """
        try:
            import ipctk
        except ImportError:
            raise InputError(
                f"contact of the sheet with itself needs ipctk; install it by {INSTALL}",
                key="contact.self_contact",
                value=True,
            ) from None
        self._ipctk: Any = ipctk
        ipctk.set_num_threads(threads)
        ipctk.set_logger_level(ipctk.LoggerLevel.error)
        self.growth, self.shields = Growth(), tuple(shields)
        self._count = len(mesh.nodes)
        self._broad, self._ccd = ipctk.LBVH(), ipctk.AdditiveCCD(conservative_rescaling=KEPT)
        self._meshes = [self._collision_mesh(mesh, shield) for shield in shields]
        self._potentials = [self._potential(shield) for shield in shields]
        self.begin()
        for shield, touching in zip(self.shields, self._collisions(mesh.nodes), strict=True):
            if len(touching):
                raise InputError(
                    "parts of the sheet are closer to each other before actuation than "
                    f"{1e3 * (shield.gap + shield.range):.3g} mm",
                    key="contact.gap" if shield.gap else "contact.self_contact",
                    allowed="a smaller gap and range; cuts with a width",
                )

    def with_shields(self, shields: Sequence[Shield]) -> Self:
        """The same contact with other gaps, ranges and forces; what does not meet stays."""
        other = copy(self)
        other.growth, other.shields = Growth(), tuple(shields)
        other._potentials = [self._potential(shield) for shield in shields]
        other.begin()
        return other

    def _collision_mesh(self, mesh: SheetMesh, shield: Shield) -> Any:
        made = self._ipctk.CollisionMesh(
            np.asfortranarray(mesh.nodes),
            np.asfortranarray(mesh.edges.astype(np.int32)),
            np.asfortranarray(mesh.triangles.astype(np.int32)),
        )
        if shield.apart > 0.0:
            near = cKDTree(mesh.nodes).query_pairs(shield.apart)
            made.can_collide = self._ipctk.make_sparse_filter(dict.fromkeys(near, False), True)
        return made

    def _potential(self, shield: Shield) -> Any:
        unit = self._ipctk.BarrierPotential(shield.range, 1.0)
        far = 2.0 * shield.gap * shield.range + shield.range**2
        half = shield.gap + 0.5 * shield.range
        slope = unit.barrier.first_derivative(half**2 - shield.gap**2, far) * 2.0 * half
        return self._ipctk.BarrierPotential(shield.range, shield.force / abs(slope))

    def begin(self) -> None:
        """Forget earlier states, so that nothing that follows depends on them."""
        self.growth.begin()
        self._at: Floats | None = None
        self._touching: list[Any] = []

    def _collisions(self, nodes: Floats) -> list[Any]:
        """What touches at a state, for each shield; that of the last state is kept."""
        if self._at is None or not np.array_equal(self._at, nodes):
            vertices = np.asfortranarray(nodes)
            self._touching = []
            for mesh, shield in zip(self._meshes, self.shields, strict=True):
                touching = self._ipctk.NormalCollisions()
                touching.build(mesh, vertices, shield.range, shield.gap, self._broad)
                self._touching.append(touching)
            self._at = nodes.copy()
        return self._touching

    def add(self, x: Floats, order: int, gradient: Floats) -> tuple[float, Floats]:
        """The energy of the barriers, their forces, and their part of the Hessian.

        Args:
            x: positions in rows of three [m], shape (≥ V, 3).
            order: see `Total.evaluate`; with 3 the blocks of each pair are projected to the
                nearest positive semidefinite ones.
            gradient: to which that of the barriers is added, from order 1 [N], same shape.

        Returns:
            Energy [J] and entries of the Hessian beyond the pattern [N/m], in the order of
            `growth`; none below order 2.
        """
        nodes = x[: self._count]
        vertices = np.asfortranarray(nodes)
        energy, blocks = 0.0, []
        method = self._ipctk.PSDProjectionMethod
        for mesh, touching, potential in zip(
            self._meshes, self._collisions(nodes), self._potentials, strict=True
        ):
            if not len(touching):
                continue
            energy += float(potential(touching, mesh, vertices))
            if order >= 1:
                gradient[: self._count] += potential.gradient(touching, mesh, vertices).reshape(
                    -1, 3
                )
            if order >= 2:
                projection = method.CLAMP if order == 3 else method.NONE
                blocks.append(potential.hessian(touching, mesh, vertices, projection).tocoo())
        return energy, self._entries(blocks) if order >= 2 else np.zeros(0)

    def _entries(self, blocks: list[Any]) -> Floats:
        """The upper triangles of sparse matrices in the order of the growth, which may change."""
        if not blocks:
            return np.zeros(self.growth.count)
        rows = np.concatenate([block.row for block in blocks]).astype(np.int64)
        columns = np.concatenate([block.col for block in blocks]).astype(np.int64)
        values = np.concatenate([block.data for block in blocks])
        upper = columns >= rows
        rows, columns, values = rows[upper], columns[upper], values[upper]
        keys, place = np.unique(rows // 3 * self._count + columns // 3, return_inverse=True)
        if len(self.growth.pairs) > STALE[0] * len(keys) + STALE[1]:
            self.growth.begin()
        slots = self.growth.add(np.column_stack([keys // self._count, keys % self._count]))
        places = 9 * slots[place] + 3 * (rows % 3) + columns % 3
        entries = np.zeros(self.growth.count)
        np.add.at(entries, places, values)
        return entries

    def reach(self, x: Floats, step: Floats) -> float:
        """The part of a step, at most 1, on which nothing comes to its least distance.

        Args:
            x: positions in rows of three [m], shape (≥ V, 3).
            step: their change, same shape.
        """
        start = np.asfortranarray(x[: self._count])
        end = np.asfortranarray(x[: self._count] + step[: self._count])
        # Two nodes near each other by at most twice the longest move.
        nearing = 2.0 * float(np.sqrt(((end - start) ** 2).sum(axis=1).max()))
        part = 1.0
        for mesh, shield, room in zip(
            self._meshes, self.shields, self.rooms(x[: self._count]), strict=True
        ):
            if nearing >= min(room, shield.range):
                free = self._ipctk.compute_collision_free_stepsize(
                    mesh, start, end, shield.gap, self._broad, self._ccd
                )
                part = min(part, float(free))
        return part

    def rooms(self, positions: Floats) -> list[float]:
        """Least distance beyond the gap, for each shield [m]; inf where nothing touches.

        Args:
            positions: of the nodes [m], shape (V, 3).
        """
        vertices = np.asfortranarray(positions)
        return [
            float(np.sqrt(touching.compute_minimum_distance(mesh, vertices))) - shield.gap
            if len(touching)
            else float("inf")
            for mesh, touching, shield in zip(
                self._meshes, self._collisions(positions), self.shields, strict=True
            )
        ]
