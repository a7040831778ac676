"""Contact of the sheet with itself: derivatives, forces, and that no step passes through."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.energy.loads import Weight
from sheetmorph.energy.self_contact import SelfContact, Shield
from sheetmorph.energy.stretch import EdgeStretch
from sheetmorph.energy.table import TableContact
from sheetmorph.energy.taylor import taylor_slopes
from sheetmorph.energy.term import evaluate_elements
from sheetmorph.energy.total import Total
from sheetmorph.geometry.crossings import crossing_pairs
from sheetmorph.geometry.mesh import SheetMesh
from sheetmorph.geometry.structured import rectangle

GAP, RANGE, FORCE = 0.01, 0.03, 2.0
SIZES = np.geomspace(1e-4, 3e-6, 7)


@pytest.fixture(scope="module")
def sheet() -> SheetMesh:
    return rectangle(1.0, 0.25, 16, 4, "alternating")


def curled(sheet: SheetMesh, distance: float) -> np.ndarray:
    """A C whose lips are so far from each other, a little jittered; shape (V, 3)."""
    along = sheet.nodes[:, 0] - sheet.nodes[:, 0].min()
    radius = (1.0 + distance) / (2.0 * np.pi)
    angle = along / radius
    shape = np.column_stack([radius * np.sin(angle), sheet.nodes[:, 1], -radius * np.cos(angle)])
    return shape + 1e-3 * np.random.default_rng(0).standard_normal(shape.shape)


def total_of(sheet: SheetMesh, gap: float = GAP) -> Total:
    apart = 0.3 if gap else 0.0
    contact = SelfContact(sheet, [Shield(gap, RANGE, FORCE, apart)])
    edges = len(sheet.edges)
    stretch = EdgeStretch(sheet.edges, sheet.edge_lengths, np.zeros(edges), np.zeros(edges))
    return Total.of([stretch], len(sheet.nodes), contact=contact)


def spiral(sheet: SheetMesh, distance: float) -> np.ndarray:
    """A roll of 1.2 turns, so far from itself; no corner or edge faces another, shape (V, 3)."""
    along = sheet.nodes[:, 0] - sheet.nodes[:, 0].min()
    angle = 2.4 * np.pi * along
    radius = 0.13 + distance * angle / (2.0 * np.pi)
    across = sheet.nodes[:, 1] + 0.1 * along
    return np.column_stack([radius * np.sin(angle), across, -radius * np.cos(angle)])


@pytest.mark.parametrize("gap", [0.0, GAP])
def test_taylor_slopes(sheet: SheetMesh, gap: float) -> None:
    """Slopes at a state in contact: 2 for the gradient, 3 for the Hessian with what has grown."""
    total, x = total_of(sheet, gap), spiral(sheet, gap + 0.8 * RANGE).ravel()
    energy = total.evaluate(x, 0)[0]
    assert energy > 0.0
    direction = 0.1 * np.random.default_rng(2).standard_normal(x.size)
    slopes = taylor_slopes(total, x, direction, SIZES)
    assert slopes.gradient == pytest.approx(2.0, abs=0.02)
    assert slopes.hessian == pytest.approx(3.0, abs=0.02)


def test_no_net_force_no_net_moment_and_rigid_motion(sheet: SheetMesh) -> None:
    total, x = total_of(sheet), curled(sheet, GAP + 0.5 * RANGE)
    energy, gradient, _ = total.evaluate(x.ravel(), 1)
    forces = gradient.reshape(-1, 3)
    scale = np.abs(forces).sum()
    np.testing.assert_allclose(forces.sum(axis=0), 0, atol=1e-12 * scale)
    np.testing.assert_allclose(np.cross(x, forces).sum(axis=0), 0, atol=1e-12 * scale)
    turned = x @ np.linalg.qr(np.random.default_rng(1).standard_normal((3, 3)))[0] + 0.3
    assert total.evaluate(turned.ravel(), 0)[0] == pytest.approx(energy, rel=1e-9)


def test_the_convex_part_is_positive(sheet: SheetMesh) -> None:
    total, x = total_of(sheet), curled(sheet, GAP + 0.5 * RANGE).ravel()
    exact = np.linalg.eigvalsh(total.matrix(total.evaluate(x, 2)[2]).toarray())
    convex = np.linalg.eigvalsh(total.matrix(total.evaluate(x, 3)[2]).toarray())
    assert exact[0] < -1e-3 * exact[-1]  # contact alone is not convex
    assert convex[0] > -1e-12 * convex[-1]


def test_the_force_halfway_through_the_range() -> None:
    """One node above one triangle."""
    apart = rectangle(2.0, 1.0, 2, 1, "alternating")
    contact = SelfContact(apart, [Shield(GAP, RANGE, FORCE, 0.1)])
    corner = apart.triangles[0]
    free, *far = (node for node in range(len(apart.nodes)) if node not in corner)
    found = []
    for where in (0.5, 1.0):
        x = apart.nodes.copy()
        x[far] += np.column_stack(
            [3.0 * np.arange(len(far)), np.zeros(len(far)), [10.0] * len(far)]
        )
        x[free] = x[corner].mean(axis=0) + np.array([0.0, 0.0, GAP + where * RANGE])
        gradient = np.zeros_like(x)
        contact.add(x, 1, gradient)
        found.append(-gradient[free, 2])
    assert found[0] == pytest.approx(FORCE, rel=1e-9)
    assert found[1] == pytest.approx(0.0, abs=1e-9)


def test_no_step_passes_through(sheet: SheetMesh) -> None:
    """Steps that would close the C beyond its lips end before they cross; the whole ones cross."""
    total, start = total_of(sheet), curled(sheet, 0.3)
    crossed = 0
    for seed in range(5):
        rng = np.random.default_rng(seed)
        goal = curled(sheet, -0.25) + 5e-3 * rng.standard_normal(start.shape)
        crossed += len(crossing_pairs(goal, sheet.triangles)) > 0
        part = total.reach(start.ravel(), (goal - start).ravel())
        assert 0.0 < part < 1.0
        held = start + part * (goal - start)
        assert len(crossing_pairs(held, sheet.triangles)) == 0
        assert min(total.contact.rooms(held)) > 0.0
    assert crossed == 5
    assert total.reach(start.ravel(), np.full(start.size, 0.5)) == 1.0


def test_growth_keeps_what_was_there_and_begins_anew(sheet: SheetMesh) -> None:
    total, x = total_of(sheet), curled(sheet, GAP + 0.5 * RANGE).ravel()
    nnz = total.pattern.nnz
    assert len(total.evaluate(sheet.nodes.ravel(), 2)[2]) == nnz
    first = total.evaluate(x, 2)[2]
    assert len(first) == nnz + total.growth.count > nnz
    pairs = total.growth.pairs
    moved = x + 1e-3 * np.random.default_rng(7).standard_normal(x.size)
    total.evaluate(moved, 2)
    assert np.array_equal(total.growth.pairs[: len(pairs)], pairs)
    assert np.array_equal(total.evaluate(x, 2)[2][: len(first)], first)
    assert total.at(0.5, 1.0).growth.count == 0


def test_parts_too_close_before_actuation_are_refused(sheet: SheetMesh) -> None:
    with pytest.raises(InputError, match=r"contact.gap: .* closer to each other before"):
        SelfContact(sheet, [Shield(0.1, 0.1, 1.0)])


def test_without_the_library(sheet: SheetMesh, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ipctk", None)
    with pytest.raises(InputError, match=r"sheetmorph\[contact\]"):
        SelfContact(sheet, [Shield(0.0, RANGE, 1.0)])


def table_of(count: int) -> TableContact:
    return TableContact.of(count, np.array([0.0, 0.0, 1.0]), 0.5, 0.1, 3.0)


def test_the_table_bears_a_force_halfway_and_stops_steps() -> None:
    table = table_of(3)
    x = np.array([[0.0, 0.0, 0.55], [1.0, 0.0, 0.61], [0.0, 1.0, 0.501]])
    forces = table.forces(x)
    assert forces[0] == pytest.approx(3.0, rel=1e-12)
    assert forces[1] == 0.0
    assert forces[2] > 20.0
    down = np.zeros_like(x)
    down[:, 2] = -0.02
    assert table.reach(x, down) == pytest.approx(0.9 * 0.001 / 0.02)
    assert table.reach(x, -down) == 1.0
    energy = np.zeros(3)
    none = (np.zeros((0, 1, 3)), np.zeros((0, 1, 3, 3)))
    evaluate_elements(table.local_kernel(), x - [0, 0, 0.01], (0, 3), 0, energy, *none)
    assert np.isinf(energy[2])


def test_weight_comes_before_the_actuation_and_stays() -> None:
    weight = Weight(np.zeros((1, 1), dtype=np.int32), np.ones((1, 3)), np.zeros((1, 3)))
    factors = [weight.at(*point).factor for point in ((0, 0), (0, 0.3), (0.1, 1), (1, 0.2), (1, 0))]
    assert factors == [0.0, 0.3, 1.0, 1.0, 1.0]
