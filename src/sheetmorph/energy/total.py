"""The sum of all terms: gather positions, evaluate locally, scatter into a fixed pattern."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array

from sheetmorph.core.compiled import kernel
from sheetmorph.core.sparse import Growth, SymmetricPattern, symmetric_matrix
from sheetmorph.energy.self_contact import SelfContact
from sheetmorph.energy.structure import Slots, Structure, assembly_map
from sheetmorph.energy.term import Term, evaluate_elements, local_width
from sheetmorph.geometry.mesh import Floats

CHUNK = 1024
"""Elements evaluated at a time: enough to hide the calls, few enough to stay in cache."""


@dataclass(frozen=True, eq=False)
class Total:
    """The energy of the sheet as a function of all node positions, and of scalar unknowns.

    The degrees of freedom are the coordinates of the nodes, 3 V of them, and after them the
    scalar unknowns that terms may have (see `Term`), all lengths. Their number is filled up to
    a multiple of 3, so that x can be seen as rows of three.

    Attributes:
        terms: the terms, at the current actuation and load.
        structure: assembly map, shared by all copies.
        workspace: scratch arrays, shared by all copies (one evaluation at a time).
        contact: what keeps the sheet from passing through itself; None where nothing does.
    """

    terms: tuple[Term, ...]
    structure: Structure
    workspace: Workspace
    contact: SelfContact | None = None

    @classmethod
    def of(
        cls,
        terms: Sequence[Term],
        node_count: int,
        scalar_count: int = 0,
        contact: SelfContact | None = None,
    ) -> Total:
        """Build the pattern of the Hessian and the scratch arrays for these terms.

        Args:
            terms: the terms.
            node_count: V.
            scalar_count: number of scalar unknowns, a multiple of 3.
            contact: of the sheet with itself.
        """
        structure = assembly_map(terms, node_count, scalar_count)
        return cls(tuple(terms), structure, Workspace.of(terms, structure), contact)

    def at(self, ramp: float, load: float) -> Total:
        """The same energy at a fraction of the actuation and of the perturbation load."""
        if self.contact is not None:
            self.contact.begin()
        return replace(self, terms=tuple(t.at(ramp, load) for t in self.terms))

    @property
    def linear_in_ramp(self) -> bool:
        """True when the forces at fixed positions are linear in the actuation and the load."""
        return all(getattr(term, "linear_in_ramp", True) for term in self.terms)

    def reach(self, x: Floats, step: Floats) -> float:
        """The part of a step, at most 1, that all terms allow; see `Term`."""
        rows, moves = x.reshape(-1, 3), step.reshape(-1, 3)
        limits = [term.reach(rows, moves) for term in self.terms if hasattr(term, "reach")]
        part = float(min(limits, default=1.0))
        return part if self.contact is None else self.contact.reach(rows, part * moves) * part

    @property
    def pattern(self) -> SymmetricPattern:
        """Pattern of the Hessian, shape (n, n), but for what grows."""
        return self.structure.pattern

    @property
    def growth(self) -> Growth | None:
        """What the last Hessian has beyond the pattern; None where nothing touches."""
        return None if self.contact is None else self.contact.growth

    def matrix(self, data: Floats) -> csr_array:
        """The whole Hessian by the entries that `evaluate` has given."""
        return symmetric_matrix(self.pattern, self.growth, data)

    def evaluate(self, x: Floats, order: int) -> tuple[float, Floats | None, Floats | None]:
        """Energy, gradient and Hessian at the positions x.

        Args:
            x: degrees of freedom [m], shape (n,) or (n / 3, 3), C-contiguous.
            order: 0 energy only, 1 with the gradient, 2 with the Hessian, 3 with the positive
                semidefinite part of the Hessian instead (see `evaluate_elements`).

        Returns:
            Energy [J]; gradient [N], shape (n,); entries of the Hessian [N/m] in the order
            of `pattern`, then those of `growth`. The latter two are None where `order` does not
            ask for them.
        """
        work = self.workspace
        if x.size != self.pattern.size:
            raise ValueError(f"x has {x.size} degrees of freedom instead of {self.pattern.size}")
        nodes = x.reshape(-1, 3)
        gradient = np.zeros(nodes.shape) if order >= 1 else work.no_gradient
        if order >= 2:
            work.storage[:] = 0.0
        energy = 0.0
        for term, slots in zip(self.terms, self.structure.slots, strict=True):
            energy += _sum_term(term, slots, nodes, order, gradient, work)
        hessian = np.take(work.storage, self.structure.gather) if order >= 2 else None
        if self.contact is not None:
            touching, beyond = self.contact.add(nodes, order, gradient)
            energy += touching
            hessian = None if hessian is None else np.concatenate([hessian, beyond])
        return energy, gradient.reshape(-1) if order >= 1 else None, hessian

    def energies(self, x: Floats) -> dict[str, float]:
        """Energy of each term [J] by its name."""
        nodes, work = x.reshape(-1, 3), self.workspace
        found = {
            term.name: _sum_term(term, slots, nodes, 0, work.no_gradient, work)
            for term, slots in zip(self.terms, self.structure.slots, strict=True)
        }
        if self.contact is not None:
            found[self.contact.name], _ = self.contact.add(nodes, 0, work.no_gradient)
        return found


@dataclass(frozen=True, eq=False)
class Workspace:
    """Scratch arrays of one assembly; the local ones are as long as a chunk."""

    storage: Floats
    energy: Floats
    gradients: dict[int, Floats]
    hessians: dict[int, Floats]
    no_gradient: Floats

    @classmethod
    def of(cls, terms: Sequence[Term], structure: Structure) -> Workspace:
        """Allocate for the stencil widths that occur."""
        widths = {local_width(t) for t in terms}
        return cls(
            storage=np.zeros(structure.storage),
            energy=np.zeros(CHUNK),
            gradients={m: np.zeros((CHUNK, m, 3)) for m in widths},
            hessians={m: np.zeros((CHUNK, m * (m + 1) // 2, 3, 3)) for m in widths},
            no_gradient=np.zeros((0, 3)),
        )

    def local(self, term: Term) -> tuple[Floats, Floats, Floats]:
        """Scratch for the local energies, gradients and Hessians of a term."""
        width = local_width(term)
        return self.energy, self.gradients[width], self.hessians[width]


def _chunks(count: int) -> list[tuple[int, int]]:
    return [(start, min(start + CHUNK, count)) for start in range(0, count, CHUNK)]


def _sum_term(
    term: Term, slots: Slots, nodes: Floats, order: int, gradient: Floats, work: Workspace
) -> float:
    if hasattr(term, "idle") and term.idle(nodes):
        return 0.0
    local_order = min(order, 1) if term.linear else order
    local, local_kernel = work.local(term), term.local_kernel()
    energy = 0.0
    for start, stop in _chunks(len(term.stencil)):
        evaluate_elements(local_kernel, nodes, (start, stop), local_order, *local)
        energy += _scatter(
            term.stencil,
            slots.pairs,
            slots.scalars,
            slots.mixed,
            slots.own,
            start,
            stop,
            local_order,
            *local,
            gradient.reshape(-1),
            work.storage,
        )
    return energy


@kernel
def _scatter(  # type: ignore[no-untyped-def]
    stencil, pairs, scalars, mixed, own, start, stop, order, energy, grad, hess, gradient, storage
):
    total = 0.0
    width = stencil.shape[1]
    scalar = scalars.shape[1] > 0
    local = width + 1 if scalar else width
    for i in range(start, stop):
        k = i - start
        total += energy[k]
        if order < 1:
            continue
        for p in range(width):
            node = stencil[i, p]
            for c in range(3):
                gradient[3 * node + c] += grad[k, p, c]
        if scalar:
            for c in range(3):
                gradient[scalars[i, c]] += grad[k, width, c]
        if order < 2:
            continue
        slot_of = 0
        block = 0
        for p in range(width):
            for q in range(p, width):
                slot = pairs[i, slot_of]
                if q > p and stencil[i, q] == stencil[i, p]:
                    # One node in two places: the pair counts as (p, q) and as (q, p).
                    place = 9 * slot
                    for r in range(3):
                        for c in range(3):
                            storage[place + 3 * c + r] += hess[k, block, r, c]
                if slot >= 0:
                    place = 9 * slot
                    for r in range(3):
                        for c in range(3):
                            storage[place + 3 * r + c] += hess[k, block, r, c]
                else:
                    place = 9 * (-1 - slot)
                    for r in range(3):
                        for c in range(3):
                            storage[place + 3 * c + r] += hess[k, block, r, c]
                slot_of += 1
                block += 1
            if scalar:
                for c in range(3):
                    place = mixed[i, 3 * p + c]
                    for r in range(3):
                        storage[place + r] += hess[k, block, r, c]
                block += 1
        if scalar:
            pair = 0
            for r in range(3):
                for c in range(r, 3):
                    storage[own[i, pair]] += hess[k, local * (local + 1) // 2 - 1, r, c]
                    pair += 1
    return total
