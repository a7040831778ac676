"""A strip that would curve alike both ways: its width decides how far it does."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sheetmorph.design.spec import Design
from sheetmorph.geometry.structured import rectangle
from sheetmorph.proofs.bilayer import curvature_of_a_wide_strip
from sheetmorph.proofs.proof import Check, Curve, Plot, Proof
from sheetmorph.proofs.sheets import QUARTER, circle_curvature, solved

DESIGN = f"""
name = "wide strip"
model = "laminate"
[outline]
kind = "rectangle"
width = "20 mm"
height = "5 mm"
[[layers]]
name = "lower"
role = "active"
thickness = "0.05 mm"
young_modulus = "1 MPa"
poisson_ratio = 0.33
[[layers]]
name = "upper"
role = "inert"
thickness = "0.05 mm"
young_modulus = "1 MPa"
poisson_ratio = 0.33
[actuation]
eps_pre = -0.001
profile = "uniform"
[perturbation]
total_force = "0 N"
[laminate]
thickening = "none"
{QUARTER}[mesh]
size = "1 mm"
[solver]
initial_step = 0.05
max_step = 0.1
"""

THICKNESS, POISSON = 0.1e-3, 0.33
WIDTHS = (0.2, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0)
"""W² κ0/h: natural curvature κ0 times the width W squared over the thickness."""
ASPECT = 6
CELLS = 8
"""Over half the width."""
BEND = 0.1
"""κ0 W, so that slopes across the strip stay small; 0.2 for wide strips, 0.05 for narrow ones."""


def prove(reference: Path | None = None) -> Proof:
    """Lengthwise curvature of strips of many widths, on quarters of them."""
    checks: list[Check] = []
    found: dict[str, list[float]] = {"structured": [], "irregular": []}
    for width in WIDTHS:
        for mesh, irregular in (("structured", 0.0), ("irregular", 0.2)):
            known, curvature = _ratios(width, irregular)
            found[mesh].append(curvature)
            what = f"κ/κ0 at W²κ0/h = {width:g}, {mesh} mesh"
            checks.append(Check(f"{mesh}-{width:g}", what, known, curvature, 0.01))
    fine = np.geomspace(WIDTHS[0], WIDTHS[-1], 80)
    theory = [curvature_of_a_wide_strip(1.0, w**0.5, 1.0, POISSON) for w in fine]
    return Proof(
        name="wide_strip",
        title="Width of a bilayer strip",
        statement=(
            "Equal layers with ν = 0.33, the lower one shrinking alike both ways, so that the "
            "natural curvature is κ0 = 1.5 e/h both ways. A narrow strip takes it; a wide one "
            "cannot, for that would stretch it: it rolls up lengthwise with (1 + ν) κ0, and its "
            "edges alone curve across. In between the curvature is lower than κ0. Strips "
            f"{ASPECT} times as long as wide, quarters of them, {CELLS} cells over half the width: "
            "the curvature is that of the circle through the middle line, the ends left out. The "
            "known answer is that of a cross-section that bends as a beam on an elastic "
            "foundation, at the lengthwise curvature of least energy."
        ),
        source="Ashwell, The anticlastic curvature of rectangular beams and plates, Journal of "
        "the Royal Aeronautical Society 54, 1950; Mansfield, The bending and stretching of plates, "
        "1989",
        checks=tuple(checks),
        plots=(
            Plot(
                "wide_strip",
                "Lengthwise curvature of a strip",
                "W² κ0 / h",
                "κ / κ0",
                (
                    Curve("beam on an elastic foundation", fine, np.array(theory), "line"),
                    Curve("1 + ν", fine, np.full(len(fine), 1.0 + POISSON), "dashes"),
                    *(
                        Curve(f"{m} meshes", np.array(WIDTHS), np.array(f))
                        for m, f in found.items()
                    ),
                ),
                "x",
            ),
        ),
    )


def _ratios(size: float, irregular: float) -> tuple[float, float]:
    """Known and computed κ/κ0 of the strip with W² κ0/h = size."""
    bend = BEND * (0.5 if size < 1.0 else 2.0 if size > 10.0 else 1.0)
    width = size / bend * THICKNESS
    natural = bend / width
    length = ASPECT * width
    design = Design.from_toml(DESIGN).with_values(
        {
            "outline.width": f"{length / 2} m",
            "outline.height": f"{width / 2} m",
            "outline.centre": [f"{length / 4} m", f"{width / 4} m"],
            "actuation.eps_pre": -natural * THICKNESS / 1.5,
            "mesh.size": f"{width / 8} m",
        }
    )
    mesh = rectangle(
        *(length / 2, width / 2, ASPECT * CELLS, CELLS, "alternating"),
        centre=(length / 4, width / 4),
        irregular=irregular,
    )
    x = solved(design, mesh=mesh).positions[-1]
    line = x[(mesh.nodes[:, 1] < 1e-9) & (mesh.nodes[:, 0] < length / 4)][:, [0, 2]]
    curvature = circle_curvature(np.concatenate([line, line * [-1.0, 1.0]]))
    known = curvature_of_a_wide_strip(natural, width, THICKNESS, POISSON)
    return known / natural, curvature / natural
