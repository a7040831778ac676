"""Derivatives by the fields of the laminate model, from the adjoint of a state."""

from __future__ import annotations

import numpy as np

from sheetmorph.design.laminate import LayerStack
from sheetmorph.design.sections import EVERYWHERE
from sheetmorph.energy.laminate import LaminateShell
from sheetmorph.energy.laminate_rest_slopes import Motion, rest_slopes
from sheetmorph.energy.lamination_slopes import Layers, LayerSlopes, layer_slopes
from sheetmorph.geometry.mesh import Floats
from sheetmorph.study.model import Problem
from sheetmorph.study.parameters import layer_presence


def laminate_fields(
    problem: Problem, x: Floats, adjoint: Floats, ramp: float, rest: bool
) -> dict[str, Floats]:
    """−λᵀ ∂g/∂p for free strains, layers and rest positions of the triangles.

    Args:
        problem: the problem.
        x: the state, shape (n,).
        adjoint: λ, shape (n,).
        ramp: actuation of the state.
        rest: whether rest positions are wanted, which cost as much as all the others.

    Returns:
        "eigenstrain" (T, 3) at full actuation; "thickness", "young_modulus", "poisson_ratio" and
        "eigenstrain_factor" by layer and triangle (L, T); "rest_positions" (V, 3).
    """
    shell = problem.model.terms[0]
    assert isinstance(shell, LaminateShell)  # noqa: S101  as laminate_parts makes it
    measures = shell.lamination.measures
    motion = Motion.of(shell.patch, x.reshape(-1, 3), adjoint.reshape(-1, 3))
    maps, areas = measures.strain_maps, measures.areas
    slopes = layer_slopes(
        _layers(problem, shell.lamination.thickening),
        ramp * shell.lamination.eigenstrains,
        measures.reference_curvatures,
        np.einsum("tij,tj->ti", maps, motion.measures),
        np.einsum("tij,tj->ti", maps, motion.change),
    )
    found = {
        "eigenstrain": -ramp * areas[:, None] * slopes.eigenstrain,
        "thickness": -areas * slopes.thickness,
        "young_modulus": -areas * slopes.young_modulus,
        "poisson_ratio": -areas * slopes.poisson_ratio,
        "eigenstrain_factor": -areas * slopes.eigenstrain_factor,
    }
    if rest:
        found["rest_positions"] = -_rest(problem, shell, motion, slopes)
    return found


def _rest(problem: Problem, shell: LaminateShell, motion: Motion, slopes: LayerSlopes) -> Floats:
    return rest_slopes(problem.mesh, shell.patch, motion, slopes)


def _layers(problem: Problem, thickening: bool) -> Layers:
    whole = LayerStack.of(problem.design.layers)
    shares = layer_presence(problem.design, problem.regions)
    return Layers(
        thicknesses=shares * whole.thicknesses[:, None],
        young_moduli=whole.young_moduli,
        poisson_ratios=whole.poisson_ratios,
        factors=whole.eigenstrain_factors,
        active=whole.active,
        anchors=np.array([layer.where == EVERYWHERE for layer in problem.design.layers]),
        thickening=thickening,
    )
