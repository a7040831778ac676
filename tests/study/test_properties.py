"""The solver, by properties: what must not matter does not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import sheetmorph as sm
from sheetmorph.geometry.topology import build_mesh
from sheetmorph.study.model import build_problem

often = settings(deadline=None, max_examples=6, derandomize=True)

MODELS = st.sampled_from(["published", "laminate"])
ORIENTED = {"published.hinge_orientation": "away_from_pattern"}


def of_model(design: sm.Design, model: str) -> sm.Design:
    return design.with_values({"model": model, **(ORIENTED if model == "published" else {})})


def heights(result: sm.Result) -> float:
    return float(result.summary["height_m"])


def energy(result: sm.Result) -> float:
    return float(result.summary["energy_J"]["total"])


@often
@given(MODELS, st.integers(0, 1000))
def test_energies_do_not_see_rigid_motions(small_design: sm.Design, model: str, seed: int) -> None:
    problem = build_problem(of_model(small_design, model))
    rng = np.random.default_rng(seed)
    x = problem.start + 1e-3 * rng.standard_normal(problem.start.size)
    turn, shift = Rotation.random(rng=rng), rng.standard_normal(3)
    moved = x.copy()
    moved[: problem.mesh.nodes.size] = (turn.apply(problem.positions(x)) + shift).ravel()
    before, after = (problem.total.at(0.7, 0.0).energies(y) for y in (x, moved))
    assert before == pytest.approx(after, rel=1e-8)


@settings(often, max_examples=3)
@given(st.integers(0, 1000))
def test_numbers_of_nodes_do_not_matter(small_design: sm.Design, seed: int) -> None:
    """The laminate model; for the published one see test_orientation."""
    design = of_model(small_design, "laminate")
    mesh = design.build_mesh()
    order = np.random.default_rng(seed).permutation(len(mesh.nodes))
    other = build_mesh(mesh.nodes[order], np.argsort(order)[mesh.triangles])
    first, second = sm.simulate(design, mesh=mesh), sm.simulate(design, mesh=other)
    assert heights(second) == pytest.approx(heights(first), rel=1e-5)
    assert energy(second) == pytest.approx(energy(first), rel=1e-7)


@often
@given(MODELS, st.floats(-3.0, 6.0))
def test_shapes_do_not_know_the_unit_of_moduli(
    small_design: sm.Design, model: str, power: float
) -> None:
    """All moduli times a factor: the same shape, and that much more energy."""
    design = of_model(small_design, model)
    factor = 10.0**power
    scaled = design.with_values(
        {
            f"layers.{k}.young_modulus": f"{layer.young_modulus * factor!r} Pa"
            for k, layer in enumerate(design.layers)
        }
    )
    first, second = sm.simulate(design), sm.simulate(scaled)
    assert heights(second) == pytest.approx(heights(first), rel=1e-6)
    assert energy(second) == pytest.approx(factor * energy(first), rel=1e-6)


@pytest.mark.parametrize("model", ["published", "laminate"])
def test_the_other_way_up_is_the_mirror_image(small_design: sm.Design, model: str) -> None:
    """Upside down: the layers from the top, the load from below."""
    design = of_model(small_design, model)
    if model == "published":  # its layers do not tell top from bottom, its coupling does
        design = design.with_values({"published.coupling": 0.0})
    swapped = design.with_values(
        {"perturbation.direction": "down" if design.perturbation.direction == "up" else "up"}
    )
    if model == "laminate":
        head, *layers = swapped.to_toml().split("[[layers]]")
        *inner, last = layers
        tail = last[last.index("\n[") :]
        body = [
            "[[layers]]" + text.rstrip() + "\n\n" for text in (*inner, last[: last.index("\n[")])
        ]
        swapped = sm.Design.from_toml(head + "".join(reversed(body)) + tail)
    up, down = sm.simulate(design), sm.simulate(swapped)
    assert up.summary["height_m"] == pytest.approx(down.summary["height_m"], rel=1e-5)
    np.testing.assert_allclose(
        down.positions[-1], up.positions[-1] * [1.0, 1.0, -1.0], atol=1e-6 * np.ptp(up.positions)
    )
