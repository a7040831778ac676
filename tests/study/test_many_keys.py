"""Derivatives by hundreds of keys at once, and beside weight and contact, by no chain rule."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from anew import Anew
from small import SMALL

import sheetmorph as sm
from sheetmorph.core.errors import ComputationError
from sheetmorph.energy.guard import TriangleGuard
from sheetmorph.study.design_keys import number_at
from sheetmorph.study.key_slopes import KeySlopes
from sheetmorph.study.model import build_problem
from sheetmorph.study.sensitivity import Objective, distance_to, sensitivities

PADS = 42
NAMES = ("width", "height", "centre.0", "centre.1", "rotation")
DIRECTIONS = 6


def rise(result: sm.Result) -> Objective:
    """How far the sheet is from flat."""
    return distance_to(result.mesh.nodes, 1e3 * np.ones(len(result.mesh.nodes)))


def text_of(model: str, more: str = "") -> str:
    """The small star with a smeared boundary, held in the middle, with densities."""
    text = SMALL.replace('"published"', f'"{model}"').replace("eps_pre = -0.4", "eps_pre = -0.25")
    text = text.replace('half_width = "3 mm"', 'half_width = "3.2 mm"\nrotation = "7 deg"')
    text = text.replace('size = "3 mm"', 'size = "3 mm"\npattern_smoothing = "4 mm"')
    text = text.replace("young_modulus", 'density = "1100 kg/m^3"\nyoung_modulus')
    return f"{text}[solver]\ntolerance = 1e-12\n{more}"


HELD = """
[[supports]]
kind = "box"
x = ["-4 mm", "4 mm"]
y = ["-4 mm", "4 mm"]
"""
WEIGHT, RESTING = HELD + "[gravity]\n", "[gravity]\n[contact]\ntable = true\n"
PRESSED = HELD + '[contact]\ntable = true\ntable_distance = "0.1 mm"\nrange = "0.4 mm"\n'


def pads() -> str:
    """Rectangles spread evenly over the sheet; some lie across the arms of the star."""
    steps = np.arange(PADS) + 0.5
    r, t = 18.0 * np.sqrt(steps / PADS), np.pi * (3.0 - np.sqrt(5.0)) * steps
    return "".join(
        f'[[pattern]]\nkind = "rectangle"\nwidth = "{1.5 + 0.01 * k} mm"\nheight = "1.2 mm"\n'
        f'centre = ["{x} mm", "{y} mm"]\nrotation = "{3 * k + 5} deg"\nclip = true\n'
        for k, (x, y) in enumerate(zip(r * np.cos(t), r * np.sin(t), strict=True))
    )


@pytest.mark.parametrize("model", ["published", "laminate"])
def test_two_hundred_keys_equal_the_differenced_ones(model: str) -> None:
    """Along random motions of all of them, which also tell if one alone were a little wrong."""
    result = sm.simulate(sm.Design.from_toml(text_of(model, HELD + pads())))
    keys = [f"pattern.{pad + 1}.{name}" for pad in range(PADS) for name in NAMES]
    keys += ["pattern.0.arm_length", "pattern.0.rotation", "layers.1.thickness"]
    assert len(keys) > 200
    found = sensitivities(result, rise(result), keys, fields=()).keys
    values = {key: number_at(result.design, key) for key in keys}
    anew, rng = Anew(result, rise(result)), np.random.default_rng(1)
    size = np.linalg.norm([found[key] * (abs(values[key]) or 1.0) for key in keys])
    for _ in range(DIRECTIONS):
        rates = {key: float(rng.standard_normal()) * (abs(values[key]) or 1.0) for key in keys}
        chained = sum(found[key] * rates[key] for key in keys)
        assert chained == pytest.approx(anew.slope(values, rates), abs=1e-6 * size)


@pytest.mark.parametrize(
    ("model", "around", "keys"),
    [
        *((model, WEIGHT, ["gravity.magnitude"]) for model in ("published", "laminate")),
        *((model, RESTING, ["gravity.magnitude"]) for model in ("published", "laminate")),
        ("published", PRESSED, ["contact.table_distance", "contact.range"]),
    ],
)
def test_weight_and_table_are_part_of_the_chain(model: str, around: str, keys: list[str]) -> None:
    """A sheet with weight, one that rests on a table, and one that bends down onto it."""
    text = text_of(model, around)
    if around == PRESSED:
        text = text.replace('direction = "up"', 'direction = "down"')
    result = sm.simulate(sm.Design.from_toml(text))
    assert result.status == "completed"
    keys = [
        *keys,
        *(f"pattern.0.{name}" for name in ("half_width", "arm_length", "rotation")),
        *(f"layers.{k}.{name}" for k in (0, 1) for name in ("thickness", "young_modulus")),
        *("layers.1.density", "layers.0.poisson_ratio", "actuation.eps_pre"),
    ]
    found = sensitivities(result, rise(result), keys, fields=()).keys
    anew = Anew(result, rise(result))
    values = {key: number_at(result.design, key) for key in keys}
    for key, value in values.items():
        expected = anew.slope({key: value}, {key: value}) / value
        assert found[key] == pytest.approx(expected, rel=1e-4), key
        assert found[key] != 0.0 or key == "layers.1.density"


def test_shapes_that_touch_are_drawn_together() -> None:
    """A bar that ends flush on another: its corners slide along the other's side."""
    bars = "".join(
        f'[[pattern]]\nkind = "rectangle"\nwidth = "10 mm"\nheight = "{height} mm"\n'
        f'centre = ["{x} mm", "0 mm"]\n'
        for x, height in ((-5, 9), (5, 5))
    )
    text = text_of("published", HELD)
    star = text[text.index("[[pattern]]") : text.index("[[layers]]")]
    result = sm.simulate(sm.Design.from_toml(text.replace(star, bars)))
    keys = ["pattern.0.height", "pattern.1.height"]
    found = sensitivities(result, rise(result), keys, fields=()).keys
    anew = Anew(result, rise(result))
    for key in keys:
        value = number_at(result.design, key)
        expected = anew.slope({key: value}, {key: value}) / value
        assert found[key] == pytest.approx(expected, rel=1e-4), key


def test_a_term_that_is_no_part_of_the_chain_is_refused() -> None:
    """A new kind of energy must be told to the chain before there are derivatives by keys."""
    problem = build_problem(sm.Design.from_toml(text_of("published", HELD)))
    nodes = problem.mesh.nodes
    more = TriangleGuard.of(problem.mesh, np.ones(len(problem.mesh.triangles)))
    total = replace(problem.total, terms=(*problem.total.terms, more))
    still = np.zeros(nodes.size)
    with pytest.raises(ComputationError, match="guard is not known"):
        KeySlopes.of(replace(problem, total=total), {}, nodes.ravel(), still, 1.0)
