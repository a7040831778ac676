"""Designs whose pattern has a smeared boundary."""

from __future__ import annotations

import numpy as np
import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.design.actuation import thermal_strain, triangle_eigenstrain
from sheetmorph.design.laminate import published_stiffness, total_mass
from sheetmorph.design.meshing import farther_side, hinge_coupling
from sheetmorph.design.regions import regions
from sheetmorph.design.smoothing import blended_maximum, smooth_sign, smooth_sign_slope
from sheetmorph.design.spec import Design

TEXT = """
name = "smeared"
model = "published"
[outline]
kind = "disc"
radius = "20 mm"
[[pattern]]
kind = "star"
arms = 3
arm_length = "15 mm"
half_width = "3.1 mm"
rotation = "7 deg"
centre = ["0.3 mm", "0.2 mm"]
[[layers]]
name = "film"
role = "active"
thickness = "0.3 mm"
young_modulus = "1 MPa"
[[layers]]
name = "print"
role = "inert"
thickness = "0.7 mm"
young_modulus = "3 MPa"
where = "pattern"
[actuation]
eps_pre = -0.4
profile = "exponential"
gamma = 1.5
[mesh]
size = "2 mm"
pattern_smoothing = "2 mm"
"""
BELOW = """
[[pattern]]
kind = "disc"
radius = "2 mm"
centre = ["-12 mm", "0 mm"]
part = "pads"
"""
BELOW_LAYER = """
[[layers]]
name = "pad"
role = "inert"
thickness = "0.5 mm"
young_modulus = "3 MPa"
where = "pads"
"""


@pytest.fixture(scope="module")
def design() -> Design:
    return Design.from_toml(TEXT)


def test_the_mesh_stays_when_the_pattern_moves(design: Design) -> None:
    mesh = design.build_mesh()
    moved = design.with_values({"pattern.0.half_width": "4 mm"}).build_mesh()
    assert np.array_equal(mesh.nodes, moved.nodes)
    assert np.array_equal(mesh.hinges, moved.hinges)
    sharp = design.with_values({"mesh.pattern_smoothing": None}).build_mesh()
    assert len(sharp.nodes) != len(mesh.nodes)


@pytest.mark.parametrize("model", ["published", "laminate"])
def test_a_small_width_gives_the_arrays_of_the_sharp_pattern(design: Design, model: str) -> None:
    """On the same mesh; strains approach in proportion to the width, for d_max is blended over it.

    Hinges all but parallel to the boundary's normal have no sense in the limit; on an irregular
    mesh there are none.
    """
    mesh = design.build_mesh()
    sharp = design.with_values({"model": model, "mesh.pattern_smoothing": None})
    oriented = mesh.with_hinges_reversed(farther_side(mesh, sharp.pattern_polygon()) < 0)
    errors = []
    for width in ("0.1 mm", "0.01 mm"):
        smeared = sharp.with_values({"mesh.pattern_smoothing": width})
        one, other = (regions(d, oriented) for d in (smeared, sharp))
        if model == "laminate":
            strains = [
                triangle_eigenstrain(d, oriented, r) for d, r in ((smeared, one), (sharp, other))
            ]
        else:
            strains = [thermal_strain(d, oriented, r) for d, r in ((smeared, one), (sharp, other))]
        errors.append(np.abs(strains[0] - strains[1]).max() / 0.4)
    assert errors[1] < 0.25 * errors[0]
    assert errors[1] < 1e-3
    assert total_mass(oriented, one) == pytest.approx(total_mass(oriented, other), rel=1e-3)
    if model == "published":
        a, b = (published_stiffness(d, oriented, r) for d, r in ((smeared, one), (sharp, other)))
        for name in ("stretch", "bending"):  # but within 5 µm of the boundary
            assert np.isclose(getattr(a, name), getattr(b, name), rtol=1e-9).mean() > 0.995
        sense = [hinge_coupling(d, oriented, r) for d, r in ((smeared, one), (sharp, other))]
        assert (np.abs(sense[0] - sense[1]) < 1e-9).mean() > 0.98


def test_layers_taper_off(design: Design) -> None:
    """Across a straight side of an arm the printed layer thins from whole to nothing over w."""
    mesh = design.build_mesh()
    region = regions(design, mesh)
    assert region.smooth is not None
    shares = region.smooth.layer_shares(design, region.smooth.edges)
    assert set(shares[0]) == {1.0}
    between = (shares[1] > 0.01) & (shares[1] < 0.99)
    assert 0.1 < between.mean() < 0.5
    stiffness = published_stiffness(design, mesh, region).bending
    ends = stiffness[shares[1][mesh.hinge_edges[:, 0]] == 0.0].max()
    assert stiffness.min() == pytest.approx(ends)
    assert stiffness.max() > 10 * ends


def test_everything_moves_smoothly_with_the_pattern(design: Design) -> None:
    """Second differences of the arrays fall as h²: no array jumps, or has a kink of its own."""
    mesh = design.build_mesh()

    def arrays(turn: float) -> np.ndarray:
        moved = design.with_values({"pattern.0.rotation": f"{0.3 + turn!r} rad"})
        region = regions(moved, mesh)
        return np.concatenate(
            [
                thermal_strain(moved, mesh, region) / 0.4,
                published_stiffness(moved, mesh, region).stretch * 1e6,
                hinge_coupling(moved, mesh, region),
            ]
        )

    middle = arrays(0.0)
    bends = [np.abs(arrays(h) - 2 * middle + arrays(-h)).max() for h in (4e-4, 2e-4)]
    assert bends[1] == pytest.approx(bends[0] / 4, rel=0.1)


def test_keys_that_do_not_go_together() -> None:
    with pytest.raises(InputError, match=r"actuation\.distance.*pattern_boundary"):
        Design.from_toml(TEXT.replace("gamma = 1.5", 'gamma = 1.5\ndistance = "bilayer_edges"'))
    plain = TEXT[: TEXT.index("[[pattern]]")] + TEXT[TEXT.index("[[layers]]") :]
    with pytest.raises(InputError, match="no pattern"):
        Design.from_toml(plain.replace('where = "pattern"', ""))
    both = TEXT.replace("[[layers]]", BELOW + BELOW_LAYER + "[[layers]]", 1)
    with pytest.raises(InputError, match="both faces"):
        Design.from_toml(both)
    assert Design.from_toml(both.replace('"published"', '"laminate"')).laminate


def test_the_key_enters_the_hash(design: Design) -> None:
    sharp = design.with_values({"mesh.pattern_smoothing": None})
    other = design.with_values({"mesh.pattern_smoothing": "1 mm"})
    assert len({design.hash, sharp.hash, other.hash}) == 3


def test_blends() -> None:
    u = np.linspace(-1.2, 1.2, 97)
    h = 1e-6
    slope = (smooth_sign(u + h) - smooth_sign(u - h)) / (2 * h)
    assert smooth_sign_slope(u) == pytest.approx(slope, abs=1e-5)
    assert (smooth_sign(np.array([-5.0, 0.0, 5.0])) == [-1.0, 0.0, 1.0]).all()
    values, areas = np.array([1.0, 2.0, 2.0]), np.full(3, 1e-6)
    top, weights = blended_maximum(values, areas, 1e-3)
    assert top == pytest.approx(2.0, abs=1e-3)
    assert weights == pytest.approx([0.0, 0.5, 0.5])
