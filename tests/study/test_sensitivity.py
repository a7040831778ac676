"""Derivatives of the final shape against runs with changed parameters."""

from __future__ import annotations

import numpy as np
import pytest
from small import SMALL

import sheetmorph as sm
from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.study.design_keys import number_at, with_number
from sheetmorph.study.sensitivity import (
    distance_to,
    sensitivities,
)
from sheetmorph.study.simulate import simulate

HELD = """
[[supports]]
kind = "pattern_in_box"
x = ["-6 mm", "6 mm"]
y = ["-6 mm", "6 mm"]
"""
PUBLISHED = SMALL.replace("eps_pre = -0.4", 'eps_pre = -0.3\nprofile = "exponential"\ngamma = 1.5')
PUBLISHED = PUBLISHED + HELD + "[solver]\ntolerance = 1e-12\n"
LAMINATE = PUBLISHED.replace('"published"', '"laminate"').replace(
    "gamma = 1.5", "gamma = 1.5\nunder_pattern = 0.1"
)
KEYS = {
    "published": [
        "actuation.eps_pre",
        "actuation.gamma",
        "layers.film.thickness",
        "layers.1.young_modulus",
        "published.coupling",
        "published.stretch_factor",
    ],
    "laminate": [
        "actuation.eps_pre",
        "actuation.gamma",
        "actuation.under_pattern",
        "layers.film.thickness",
        "layers.1.thickness",
        "layers.1.young_modulus",
        "layers.film.poisson_ratio",
    ],
}


@pytest.fixture(scope="module", params=["published", "laminate"])
def run(request: pytest.FixtureRequest) -> sm.Result:
    text = PUBLISHED if request.param == "published" else LAMINATE
    return sm.simulate(sm.Design.from_toml(text))


def rise(result: sm.Result) -> tuple[float, np.ndarray]:
    """A smooth function: how far the sheet is from flat."""
    return distance_to(result.mesh.nodes, 1e3 * np.ones(len(result.mesh.nodes)))


@pytest.mark.slow
def test_every_key_has_a_taylor_slope_of_two(run: sm.Result) -> None:
    """J(p + h) − J(p) − h dJ/dp falls as h², with J from whole runs."""
    objective = rise(run)
    keys = KEYS[run.design.model]
    found = sensitivities(run, objective, keys)
    for key in keys:
        value = number_at(run.design, key)
        sizes = abs(value) * np.array([0.02, 0.01, 0.005])
        rests = []
        for h in sizes:
            moved = simulate(with_number(run.design, key, value + h), mesh=run.mesh)
            change = objective(moved.positions[-1])[0] - found.value
            rests.append(abs(change - h * found.keys[key]))
        slope = np.polyfit(np.log(sizes), np.log(rests), 1)[0]
        assert slope == pytest.approx(2.0, abs=0.15), (key, rests)


def test_fields_sum_to_keys(run: sm.Result) -> None:
    """The strain everywhere in proportion is eps_pre; all couplings together are the key."""
    found = sensitivities(run, rise(run), KEYS[run.design.model])
    eps = run.design.eps_pre
    if run.design.laminate:
        from sheetmorph.design.actuation import triangle_eigenstrain

        strain = triangle_eigenstrain(run.design, run.mesh, run.regions)
        chained = float((found.fields["eigenstrain"] * strain).sum()) / eps
        assert chained == pytest.approx(found.keys["actuation.eps_pre"], rel=1e-6)
        return
    chained = float(found.fields["eigenstrain"] @ run.thermal_strain_full) / eps
    assert chained == pytest.approx(found.keys["actuation.eps_pre"], rel=1e-6)
    chained = float(found.fields["coupling"] @ run.coupling) / run.design.published.coupling
    assert chained == pytest.approx(found.keys["published.coupling"], rel=1e-6)
    chained = float(found.fields["stretch_stiffness"] @ run.stretch_stiffness)
    factor = run.design.published.stretch_factor
    assert chained / factor == pytest.approx(found.keys["published.stretch_factor"], rel=1e-6)
    # Only the ratio of all stiffnesses matters for the shape.
    bent = float(found.fields["bending_stiffness"] @ run.bending_stiffness)
    assert bent == pytest.approx(-chained, rel=1e-5)


def test_a_state_that_is_no_equilibrium_is_refused(run: sm.Result) -> None:
    from dataclasses import replace

    moved = run.positions.copy()
    moved[-1, 5, 2] += 1e-4
    with pytest.raises(ComputationError, match="no equilibrium"):
        sensitivities(replace(run, positions=moved), rise(run))


def test_a_run_that_did_not_finish_is_refused(run: sm.Result) -> None:
    from dataclasses import replace

    other = replace(run, summary={**run.summary, "status": "step_too_small"})
    with pytest.raises(ComputationError, match="step_too_small"):
        sensitivities(other, rise(run))


def test_a_saddle_is_refused() -> None:
    """A flat sheet beyond its buckling is an equilibrium but no minimum."""
    text = """
name = "heated"
model = "laminate"
[outline]
kind = "rectangle"
width = "20 mm"
height = "20 mm"
[[layers]]
name = "film"
role = "active"
thickness = "0.1 mm"
young_modulus = "1 MPa"
[actuation]
eps_pre = 0.02
profile = "uniform"
[perturbation]
total_force = "0 N"
[mesh]
size = "4 mm"
[[supports]]
kind = "box"
x = ["-10 mm", "10 mm"]
y = ["-10 mm", "-10 mm"]
[[supports]]
kind = "box"
x = ["-10 mm", "10 mm"]
y = ["10 mm", "10 mm"]
[[supports]]
kind = "box"
x = ["-10 mm", "-10 mm"]
y = ["-10 mm", "10 mm"]
[[supports]]
kind = "box"
x = ["10 mm", "10 mm"]
y = ["-10 mm", "10 mm"]
"""
    from dataclasses import replace

    result = sm.simulate(sm.Design.from_toml(text).with_values({"actuation.eps_pre": 1e-6}))
    flat = replace(
        result,
        design=result.design.with_values({"actuation.eps_pre": 0.02}),
        positions=result.mesh.nodes[None],
        scalars=np.zeros_like(result.scalars[-1:]),
        ramp=np.ones(1),
        load_fraction=np.zeros(1),
    )
    with pytest.raises(ComputationError, match="no stable equilibrium"):
        sensitivities(flat, rise(flat))


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("mesh.size", "geometry"),
        ("layers.film.thicknes", "did you mean thickness"),
        ("layers.9.thickness", "no such key"),
        ("actuation.profile", "no number"),
    ],
)
def test_keys_that_cannot_be_differentiated(run: sm.Result, key: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        sensitivities(run, rise(run), [key])
