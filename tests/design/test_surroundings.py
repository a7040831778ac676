"""The tables `gravity` and `contact`: weights, rules, hashes, words."""

from __future__ import annotations

import numpy as np
import pytest
from laminates import LAMINATE

from sheetmorph.core.errors import InputError
from sheetmorph.design.check import describe, format_description
from sheetmorph.design.loads import gravity_forces
from sheetmorph.design.regions import regions
from sheetmorph.design.spec import Design

HEAVY = LAMINATE.replace("young_modulus", 'density = "1100 kg/m^3"\nyoung_modulus')
FREE = {"supports": None}
BARE = LAMINATE.replace("[[layers]]", "[gravity]\n[[layers]]", 1)


def heavy(**values: object) -> Design:
    keyed = {key.replace("__", "."): value for key, value in values.items()}
    return Design.from_toml(HEAVY).with_values(keyed)


@pytest.mark.parametrize(
    ("key", "value", "down"),
    [
        ("orientation", "as_drawn", (0, 0, -1)),
        ("orientation", "turned_over", (0, 0, 1)),
        ("orientation", "upright", (0, -1, 0)),
        ("direction", [3, 0, -4], (0.6, 0, -0.8)),
    ],
)
def test_weights_are_density_times_thickness_times_area(key, value, down) -> None:
    values = {"gravity.magnitude": "9.81 m/s^2", f"gravity.{key}": value, "mesh.size": "4 mm"}
    design = Design.from_toml(HEAVY).with_values(values)
    mesh = design.build_mesh()
    region = regions(design, mesh)
    weights = gravity_forces(design, mesh, region)
    areas = mesh.triangle_areas
    mass = 1100 * (0.3e-3 * areas.sum() + 1e-3 * areas[region.triangle_in_pattern].sum())
    np.testing.assert_allclose(weights.sum(axis=0), 9.81 * mass * np.array(down), atol=1e-12)
    # Every node bears a third of its triangles: no more where only film is.
    film = ~np.isin(np.arange(len(mesh.nodes)), mesh.triangles[region.triangle_in_pattern])
    np.testing.assert_allclose(
        np.linalg.norm(weights[film], axis=1),
        9.81 * 1100 * 0.3e-3 * mesh.node_areas[film],
        rtol=1e-12,
    )


def test_the_standard_gravity_is_the_default() -> None:
    design = heavy(gravity__orientation="as_drawn")
    assert design.gravity.magnitude == 9.80665
    assert Design.from_toml(HEAVY).gravity is None


def test_one_way_replaces_the_other() -> None:
    design = heavy(gravity__orientation="upright").with_values({"gravity.direction": [1, 0, 0]})
    assert "orientation" not in design.to_toml()
    assert design.gravity.down == (1.0, 0.0, 0.0)


def test_hashes_of_designs_without_the_tables_are_what_they_were() -> None:
    """SHA-256 by the release before there were gravity and contact."""
    plain = Design.from_toml(HEAVY)
    assert plain.hash.startswith("b1ffda1fcb05ba13")
    assert plain.with_values({"contact.self_contact": False}).hash == plain.hash
    others = [
        heavy(gravity__orientation="as_drawn"),
        heavy(gravity__orientation="upright"),
        heavy(contact__self_contact=True),
        heavy(contact__self_contact=True, contact__gap="0.1 mm"),
        heavy(contact__table=True),
    ]
    assert len({plain.hash, *(design.hash for design in others)}) == 6


def test_gravity_may_stand_in_the_place_of_an_actuation() -> None:
    text = HEAVY.replace("[actuation]\neps_pre = -0.3\n", "[gravity]\n")
    assert Design.from_toml(text).eps_pre == 0.0


SLIT = '[contact]\nself_contact = true\n[outline]\nslits = [[["0 mm", "5 mm"], ["5 mm", "5 mm"]]]'
DYNAMIC = """
[solver]
kind = "dynamic"
[solver.dynamic]
time_step = "5 ms"
[solver.dynamic.course]
times = ["0 s", "1 s"]
actuation = [0, 1]
"""
TWO_WAYS = 'orientation = "upright"\ndirection = [0, 0, 1]'
BROKEN = {
    "density": (BARE, {}, ["layers[0].density", "weight"]),
    "falls": (HEAVY, {**FREE, "gravity.orientation": "as_drawn"}, ["gravity", "falls"]),
    "hangs free": (
        HEAVY,
        {**FREE, "gravity.orientation": "upright", "contact.table": True},
        ["gravity.orientation", "lies flat"],
    ),
    "leans": (
        HEAVY,
        {**FREE, "gravity.direction": [0, 1, -1], "contact.table": True},
        ["gravity.direction", "lies flat"],
    ),
    "hovers": (
        HEAVY,
        {
            **FREE,
            "gravity.orientation": "as_drawn",
            "contact.table": True,
            "contact.table_distance": "5 mm",
        },
        ["contact.table_distance", "begins on the table"],
    ),
    "no weight": (HEAVY, {**FREE, "contact.table": True}, ["contact.table", "[gravity]"]),
    "slit": (HEAVY.replace("[outline]", SLIT), {}, ["contact.self_contact", "cutouts"]),
    "dynamic": (HEAVY + DYNAMIC, {"contact.self_contact": True}, ["contact", "quasi_static"]),
    "no table": (HEAVY, {"contact.table_distance": "1 mm"}, ["contact.table_distance"]),
    "no direction": (HEAVY, {"gravity.direction": [0, 0, 0]}, ["gravity.direction", "[0, 0, -1]"]),
    "two ways": (
        HEAVY.replace(
            "[mesh]", '[gravity]\norientation = "upright"\ndirection = [0, 0, 1]\n[mesh]'
        ),
        {},
        ["gravity.direction", "exclude each other"],
    ),
    "unit": (HEAVY, {"gravity.magnitude": 9.81}, ["gravity.magnitude", "9.81 m/s^2"]),
    "range": (HEAVY, {"contact.range": "0 mm"}, ["contact.range", "0.1 um"]),
    "key": (HEAVY, {"contact.self": True}, ["contact.self", "self_contact"]),
    "orientation": (HEAVY, {"gravity.orientation": "down"}, ["gravity.orientation", "upright"]),
}


@pytest.mark.parametrize("name", BROKEN)
def test_what_is_refused_and_how(name: str) -> None:
    text, values, words = BROKEN[name]
    with pytest.raises(InputError) as error:
        Design.from_toml(text).with_values(values)
    for word in words:
        assert word in str(error.value)


def test_check_tells_of_weight_and_table_and_warns_of_soft_edges() -> None:
    values = {**FREE, "gravity.orientation": "turned_over", "contact.table": True}
    design = Design.from_toml(HEAVY).with_values(values)
    report = describe(design)
    text = format_description(report)
    assert report["gravity"]["weight"] == pytest.approx(9.80665 * report["mass"], rel=1e-12)
    assert "down is (0, 0, 1)" in text
    assert "with a table" in text
    assert "free to slide" in text
    assert report["warnings"] == []
    soft = describe(design.with_values({"model": "published"}))
    assert any("published.stretch_stiffness" in warning for warning in soft["warnings"])
