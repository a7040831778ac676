"""Derivatives by a smeared pattern, by layers and by rest positions, against whole runs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from small import SMALL

import sheetmorph as sm
from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.study.design_keys import number_at, with_number
from sheetmorph.study.parameters import layer_presence
from sheetmorph.study.sensitivity import (
    Objective,
    Sensitivities,
    distance_to,
    sensitivities,
)

SMEARED = {
    "published": SMALL.replace("eps_pre = -0.4", "eps_pre = -0.3")
    .replace(
        'half_width = "3 mm"',
        'half_width = "3.2 mm"\nrotation = "7 deg"\ncentre = ["0.3 mm", "0.2 mm"]',
    )
    .replace('direction = "up"', 'direction = "down"')
    .replace('size = "3 mm"', 'size = "3 mm"\npattern_smoothing = "4 mm"')
    + """
[[pattern]]
kind = "ellipse"
half_width = "4.4 mm"
half_height = "2 mm"
centre = ["-10 mm", "1 mm"]
rotation = "50 deg"
[[supports]]
kind = "box"
x = ["-4 mm", "4 mm"]
y = ["-4 mm", "4 mm"]
[solver]
tolerance = 1e-12
"""
}
SMEARED["laminate"] = SMEARED["published"].replace('"published"', '"laminate"')
KEYS = [
    "pattern.0.half_width",
    "pattern.0.arm_length",
    "pattern.0.rotation",
    "pattern.1.half_width",
    "pattern.1.centre.1",
]


def rise(result: sm.Result) -> Objective:
    """A smooth function: how far the sheet is from flat."""
    return distance_to(result.mesh.nodes, 1e3 * np.ones(len(result.mesh.nodes)))


@pytest.fixture(scope="module", params=["published", "laminate"])
def run(request: pytest.FixtureRequest) -> sm.Result:
    return sm.simulate(sm.Design.from_toml(SMEARED[request.param]))


@pytest.fixture(scope="module")
def found(run: sm.Result) -> Sensitivities:
    return sensitivities(run, rise(run), [*KEYS, "layers.print.thickness"])


@pytest.mark.slow
@pytest.mark.parametrize("key", KEYS)
def test_pattern_keys_have_taylor_slopes_of_two(
    run: sm.Result, found: Sensitivities, key: str
) -> None:
    """J(p + h) − J(p) − h dJ/dp falls as h², with J from whole runs of moved patterns.

    From both sides, which parts the second order from the third; what is left of the first
    after an extrapolation is nothing.
    """
    value = number_at(run.design, key)
    bends, slopes = [], []
    for fraction in (0.008, 0.004):
        h = fraction * (abs(value) if "rotation" not in key else 1.0)
        ahead, behind = (
            rise(run)(sm.simulate(with_number(run.design, key, value + s)).positions[-1])[0]
            for s in (h, -h)
        )
        bends.append(abs(ahead - 2.0 * found.value + behind) / 2.0)
        slopes.append((ahead - behind) / (2.0 * h))
    assert np.log2(bends[0] / bends[1]) == pytest.approx(2.0, abs=0.15), bends
    slope = (4.0 * slopes[1] - slopes[0]) / 3.0
    assert found.keys[key] == pytest.approx(slope, rel=2e-3), slopes


def test_corners_of_the_boundary_sum_to_the_keys(run: sm.Result, found: Sensitivities) -> None:
    """A pad that moves takes all its corners along."""
    corners, slopes = found.corners["pattern"], found.boundary["pattern"]
    pad = np.hypot(corners[:, 0] + 0.010, corners[:, 1] - 0.001) < 0.005
    assert slopes[pad, 1].sum() == pytest.approx(found.keys["pattern.1.centre.1"], rel=1e-6)
    assert np.count_nonzero(pad) > 200


def test_layers_of_every_place_sum_to_the_key(run: sm.Result, found: Sensitivities) -> None:
    smooth = run.regions.smooth
    assert smooth is not None
    if run.design.laminate:
        shares = layer_presence(run.design, run.regions)[1]
    else:
        shares = smooth.layer_shares(run.design, smooth.edges)[1]
    chained = float(found.fields["thickness"][1] @ shares)
    assert chained == pytest.approx(found.keys["layers.print.thickness"], rel=1e-6)


def test_keys_alone_need_no_fields(run: sm.Result, found: Sensitivities) -> None:
    plain = sensitivities(run, rise(run), ["pattern.0.half_width"], fields=())
    assert plain.fields == {}
    assert plain.keys["pattern.0.half_width"] == found.keys["pattern.0.half_width"]


def test_rest_positions_against_runs_of_moved_meshes() -> None:
    """All nodes a little moved in the plane; held ones, their neighbours, and areas follow.

    The published model by the order of the file, whose hinges do not turn over when nodes move.
    """
    for model, more in (
        ("published", {"published.hinge_orientation": "file_order"}),
        ("laminate", {}),
    ):
        text = SMEARED[model].replace('\npattern_smoothing = "4 mm"', "")
        mesh = sm.Design.from_toml(SMEARED[model]).build_mesh()
        design = sm.Design.from_toml(text).with_values({"actuation.profile": "step", **more})
        result = sm.simulate(design, mesh=mesh)
        found = sensitivities(result, rise(result), fields=["rest_positions"])
        rng = np.random.default_rng(5)
        motion = rng.standard_normal(mesh.nodes.shape) * [1.0, 1.0, 0.0]
        rate = float((found.fields["rest_positions"] * motion).sum())
        rests = []
        for h in (4e-6, 2e-6):
            ends = [
                rise(result)(
                    sm.simulate(
                        design, mesh=replace(mesh, nodes=mesh.nodes + s * motion)
                    ).positions[-1]
                )[0]
                for s in (h, -h)
            ]
            assert (ends[0] - ends[1]) / (2 * h) == pytest.approx(rate, rel=2e-3)
            rests.append(abs(sum(ends) / 2 - found.value))
        assert np.log2(rests[0] / rests[1]) == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("pattern.0.arms", "whole number"),
        ("pattern.0.hub_radius", "end of its range"),
        ("pattern.0.kind", "no number"),
        ("pattern.2.radius", "no such key"),
        ("pattern.0.arm_lenght", "did you mean arm_length"),
    ],
)
def test_pattern_keys_that_cannot_be_differentiated(run: sm.Result, key: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        sensitivities(run, rise(run), [key])


def test_a_sharp_pattern_is_refused(run: sm.Result) -> None:
    sharp = run.design.with_values({"mesh.pattern_smoothing": None})
    with pytest.raises(InputError, match="pattern_smoothing"):
        sensitivities(replace(run, design=sharp), rise(run), ["pattern.0.half_width"])


def test_a_field_that_is_none_is_refused(run: sm.Result) -> None:
    with pytest.raises(InputError, match="eigenstrain"):
        sensitivities(run, rise(run), fields=["temperature"])


def test_a_state_of_another_pattern_is_refused(run: sm.Result) -> None:
    wider = with_number(run.design, "pattern.0.half_width", 0.0034)
    with pytest.raises(ComputationError, match="no equilibrium"):
        sensitivities(replace(run, design=wider), rise(run))


def test_a_shape_that_leans_on_the_guard_is_refused(run: sm.Result) -> None:
    corner = run.mesh.triangles[0]
    squeezed = run.positions.copy()
    squeezed[-1, corner[2]] = squeezed[-1, corner[:2]].mean(axis=0)
    with pytest.raises(ComputationError, match="collapsing"):
        sensitivities(replace(run, positions=squeezed), rise(run))
