"""Stack formulas against numbers worked by hand, and equal layers against one layer."""

from __future__ import annotations

import numpy as np
import pytest

from sheetmorph.design.laminate import (
    LayerStack,
    film_stack,
    mean_edge_length,
    published_stiffness,
    stack_of,
    total_mass,
)
from sheetmorph.design.regions import regions
from sheetmorph.design.spec import Design


def stack(*layers: tuple[float, float, float, float]) -> LayerStack:
    return LayerStack(*np.array(layers, dtype=float).T, *2 * [np.arange(len(layers)) == 0])


# By hand, in MPa and mm, with Y1 = 0.8911/(1 - 0.33^2) = 0.8911/0.8911 = 1 and Y2 = 3:
#   film, all designs: D = 1 * 0.3^3/12 = 0.00225 MPa mm^3 = 2.25e-6 N m
#   A (0.3 + 0.7): y = 0.15, 0.65; weights 0.3, 2.1; neutral = (0.045 + 1.365)/2.4 = 0.5875
#     D = 0.00225 + 0.3*0.4375^2 + 3*(0.343/12 + 0.7*0.0625^2)
#       = 0.00225 + 0.057421875 + 0.08575 + 0.008203125 = 0.153625
#   B (0.3 + 0.6): y = 0.15, 0.60; weights 0.3, 1.8; neutral = 1.125/2.1 = 15/28
#     D = 0.00225 + 0.3*(27/70)^2 + 3*(0.018 + 0.6*(9/140)^2)
#       = 0.05625 + 255.15/4900 = 0.108321428571...
#   C (0.3 + 1.0): y = 0.15, 0.80; weights 0.3, 3.0; neutral = 2.445/3.3 = 0.7409090...
#     D = 0.00225 + 0.3*(13/22)^2 + 3*(1/12 + (1.3/22)^2)
#       = 0.25225 + (50.7 + 5.07)/484 = 0.367477272727...
# k_s = 0.8660254037844386 * (sum of Y h in N/m) * l0^2:
#   film: 300 N/m; A: 300 + 2100 = 2400; B: 300 + 1800 = 2100; C: 300 + 3000 = 3300
#   l0^2: A 1.024e-5, B 1.6e-5, C 3.364e-5 m^2
HAND = {
    "bowl": (0.5875e-3, 1.53625e-4, 2.660430041e-3, 2.128344032e-2),
    "canoe": (5.357142857e-4, 1.083214286e-4, 4.156921938e-3, 2.909845357e-2),
    "petals": (7.409090909e-4, 3.674772727e-4, 8.739928375e-3, 9.613921213e-2),
}


@pytest.mark.parametrize("name", HAND)
def test_published_designs(examples, name):
    design = Design.load(examples / f"{name}.toml")
    neutral, rigidity, film_stretch, pattern_stretch = HAND[name]
    film, both = film_stack(design), stack_of(design, ["pattern"])
    l0 = design.published.mean_edge_length
    assert film.plate_moduli == pytest.approx([1e6], rel=1e-14)
    assert both.plate_moduli == pytest.approx([1e6, 3e6], rel=1e-14)
    assert film.neutral_height == pytest.approx(0.15e-3, rel=1e-14)
    assert both.neutral_height == pytest.approx(neutral, rel=1e-9)
    assert film.flexural_rigidity == pytest.approx(2.25e-6, rel=1e-12)
    assert both.flexural_rigidity == pytest.approx(rigidity, rel=1e-9)
    # 2/sqrt(3) = 1.1547005383792517
    assert film.bending_stiffness == pytest.approx(2.5980762114e-6, rel=1e-9)
    assert both.bending_stiffness == pytest.approx(1.1547005383792517 * rigidity, rel=1e-9)
    assert film.stretching_stiffness(l0) == pytest.approx(film_stretch, rel=1e-9)
    assert both.stretching_stiffness(l0) == pytest.approx(pattern_stretch, rel=1e-9)


def test_areal_mass_by_hand(design):
    # 0.3 mm * 1050 + 1.0 mm * 1250 = 0.315 + 1.25 kg/m^2
    assert stack_of(design, ["pattern"]).areal_mass == pytest.approx(1.565, rel=1e-14)


def test_equal_layers_are_one_thick_layer():
    whole = stack((1e-3, 2e6, 0.3, 1000))
    parts = stack(*[(h, 2e6, 0.3, 1000) for h in (2e-4, 5e-4, 3e-4)])
    for name in ("thickness", "neutral_height", "flexural_rigidity", "areal_mass"):
        assert getattr(parts, name) == pytest.approx(getattr(whole, name), rel=1e-13)
    assert parts.stretching_stiffness(3e-3) == pytest.approx(whole.stretching_stiffness(3e-3))


def test_turning_the_stack_over_keeps_the_rigidity():
    layers = [(3e-4, 1e6, 0.33, 1050), (1e-4, 5e4, 0.4, 1200), (7e-4, 3e6, 0.3, 1250)]
    up, down = stack(*layers), stack(*reversed(layers))
    assert down.flexural_rigidity == pytest.approx(up.flexural_rigidity, rel=1e-13)
    assert down.neutral_height == pytest.approx(up.thickness - up.neutral_height, rel=1e-13)


def test_a_third_layer_of_no_thickness_changes_nothing():
    two = stack((3e-4, 1e6, 0.33, 1050), (7e-4, 3e6, 0.3, 1250))
    three = stack((3e-4, 1e6, 0.33, 1050), (0.0, 9e9, 0.3, 1200), (7e-4, 3e6, 0.3, 1250))
    assert three.flexural_rigidity == pytest.approx(two.flexural_rigidity, rel=1e-14)


def test_stiffness_of_edges_and_hinges(design, strip):
    region = regions(design, strip)
    stiffness = published_stiffness(design, strip, region)
    inside = region.edge_in_pattern
    l0 = strip.mean_edge_length
    assert mean_edge_length(design, strip) == l0
    both, film = stack_of(design, ["pattern"]), film_stack(design)
    assert stiffness.stretch_plain[inside] == pytest.approx(10 * both.stretching_stiffness(l0))
    assert stiffness.stretch_plain[~inside] == pytest.approx(10 * film.stretching_stiffness(l0))
    assert np.array_equal(stiffness.stretch, stiffness.stretch_plain * strip.edge_lengths)
    hinge = region.hinge_cell > 0
    assert set(stiffness.bending[hinge]) == {both.bending_stiffness}
    assert set(stiffness.bending[~hinge]) == {film.bending_stiffness}


def test_stiffness_options(design, strip):
    design = design.with_values(
        {
            "published.stretch_stiffness": "printed",
            "published.stretch_factor": 1,
            "published.mean_edge_length": "2 mm",
        }
    )
    region = regions(design, strip)
    stiffness = published_stiffness(design, strip, region)
    assert stiffness.stretch is stiffness.stretch_plain
    assert stiffness.stretch.min() == film_stack(design).stretching_stiffness(2e-3)


def test_mass_by_hand(design, strip):
    # The grid gives the pattern 20 mm x 4 mm (whole squares within |y| <= 3 mm) and a part
    # of those cut by its edge; the film weighs 0.04 * 0.02 * 0.315 = 2.52e-4 kg.
    region = regions(design, strip)
    area = strip.triangle_areas[region.triangle_in_pattern].sum()
    expected = 0.04 * 0.02 * 0.315 + area * 1.25
    assert total_mass(strip, region) == pytest.approx(expected, rel=1e-12)
