"""Many patterns: every one must give good triangles that fit, the same ones every time."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import shapely
from shapely import affinity

from sheetmorph.geometry.generate import generate_mesh

SMALLEST = 25.0  # deg
SHARP = 30.0  # deg; corners of the drawing below this limit the triangles that touch them


def turned(shape, count, first=0.0):
    return [affinity.rotate(shape, first + 360 * k / count, origin=(0, 0)) for k in range(count)]


def disc(radius, x=0.0, y=0.0):
    return shapely.Point(x, y).buffer(radius, quad_segs=48)


def star(arms, width, length=44, fillet=0.0, centre=0.0, first=0.0):
    bar = shapely.box(0, -width / 2, length, width / 2)
    shape = shapely.union_all([*turned(bar, arms, first), disc(max(centre, 0.1))])
    if fillet:
        shape = shape.buffer(fillet).buffer(-2 * fillet).buffer(fillet)
    return shape


def twin_star(arms, width, apart):
    one = star(arms, width, 30)
    bridge = shapely.box(-apart, -width / 2, apart, width / 2)
    return shapely.union_all(
        [affinity.translate(one, -apart), affinity.translate(one, apart), bridge]
    )


def chamfered_cross(arms, width, length=42):
    half = width / 2
    arm = shapely.Polygon(
        [(0, -half), (length - half, -half), (length, 0), (length - half, half), (0, half)]
    )
    return shapely.union_all(turned(arm, arms))


def lotus(petals, width, radius=9):
    petal = affinity.translate(affinity.scale(disc(1), 17, width), 26)
    return shapely.union_all([disc(radius), *turned(petal, petals)])


def rings(radii, width):
    return shapely.union_all([disc(r + width / 2) - disc(r - width / 2) for r in radii])


def stripes(width, gap, angle=0.0, reach=80):
    starts = np.arange(-reach, reach, width + gap)
    bars = [shapely.box(-reach, y, reach, y + width) for y in starts]
    return affinity.rotate(shapely.union_all(bars), angle, origin=(0, 0))


def grid(width, gap, angle=0.0, skew=90.0, reach=80):
    return shapely.union(
        stripes(width, gap, angle, reach), stripes(width, gap, angle + skew, reach)
    )


def spiral(width, pitch, turns=2.5, start=8.0):
    t = np.linspace(0, 2 * np.pi * turns, 400)
    r = start + pitch * t / (2 * np.pi)
    line = shapely.LineString(np.column_stack([r * np.cos(t), r * np.sin(t)]))
    return line.buffer(width / 2, quad_segs=16)


def honeycomb(cell, wall, angle=0.0):
    corner = np.pi / 3 * np.arange(6) + np.pi / 6
    radius = (cell - wall) / np.sqrt(3)
    hexagon = shapely.Polygon(radius * np.column_stack([np.cos(corner), np.sin(corner)]))
    holes = [
        affinity.translate(hexagon, cell * (i + j / 2), cell * j * np.sqrt(0.75))
        for i in range(-9, 10)
        for j in range(-6, 7)
    ]
    return affinity.rotate(disc(46) - shapely.union_all(holes), angle, origin=(0, 0))


def ribs(seed, count, width):
    """Straight ribs at random, with gaps of at least 3 mm between those that do not cross."""
    rng = np.random.default_rng(seed)
    chosen = []
    while len(chosen) < count:
        x, y = rng.uniform(-30, 30, 2)
        angle = rng.uniform(0, 180)
        half = rng.uniform(12, 35)
        bar = shapely.box(-half, -width / 2, half, width / 2)
        bar = affinity.translate(affinity.rotate(bar, angle, origin=(0, 0)), x, y)
        crossing = [
            (abs((angle - other + 90) % 180 - 90), bar.distance(shape)) for other, shape in chosen
        ]
        if all(gap >= 3 or (gap == 0 and turn > 40) for turn, gap in crossing):
            chosen.append((angle, bar))
    return shapely.union_all([shape for _, shape in chosen])


RECTANGLE = shapely.box(-55, -40, 55, 40)
ROUNDED = shapely.box(-45, -35, 45, 35).buffer(8, quad_segs=16)
HEXAGON = shapely.Polygon(
    52 * np.column_stack([np.cos(np.arange(6) * np.pi / 3), np.sin(np.arange(6) * np.pi / 3)])
)
DISC = disc(50)
HOLED = DISC - disc(6)
PUNCHED = RECTANGLE - shapely.union_all(
    [disc(4, -45, 30), disc(4, 45, 30), shapely.box(35, -34, 47, -24)]
)

# name → outline, pattern [mm], mesh size [mm]
ZOO = {f"star {n}": (DISC, star(n, 5, centre=1.2 * n), 3.0) for n in range(3, 13)}
ZOO |= {
    f"filleted star {n}": (HEXAGON, star(n, 4.5, 42, fillet=1.5, centre=n), 2.7)
    for n in (3, 5, 6, 8, 11)
}
ZOO |= {f"chamfered cross {n}": (DISC, chamfered_cross(n, 8), 3.3) for n in (3, 4, 5, 6)}
ZOO |= {
    f"lotus {n}": (DISC, lotus(n, w, r), 2.8) for n, w, r in ((4, 8, 11), (6, 6, 12), (8, 5, 13))
}
ZOO |= {
    "plain star without hub": (DISC, star(6, 8), 3.2),
    "star to the rim": (DISC, star(5, 6, 80) & DISC, 3.0),
    "star on a hole": (HOLED, star(7, 4, 40) & HOLED, 2.5),
    "twin star": (shapely.box(-75, -45, 75, 45), twin_star(6, 5.6, 28), 4.0),
    "twin star of five": (shapely.box(-70, -45, 70, 45), twin_star(5, 4, 27), 2.6),
    "ring": (ROUNDED, rings([25], 7), 3.0),
    "concentric rings": (DISC, rings([12, 22, 33, 43], 4), 2.7),
    "rings around a hole": (HOLED, rings([14, 24, 35], 5) & HOLED, 3.0),
    "stripes": (RECTANGLE, stripes(5, 4.1, 0, 83) & RECTANGLE, 3.0),
    "slanted stripes": (ROUNDED, stripes(4, 5, 35) & ROUNDED, 2.5),
    "stripes on a disc": (DISC, stripes(6, 3, 10) & DISC, 3.0),
    "stripes on a hexagon": (HEXAGON, stripes(7, 4, 60) & HEXAGON, 4.0),
    "grid": (RECTANGLE, grid(4, 8, 0, 90, 81) & RECTANGLE, 2.5),
    "slanted grid": (DISC, grid(5, 9, 20) & DISC, 3.0),
    "skewed grid": (HEXAGON, grid(4, 9, 10, 60) & HEXAGON, 2.6),
    "grid with holes": (PUNCHED, grid(4, 9, 45) & PUNCHED, 2.5),
    "spiral": (DISC, spiral(5, 13), 2.5),
    "narrow spiral": (DISC, spiral(4, 8.5, 4), 3.0),
    "wide spiral": (ROUNDED, spiral(8, 14, 1.7), 3.5),
    "honeycomb": (DISC, honeycomb(16, 4), 2.5),
    "turned honeycomb": (HEXAGON, honeycomb(20, 5, 13) & HEXAGON.buffer(-3), 3.0),
    "random ribs 1": (RECTANGLE, ribs(1, 6, 4) & RECTANGLE, 2.5),
    "random ribs 2": (DISC, ribs(2, 7, 5) & DISC, 3.0),
    "random ribs 3": (PUNCHED, ribs(3, 6, 6) & PUNCHED, 3.5),
    "random ribs 4": (HEXAGON, ribs(4, 6, 8) & HEXAGON, 4.0),
}
FAST = ("star 5", "chamfered cross 4", "lotus 6", "star on a hole", "skewed grid", "random ribs 2")


def cases(names, fast):
    return [name if name in fast else pytest.param(name, marks=pytest.mark.slow) for name in names]


def millimetres(shape):
    return affinity.scale(shape, 1e-3, 1e-3, origin=(0, 0))


def sharp_corners(*shapes):
    """Places where lines of a drawing meet below `SHARP`: at a vertex of the noded lines."""
    lines = shapely.union_all([shape.boundary for shape in shapes if not shape.is_empty])
    ends = np.array(
        [
            pair
            for part in shapely.get_parts(shapely.node(lines))
            for line in [shapely.get_coordinates(part.simplify(1e-6))]
            for pair in itertools.pairwise(line)
        ]
    )
    both = np.concatenate([ends, ends[:, ::-1]])
    places, owner = np.unique(np.round(both[:, 0], 8), axis=0, return_inverse=True)
    step = both[:, 1] - both[:, 0]
    heading = np.degrees(np.arctan2(step[:, 1], step[:, 0]))
    order = np.lexsort((heading, owner))
    heading, owner = heading[order], owner[order]
    first = np.flatnonzero(np.diff(owner, prepend=-1))
    following = np.arange(1, len(owner) + 1)
    following[np.append(first[1:], len(owner)) - 1] = first
    between = (heading[following] - heading) % 360.0
    return places[np.unique(owner[(between > 1e-6) & (between < SHARP)])]


def smallest_angle(mesh, *shapes):
    """Smallest angle [deg] of the triangles that touch no sharp corner of the drawing."""
    angles = np.degrees(mesh.minimum_angles)
    sharp = sharp_corners(*shapes)
    if len(sharp):
        reach = 0.4 * mesh.mean_edge_length
        corners = shapely.points(mesh.nodes[:, :2])
        near = shapely.dwithin(shapely.multipoints(sharp), corners, reach)
        angles = angles[~near[mesh.triangles].any(axis=1)]
    return angles.min()


def check_areas(mesh, outline, regions, size):
    """Areas by region, and what triangles of one side cover on the other.

    A chord leaves its curve by at most 5 % of the size.
    """
    assert mesh.triangle_areas.sum() == pytest.approx(
        outline.area, abs=0.05 * size * outline.length
    )
    for region in regions:
        inside = shapely.contains_xy(region, *mesh.triangle_centroids.T)
        area = mesh.triangle_areas[inside].sum()
        assert area == pytest.approx(region.area, abs=0.05 * size * region.length)
        covered = shapely.union_all(shapely.polygons(mesh.nodes[mesh.triangles[inside], :2]))
        wrong = shapely.symmetric_difference(covered, region)
        assert wrong.area < 0.03 * size * region.length
        assert shapely.area(shapely.get_parts(wrong)).max(initial=0.0) < 0.3 * size**2


@pytest.mark.parametrize("name", cases(ZOO, FAST))
def test_zoo(name):
    outline, pattern, size = ZOO[name]
    outline, pattern = millimetres(outline), millimetres(pattern)
    mesh = generate_mesh(outline, pattern, 1e-3 * size)
    assert smallest_angle(mesh, outline, pattern) >= SMALLEST
    assert mesh.mean_edge_length == pytest.approx(1e-3 * size, rel=0.06)
    check_areas(mesh, outline, [pattern], 1e-3 * size)


@pytest.mark.parametrize("name", ["lotus 6", "skewed grid"])
def test_the_same_input_gives_the_same_bits(name):
    outline, pattern, size = ZOO[name]
    outline, pattern = millimetres(outline), millimetres(pattern)
    one, other = (generate_mesh(outline, [pattern], 1e-3 * size) for _ in range(2))
    assert np.array_equal(one.nodes, other.nodes)
    assert np.array_equal(one.triangles, other.triangles)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["star 5", "lotus 4", "concentric rings", "spiral", "twin star"])
def test_graded_zoo(name):
    outline, pattern, size = ZOO[name]
    outline, pattern, size = millimetres(outline), millimetres(pattern), 1.5e-3 * size
    mesh = generate_mesh(outline, pattern, size, boundary_size=0.3 * size)
    assert smallest_angle(mesh, outline, pattern) >= SMALLEST
    check_areas(mesh, outline, [pattern], 0.3 * size)
    on = shapely.dwithin(pattern.boundary, shapely.points(mesh.nodes[mesh.edges, :2]), 1e-8)
    middle = shapely.points(mesh.edge_midpoints)
    on = on.all(axis=1) & shapely.dwithin(pattern.boundary, middle, 0.03 * size)
    assert np.median(mesh.edge_lengths[on]) == pytest.approx(0.3 * size, rel=0.25)
    far = 0.3 * size + 0.3 * shapely.distance(pattern.boundary, middle) > 1.1 * size
    if far.sum() > 50:
        assert np.median(mesh.edge_lengths[far]) == pytest.approx(size, rel=0.2)
