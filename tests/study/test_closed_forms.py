"""The published model against closed forms, with the order of convergence."""

from __future__ import annotations

import numpy as np
import pytest
from lattice import solve, strip, system_of

Y, H = 1e6, 0.3e-3


def pulled(rows: int, strain: float) -> tuple[float, float]:
    """Young's modulus times thickness, and Poisson's ratio, of a square pulled along x."""
    l0 = 0.02 / rows
    mesh = strip(2 * rows, rows, l0)
    x = mesh.nodes[:, 0]
    length = float(np.ptp(x))
    # Rollers on the two sides: zig-zag ends are held along x where they are.
    ends = (x < 0.6 * l0) | (x > length - 0.6 * l0)
    held = np.zeros((len(x), 3), dtype=bool)
    held[ends, 0] = True
    held[:, 2] = True
    held[np.argmin(np.abs(mesh.nodes - [length / 2, 0, 0]).sum(axis=1)), 1] = True
    start = mesh.nodes * [1 + strain, 1, 1]
    stiffness = np.sqrt(3) / 2 * Y * H * l0**2
    found = solve(system_of(mesh, held, stretch=stiffness, bend=0.0), start, 1e-12)
    moved = found.x.reshape(-1, 3)
    middle = np.abs(x - length / 2) < length / 4
    across = np.polyfit(mesh.nodes[middle, 1], moved[middle, 1], 1)[0] - 1
    area = float(mesh.triangle_areas.sum())
    return 2 * found.energy / (strain**2 * area), -across / strain


@pytest.mark.parametrize("strain", [1e-4, -1e-4], ids=["tension", "compression"])
def test_uniaxial(strain: float) -> None:
    """Y h within 4 % on the finest strip. The spare springs of the rim make the order 1."""
    rows = np.array([8, 16, 32])
    moduli, ratios = np.array([pulled(int(n), strain) for n in rows]).T
    errors = np.abs(moduli / (Y * H) - 1)
    order = -np.polyfit(np.log(rows), np.log(errors), 1)[0]
    assert order == pytest.approx(1.0, abs=0.15)
    assert errors[-1] < 0.04
    # What is left at rows → ∞, by Richardson's extrapolation of order 1.
    assert 2 * moduli[-1] - moduli[-2] == pytest.approx(Y * H, rel=2e-3)
    assert ratios[-1] == pytest.approx(1 / 3, abs=0.01)


def bent(rows: int, load: float, thickness: float) -> tuple[float, float]:
    """A beam held in its middle and loaded at both ends: two cantilevers, free to curve across.

    The load is P L²/EI. Returns tip deflection and tip shortening over L.
    """
    width = 0.01
    l0 = width / rows / np.sqrt(0.75)
    columns = 2 * round(8 * width / l0)
    mesh = strip(columns, rows, l0)
    x = mesh.nodes[:, 0]
    length = columns * l0 / 2
    rigidity = Y * thickness**3 / 12
    bending = 8 / 9 * rigidity * width
    force = np.zeros_like(mesh.nodes)
    for end in (0.0, columns * l0):
        tip = np.abs(x - end) < 0.1 * l0
        force[tip, 2] = load * bending / length**2 / tip.sum()
    held = np.zeros((len(x), 3), dtype=bool)
    middle = int(np.argmin(np.abs(mesh.nodes - [length, 0, 0]).sum(axis=1)))
    held[middle] = True
    # Stops the sheet from turning about y, without a force by symmetry.
    held[np.argmin(np.abs(mesh.nodes - [length - l0, 0, 0]).sum(axis=1)), 2] = True
    held[np.abs(mesh.nodes[:, 1]) < 0.1 * l0, 1] = True  # the mirror plane y = 0
    stretch = np.sqrt(3) / 2 * Y * thickness * l0**2
    system = system_of(mesh, held, stretch=stretch, bend=2 / np.sqrt(3) * rigidity, force=force)
    found = solve(system, mesh.nodes, 1e-5 * load * bending / length**2)
    moved = found.x.reshape(-1, 3)
    tips = np.abs(x) < 0.1 * l0
    far = tips | (np.abs(x - 2 * length) < 0.1 * l0)
    return (
        float(moved[far, 2].mean() - moved[middle, 2]) / length,
        float(2 * length - moved[far & ~tips, 0].mean() + moved[tips, 0].mean()) / (2 * length),
    )


def test_cantilever_under_a_small_end_load() -> None:
    """δ = P L³/(3 EI) with EI = (8/9) D w. The missing hinges of the rim make the order 1."""
    rows = np.array([4, 8, 16])
    load = 1e-2
    deflections = np.array([bent(int(n), load, H)[0] for n in rows]) / (load / 3)
    errors = np.abs(deflections - 1)
    assert errors[-1] < 5e-4
    order = -np.polyfit(np.log(rows), np.log(errors), 1)[0]
    assert order > 0.9


@pytest.mark.parametrize(
    ("load", "deflection", "shortening"),
    [(1.0, 0.30172, 0.05643), (2.0, 0.49346, 0.16064), (5.0, 0.71379, 0.38763)],
)
def test_elastica_under_a_large_end_load(load: float, deflection: float, shortening: float) -> None:
    """Tip deflection and shortening over L of the inextensible elastica at P L²/EI.

    Values by elliptic integrals: Mattiasson, IJNME 17, 145 (1981). The strip is thick, so
    that bending does not flatten its cross-section (w² κ/h stays small).
    """
    found = bent(8, load, 10 * H)
    np.testing.assert_allclose(found, [deflection, shortening], rtol=5e-3)
