"""Lumped masses of the nodes."""

from __future__ import annotations

import numpy as np

from sheetmorph.design.laminate import triangle_masses
from sheetmorph.design.regions import Regions
from sheetmorph.geometry.mesh import Floats, SheetMesh


def node_masses(mesh: SheetMesh, region: Regions) -> Floats:
    """Masses of the nodes [kg], shape (V,): a third of that of each triangle around.

    The mass of a triangle is density times thickness times area over its layers before
    actuation; it stays as they shrink and thicken.
    """
    shares = np.repeat(triangle_masses(mesh, region) / 3.0, 3)
    return np.asarray(
        np.bincount(mesh.triangles.ravel(), shares, minlength=len(mesh.nodes)), dtype=np.float64
    )
