"""Components that supports hold, edges that keep their normal, and rigid motions that are left."""

from __future__ import annotations

import numpy as np
import pytest
from laminates import LAMINATE

from sheetmorph.core.errors import InputError
from sheetmorph.design.regions import regions
from sheetmorph.design.spec import Design
from sheetmorph.design.supports import directed_edges, held_components, held_nodes

LEFT = 'kind = "box"\nx = ["-20 mm", "-20 mm"]\ny = ["-10 mm", "10 mm"]'
MESH = "[mesh]"


def held_by(*tables: str) -> Design:
    start, end = LAMINATE.index("[[supports]]"), LAMINATE.index(MESH)
    rows = "".join(f"[[supports]]\n{table}\n" for table in tables)
    return Design.from_toml(LAMINATE[:start] + rows + LAMINATE[end:])


def of(function, design, mesh):
    return function(design, mesh, regions(design, mesh))


def test_components_add_up(strip):
    design = held_by(
        'kind = "box"\nx = ["-20 mm", "-10 mm"]\ny = ["-10 mm", "10 mm"]\nhold = ["z", "x"]',
        'kind = "nodes"\nnodes = [0]\nhold = ["y"]',
    )
    held = of(held_components, design, strip)
    left = strip.nodes[:, 0] <= -0.01 + 1e-12
    assert np.array_equal(held[:, 0], left)
    assert np.array_equal(held[:, 2], left)
    assert np.flatnonzero(held[:, 1]).tolist() == [0]
    assert np.array_equal(of(held_nodes, design, strip), np.flatnonzero(left))


def test_all_three_by_default(design, strip):
    held = of(held_components, design, strip)
    assert np.array_equal(held.any(axis=1), held.all(axis=1))
    assert held.any()


def test_a_clamped_edge_needs_no_second_line(strip):
    with pytest.raises(InputError, match="on one line"):
        of(held_components, held_by(LEFT), strip)
    design = held_by(f"{LEFT}\nclamp = true")
    assert of(held_components, design, strip).all(axis=1).sum() == 11
    edges, conormal = of(directed_edges, design, strip)
    assert edges.dtype == np.int32
    assert (np.diff(edges) > 0).all()
    assert np.array_equal(np.sort(strip.edges[edges], axis=1)[:, 0] % 21, np.zeros(10))
    assert np.array_equal(conormal, np.tile([-1.0, 0.0, 0.0], (10, 1)))


def test_a_clamp_takes_the_edges_of_the_rim_alone(strip):
    box = 'kind = "box"\nx = ["-20 mm", "-10 mm"]\ny = ["-10 mm", "10 mm"]\nclamp = true'
    edges, conormal = of(directed_edges, held_by(box), strip)
    assert len(edges) == 10 + 5 + 5
    middle = strip.edge_midpoints[edges]
    expected = np.where(
        np.isclose(middle[:, [0]], -0.02), [-1.0, 0.0], np.sign(middle[:, [1]]) * [0.0, 1.0]
    )
    assert conormal[:, :2] == pytest.approx(expected, abs=1e-14)


def test_planes_of_symmetry(strip):
    design = held_by(
        'kind = "symmetry"\nplane = "x"\nat = "-20 mm"',
        'kind = "symmetry"\nplane = "y"\nat = "10 mm"',
        'kind = "nodes"\nnodes = [0]\nhold = ["z"]',
    )
    held = of(held_components, design, strip)
    assert np.array_equal(held[:, 0], np.isclose(strip.nodes[:, 0], -0.02))
    assert np.array_equal(held[:, 1], np.isclose(strip.nodes[:, 1], 0.01))
    edges, conormal = of(directed_edges, design, strip)
    assert len(edges) == 10 + 20
    top = np.isclose(strip.edge_midpoints[edges, 1], 0.01)
    assert top.sum() == 20
    assert np.array_equal(conormal[top], np.tile([0.0, 1.0, 0.0], (20, 1)))
    assert np.array_equal(conormal[~top], np.tile([-1.0, 0.0, 0.0], (10, 1)))


def test_without_clamps_no_edge_is_directed(design, strip):
    edges, conormal = of(directed_edges, design, strip)
    assert edges.shape == (0,)
    assert conormal.shape == (0, 3)


X_PLANE = 'kind = "symmetry"\nplane = "x"\nat = "-20 mm"'
FLAT = 'kind = "box"\nx = ["-20 mm", "20 mm"]\ny = ["-10 mm", "10 mm"]\nhold = ["z"]'


@pytest.mark.parametrize(
    ("tables", "motion"),
    [
        ([LEFT], "turn about the line along y through (-20, 0, 0) mm"),
        ([FLAT], "move along x and y, and turn about z"),
        (
            [FLAT, 'kind = "nodes"\nnodes = [0]'],
            "turn about the line along z through (-20, -10, 0)",
        ),
        ([X_PLANE], "move along y and z, and turn about x"),
        ([X_PLANE, 'kind = "nodes"\nnodes = [3]\nhold = ["y"]'], "move along z, and turn about"),
        ([f'{LEFT}\nclamp = true\nhold = ["x", "z"]'], "move along y"),
        (['kind = "nodes"\nnodes = [0]'], "turn about x, y and z"),
        (['kind = "nodes"\nnodes = [0, 22]'], "turn about the line along (0.71, 0.71, 0.00) thr"),
    ],
)
def test_the_motion_that_is_left_is_named(strip, tables, motion):
    with pytest.raises(InputError) as caught:
        of(held_components, held_by(*tables), strip)
    message = str(caught.value)
    assert message.startswith("supports: the supports hold ")
    assert f"so the sheet can still {motion}" in message
    assert "a free sheet" in message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("tables", "fragments"),
    [
        ([f'{LEFT}\nhold = ["x", "x"]'], ["supports[0].hold", "twice"]),
        ([f'{LEFT}\nhold = ["u"]'], ["supports[0].hold[0]", "'u'", "x, y, z"]),
        ([f"{LEFT}\nhold = []"], ["supports[0].hold", "≥ 1"]),
        ([f'{LEFT}\nclamp = "yes"'], ["supports[0].clamp", "true or false"]),
        ([f'{LEFT}\nz = ["1 mm", "0 mm"]'], ["supports[0].z", "smaller"]),
        (['kind = "symmetry"\nplane = "z"'], ["supports[0].plane", "'z'", "x, y"]),
        (['kind = "symmetry"'], ["supports[0].plane: is required"]),
        (['kind = "symmetry"\nplane = "x"\nhold = ["x"]'], ["supports[0].hold", "unknown key"]),
        ([X_PLANE, 'kind = "free"'], ["supports[1].kind", "remove one"]),
    ],
)
def test_broken_supports(tables, fragments):
    with pytest.raises(InputError) as caught:
        held_by(*tables)
    for fragment in fragments:
        assert fragment in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("table", "fragments"),
    [
        ('kind = "nodes"\nnodes = [0, 5, 100]\nclamp = true', ["supports[0].clamp", "no edge"]),
        ('kind = "symmetry"\nplane = "x"\nat = "1 m"', ["supports[0]: holds no node"]),
        (f'{LEFT}\nz = ["1 mm", "2 mm"]', ["supports[0]: holds no node"]),
    ],
)
def test_supports_that_do_not_hold(strip, table, fragments):
    with pytest.raises(InputError) as caught:
        of(held_components, held_by(table), strip)
    for fragment in fragments:
        assert fragment in str(caught.value)


@pytest.mark.parametrize(
    ("table", "key"),
    [
        (f'{LEFT}\nhold = ["x"]', "supports[0].hold"),
        (f"{LEFT}\nclamp = true", "supports[0].clamp"),
        (X_PLANE, "supports[0].kind"),
    ],
)
def test_the_published_model_holds_whole_nodes(table, key):
    text = held_by(table).to_toml().replace('"laminate"', '"published"')
    with pytest.raises(InputError) as caught:
        Design.from_toml(text)
    assert str(caught.value).startswith(f"{key}: belongs to the laminate model")


def test_hash_of_supports():
    plain = held_by(f"{LEFT}\nclamp = true")
    named = held_by(f'{LEFT}\nclamp = true\nhold = ["y", "z", "x"]')
    assert named.hash == plain.hash
    assert held_by(f'{LEFT}\nclamp = true\nhold = ["y", "z"]').hash != plain.hash
