"""Several regions at once, and meshes whose edges grow away from them."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import affinity

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.generate import generate_mesh

SHEET = shapely.box(-0.05, -0.05, 0.05, 0.05)
DISC = shapely.Point(0, 0).buffer(0.05, 64)
NOTHING = shapely.Polygon()
SIZE = 3e-3


def disc(radius, x=0.0, y=0.0):
    return shapely.Point(x * 1e-3, y * 1e-3).buffer(radius * 1e-3, 32)


def box(*bounds):
    return shapely.box(*(1e-3 * np.array(bounds, float)).tolist())


def star(width):
    bars = [affinity.rotate(box(0, -width / 2, 45, width / 2), 60 * k, (0, 0)) for k in range(6)]
    return shapely.union_all(bars)


# outline, regions, smallest angle
REGIONS = {
    "star, ring and hub": (DISC, [star(6), disc(30) - disc(22), disc(12)], 28),
    "nested": (DISC, [disc(40), disc(28), disc(15)], 35),
    "side by side": (SHEET, [box(-30, -20, 0, 20), box(0, -20, 30, 20)], 35),
    "touching at a corner": (SHEET, [box(-30, -20, 0, 0), box(0, 0, 30, 20)], 35),
    "crossing bars": (SHEET, [box(-50, -4, 50, 4), box(-4, -50, 4, 50)], 35),
    "a gap of rounding": (SHEET, [box(-30, -20, 0, 20), box(1e-7, -20, 30, 20)], 35),
    "a long gap of 0.1 mm": (SHEET, [box(-30, -45, 0, 45), box(0.1, -45, 30, 45)], 35),
    "a long overlap of 0.1 mm": (SHEET, [box(-30, -45, 0, 45), box(-0.1, -45, 30, 45)], 35),
    "overlapping discs": (SHEET, [disc(20, -8), disc(20, 8), disc(20, 0, 14)], 25),
    "the same twice": (DISC, [star(6), star(6)], 35),
    "one is empty": (DISC, [NOTHING, disc(20)], 35),
    "one covers the sheet": (SHEET, [SHEET, disc(20)], 35),
}


@pytest.mark.parametrize("name", REGIONS)
def test_the_mesh_follows_every_region(name):
    outline, regions, smallest = REGIONS[name]
    mesh = generate_mesh(outline, regions, SIZE)
    assert np.degrees(mesh.minimum_angles.min()) > smallest
    assert mesh.triangle_areas.sum() == pytest.approx(outline.area, rel=3e-3)
    assert mesh.mean_edge_length == pytest.approx(SIZE, rel=0.05)
    for region in regions:
        inside = shapely.contains_xy(region, *mesh.triangle_centroids.T)
        covered = shapely.union_all(shapely.polygons(mesh.nodes[mesh.triangles[inside], :2]))
        wrong = shapely.symmetric_difference(covered, region).area
        assert wrong <= 0.03 * SIZE * region.length


def test_a_sequence_of_one_is_the_same_as_one():
    one, other = generate_mesh(DISC, star(6), SIZE), generate_mesh(DISC, [star(6)], SIZE)
    assert np.array_equal(one.nodes, other.nodes)
    assert np.array_equal(one.triangles, other.triangles)


def test_a_thin_gap_between_regions_is_an_error_with_its_place():
    regions = [box(-30, -45, 0, 45), box(0.7, -45, 30, 45)]
    with pytest.raises(InputError, match=r"film is only about 0\.6.* wide near \(0\.35, "):
        generate_mesh(SHEET, regions, SIZE)


@pytest.mark.parametrize("ratio", [0.25, 0.5, 0.9])
def test_edges_grow_away_from_the_boundaries(ratio):
    size, pattern = 5e-3, disc(10, -25, 10)
    first, second = (
        generate_mesh(SHEET, pattern, size, boundary_size=ratio * size) for _ in range(2)
    )
    assert np.array_equal(first.nodes, second.nodes)
    assert np.array_equal(first.triangles, second.triangles)
    distance = shapely.distance(pattern.boundary, shapely.points(first.edge_midpoints))
    ends = shapely.dwithin(pattern.boundary, shapely.points(first.nodes[first.edges, :2]), 1e-8)
    on = ends.all(axis=1) & (distance < 0.1 * ratio * size)
    far = ratio * size + 0.3 * distance > 1.2 * size
    assert np.median(first.edge_lengths[on]) == pytest.approx(ratio * size, rel=0.25)
    assert np.median(first.edge_lengths[far]) == pytest.approx(size, rel=0.2)
    wanted = np.minimum(size, ratio * size + 0.3 * distance)
    assert np.median(first.edge_lengths / wanted) == pytest.approx(1.0, rel=0.1)
    assert np.degrees(first.minimum_angles.min()) > 30.0


def test_growth_is_faster_with_a_larger_growth():
    counts = [
        generate_mesh(SHEET, disc(10), 5e-3, boundary_size=1e-3, growth=growth).counts[0]
        for growth in (0.15, 0.3, 0.6)
    ]
    assert counts[0] > 1.2 * counts[1] > 1.2**2 * counts[2]


def test_grading_with_regions_and_the_smallest_boundary_size():
    mesh = generate_mesh(DISC, [disc(20), disc(10, 15)], 4e-3, boundary_size=4e-3 / 20)
    assert np.degrees(mesh.minimum_angles.min()) > 25.0
    assert mesh.edge_lengths.max() < 8e-3
    assert mesh.triangle_areas.sum() == pytest.approx(DISC.area, rel=3e-3)


BAD = {
    "too small": ({"boundary_size": 0.1e-3}, r"0\.15 mm to 3 mm"),
    "too large": ({"boundary_size": 4e-3}, r"got '4 mm'.*0\.15 mm to 3 mm"),
    "zero": ({"boundary_size": 0.0}, "boundaries of the pattern"),
    "no number": ({"boundary_size": "1 mm"}, "boundaries of the pattern"),
    "not finite": ({"boundary_size": float("nan")}, "boundaries of the pattern"),
    "growth zero": ({"boundary_size": 1e-3, "growth": 0.0}, r"growth .*0\.05 to 1"),
    "growth not finite": ({"boundary_size": 1e-3, "growth": float("inf")}, "growth"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_sizes_are_refused(name):
    options, text = BAD[name]
    with pytest.raises(InputError, match=text) as caught:
        generate_mesh(DISC, disc(10), SIZE, **options)
    assert "\n" not in str(caught.value)


def test_too_many_nodes_are_refused_before_meshing():
    dots = shapely.union_all(
        [box(x, y, x + 2, y + 2) for x in range(-45, 45, 3) for y in range(-45, 45, 3)]
    )
    with pytest.raises(InputError, match="at most 500000 nodes"):
        generate_mesh(SHEET, dots, 1.5e-3, boundary_size=0.08e-3, growth=0.1)


def spread(mesh, line):
    xy = mesh.nodes[:, :2]
    on = shapely.dwithin(line, shapely.points(xy), 1e-9)
    return np.sort(np.linalg.norm(xy[on], axis=1))


@pytest.mark.parametrize("options", [{}, {"boundary_size": 1e-3}])
@pytest.mark.parametrize("first", [0.0, 0.3])
def test_locked_lines_get_congruent_nodes(first, options):
    """The sides of a fifth of a sheet whose pattern is the same after each fifth of a turn."""
    bent = shapely.union(box(12, -2, 40, 2), box(36, -2, 40, 13))
    pattern = shapely.union_all([affinity.rotate(bent, 72 * k, (0, 0)) for k in range(5)])
    sheet = shapely.Point(0, 0).buffer(0.05, 75)
    rays = [0.2 * np.array([np.cos(a), np.sin(a)]) for a in (first, first + 0.4 * np.pi)]
    wedge = sheet & shapely.Polygon([(0, 0), rays[0], 1.5 * (rays[0] + rays[1]), rays[1]])
    lines = [shapely.LineString([(0, 0), ray]) & sheet for ray in rays]
    locked = shapely.MultiLineString(lines)
    mesh = generate_mesh(wedge, pattern & wedge, SIZE, locked=locked, **options)
    one, other = (spread(mesh, line) for line in lines)
    assert len(one) == len(other) > 12
    np.testing.assert_allclose(one, other, atol=1e-9)
