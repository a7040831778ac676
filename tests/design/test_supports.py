"""Held nodes and the perturbation load."""

from __future__ import annotations

import numpy as np
import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.design.laminate import film_stack
from sheetmorph.design.regions import regions
from sheetmorph.design.spec import Design
from sheetmorph.design.supports import held_nodes, perturbation_forces


def held(design: Design, mesh):
    return held_nodes(design, mesh, regions(design, mesh))


def with_supports(base: str, *tables: str) -> Design:
    start, end = base.index("[[supports]]"), base.index("[perturbation]")
    text = base[:start] + "\n".join(f"[[supports]]\n{table}" for table in tables) + base[end - 1 :]
    return Design.from_toml(text)


def test_a_box_holds_its_edges_too(base, strip):
    plane = strip.nodes[:, :2]
    design = with_supports(base, 'kind = "box"\nx = ["-4 mm", "4 mm"]\ny = ["-4 mm", "4 mm"]')
    nodes = held(design, strip)
    assert np.array_equal(nodes, np.flatnonzero((np.abs(plane) <= 0.004 + 1e-12).all(axis=1)))
    assert len(nodes) == 25


def test_pattern_in_box(base, strip):
    design = with_supports(
        base, 'kind = "pattern_in_box"\nx = ["-4 mm", "4 mm"]\ny = ["-9 mm", "9 mm"]'
    )
    assert len(held(design, strip)) == 5 * 3


def test_several_supports_add_up(base, strip):
    design = with_supports(
        base,
        'kind = "box"\nx = ["-4 mm", "4 mm"]\ny = ["-4 mm", "4 mm"]',
        'kind = "nodes"\nnodes = [7, 3]',
    )
    nodes = held(design, strip)
    assert len(nodes) == 27
    assert nodes[:2].tolist() == [3, 7]
    assert not design.is_free


@pytest.mark.parametrize("table", ['kind = "free"', None])
def test_a_free_sheet_holds_nothing(design, strip, table):
    design = design.with_values({"perturbation.shape": "bowl", "supports": None})
    if table:
        design = design.with_values({"supports": [{"kind": "free"}]})
    assert design.is_free
    assert len(held(design, strip)) == 0


@pytest.mark.parametrize(
    ("table", "fragment"),
    [
        ('kind = "box"\nx = ["30 mm", "40 mm"]\ny = ["0 mm", "1 mm"]', "holds no node"),
        ('kind = "nodes"\nnodes = [0, 1, 2, 3]', "on one line"),
        ('kind = "nodes"\nnodes = [0, 25]', "on one line"),
        ('kind = "nodes"\nnodes = [0, 1, 99999]', "no such node"),
    ],
)
def test_supports_that_do_not_hold(base, strip, table, fragment):
    with pytest.raises(InputError, match=fragment) as caught:
        held(with_supports(base, table), strip)
    assert "supports" in str(caught.value)


def test_uniform_force_per_node(design, strip):
    forces = perturbation_forces(design, strip)
    assert set(forces[:, 2]) == {1e-6}
    assert not forces[:, :2].any()


def test_uniform_total_force_is_shared_by_area(design, strip):
    design = design.with_values(
        {"perturbation.total_force": "2 mN", "perturbation.direction": "down"}
    )
    forces = perturbation_forces(design, strip)[:, 2]
    assert forces.sum() == pytest.approx(-2e-3, rel=1e-12)
    assert forces / forces.sum() == pytest.approx(strip.node_areas / strip.node_areas.sum())


def test_bowl_has_no_net_force_or_moment(design, strip):
    design = design.with_values({"perturbation.shape": "bowl", "perturbation.total_force": "1 mN"})
    forces = perturbation_forces(design, strip)[:, 2]
    assert np.abs(forces).sum() == pytest.approx(1e-3, rel=1e-12)
    assert abs(forces.sum()) < 1e-17
    assert np.abs(strip.nodes[:, :2].T @ forces).max() < 1e-18
    radius = np.linalg.norm(strip.nodes[:, :2], axis=1)
    assert forces[radius.argmin()] < 0 < forces[radius.argmax()]
    down = design.with_values({"perturbation.direction": "down"})
    assert np.array_equal(perturbation_forces(down, strip)[:, 2], -forces)


def test_a_perturbation_that_names_no_force_has_one(design, strip):
    design = design.with_values({"perturbation": None})
    assert np.abs(perturbation_forces(design, strip)).sum() == pytest.approx(
        0.1 * film_stack(design).flexural_rigidity / (0.5 * strip.size)
    )
