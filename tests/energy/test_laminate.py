"""The layered triangle: flaps, forms of known surfaces, lamination theory by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sheetmorph.energy.laminate import LaminateShell
from sheetmorph.energy.laminate_kernel import measure_shapes
from sheetmorph.energy.laminate_patch import Patch
from sheetmorph.energy.lamination import Lamination, Layup
from sheetmorph.energy.shape_measures import ShapeMeasures
from sheetmorph.energy.taylor import taylor_slopes
from sheetmorph.energy.total import Total
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.geometry.topology import build_mesh

SIZES = np.geomspace(1e-2, 1e-4, 9)


def flapped_patch(mesh: SheetMesh) -> Patch:
    """All edges of the rim keep a normal, each another one."""
    rim = mesh.rim_edges
    rng = np.random.default_rng(7)
    away = mesh.edge_midpoints[rim] - mesh.nodes[:, :2].mean(axis=0)
    conormals = np.column_stack([away, 0.3 * rng.standard_normal(len(rim)) * 0.02])
    conormals /= np.linalg.norm(conormals, axis=1)[:, None]
    return Patch.of(mesh, mesh.mean_edge_length, rim, conormals)


def natural_curvature(lamination: Lamination) -> Floats:
    """Second form (b11, b22, 2 b12) of the triangles left to themselves, one layup."""
    every = np.arange(len(lamination.cells))
    section = lamination.section(every, lamination.layups[0], 1.0)
    rest = np.linalg.solve(section.stiffness, section.resultants[:, :, None])[:, :, 0]
    return np.asarray(-rest[:, 3:])


def uniform(values: tuple[float, ...], count: int) -> Floats:
    """The same eigenstrain (e11, e22, e12) for all triangles."""
    return np.tile(np.asarray(values, dtype=np.float64), (count, 1))


def frames_of(mesh: SheetMesh) -> Floats:
    return mesh.triangle_frames


def plain(mesh: SheetMesh, patch: Patch, layup: Layup, strain: tuple[float, ...]) -> Lamination:
    count = len(mesh.triangles)
    return Lamination(
        ShapeMeasures.of(mesh.nodes, patch, frames_of(mesh)),
        np.zeros(count, dtype=np.intp),
        (layup,),
        uniform(strain, count),
        False,
    )


BILAYER = Layup(
    np.array([0.3e-3, 0.9e-3]),
    np.array([2e6, 5e6]),
    np.array([0.3, 0.3]),
    np.array([1.0, 0.0]),
    np.array([True, False]),
)


@pytest.mark.parametrize("bent", [False, True])
def test_flapped_sides_have_right_derivatives(small_mesh: SheetMesh, bent: bool) -> None:
    patch = flapped_patch(small_mesh)
    lamination = Lamination.specimen(small_mesh, patch, np.random.default_rng(0))
    term = LaminateShell.of(patch, lamination)
    total = Total.of([term], len(small_mesh.nodes), patch.scalar_count).at(0.6, 1.0)
    x = np.concatenate([small_mesh.nodes.ravel(), np.zeros(patch.scalar_count)])
    rng = np.random.default_rng(1)
    if bent:
        x = x + 1e-3 * rng.standard_normal(x.size)
    direction = 1e-2 * rng.standard_normal(x.size)
    slopes = taylor_slopes(total, x, direction, SIZES)
    assert slopes.gradient == pytest.approx(2.0, abs=0.1)
    assert slopes.hessian > 2.9
    # The unknowns of directors with a flap have no effect.
    _, gradient, _ = total.evaluate(x, 1)
    assert gradient is not None
    assert (gradient[small_mesh.nodes.size :][patch.held] == 0.0).all()


def test_a_flap_that_goes_on_flat_costs_nothing(small_mesh: SheetMesh) -> None:
    """A flat sheet with flaps in its plane is at rest; one whose rim is lifted is not."""
    rim = small_mesh.rim_edges
    ends = small_mesh.nodes[small_mesh.edges[rim]]
    along = ends[:, 1] - ends[:, 0]
    away = small_mesh.edge_midpoints[rim] - small_mesh.nodes[:, :2].mean(axis=0)
    normal = np.column_stack([along[:, 1], -along[:, 0], np.zeros(len(rim))])
    normal *= np.sign((normal[:, :2] * away).sum(axis=1))[:, None]
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    patch = Patch.of(small_mesh, 0.01, rim, normal)
    term = LaminateShell.of(patch, plain(small_mesh, patch, BILAYER, (0.0, 0.0, 0.0)))
    total = Total.of([term], len(small_mesh.nodes), patch.scalar_count)
    x = np.concatenate([small_mesh.nodes.ravel(), np.zeros(patch.scalar_count)])
    energy, gradient, _ = total.evaluate(x, 1)
    assert gradient is not None
    assert abs(energy) < 1e-15
    assert np.abs(gradient).max() < 1e-9
    lifted = x.copy()
    inner = np.setdiff1d(np.arange(len(small_mesh.nodes)), small_mesh.edges[rim])
    lifted[3 * inner + 2] += 1e-3
    assert total.evaluate(lifted, 0)[0] > 1e-6


@pytest.mark.parametrize("curvatures", [(20.0, 0.0, 0.0), (8.0, -8.0, 0.0), (5.0, 5.0, 3.0)])
def test_the_second_form_of_a_shallow_surface(
    small_mesh: SheetMesh, curvatures: tuple[float, float, float]
) -> None:
    """z = ½ (κ1 x² + κ2 y²) + κ12 x y with directors along its normals: b is (κ1, κ2, κ12)."""
    k1, k2, k12 = (1e-2 * value for value in curvatures)
    patch = Patch.of(small_mesh, 1.0)
    x, y = (small_mesh.nodes[:, :2] - 0.03).T
    bent = small_mesh.nodes.copy()
    bent[:, 2] = 0.5 * (k1 * x * x + k2 * y * y) + k12 * x * y
    # The turn from the left triangle's normal to that of the surface at the edge's middle.
    middles = small_mesh.edge_midpoints - 0.03
    slopes = np.column_stack(
        [k1 * middles[:, 0] + k12 * middles[:, 1], k2 * middles[:, 1] + k12 * middles[:, 0]]
    )
    scalars = np.zeros(patch.scalar_count)
    left = patch.turn > 0
    a, b, c = (bent[small_mesh.triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    steep = -normals[:, :2] / normals[:, 2:]  # slope of each triangle
    for side in range(3):
        rows = np.flatnonzero(left[:, side])
        edges = patch.directors[rows, side] - 3 * len(small_mesh.nodes)
        ends = small_mesh.triangles[rows][:, [(side + 1) % 3, (side + 2) % 3]]
        along = small_mesh.nodes[ends[:, 1], :2] - small_mesh.nodes[ends[:, 0], :2]
        out = np.column_stack([along[:, 1], -along[:, 0]])
        out /= np.linalg.norm(out, axis=1)[:, None]
        scalars[edges] = -((slopes[edges] - steep[rows]) * out).sum(axis=1)
    measures = ShapeMeasures.of(small_mesh.nodes, patch, frames_of(small_mesh))
    _, second = measures.forms(np.concatenate([bent.ravel(), scalars]), patch)
    np.testing.assert_allclose(second, np.tile([k1, k2, k12], (len(second), 1)), atol=2e-5)


def test_forms_of_a_stretched_sheet(small_mesh: SheetMesh) -> None:
    """x → 1.2 x + 0.1 y, y → 0.9 y: the metric is Fᵀ F."""
    patch = Patch.of(small_mesh, 1.0)
    gradient = np.array([[1.2, 0.1, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 1.0]])
    measures = ShapeMeasures.of(small_mesh.nodes, patch, frames_of(small_mesh))
    first, second = measures.forms((small_mesh.nodes @ gradient.T).ravel(), patch)
    metric = (gradient.T @ gradient)[:2, :2]
    wanted = [metric[0, 0], metric[1, 1], metric[0, 1]]
    np.testing.assert_allclose(first, np.tile(wanted, (len(first), 1)), atol=1e-12)
    np.testing.assert_allclose(second, 0.0, atol=1e-12)


def test_the_check_value_of_two_layers(small_mesh: SheetMesh) -> None:
    """Timoshenko's curvature, the shrinking face (the lower one) concave: a dome, b negative."""
    patch = Patch.of(small_mesh, 1.0)
    eps = -1e-5
    layup = replace(BILAYER, poisson_ratios=np.zeros(2))
    lamination = plain(small_mesh, patch, layup, (eps, 0.0, 0.0))
    h1, h2 = layup.thicknesses
    m, n, h = h1 / h2, layup.young_moduli[0] / layup.young_moduli[1], h1 + h2
    kappa = 6 * eps * (1 + m) ** 2 / (h * (3 * (1 + m) ** 2 + (1 + m * n) * (m**2 + 1 / (m * n))))
    found = natural_curvature(lamination)
    np.testing.assert_allclose(found[:, 0], kappa, rtol=1e-4)
    assert (found[:, 0] < 0).all()


def test_thickening_keeps_the_volume(small_mesh: SheetMesh) -> None:
    """A layer that shrinks by half is four times as thick: A grows fourfold, D 64 times."""
    patch = Patch.of(small_mesh, 1.0)
    one = Layup(np.array([1e-3]), np.array([1e6]), np.array([0.3]), np.array([1.0]), np.ones(1) > 0)
    thin = plain(small_mesh, patch, one, (-0.5, -0.5, 0.0))
    thick = replace(thin, thickening=True)
    here = np.arange(len(small_mesh.triangles))
    plate = [one_.section(here, one, 1.0).stiffness[0] for one_ in (thin, thick)]
    assert plate[1][0, 0] / plate[0][0, 0] == pytest.approx(4.0)
    assert plate[1][3, 3] / plate[0][3, 3] == pytest.approx(64.0)


def test_a_turned_frame_changes_nothing(small_mesh: SheetMesh) -> None:
    """Orthotropic shrinkage in a frame turned by 0.7 rad: the same natural measures."""
    patch = Patch.of(small_mesh, 1.0)
    c, s = np.cos(0.7), np.sin(0.7)
    frames = np.einsum("ij,tjx->tix", np.array([[c, s], [-s, c]]), frames_of(small_mesh))
    strain = np.array([[-0.3, 0.05], [0.05, 0.1]])
    turn = np.array([[c, s], [-s, c]])
    turned = turn @ strain @ turn.T
    lamination = plain(small_mesh, patch, BILAYER, (strain[0, 0], strain[1, 1], strain[0, 1]))
    other = replace(
        lamination,
        measures=ShapeMeasures.of(small_mesh.nodes, patch, frames),
        eigenstrains=uniform((turned[0, 0], turned[1, 1], turned[0, 1]), len(frames)),
    )
    first, second = lamination.rest_at(1.0), other.rest_at(1.0)
    np.testing.assert_allclose(first.natural, second.natural, atol=1e-12)
    np.testing.assert_allclose(first.stiffness, second.stiffness, rtol=1e-9, atol=1e-9)


def test_wrong_numbers_of_unknowns_are_refused(small_mesh: SheetMesh) -> None:
    patch = Patch.of(small_mesh, 1.0)
    term = LaminateShell.of(patch, plain(small_mesh, patch, BILAYER, (0.0, 0.0, 0.0)))
    total = Total.of([term], len(small_mesh.nodes), patch.scalar_count)
    with pytest.raises(ValueError, match="degrees of freedom"):
        total.evaluate(small_mesh.nodes.ravel(), 0)


def test_a_mesh_of_one_triangle() -> None:
    """No hinge at all: three free sides."""
    mesh = build_mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    patch = Patch.of(mesh, 1.0)
    assert (patch.share == 0).all()
    assert (patch.turn > 0).all()


def test_one_side_may_take_the_whole_turn() -> None:
    """Beside a stiff rib the director leans out of the soft triangle alone: nothing jumps."""
    nodes = np.array([[0.0, 0, 0], [1, 0, 0], [0.5, 1, 0], [0.5, -1, 0]])
    mesh = build_mesh(nodes, np.array([[0, 1, 2], [1, 0, 3]]))
    patch = Patch.of(mesh, 1.0)
    edge = int(mesh.hinge_edges[0, 0])
    right = int(np.flatnonzero(patch.share.any(axis=1))[0])
    side = int(np.flatnonzero(patch.share[right])[0])
    turn = np.deg2rad(175.0)
    for share in (0.0, 0.5, 1.0, 1.05):
        for sign in (1.0, -1.0):
            x = nodes.copy()
            x[3] = [0.5, -np.cos(turn), -sign * np.sin(turn)]
            scalars = np.zeros(6)
            scalars[edge] = sign * share * turn
            measures = np.empty((2, 6))
            measure_shapes(
                np.concatenate([x.ravel(), scalars]).reshape(-1, 3),
                *(patch.stencil, patch.directors, patch.share, patch.turn, patch.lean, patch.flap),
                measures,
            )
            lean = measures[right, 3 + side] / 2.0
            assert lean == pytest.approx(sign * (1.0 - share) * turn, abs=1e-9)


def test_a_node_beyond_two_sides_of_a_triangle() -> None:
    """About a node with three neighbours the node beyond two sides is the same."""
    nodes = np.array([[0.0, 0, 0], [1.2, 1, 0], [3, 0, 0], [1, 3, 0]])
    mesh = build_mesh(1e-2 * nodes, np.array([[0, 2, 1], [2, 3, 1], [3, 0, 1]]))
    shell = LaminateShell.specimen(mesh, np.random.default_rng(0))
    assert any(len({*beyond.tolist()}) < 3 for beyond in shell.stencil[:, 3:])
    total = Total.of([shell], len(nodes), shell.patch.scalar_count).at(0.6, 0.0)
    rng = np.random.default_rng(1)
    x = np.concatenate([mesh.nodes.ravel(), np.zeros(shell.patch.scalar_count)])
    x += 1e-3 * rng.standard_normal(x.size)
    slopes = taylor_slopes(total, x, 1e-2 * rng.standard_normal(x.size), SIZES)
    assert slopes.hessian == pytest.approx(3.0, abs=0.1)
