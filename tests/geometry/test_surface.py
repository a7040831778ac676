from __future__ import annotations

import numpy as np
import pytest
import shapely

from sheetmorph.core.errors import InputError
from sheetmorph.geometry import surface
from sheetmorph.geometry.files import read_mesh
from sheetmorph.geometry.generate import generate_mesh


@pytest.fixture(scope="module")
def disc():
    """An irregular mesh of the unit disc."""
    return generate_mesh(shapely.Point(0, 0).buffer(1.0, 64), shapely.Polygon(), 0.1)


def sphere(nodes, radius):
    """Lift a disc to a cap with its pole up."""
    height = np.sqrt(radius**2 - (nodes[:, :2] ** 2).sum(axis=1)) - radius
    return np.column_stack([nodes[:, :2], height])


def cylinder(nodes, radius):
    """Roll a sheet about the y axis, without stretch, its middle up."""
    angle = nodes[:, 0] / radius
    return np.column_stack([radius * np.sin(angle), nodes[:, 1], radius * (np.cos(angle) - 1.0)])


def rotation(seed):
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))


def test_released_dihedrals_and_strains(reference):
    mesh = read_mesh(reference / "petals_mesh.txt")
    with np.load(reference / "petals_eps-0.30.npz") as released:
        x = released["positions"]
        assert np.array_equal(mesh.hinges, released["hinges"])
        dihedral = surface.dihedral_angles(x, mesh.hinges)
        np.testing.assert_allclose(dihedral, released["dihedral"], rtol=0, atol=1e-12)
        strain = surface.edge_strain(x, mesh.edges, mesh.edge_lengths)
        np.testing.assert_allclose(strain, released["strain"], rtol=0, atol=1e-12)


@pytest.mark.parametrize("angle", [-3.0, -1.2, -1e-9, 0.0, 1e-9, 0.4, 2.0, 3.1])
def test_dihedral_of_one_fold(angle):
    # Ridge along y; the right-hand triangle is folded down by `angle`.
    x = np.array(
        [[0, 0, 0], [0, 1, 0], [-1, 0.5, 0], [np.cos(angle), 0.5, -np.sin(angle)]], dtype=float
    )
    hinge = np.array([[0, 1, 2, 3]])
    assert surface.dihedral_angles(x, hinge)[0] == pytest.approx(angle, abs=1e-15, rel=1e-14)
    reverse = hinge[:, [1, 0, 3, 2]]
    assert surface.dihedral_angles(x, reverse)[0] == pytest.approx(angle, abs=1e-15, rel=1e-14)


def test_all_states_at_once_equal_one_by_one(disc):
    rng = np.random.default_rng(1)
    x = disc.nodes + 0.01 * rng.normal(size=(3, *disc.nodes.shape))
    for function, table in (
        (surface.edge_lengths, disc.edges),
        (surface.dihedral_angles, disc.hinges),
        (surface.triangle_normals, disc.triangles),
        (surface.triangle_areas, disc.triangles),
        (surface.vertex_normals, disc.triangles),
        (surface.mean_curvature, disc.triangles),
        (surface.gaussian_curvature, disc.triangles),
    ):
        together = function(x, table)
        for state in range(3):
            np.testing.assert_array_equal(together[state], function(x[state], table))
    for width in ("feret_max", "feret_min", "x"):
        ratios = surface.aspect_ratio(x, width)
        assert ratios.shape == (3,)
        assert ratios[1] == surface.aspect_ratio(x[1], width)


def test_flat_sheet(disc):
    x, faces = disc.nodes, disc.triangles
    assert np.abs(surface.dihedral_angles(x, disc.hinges)).max() == 0.0
    assert np.abs(surface.edge_strain(x, disc.edges, disc.edge_lengths)).max() < 1e-15
    np.testing.assert_allclose(surface.triangle_areas(x, faces), disc.triangle_areas, rtol=1e-12)
    for normals in (surface.triangle_normals(x, faces), surface.vertex_normals(x, faces)):
        np.testing.assert_allclose(normals, np.broadcast_to([0, 0, 1.0], normals.shape))
    assert np.abs(surface.mean_curvature(x, faces)).max() < 1e-10
    assert np.abs(surface.gaussian_curvature(x, faces)).max() < 1e-10
    assert surface.aspect_ratio(x) == 0.0


@pytest.mark.parametrize("sign", [1, -1])
def test_rigid_motion_changes_nothing_and_a_mirror_turns_the_sign(disc, sign):
    x = sphere(disc.nodes, 2.0) * [1, 1, sign]
    moved = x @ rotation(3).T + [1, 2, 3]
    for function, table in (
        (surface.dihedral_angles, disc.hinges),
        (surface.mean_curvature, disc.triangles),
        (surface.gaussian_curvature, disc.triangles),
        (surface.triangle_areas, disc.triangles),
    ):
        np.testing.assert_allclose(function(moved, table), function(x, table), atol=1e-9)
    inner = np.linalg.norm(disc.nodes[:, :2], axis=1) < 0.8
    assert np.sign(surface.mean_curvature(x, disc.triangles)[inner]).mean() == sign
    assert np.median(surface.dihedral_angles(x, disc.hinges)) * sign > 0
    assert surface.gaussian_curvature(x, disc.triangles)[inner].mean() > 0


def curvature_errors(make, size, mean, gauss):
    """Root mean square errors on irregular meshes, away from the rim."""
    mesh = generate_mesh(shapely.Point(0, 0).buffer(1.0, 64), shapely.Polygon(), size)
    x = make(mesh.nodes)
    inner = np.linalg.norm(mesh.nodes[:, :2], axis=1) < 0.8
    errors = []
    for function, exact in (
        (surface.mean_curvature, mean),
        (surface.gaussian_curvature, gauss),
    ):
        error = function(x, mesh.triangles)[inner] - exact
        errors.append(float(np.sqrt((error**2).mean())))
    return errors


@pytest.mark.parametrize(
    ("shape", "mean", "gauss"), [(sphere, 1 / 1.5, 1 / 1.5**2), (cylinder, 0.5 / 1.5, 0.0)]
)
def test_curvatures_converge(shape, mean, gauss):
    coarse = curvature_errors(lambda n: shape(n, 1.5), 0.16, mean, gauss)
    fine = curvature_errors(lambda n: shape(n, 1.5), 0.04, mean, gauss)
    # Irregular nodes keep a local error; over all it falls by half or more for a quarter size.
    assert fine[0] < 0.02 * mean
    assert fine[1] < 0.04 / 1.5**2
    assert fine[0] < 0.5 * coarse[0]
    assert fine[1] < 0.6 * coarse[1] + 1e-12


def test_total_gaussian_curvature_is_the_turning_of_the_rim(disc):
    """Gauss–Bonnet: the integral over a cap is the solid angle it spans."""
    radius = 1.5
    x = sphere(disc.nodes, radius)
    areas = surface.triangle_areas(x, disc.triangles)
    node_area = np.bincount(disc.triangles.ravel(), np.repeat(areas / 3, 3))
    total = (surface.gaussian_curvature(x, disc.triangles) * node_area).sum()
    inside = areas.sum() - node_area[surface.gaussian_curvature(x, disc.triangles) == 0].sum()
    assert total == pytest.approx(inside / radius**2, rel=0.02)


def test_rim_values(disc):
    x = sphere(disc.nodes, 1.5)
    rim = np.abs(np.linalg.norm(disc.nodes[:, :2], axis=1) - 1.0) < 1e-3
    assert (surface.gaussian_curvature(x, disc.triangles)[rim] == 0).all()
    np.testing.assert_allclose(surface.mean_curvature(x, disc.triangles)[rim], 1 / 1.5, rtol=0.1)
    one = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]])
    assert (surface.mean_curvature(one, np.array([[0, 1, 2]])) == 0).all()


@pytest.mark.parametrize(
    ("width", "expected"), [("feret_max", np.hypot(3, 4)), ("feret_min", 3.0), ("x", None)]
)
@pytest.mark.parametrize("turn", [0.0, 0.3, 1.1])
def test_aspect_ratio_of_a_box(width, expected, turn):
    corners = np.array([[x, y, z] for x in (0, 3) for y in (0, 4) for z in (0, 2.0)])
    c, s = np.cos(turn), np.sin(turn)
    x = corners @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
    width_now = np.ptp(x[:, 0]) if expected is None else expected
    assert surface.aspect_ratio(x, width) == pytest.approx(2.0 / width_now, rel=1e-12)


def test_aspect_ratio_of_a_line_and_a_point():
    line = np.array([[0, 0, 0], [3, 4, 1], [1.5, 2, 0]], dtype=float)
    assert surface.aspect_ratio(line) == pytest.approx(0.2)
    assert np.isnan(surface.aspect_ratio(line, "feret_min"))
    assert np.isnan(surface.aspect_ratio(np.zeros((3, 3))))


def test_unknown_width_is_refused():
    with pytest.raises(InputError, match="feret_max, feret_min, x"):
        surface.aspect_ratio(np.zeros((3, 3)), "diagonal")  # type: ignore[arg-type]
