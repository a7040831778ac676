"""The profile in its limits, distances, and which parts of a mesh lie in the pattern."""

from __future__ import annotations

from decimal import Decimal, getcontext

import numpy as np
import pytest
import shapely

from sheetmorph.core.errors import InputError
from sheetmorph.design.actuation import edge_distance, profile, thermal_strain
from sheetmorph.design.distance import contains, distance_to_boundary, signed_distance
from sheetmorph.design.laminate import LayerStack
from sheetmorph.design.regions import Cell, classify, regions

S = np.array([0.0, 1e-9, 0.1, 0.5, 0.9, 1.0])


def exact(s: float, gamma: float) -> float:
    getcontext().prec = 60
    g = Decimal(gamma)
    return float((1 - (-g * Decimal(s)).exp()) / (1 - (-g).exp()))


@pytest.mark.parametrize("gamma", [1e-12, 1e-6, 0.01, 1.0, 3.0, 40.0, 700.0, 1e4, 1e6])
def test_exponential_profile_is_accurate(gamma):
    expected = [exact(s, gamma) for s in S]
    assert profile(S, "exponential", gamma) == pytest.approx(expected, rel=1e-14, abs=0)


def test_limits_of_gamma():
    assert np.array_equal(profile(S, "exponential", 0.0), S)
    assert np.array_equal(profile(S, "linear"), S)
    assert profile(S, "exponential", 1e-300) == pytest.approx(S, rel=1e-15)
    assert profile(S, "exponential", 1e12) == pytest.approx(profile(S, "step"), rel=1e-12)
    assert np.array_equal(profile(S, "step"), [0, 1, 1, 1, 1, 1])


@pytest.mark.parametrize("gamma", [1e-12, 1.0, 1e6])
def test_profile_runs_from_zero_to_one_and_never_falls(gamma):
    values = profile(np.linspace(0, 1, 1001), "exponential", gamma)
    assert values[0] == 0
    assert values[-1] == 1
    assert (np.diff(values) >= 0).all()


def test_regions_by_midpoint_centroid_and_position(design, strip):
    region = regions(design, strip)
    mid, centre, node = strip.edge_midpoints, strip.triangle_centroids, strip.nodes[:, :2]
    for points, got in (
        (mid, region.edge_in_pattern),
        (centre, region.triangle_in_pattern),
        (node, region.node_in_pattern),
    ):
        inside = (np.abs(points[:, 0]) <= 0.01 + 1e-12) & (np.abs(points[:, 1]) <= 0.003 + 1e-12)
        assert np.array_equal(got, inside)
    assert np.array_equal(region.hinge_cell > 0, region.edge_in_pattern[strip.hinge_edges[:, 0]])


def two_cells(area):
    film = LayerStack.of(())
    return Cell((), shapely.Polygon(), film), Cell(("pattern",), area, film)


def test_the_boundary_of_the_pattern_belongs_to_it(grid):
    mesh = grid(0.01, 0.01, 0.001)
    square = shapely.box(-0.003, -0.003, 0.003, 0.003)
    region = classify(mesh, two_cells(square))
    on_edge = np.isclose(np.abs(mesh.edge_midpoints).max(axis=1), 0.003, rtol=0, atol=1e-12)
    assert on_edge.any()
    assert region.edge_in_pattern[on_edge].all()


def test_an_empty_pattern_holds_nothing(strip):
    region = classify(strip, two_cells(shapely.MultiPolygon()))
    assert not region.edge_in_pattern.any()
    assert not region.node_in_pattern.any()


def test_distance_to_bilayer_edges_is_that_to_the_nearest_midpoint(design, strip):
    region = regions(design, strip)
    distances, farthest = edge_distance(design, strip, region)
    inside = region.edge_in_pattern
    mid = strip.edge_midpoints
    gaps = np.linalg.norm(mid[:, None] - mid[None, inside], axis=2).min(axis=1)
    assert distances == pytest.approx(np.where(inside, 0.0, gaps), rel=1e-12, abs=1e-15)
    assert farthest == distances.max()
    strain = thermal_strain(design, strip, region)
    assert strain.min() == pytest.approx(-0.3, rel=1e-14)
    assert (strain[inside] == 0).all()
    assert (strain[~inside] < 0).all()


def test_distance_to_the_pattern_boundary_does_not_depend_on_the_mesh(design, grid):
    design = design.with_values({"actuation.distance": "pattern_boundary"})
    for step in (0.002, 0.001):
        mesh = grid(0.04, 0.02, step)
        region = regions(design, mesh)
        distances, farthest = edge_distance(design, mesh, region)
        beyond = np.maximum(np.abs(mesh.edge_midpoints) - [0.01, 0.003], 0.0)
        assert distances == pytest.approx(np.linalg.norm(beyond, axis=1), rel=1e-9, abs=1e-12)
        # The corner of the sheet: 10 mm past the bar's end, 7 mm past its side.
        assert farthest == pytest.approx(np.hypot(0.010, 0.007), rel=1e-9)


def test_profiles_reach_the_strain(design, strip):
    region = regions(design, strip)
    linear = thermal_strain(design, strip, region)
    outside = ~region.edge_in_pattern
    step = thermal_strain(design.with_values({"actuation.profile": "step"}), strip, region)
    assert set(step[outside]) == {-0.3}
    steep = design.with_values({"actuation.profile": "exponential", "actuation.gamma": 3.0})
    strain = thermal_strain(steep, strip, region)
    assert (strain[outside] <= linear[outside] + 1e-15).all()


def test_without_a_pattern_the_strain_is_uniform(design, strip):
    design = design.with_values({"pattern": [], "layers.1": None})
    strain = thermal_strain(design, strip, regions(design, strip))
    assert set(strain) == {-0.3}


def test_a_pattern_too_fine_for_the_mesh(design, grid):
    design = design.with_values(
        {
            "pattern.0.half_width": "0.1 mm",
            "pattern.0.start": '["-10 mm", "0.3 mm"]',
            "pattern.0.end": '["10 mm", "0.3 mm"]',
        }
    )
    mesh = grid(0.04, 0.02, 0.002)
    with pytest.raises(InputError, match="no edge of the mesh has its midpoint in the pattern"):
        thermal_strain(design, mesh, regions(design, mesh))


def test_distances_of_points():
    ring = shapely.box(-2, -2, 2, 2).difference(shapely.box(-1, -1, 1, 1))
    points = np.array([[0.0, 0.0], [1.5, 0.0], [5.0, 0.0], [5.0, 6.0], [2.0, 0.0]])
    assert distance_to_boundary(ring, points) == pytest.approx([1, 0.5, 3, 5, 0])
    assert signed_distance(ring, points) == pytest.approx([1, -0.5, 3, 5, 0])
    assert contains(ring, points, 1e-9).tolist() == [False, True, False, False, True]
