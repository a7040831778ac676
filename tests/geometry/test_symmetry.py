from __future__ import annotations

import numpy as np
import pytest
import shapely
from scipy.spatial import cKDTree
from shapely import affinity

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.generate import generate_mesh
from sheetmorph.geometry.quality import mesh_quality
from sheetmorph.geometry.symmetric_mesh import subgroups, symmetric_mesh
from sheetmorph.geometry.symmetry import Symmetry, find_symmetry, node_images

PLACES = {"drawn": (0.0, (0.0, 0.0)), "turned and moved": (17.3, (0.31, -0.2))}
EMPTY = shapely.Polygon()


def disc(radius, x=0.0, y=0.0):
    return shapely.Point(x, y).buffer(radius, quad_segs=60)


def turned(shape, degrees):
    return affinity.rotate(shape, degrees, origin=(0, 0))


def around(shape, count):
    """Copies of a shape at equal angles about the origin."""
    return shapely.union_all([turned(shape, 360 * k / count) for k in range(count)])


def star(arms, half_width=3e-3, length=0.044, hub=2.9e-3):
    bar = shapely.box(0, -half_width, length, half_width)
    return shapely.union(around(bar, arms), disc(hub))


def pinwheel(count=4):
    blade = [(0.0, 0.0), (0.04, -0.004), (0.042, 0.012), (0.02, 0.008), (0.006, 0.006)]
    return around(shapely.Polygon(blade), count)


def line(*points):
    return shapely.LineString(points)


def random_blot():
    rng = np.random.default_rng(3)
    return shapely.MultiPoint(rng.uniform(-0.03, 0.03, (7, 2))).convex_hull


def placed(shape, turn, place):
    return affinity.translate(turned(shape, turn), *place)


SHEET = disc(0.05)
BOX = shapely.box(-0.05, -0.03, 0.05, 0.03)
LEAF = disc(0.05, 0, 0.03) & disc(0.05, 0, -0.03)
RING = disc(0.05) - disc(0.02)
STAR5 = around(shapely.box(0, -0.004, 0.06, 0.004), 5)
SPOKES = STAR5 & RING
SPIRAL = np.linspace(0.9, 2.6, 40)
SPIRAL = line(
    *np.column_stack([np.cos(1.4 * SPIRAL), np.sin(1.4 * SPIRAL)]) * 0.015 * SPIRAL[:, None]
)

# Shapes, order, direction of a mirror line [deg] or None.
GROUPS = {
    **{f"star of {n} arms": ((SHEET, star(n)), n, 0.0) for n in (3, 4, 5, 6, 7, 8, 13)},
    "one arm": ((SHEET, star(1)), 1, 0.0),
    "star on a rectangle": ((BOX, star(6, length=0.025)), 2, 0.0),
    "star askew on a rectangle": ((BOX, turned(star(6, length=0.025), 5)), 2, None),
    "square": ((shapely.box(-0.05, -0.05, 0.05, 0.05),), 4, 0.0),
    "two regions of different groups": ((SHEET, star(6), disc(0.004, 0.02)), 1, 0.0),
    "two regions of a common group": ((SHEET, star(6), star(4)), 2, 0.0),
    "leaf": ((LEAF, disc(0.006, 0.012)), 1, 0.0),
    "pinwheel": ((SHEET, pinwheel()), 4, None),
    "pinwheel with an empty region": ((SHEET, EMPTY, pinwheel()), 4, None),
    "spiral slits": ((SHEET, disc(0.008), around(SPIRAL, 3)), 3, None),
    "slit askew": ((BOX, disc(0.01), line((-0.03, -0.01), (0.03, 0.01))), 2, None),
    "short notch": ((SHEET - shapely.box(0.048, -1e-4, 0.06, 1e-4), star(6)), 1, 0.0),
    "ring with spokes": ((RING, SPOKES), 5, 0.0),
    "circles": ((SHEET, disc(0.02)), 12, 0.0),
    "gear of 60 teeth": ((SHEET | around(shapely.box(0, -1e-3, 0.052, 1e-3), 60),), 60, 0.0),
    "blot": ((SHEET, random_blot()), 1, None),
}  # fmt: skip


@pytest.mark.parametrize(
    "place", [pytest.param("drawn", marks=pytest.mark.slow), "turned and moved"]
)
@pytest.mark.parametrize("name", GROUPS)
def test_groups(name, place):
    shapes, order, mirror = GROUPS[name]
    turn, shift = PLACES[place]
    found = find_symmetry([placed(shape, turn, shift) for shape in shapes])
    assert found.order == order
    if "notch" not in name:  # a notch moves the centroid
        assert np.allclose(found.centre, shift, atol=1e-9)
    assert (found.mirror is None) == (mirror is None)
    if mirror is not None and name != "circles":
        wanted = np.radians(mirror + turn) % (np.pi / order)
        assert found.mirror == pytest.approx(wanted, abs=1e-6)
    assert found.elements == order * (2 if mirror is not None else 1)


def test_what_differs_by_more_than_the_tolerance_is_not_alike():
    def sheet(extra):
        longer = shapely.box(0, -3e-3, 0.044 + extra, 3e-3)
        return [SHEET, shapely.union(star(6), longer)]

    diagonal = 0.1 * np.sqrt(2)
    assert find_symmetry(sheet(1e-4 * diagonal)).order == 6
    assert find_symmetry(sheet(4e-4 * diagonal)) == Symmetry(find_symmetry([SHEET]).centre, 1, 0.0)
    assert find_symmetry(sheet(1e-3), tolerance=2e-3).order == 6


def test_the_group_is_a_group():
    group = Symmetry((0.1, 0.2), 6, 0.3)
    matrices = group.matrices().reshape(12, 4)
    products = np.einsum("aij,bjk->abik", group.matrices(), group.matrices()).reshape(-1, 4)
    assert cKDTree(matrices).query(products)[0].max() < 1e-15 * 4
    assert np.linalg.det(group.matrices()) == pytest.approx([1.0] * 6 + [-1.0] * 6)
    axis = np.array([[np.cos(0.3), np.sin(0.3)]]) + group.centre
    assert np.allclose(group.images(axis)[6], axis, atol=1e-15)
    assert str(group) == "rotations by 60° and 6 mirror lines (one at 17.19°)"
    assert str(Symmetry((0, 0), 1, None)) == "no symmetry"


def test_subgroups_come_largest_first():
    group = Symmetry((0.0, 0.0), 6, 0.0)
    assert [g.elements for g in subgroups(group)] == [12, 6, 6, 6, 4, 4, 3, 2, 2, 2]
    assert all(g.mirror is None for g in subgroups(group, "rotation"))
    assert all(g.mirror is not None for g in subgroups(group, "mirror"))
    assert subgroups(Symmetry((0.0, 0.0), 1, None)) == []


# Outline, pattern, size, slits, smallest angle, elements that the mesh must have.
CASES = {
    "pinwheel": (SHEET, [pinwheel()], 3.2e-3, None, 35, 4),
    "pinwheel with a hub": (SHEET, [pinwheel() | disc(0.008)], 3.2e-3, None, 30, 4),
    "ring with spokes": (RING, [SPOKES], 3e-3, None, 35, 10),
    "ring with five pieces": (RING, [RING - STAR5], 3e-3, None, 35, 10),
    "star of 3 arms": (SHEET, [star(3)], 3e-3, None, 35, 6),
    "star of 5 arms": (SHEET, [star(5)], 3e-3, None, 34, 10),
    "star of 7 arms": (SHEET, [star(7, 4e-3)], 3e-3, None, 25, 14),
    # The film between arms at 45° has no room for two angles of 25°.
    "star of 8 arms": (SHEET, [star(8)], 3e-3, None, 35, 8),
    "leaf": (LEAF, [disc(0.006, 0.012)], 2.5e-3, None, 35, 2),
    "circles": (SHEET, [disc(0.02)], 3e-3, None, 29, 24),
    "no pattern": (BOX, [], 4e-3, None, 35, 4),
    "nested regions": (SHEET, [disc(0.03), disc(0.015)], 3e-3, None, 29, 24),
    "slits on mirror lines": (
        SHEET, [disc(8e-3)], 3e-3, around(line((0.015, 0), (0.04, 0)), 6), 35, 12,
    ),
    "slits to the rim": (SHEET, [disc(8e-3)], 3e-3, around(line((0.015, 0), (0.05, 0)), 6), 35, 12),
    "slits across mirror lines": (
        SHEET, [disc(8e-3)], 3e-3, around(line((0.025, -0.008), (0.025, 0.008)), 6), 35, 12,
    ),
    "spiral slits": (SHEET, [disc(8e-3)], 3e-3, around(SPIRAL, 4), 35, 4),
    "slit through the centre": (BOX, [disc(0.01)], 3e-3, line((-0.03, 0), (0.03, 0)), 35, 4),
    "slit askew": (BOX, [disc(0.01)], 3e-3, line((-0.03, -0.01), (0.03, 0.01)), 35, 2),
}  # fmt: skip


LONG = ("pinwheel with a hub", "star of 3 arms", "star of 8 arms", "nested regions", "slit askew")


def check_exact(mesh, group):
    """Nodes and triangles map to nodes and triangles under every element."""
    rounding = 1e-15 * (mesh.size + 4 * np.linalg.norm(group.centre))
    images = node_images(mesh.nodes, group, rounding)
    place = node_images(mesh.nodes, Symmetry(group.centre, 1, None), 0.0)[0]
    assert (np.sort(images, axis=1) == np.sort(place)).all()
    corners = np.sort(place[mesh.triangles], axis=1)
    count = len(corners)
    for image in images:
        both = np.concatenate([corners, np.sort(image[mesh.triangles], axis=1)])
        assert len(np.unique(both, axis=0)) == count


def check_follows(mesh, outline, pattern, size):
    for shape in (outline, *pattern):
        inside = shapely.contains_xy(shape, *mesh.triangle_centroids.T)
        area = mesh.triangle_areas[inside].sum()
        assert area == pytest.approx(shape.area, abs=0.05 * size * shape.length)
        small = mesh.triangle_centroids[:, None] * 0.4 + 0.6 * mesh.nodes[mesh.triangles, :2]
        assert not shapely.intersects(shape.boundary, shapely.polygons(small)).any()


def largest(mesh, symmetry):
    """The largest group that a mesh has."""
    for group in subgroups(symmetry):
        try:
            node_images(mesh.nodes, group, 1e-12)
        except InputError:
            continue
        return group
    raise AssertionError("the mesh has no symmetry")


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_meshes_as_drawn(name):
    check_case(name, "drawn")


@pytest.mark.parametrize("name", [name for name in CASES if name not in LONG])
def test_meshes(name):
    check_case(name, "turned and moved")


def check_case(name, place):
    outline, pattern, size, slits, smallest, elements = CASES[name]
    outline = placed(outline, *PLACES[place])
    pattern = [placed(shape, *PLACES[place]) for shape in pattern]
    cuts = shapely.MultiLineString() if slits is None else placed(slits, *PLACES[place])
    symmetry = find_symmetry([outline, *pattern, cuts])
    mesh = symmetric_mesh(outline, pattern, size, symmetry, slits=cuts)
    quality = mesh_quality(mesh)
    assert quality.min_angle > smallest
    assert quality.mean_edge == pytest.approx(size, rel=0.05)
    check_follows(mesh, outline, pattern, size)
    group = largest(mesh, symmetry)
    assert group.elements == elements
    check_exact(mesh, group)
    rim = np.ones(len(mesh.edges), dtype=bool)
    rim[mesh.hinge_edges[:, 0]] = False
    length = outline.length + 2 * cuts.length
    assert mesh.edge_lengths[rim].sum() == pytest.approx(length, rel=2e-3)


@pytest.mark.parametrize("name", ["bowl", "canoe", "petals"])
def test_paper_designs(name, sheets):
    outline, pattern, size = sheets[name]
    symmetry = find_symmetry([outline, pattern])
    assert (symmetry.order, symmetry.mirror) == ((6, 0.0) if name == "bowl" else (2, 0.0))
    mesh = symmetric_mesh(outline, [pattern], size, symmetry)
    quality = mesh_quality(mesh)
    # The film between the arms of the bowl has corners of 60°, which mirror lines halve.
    assert quality.min_angle > (29.9 if name == "bowl" else 35.0)
    assert quality.mean_edge == pytest.approx(size, rel=0.05)
    check_follows(mesh, outline, [pattern], size)
    check_exact(mesh, symmetry)


def test_the_usual_mesh_has_not_this_symmetry(sheets):
    outline, pattern, size = sheets["bowl"]
    mesh = generate_mesh(outline, pattern, size)
    with pytest.raises(InputError, match="has no image"):
        node_images(mesh.nodes, find_symmetry([outline, pattern]), 0.1 * size)


@pytest.mark.parametrize("wanted", ["mirror", "rotation"])
def test_the_kind_of_group_can_be_chosen(wanted):
    outline, pattern = SHEET, [star(8)]
    symmetry = find_symmetry([outline, *pattern])
    mesh = symmetric_mesh(outline, pattern, 4e-3, symmetry, wanted=wanted)
    kind = Symmetry(symmetry.centre, 8, None) if wanted == "rotation" else largest(mesh, symmetry)
    check_exact(mesh, kind)
    assert kind.elements == 8
    assert (kind.mirror is None) == (wanted == "rotation")


def test_fine_edges_at_boundaries(sheets):
    outline, pattern, size = sheets["bowl"]
    symmetry = find_symmetry([outline, pattern])
    mesh = symmetric_mesh(outline, [pattern], 1.5 * size, symmetry, boundary_size=0.6 * size)
    quality = mesh_quality(mesh)
    assert quality.min_angle > 25.0
    assert quality.max_edge > 2.0 * quality.mean_edge > 3.0 * quality.min_edge
    check_exact(mesh, symmetry)


def test_the_same_input_gives_the_same_mesh():
    symmetry = find_symmetry([SHEET, pinwheel()])
    first, second = (symmetric_mesh(SHEET, [pinwheel()], 4e-3, symmetry) for _ in range(2))
    assert np.array_equal(first.nodes, second.nodes)
    assert np.array_equal(first.triangles, second.triangles)


SHARP = shapely.Polygon([(0, 0), (0.1, 0.02), (0.1, -0.02)])
BAD = {
    "no symmetry": (SHEET, [random_blot()], 4e-3, {}, "no symmetry in common"),
    "no mirror": (SHEET, [pinwheel()], 4e-3, {"wanted": "mirror"}, "and no mirror"),
    "too sharp": (SHARP, [], 4e-3, {}, r"no symmetric mesh .* Tried a mirror line"),
    "too coarse": (SHEET, [star(6)], 0.08, {}, "no symmetric mesh"),
    "no size": (SHEET, [star(6)], 0.0, {}, "positive length"),
    "pattern outside": (SHEET, [disc(0.06)], 4e-3, {}, "reaches outside"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_meshed_is_refused_in_one_line(name):
    outline, pattern, size, options, text = BAD[name]
    with pytest.raises(InputError, match=text) as caught:
        symmetric_mesh(outline, pattern, size, find_symmetry([outline, *pattern]), **options)
    assert "\n" not in str(caught.value)


def test_a_group_that_the_sheet_has_not_is_refused():
    with pytest.raises(InputError, match="does not have rotations by 180°"):
        symmetric_mesh(BOX, [star(3, length=0.02)], 4e-3, Symmetry((0.0, 0.0), 2, None))


def test_an_empty_outline_has_no_symmetry():
    with pytest.raises(InputError, match="outline is empty"):
        find_symmetry([EMPTY])
