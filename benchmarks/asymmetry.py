"""How unsymmetric final shapes are, on the usual mesh and on one with the design's symmetry.

    .venv/bin/python benchmarks/asymmetry.py

Prints the largest distance between a shape and its image under any rotation or mirror image that
the flat design has, as the distance of points to densely sampled triangles.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

import sheetmorph as sm
from sheetmorph.design.presets import preset_text

SMALL_SUPPORT = {"supports.0.x": ["-3.5 mm", "3.5 mm"], "supports.0.y": ["-3.5 mm", "3.5 mm"]}
DESIGNS = {"petals": {}, "bowl": SMALL_SUPPORT}
"""Changes to the presets: the bowl's square support is less symmetric than its star."""

PARTS = 6


def misfit(result: sm.Result) -> float:
    """Largest distance of a shape from its images under the symmetry of its design [m]."""
    shape = result.positions[-1]
    weights = [(i, j, PARTS - i - j) for i in range(PARTS + 1) for j in range(PARTS + 1 - i)]
    shares = np.array(weights) / PARTS
    surface = np.einsum("sk,tkx->tsx", shares, shape[result.mesh.triangles]).reshape(-1, 3)
    tree = cKDTree(surface)
    return max(float(tree.query(image)[0].max()) for image in result.design.symmetry.images(shape))


def main() -> None:
    """Print a line for each design and kind of mesh."""
    for name, changes in DESIGNS.items():
        for kind in ("none", "auto"):
            values = {**changes, "mesh.symmetry": kind}
            result = sm.simulate(sm.Design.from_toml(preset_text(name)).with_values(values))
            print(f"{name:8} symmetry = {kind:6} {result.status}, {1e3 * misfit(result):.2g} mm")


if __name__ == "__main__":
    main()
