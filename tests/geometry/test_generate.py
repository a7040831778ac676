from __future__ import annotations

import time

import numpy as np
import pytest
import shapely
from shapely import affinity

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.generate import generate_mesh
from sheetmorph.geometry.quality import mesh_quality

NO_PATTERN = shapely.Polygon()
SQUARE = shapely.box(-0.05, -0.05, 0.05, 0.05)
DISC = shapely.Point(0, 0).buffer(0.05, quad_segs=64)
# Counts of the paper's meshes: nodes, edges, triangles.
PAPER = {"bowl": (970, 2800, 1831), "canoe": (1215, 3505, 2291), "petals": (388, 1087, 700)}


def star(tips, outer, inner):
    angle = np.pi * np.arange(2 * tips) / tips
    radius = np.where(np.arange(2 * tips) % 2, inner, outer)
    return shapely.Polygon(np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]))


def spiral():
    t = np.linspace(0, 6 * np.pi, 400)
    radius = 0.005 + 0.002 * t
    return shapely.LineString(np.column_stack([radius * np.cos(t), radius * np.sin(t)]))


def dots():
    places = np.arange(-0.04, 0.041, 0.016)
    return shapely.MultiPolygon(
        [shapely.Point(x, y).buffer(0.003, quad_segs=16) for x in places for y in places]
    )


def stripes(width):
    bars = [shapely.box(x, -0.05, x + width, 0.05) for x in np.arange(-0.045, 0.045, 0.011)]
    return shapely.MultiPolygon(bars)


def rim_length(mesh):
    uses = np.zeros(len(mesh.edges), dtype=int)
    uses[mesh.hinge_edges[:, 0]] = 1
    return mesh.edge_lengths[uses == 0].sum()


def check_conforms(mesh, outline, pattern, size, tolerance):
    """Edges on the boundaries cover them; no triangle is cut by the pattern's boundary."""
    # A triangle shrunk by what a chord may leave its curve lies on one side.
    inside = shapely.contains_xy(pattern, *mesh.triangle_centroids.T)
    assert mesh.triangle_areas[inside].sum() == pytest.approx(pattern.area, rel=tolerance)
    assert mesh.triangle_areas.sum() == pytest.approx(outline.area, rel=tolerance)
    centre = mesh.triangle_centroids[:, None]
    shrunk = centre + 0.6 * (mesh.nodes[mesh.triangles, :2] - centre)
    cut = shapely.intersects(pattern.boundary, shapely.polygons(shrunk))
    assert not cut.any()
    boundary = shapely.union(outline.boundary, pattern.boundary)
    middle = shapely.points(mesh.edge_midpoints)
    ends = shapely.points(mesh.nodes[mesh.edges, :2])
    on_curve = shapely.dwithin(boundary, ends, 1e-6 * size).all(axis=1) & shapely.dwithin(
        boundary, middle, 0.06 * size
    )
    assert mesh.edge_lengths[on_curve].sum() == pytest.approx(boundary.length, rel=0.02)


@pytest.mark.parametrize("name", PAPER)
def test_paper_designs(meshes, sheets, name):
    outline, pattern, size = sheets[name]
    mesh = meshes[name]
    quality = mesh_quality(mesh)
    assert quality.mean_edge == pytest.approx(size, rel=0.025)
    assert quality.min_angle > 38.0
    assert quality.mean_min_angle > 50.0
    assert mesh.counts == pytest.approx(PAPER[name], rel=0.1)
    assert (quality.nodes, quality.edges, quality.triangles) == mesh.counts
    assert rim_length(mesh) == pytest.approx(outline.length, rel=1e-3)
    check_conforms(mesh, outline, pattern, size, 2e-3)


@pytest.mark.parametrize("name", ["canoe", "petals"])
def test_straight_boundaries_are_exact(meshes, sheets, name):
    outline, _, _ = sheets[name]
    mesh = meshes[name]
    assert mesh.triangle_areas.sum() == pytest.approx(outline.area, rel=1e-9)
    corners = shapely.get_coordinates(outline)[:-1]
    distance = np.linalg.norm(mesh.nodes[:, None, :2] - corners, axis=2).min(axis=0)
    assert distance.max() < 1e-11


def test_the_same_input_gives_the_same_mesh(sheets):
    first, second = (generate_mesh(*sheets["petals"]) for _ in range(2))
    assert np.array_equal(first.nodes, second.nodes)
    assert np.array_equal(first.triangles, second.triangles)


def test_quality_is_readable(meshes):
    text = str(mesh_quality(meshes["petals"]))
    assert "smallest angle" in text
    assert "mm" in text


@pytest.mark.parametrize("place", [(0.0, 0.0), (1.0, -3.0)])
@pytest.mark.parametrize("turn", [0.0, 17.0])
def test_moved_sheets_keep_their_quality(sheets, place, turn):
    outline, pattern, size = sheets["petals"]
    move = lambda g: affinity.translate(affinity.rotate(g, turn, origin=(0, 0)), *place)  # noqa: E731
    quality = mesh_quality(generate_mesh(move(outline), move(pattern), size))
    assert quality.min_angle > 30.0
    assert quality.mean_edge == pytest.approx(size, rel=0.05)


# Outline, pattern, size, smallest angle to reach, tolerance of the areas.
PLATE = shapely.box(-0.04, -0.04, 0.04, 0.04)
SHAPES = {
    "disc": (DISC, NO_PATTERN, 5e-3, 40, 2e-3),
    "16-gon with kept corners": (shapely.Point(0, 0).buffer(0.05, 4), NO_PATTERN, 3e-3, 38, 1e-3),
    "hole": (SQUARE.difference(shapely.Point(0.01, 0).buffer(0.012)), NO_PATTERN, 4e-3, 35, 2e-3),
    "hole smaller than an edge": (
        SQUARE.difference(shapely.Point(0.01, 0).buffer(8e-4, 32)), NO_PATTERN, 4e-3, 25, 1e-3,
    ),
    "square hole smaller than an edge": (
        SQUARE.difference(shapely.box(0, 0, 2e-3, 2e-3)), NO_PATTERN, 4e-3, 25, 1e-3,
    ),
    "star": (star(5, 0.05, 0.02), NO_PATTERN, 3e-3, 35, 1e-9),
    "rounded corners": (PLATE.buffer(3e-3), NO_PATTERN, 4e-3, 38, 2e-3),
    "tiny fillets": (PLATE.buffer(5e-4), NO_PATTERN, 4e-3, 38, 2e-3),
    "one row of triangles": (shapely.box(0, 0, 0.2, 0.003), NO_PATTERN, 3e-3, 30, 1e-8),
    "stripes": (SQUARE, stripes(0.005), 3e-3, 30, 1e-8),
    "narrow stripes": (SQUARE, stripes(0.0018), 3e-3, 25, 1e-8),
    "ring": (DISC, DISC.buffer(-0.01).difference(DISC.buffer(-0.017)), 3e-3, 35, 2e-3),
    "spiral": (DISC, spiral().buffer(2.5e-3), 2.5e-3, 35, 3e-3),
    "dots": (SQUARE, dots(), 3e-3, 28, 8e-2),
    "pattern is the sheet": (SQUARE, SQUARE, 5e-3, 38, 1e-8),
    "pattern is half the sheet": (SQUARE, shapely.box(-0.05, -0.05, 0, 0.05), 5e-3, 38, 1e-8),
    "lens": (
        SQUARE,
        shapely.Point(-0.03, 0).buffer(0.04, 64) & shapely.Point(0.03, 0).buffer(0.04, 64),
        3e-3, 35, 5e-3,
    ),
    "gap of 50 µm to the rim": (SQUARE, shapely.box(-0.04995, -0.02, 0.02, 0.02), 4e-3, 35, 2e-3),
    "overhang of rounding": (SQUARE, shapely.box(-0.05 - 1e-9, -0.02, 0.02, 0.02), 4e-3, 35, 1e-6),
}  # fmt: skip


@pytest.mark.parametrize("name", SHAPES)
def test_shapes(name):
    outline, pattern, size, smallest, tolerance = SHAPES[name]
    mesh = generate_mesh(outline, pattern, size)
    quality = mesh_quality(mesh)
    assert quality.min_angle > smallest
    assert quality.mean_edge == pytest.approx(size, rel=0.05)
    inside = shapely.contains_xy(pattern, *mesh.triangle_centroids.T)
    assert mesh.triangle_areas.sum() == pytest.approx(outline.area, rel=tolerance)
    assert mesh.triangle_areas[inside].sum() == pytest.approx(pattern.area, rel=tolerance)


@pytest.mark.parametrize("angle", [10, 20, 40])
def test_a_sharp_corner_of_the_sheet_limits_only_its_own_triangles(angle):
    height = 0.1 * np.tan(np.radians(angle))
    outline = shapely.Polygon([(0, 0), (0.1, 0), (0.1, height)])
    mesh = generate_mesh(outline, NO_PATTERN, 4e-3)
    angles = np.degrees(mesh.minimum_angles)
    tip = np.linalg.norm(mesh.triangle_centroids, axis=1) < 0.02
    assert angles.min() > 0.9 * angle
    assert angles[~tip].min() > 25.0
    assert mesh.triangle_areas.sum() == pytest.approx(outline.area, rel=1e-9)


def test_checkerboard_whose_squares_touch_at_corners():
    squares = [
        shapely.box(i, j, i + 1, j + 1) for i in range(6) for j in range(6) if (i + j) % 2 == 0
    ]
    pattern = affinity.scale(shapely.union_all(squares), 0.01, 0.01, origin=(0, 0))
    mesh = generate_mesh(shapely.box(0, 0, 0.06, 0.06), pattern, 4e-3)
    inside = shapely.contains_xy(pattern, *mesh.triangle_centroids.T)
    assert mesh.triangle_areas[inside].sum() == pytest.approx(pattern.area, rel=1e-8)
    assert mesh_quality(mesh).min_angle > 35.0


def test_symmetric_counts_for_a_symmetric_sheet(meshes):
    mesh = meshes["bowl"]
    for sign in ([-1, 1], [1, -1]):
        mirrored = mesh.nodes[:, :2] * sign
        gap = np.linalg.norm(mesh.nodes[:, None, :2] - mirrored, axis=2).min(axis=0)
        assert np.median(gap) < 0.05 * mesh.mean_edge_length


NOT_FINITE = shapely.transform(SQUARE, lambda xy: np.where(xy > 0, np.inf, xy))
BOWTIE = shapely.Polygon([(0, 0), (0.1, 0.1), (0.1, 0), (0, 0.1)])
BAD = {
    "empty outline": (NO_PATTERN, NO_PATTERN, 1e-3, "outline is empty"),
    "outline is a line": (shapely.LineString([(0, 0), (1, 1)]), NO_PATTERN, 1e-3, "be a polygon"),
    "outline is no shape": ("disc", NO_PATTERN, 1e-3, "be a polygon"),
    "outline in two parts": (
        shapely.MultiPolygon([SQUARE, affinity.translate(SQUARE, 1)]),
        NO_PATTERN, 1e-3, "be a polygon",
    ),
    "outline crosses itself": (BOWTIE, NO_PATTERN, 1e-3, "not a valid polygon: Self-intersection"),
    "outline not finite": (NOT_FINITE, NO_PATTERN, 1e-3, "not a finite number"),
    "pattern crosses itself": (SQUARE, BOWTIE, 5e-3, "pattern is not a valid polygon"),
    "pattern is a point": (SQUARE, shapely.Point(0, 0), 5e-3, "pattern must be a polygon"),
    "pattern outside": (SQUARE, affinity.translate(SQUARE, 0.01), 5e-3, "reaches outside"),
    "pattern elsewhere": (SQUARE, affinity.translate(SQUARE, 1), 5e-3, "reaches outside"),
    "size zero": (SQUARE, NO_PATTERN, 0.0, "positive length"),
    "size negative": (SQUARE, NO_PATTERN, -1.0, "positive length"),
    "size not a number": (SQUARE, NO_PATTERN, float("nan"), "positive length"),
    "size infinite": (SQUARE, NO_PATTERN, float("inf"), "positive length"),
    "size too large": (SQUARE, NO_PATTERN, 0.2, "too large for the outline"),
    "size too large for a strip": (shapely.box(0, 0, 1, 1e-3), NO_PATTERN, 2e-3, "too large"),
    "too many nodes": (SQUARE, NO_PATTERN, 1e-5, "at most 500000 nodes"),
    "slit": (SQUARE.difference(shapely.box(-0.03, -3e-4, 0.03, 3e-4)), NO_PATTERN, 4e-3, "hole"),
    "thin stripes": (SQUARE, stripes(5e-4), 3e-3, "pattern is only about 0.498 mm wide"),
    "thin gap": (SQUARE, shapely.box(-0.0495, -0.02, 0.02, 0.02), 4e-3, "film beside the pattern"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_refused_in_one_line(name):
    outline, pattern, size, text = BAD[name]
    with pytest.raises(InputError, match=text) as caught:
        generate_mesh(outline, pattern, size)
    assert "\n" not in str(caught.value)


def test_the_advised_size_works():
    outline = SQUARE.difference(shapely.box(-0.03, -6e-4, 0.03, 6e-4))
    with pytest.raises(InputError) as caught:
        generate_mesh(outline, NO_PATTERN, 4e-3)
    advised = float(str(caught.value.allowed).split()[2]) * 1e-3
    assert generate_mesh(outline, NO_PATTERN, 0.98 * advised).counts[0] > 100


@pytest.mark.slow
def test_a_hundred_thousand_nodes(sheets):
    name = "canoe"
    outline, pattern, size = sheets[name]
    size *= np.sqrt(PAPER[name][0] / 100_000)
    start = time.perf_counter()
    mesh = generate_mesh(outline, pattern, size)
    assert time.perf_counter() - start < 20.0
    quality = mesh_quality(mesh)
    assert quality.nodes == pytest.approx(1e5, rel=0.1)
    assert quality.min_angle > 35.0
    assert quality.mean_min_angle > 58.0


@pytest.mark.slow
@pytest.mark.parametrize("name", PAPER)
@pytest.mark.parametrize("factor", [0.5, 0.6, 0.7, 0.8, 0.9, 1.1, 1.2, 1.35])
def test_any_size_gives_good_angles(sheets, name, factor):
    outline, pattern, size = sheets[name]
    quality = mesh_quality(generate_mesh(outline, pattern, factor * size))
    assert quality.min_angle > 28.0
    assert quality.mean_edge == pytest.approx(factor * size, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [24, 52, 129, 383])
def test_overlapping_shapes_are_meshed_whatever_their_crossings(seed):
    """Random discs, rings and bars: crossings at any angle, near misses, cusps at the rim."""
    rng = np.random.default_rng(seed)
    outline = affinity.rotate(shapely.box(-0.05, -0.03, 0.05, 0.03), rng.uniform(0, 90))
    outline = outline.difference(shapely.Point(rng.uniform(-0.02, 0.02), 0).buffer(0.008))
    parts = []
    for _ in range(5):
        x, y = rng.normal(size=2) * 0.02
        disc = shapely.Point(x, y).buffer(rng.uniform(0.008, 0.02))
        bar = shapely.box(-0.03, -0.003, 0.03, 0.003)
        bar = affinity.translate(affinity.rotate(bar, rng.uniform(0, 180)), x, y)
        parts += [disc.difference(disc.buffer(-0.004)), bar][: 1 + int(rng.integers(2))]
    pattern = shapely.unary_union(parts).intersection(outline)
    mesh = generate_mesh(outline, pattern, 2.5e-3)
    inside = shapely.contains_xy(pattern, *mesh.triangle_centroids.T)
    assert mesh.triangle_areas[inside].sum() == pytest.approx(pattern.area, rel=0.03)
    assert mesh.mean_edge_length == pytest.approx(2.5e-3, rel=0.05)
    assert np.median(np.degrees(mesh.minimum_angles)) > 45.0
