"""What an energy term is: local energies, gradients and Hessians over a stencil of nodes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, Self

import numpy as np

from sheetmorph.geometry.mesh import Floats, Ints, SheetMesh


class Term(Protocol):
    """An energy that is a sum over elements of a few nodes each.

    Attributes:
        name: key of the term in energy tables, such as "stretch".
        reference: source of the energy and of its derivatives.
        stencil: nodes of each element, shape (n, m).
        linear: True when the energy is linear in the positions, so that it has no Hessian.

    A term may have three scalar unknowns for each element beside the positions, such as the
    turns of a triangle's sides. It then has an attribute `scalars`, shape (n, 3): which degrees
    of freedom they are, counted from the first coordinate of node 0, so that `x.reshape(-1)`
    of the kernel holds them. They count as one more node of the stencil, the last, in all local
    quantities. A term whose forces at fixed positions are not linear in the actuation says
    `linear_in_ramp = False`. A term that is infinite somewhere has a method
    `reach(x, step)`: the part of a step, at most 1, that does not lead there. One that is zero
    with all its derivatives at most states has a method `idle(x)` that says so in less time.
    """

    @property
    def name(self) -> str: ...  # noqa: D102

    @property
    def reference(self) -> str: ...  # noqa: D102

    @property
    def stencil(self) -> Ints: ...  # noqa: D102

    @property
    def linear(self) -> bool: ...  # noqa: D102

    def at(self, ramp: float, load: float) -> Self:
        """The same term at a fraction of the actuation and of the perturbation load."""
        ...

    @classmethod
    def specimen(cls, mesh: SheetMesh, rng: np.random.Generator) -> Self:
        """A term with arbitrary parameters on this mesh, for tests and benchmarks."""
        ...

    def local_kernel(self) -> Kernel:
        """The compiled function that evaluates elements, and what it takes after the positions.

        It is called as `function(x, *parameters, start, stop, order, energy, gradient, hessian)`
        and writes the local quantities of the elements start … stop − 1 into rows 0, 1, … of the
        last three: see `evaluate_elements`, whose arguments they are.
        """
        ...


Kernel = tuple[Callable[..., None], tuple[Any, ...]]


def evaluate_elements(
    kernel: Kernel,
    x: Floats,
    elements: tuple[int, int],
    order: int,
    energy: Floats,
    gradient: Floats,
    hessian: Floats,
) -> None:
    """Write the local quantities of some elements of a term into rows 0, 1, ….

    Args:
        kernel: see `Term.local_kernel`.
        x: positions [m], shape (V, 3).
        elements: the first of them, and one past the last.
        order: 0 writes energies only, 1 gradients too, 2 Hessians too; 3 writes in place
            of the Hessians a positive semidefinite part of them: what is left without the
            terms that can destabilise (stress times second derivatives of the strains).
            Linear terms are not asked for more than 1.
        energy: out, local energies [J], shape (≥ stop − start,).
        gradient: out, with respect to the nodes of the stencil [N], shape (≥ …, m, 3).
        hessian: out, blocks of the node pairs (p, q), p ≤ q, in the order (0, 0), (0, 1),
            … (0, m − 1), (1, 1), … [N/m], shape (≥ …, m (m + 1) / 2, 3, 3). Row index:
            coordinate of node p; column index: coordinate of node q.
    """
    function, parameters = kernel
    function(x, *parameters, *elements, order, energy, gradient, hessian)


def scalar_unknowns(term: Term) -> Ints:
    """The scalar unknowns of each element as degrees of freedom, shape (n, 3) or (n, 0)."""
    none = np.zeros((len(term.stencil), 0), dtype=np.int32)
    return np.asarray(getattr(term, "scalars", none))


def local_width(term: Term) -> int:
    """Nodes of the stencil, and one more where an element has scalar unknowns."""
    return int(term.stencil.shape[1]) + (1 if scalar_unknowns(term).shape[1] else 0)
