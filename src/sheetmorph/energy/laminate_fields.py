"""What the laminate model says of a state, triangle by triangle."""

from __future__ import annotations

import numpy as np

from sheetmorph.energy.laminate import LaminateShell
from sheetmorph.energy.shape_measures import measures_at
from sheetmorph.geometry.mesh import Floats


def energy_parts(shell: LaminateShell, x: Floats) -> tuple[Floats, Floats]:
    """Energy of the triangles in stretching and in bending [J], shape (T,) each.

    Bending is that of the curvatures with the neutral surface unstretched, by
    D − B A⁻¹ B; stretching is the rest. Both are zero in the natural state; what the layers
    hold there, because they do not fit each other, is left out (`Rest.floor`).

    Args:
        shell: the shell at the actuation of the state.
        x: degrees of freedom [m], shape (n,).
    """
    measures, rest = shell.lamination.measures, shell.rest
    p = measures_at(x.reshape(-1, 3), shell.patch) - rest.natural
    whole = 0.5 * np.einsum("ti,tij,tj->t", p, rest.stiffness, p)
    back = measures.strain_inverses
    section = back.transpose(0, 2, 1) @ rest.stiffness @ back
    a, b, d = section[:, :3, :3], section[:, :3, 3:], section[:, 3:, 3:]
    rigidity = d - b.transpose(0, 2, 1) @ np.linalg.solve(a, b)
    curvature = np.einsum("tij,tj->ti", measures.strain_maps[:, 3:, 3:], p[:, 3:])
    bending = 0.5 * np.einsum("ti,tij,tj->t", curvature, rigidity, curvature)
    return np.asarray(whole - bending), np.asarray(bending)
