"""What a mechanical model makes of a design."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sheetmorph.energy.term import Term
from sheetmorph.geometry.mesh import Floats


def _nothing() -> Floats:
    return np.zeros(0)


@dataclass(frozen=True, eq=False)
class ModelParts:
    """The internal energy of a model, and what is said of it.

    Attributes:
        terms: its terms.
        held_scalars: True at the scalar unknowns that keep their value, shape (S,).
        force_scale: see `sheetmorph.design.laminate.force_scale` [N]: the measure of what residual
            force is small.
        stretch_force: largest force with which an edge resists a strain of 1 [N].
        stretch_stiffness: K of every edge [J], shape (E,); empty where edges have none.
        bending_stiffness: k_b of every hinge [J], shape (H,); empty where hinges have none.
        coupling: natural dihedral angle per strain mismatch of every hinge, shape (H,); empty
            where there is none.
        natural_lean: largest angle [rad] by which a director leans out of its triangle where the
            layers are left alone at full actuation: what the mesh has to follow; 0 where layers
            want no curvature.
    """

    terms: tuple[Term, ...]
    held_scalars: NDArray[np.bool_]
    force_scale: float
    stretch_force: float
    stretch_stiffness: Floats = field(default_factory=_nothing)
    bending_stiffness: Floats = field(default_factory=_nothing)
    coupling: Floats = field(default_factory=_nothing)
    natural_lean: float = 0.0
