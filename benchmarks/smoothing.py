"""How far a smeared pattern is from a sharp one. Prints tables; a minute or two.

    python benchmarks/smoothing.py

A three-armed star on a disc, held in the middle. First one mesh that does not follow the pattern,
and widths that go to zero; then meshes that are refined, with a width of two edges, beside the
sharp pattern on the finest mesh, which follows it. Distances of the rim's height, as a fraction of
it, for the laminate model, whose shapes converge.
"""

from __future__ import annotations

import numpy as np

import sheetmorph as sm

TEXT = """
name = "smeared"
model = "laminate"
[outline]
kind = "disc"
radius = "20 mm"
[[pattern]]
kind = "star"
arms = 3
arm_length = "15 mm"
half_width = "3 mm"
hub_radius = "5 mm"
rotation = "7 deg"
[[layers]]
name = "film"
role = "active"
thickness = "0.3 mm"
young_modulus = "1 MPa"
[[layers]]
name = "print"
role = "inert"
thickness = "0.5 mm"
young_modulus = "3 MPa"
where = "pattern"
[actuation]
eps_pre = -0.25
profile = "exponential"
gamma = 1.5
[perturbation]
direction = "down"
[mesh]
size = "2 mm"
"""
WIDTHS = ("4 mm", "2 mm", "1 mm", "0.5 mm", "0.1 mm", "0.02 mm")
SIZES = (3.0, 2.0, 1.4, 1.0)
FINEST = 0.7
ANGLES = np.deg2rad(np.arange(0.0, 360.0, 5.0))


def heights(result: sm.Result) -> np.ndarray:
    """Heights of the rim at fixed directions [m], less their mean."""
    rim = np.unique(result.mesh.edges[result.mesh.rim_edges])
    angle = np.arctan2(result.mesh.nodes[rim, 1], result.mesh.nodes[rim, 0])
    order = np.argsort(angle)
    z = np.interp(ANGLES, angle[order], result.positions[-1][rim, 2][order], period=2 * np.pi)
    return z - z.mean()


def whole(result: sm.Result) -> float:
    """Height of the shape [m]."""
    return float(np.ptp(result.positions[-1][:, 2]))


def main() -> None:
    """Print both tables."""
    sharp = sm.Design.from_toml(TEXT)
    smeared = sharp.with_values({"mesh.pattern_smoothing": "2 mm"})
    mesh = smeared.build_mesh()
    exact = sm.simulate(sharp, mesh=mesh)
    print("| width | greatest distance of a node, of the height |")
    print("|---|---|")
    for width in WIDTHS:
        result = sm.simulate(sharp.with_values({"mesh.pattern_smoothing": width}), mesh=mesh)
        away = np.linalg.norm(result.positions[-1] - exact.positions[-1], axis=1).max()
        print(f"| {width} | {100 * away / whole(exact):.2f} % |", flush=True)
    finest = sm.simulate(sharp.with_values({"mesh.size": f"{FINEST} mm"}))
    print(f"\n| edges | height, smeared over two edges | rim | sharp | rim |\n|{'---|' * 5}")
    for size in SIZES:
        shown = []
        for width in (f"{2 * size} mm", None):
            values = {"mesh.size": f"{size} mm", "mesh.pattern_smoothing": width}
            result = sm.simulate(sharp.with_values(values))
            rim = np.abs(heights(result) - heights(finest)).max() / whole(finest)
            shown.append(f"{100 * (whole(result) / whole(finest) - 1):+.2f} % | {100 * rim:.2f} %")
        print(f"| {size} mm | {' | '.join(shown)} |", flush=True)


if __name__ == "__main__":
    main()
