"""Every term of the registry: derivatives, invariances, symmetry."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sheetmorph.energy.registry import TERMS
from sheetmorph.energy.taylor import taylor_slopes
from sheetmorph.energy.term import Term, scalar_unknowns
from sheetmorph.energy.total import Total
from sheetmorph.geometry.mesh import SheetMesh
from sheetmorph.geometry.topology import build_mesh

STATES = ["random", "flat", "flat and actuated"]
INTERNAL = [name for name, term in TERMS.items() if not term.linear and name != "table"]
SIZES = np.geomspace(1e-2, 1e-4, 9)
FELT = [(name, state) for name in TERMS for state in STATES if name != "fold" or state == "random"]
"""Terms and states; no flat sheet feels a guard against folds."""


def total_of(name: str, mesh: SheetMesh, ramp: float = 0.6, seed: int = 0) -> Total:
    term = TERMS[name].specimen(mesh, np.random.default_rng(seed))
    return Total.of([term], len(mesh.nodes), scalar_count(term, mesh)).at(ramp, 1.0)


def scalar_count(term: Term, mesh: SheetMesh) -> int:
    """Scalar unknowns of the specimen of a term, filled up to rows of three."""
    scalars = scalar_unknowns(term)
    return -(-(int(scalars.max()) + 1) // 3) * 3 - 3 * len(mesh.nodes) if scalars.size else 0


def with_scalars(total: Total, nodes: np.ndarray, size: float = 0.0) -> np.ndarray:
    """Degrees of freedom: positions, and scalar unknowns that are random, or zero."""
    scalars = total.pattern.size - nodes.size
    return np.concatenate([nodes.ravel(), size * np.random.default_rng(3).standard_normal(scalars)])


def state_of(kind: str, mesh: SheetMesh) -> tuple[np.ndarray, float]:
    """Positions and actuation. At "flat", strain and angle are exactly zero."""
    if kind == "random":
        rng = np.random.default_rng(1)
        return (mesh.nodes + 1e-3 * rng.standard_normal(mesh.nodes.shape)).ravel(), 0.6
    return mesh.nodes.ravel().copy(), 0.0 if kind == "flat" else 0.6


@pytest.mark.parametrize(("name", "state"), FELT)
def test_taylor_slopes(name: str, state: str, small_mesh: SheetMesh) -> None:
    x, ramp = state_of(state, small_mesh)
    total = total_of(name, small_mesh, ramp)
    x = with_scalars(total, x, 1e-3 if state == "random" else 0.0)
    direction = 1e-2 * np.random.default_rng(2).standard_normal(x.size)
    slopes = taylor_slopes(total, x, direction, SIZES)
    if total.terms[0].linear:
        assert slopes.gradient == np.inf
        return
    assert slopes.gradient == pytest.approx(2.0, abs=0.1)
    # Symmetry of the flat state can lift the third order term away; less is a wrong Hessian.
    assert slopes.hessian > 2.9


@pytest.mark.parametrize("name", [n for n, t in TERMS.items() if not t.linear])
def test_taylor_slope_shows_a_wrong_hessian(name: str, small_mesh: SheetMesh) -> None:
    """The test above must be able to fail: a Hessian of the wrong state has order 2."""
    x, ramp = state_of("random", small_mesh)
    total = total_of(name, small_mesh, ramp)
    x = with_scalars(total, x, 1e-3)
    elsewhere = x + 1e-3 * np.random.default_rng(5).standard_normal(x.size)

    class Wrong(Total):
        def evaluate(self, y, order):  # type: ignore[no-untyped-def]
            energy, gradient, _ = total.evaluate(y, min(order, 1))
            return energy, gradient, total.evaluate(elsewhere, 2)[2] if order == 2 else None

    wrong = Wrong(total.terms, total.structure, total.workspace)
    direction = 1e-2 * np.random.default_rng(2).standard_normal(x.size)
    assert taylor_slopes(wrong, x, direction, SIZES).hessian < 2.5


@pytest.mark.parametrize("name", INTERNAL)
def test_rigid_motion_changes_nothing(name: str, small_mesh: SheetMesh) -> None:
    x, ramp = state_of("random", small_mesh)
    total = total_of(name, small_mesh, ramp)
    x = with_scalars(total, x, 1e-3)
    turn = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
    count = len(small_mesh.nodes)
    moved = x.copy().reshape(-1, 3)
    moved[:count] = moved[:count] @ turn.T + [0.3, -0.2, 0.1]
    moved = moved.ravel()
    e0, g0, _ = total.evaluate(x, 1)
    e1, g1, _ = total.evaluate(moved, 1)
    assert e1 == pytest.approx(e0, rel=1e-11)
    forces, after = g0[: 3 * count].reshape(-1, 3), g1[: 3 * count].reshape(-1, 3)
    np.testing.assert_allclose(after, forces @ turn.T, atol=1e-10 * np.abs(g0).max())
    np.testing.assert_allclose(g1[3 * count :], g0[3 * count :], atol=1e-10 * np.abs(g0).max())
    # No net force and no net moment.
    np.testing.assert_allclose(forces.sum(axis=0), 0, atol=1e-12 * np.abs(forces).sum())
    moments = np.cross(x[: 3 * count].reshape(-1, 3), forces).sum(axis=0)
    np.testing.assert_allclose(moments, 0, atol=1e-12 * np.abs(forces).sum())


@pytest.mark.parametrize("name", TERMS)
def test_hessian_is_symmetric_and_matches_gradient(name: str, small_mesh: SheetMesh) -> None:
    """The local blocks that the pattern drops by symmetry are symmetric."""
    x, ramp = state_of("random", small_mesh)
    total = total_of(name, small_mesh, ramp)
    x = with_scalars(total, x, 1e-3)
    _, _, data = total.evaluate(x, 2)
    full = total.pattern.full(data).toarray()
    np.testing.assert_array_equal(full, full.T)
    scale = max(np.abs(full).max(), 1e-12)
    rng = np.random.default_rng(4)
    for _ in range(3):
        v = rng.standard_normal(x.size)
        h = 1e-6 * 1e-2
        ahead, behind = total.evaluate(x + h * v, 1)[1], total.evaluate(x - h * v, 1)[1]
        np.testing.assert_allclose((ahead - behind) / (2 * h), full @ v, atol=2e-6 * scale)


@pytest.mark.parametrize("name", INTERNAL)
def test_renumbering_the_nodes_changes_nothing(name: str, small_mesh: SheetMesh) -> None:
    """The same elements on renumbered nodes: same energy, permuted gradient and Hessian."""
    x, ramp = state_of("random", small_mesh)
    rng = np.random.default_rng(9)
    order = rng.permutation(len(small_mesh.nodes)).astype(np.int32)
    nodes = np.empty_like(small_mesh.nodes)
    nodes[order] = small_mesh.nodes
    renumbered = build_mesh(nodes, order[small_mesh.triangles], edges=order[small_mesh.edges])
    first, second = total_of(name, small_mesh, ramp), total_of(name, renumbered, ramp)
    x = with_scalars(first, x, 1e-3)
    dofs = (3 * order[:, None] + np.arange(3)).ravel()
    dofs = np.concatenate([dofs, np.arange(nodes.size, x.size)])
    y = np.empty_like(x)
    y[dofs] = x
    e0, g0, h0 = first.evaluate(x, 2)
    e1, g1, h1 = second.evaluate(y, 2)
    assert e1 == pytest.approx(e0, rel=1e-12)
    np.testing.assert_allclose(g1[dofs], g0, atol=1e-12 * np.abs(g0).max())
    np.testing.assert_allclose(
        second.pattern.full(h1).toarray()[np.ix_(dofs, dofs)],
        first.pattern.full(h0).toarray(),
        atol=1e-10 * np.abs(h0).max(),
    )


def test_reversing_a_hinge_keeps_the_angle_and_flips_the_coupling(small_mesh: SheetMesh) -> None:
    """The second trap of the published model: θ stays, Δ changes its sign."""
    x, _ = state_of("random", small_mesh)
    every = np.ones(len(small_mesh.hinges), dtype=bool)
    turned = small_mesh.with_hinges_reversed(every)

    def energy(mesh: SheetMesh, coupling: float) -> float:
        count = len(mesh.hinges)
        term = TERMS["bend"](
            mesh.hinges,
            mesh.edge_lengths[mesh.hinge_edges[:, 1:]],
            np.ones(count),
            np.full(count, coupling),
            np.zeros(count),
        )
        return Total.of([term], len(mesh.nodes)).evaluate(x, 0)[0]

    assert energy(turned, 0.0) == pytest.approx(energy(small_mesh, 0.0), rel=1e-12)
    assert energy(turned, -0.8) == pytest.approx(energy(small_mesh, 0.8), rel=1e-12)
    assert energy(turned, 0.8) != pytest.approx(energy(small_mesh, 0.8), rel=1e-3)


def test_stretch_hessian_at_zero_strain_is_not_zero(small_mesh: SheetMesh) -> None:
    """Flat and actuated: stress alone gives the sheet a transverse stiffness −K eth/(l0 l)."""
    total = total_of("stretch", small_mesh, ramp=1.0)
    _, _, data = total.evaluate(small_mesh.nodes.ravel(), 2)
    transverse = total.pattern.full(data).toarray()[2::3, 2::3]
    assert np.abs(transverse).max() > 1e-3 * np.abs(data).max()


@pytest.mark.parametrize("name", [name for name in INTERNAL if name != "guard"])
def test_the_convex_part_is_positive_and_agrees_without_stress(
    name: str, small_mesh: SheetMesh
) -> None:
    """Order 3: no negative eigenvalue, and the Hessian itself where nothing is stressed."""
    x, ramp = state_of("random", small_mesh)
    total = total_of(name, small_mesh, ramp)
    x = with_scalars(total, x, 1e-3)
    exact = total.pattern.full(total.evaluate(x, 2)[2]).toarray()
    convex = total.pattern.full(total.evaluate(x, 3)[2]).toarray()
    values = np.linalg.eigvalsh(convex)
    assert values[0] > -1e-12 * values[-1]
    assert np.linalg.eigvalsh(exact)[0] < -1e-6 * values[-1]
    flat, ramp = state_of("flat", small_mesh)
    unstressed = total_of(name, small_mesh, ramp)
    flat = with_scalars(unstressed, flat)
    np.testing.assert_allclose(
        unstressed.evaluate(flat, 3)[2], unstressed.evaluate(flat, 2)[2], atol=1e-12 * values[-1]
    )


def test_evaluation_is_bitwise_repeatable(small_mesh: SheetMesh) -> None:
    x, ramp = state_of("random", small_mesh)
    total = total_of("bend", small_mesh, ramp)
    first = [np.copy(part) for part in total.evaluate(x, 2)]
    for part, again in zip(first, total.evaluate(x, 2), strict=True):
        np.testing.assert_array_equal(part, again)


def test_chunks_do_not_matter(small_mesh: SheetMesh, monkeypatch: pytest.MonkeyPatch) -> None:
    from sheetmorph.energy import total as module

    x, ramp = state_of("random", small_mesh)
    whole = total_of("bend", small_mesh, ramp).evaluate(x, 2)
    monkeypatch.setattr(module, "CHUNK", 7)
    parts = total_of("bend", small_mesh, ramp).evaluate(x, 2)
    assert parts[0] == pytest.approx(whole[0], rel=1e-14)
    np.testing.assert_allclose(parts[1], whole[1], atol=1e-14)
    np.testing.assert_allclose(parts[2], whole[2], rtol=1e-12, atol=1e-14)
