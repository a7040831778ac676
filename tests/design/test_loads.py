"""Forces of loads on nodes: totals, shares, places, and loads that cannot be borne."""

from __future__ import annotations

import numpy as np
import pytest
from laminates import LAMINATE

from sheetmorph.core.errors import InputError
from sheetmorph.design.check import describe, format_description
from sheetmorph.design.loads import load_forces
from sheetmorph.design.regions import regions
from sheetmorph.design.spec import Design
from sheetmorph.design.supports import directed_edges, held_components
from sheetmorph.geometry.files import write_mesh
from sheetmorph.geometry.structured import ring_sector

POINT = 'kind = "point"\nat = ["20 mm", "0 mm"]\nforce = ["0 N", "0 N", "4 mN"]'
RIGHT = 'x = ["20 mm", "20 mm"]\ny = ["-10 mm", "10 mm"]'
LINE = f'kind = "line"\n{RIGHT}\nforce_per_length = ["0 N/m", "1 N/m", "-2 mN/mm"]'
AREA = 'kind = "area"\nforce_per_area = ["0 Pa", "0 Pa", "-5 Pa"]'
ZERO = '"0 N", "0 N", "0 N"'


def loaded(*tables: str, text: str = LAMINATE) -> Design:
    return Design.from_toml(text + "".join(f"[[loads]]\n{table}\n" for table in tables))


def forces(design, mesh):
    return load_forces(design, mesh, regions(design, mesh))


def test_without_loads_no_forces(design, strip):
    assert not forces(design, strip).any()


def test_a_point_load_acts_on_the_nearest_node(strip):
    got = forces(loaded(POINT.replace("20 mm", "20.4 mm")), strip)
    node = int(np.flatnonzero(got.any(axis=1))[0])
    assert strip.nodes[node] == pytest.approx([0.02, 0.0, 0.0], abs=1e-12)
    assert got[node].tolist() == [0.0, 0.0, 4e-3]
    assert np.count_nonzero(got) == 1
    by_index = f'kind = "point"\nnode = {node}\nforce = ["0 N", "0 N", "4 mN"]'
    assert np.array_equal(forces(loaded(by_index), strip), got)
    three = POINT.replace('"0 mm"]', '"0 mm", "0 mm"]')
    assert np.array_equal(forces(loaded(three), strip), got)


def test_a_line_load_is_shared_by_length(strip):
    got = forces(loaded(LINE), strip)
    right = np.isclose(strip.nodes[:, 0], 0.02)
    assert not got[~right].any()
    shares = np.where(np.isclose(np.abs(strip.nodes[right, 1]), 0.01), 1e-3, 2e-3)
    assert got[right, 1] == pytest.approx(shares, rel=1e-12)
    assert got[right, 2] == pytest.approx(-2 * shares, rel=1e-12)
    nodes = ", ".join(map(str, np.flatnonzero(right)))
    named = LINE.replace(RIGHT, f"nodes = [{nodes}]")
    assert np.array_equal(forces(loaded(named), strip), got)


def test_a_line_load_takes_edges_of_the_rim_alone(strip):
    box = 'x = ["10 mm", "20 mm"]\ny = ["-10 mm", "10 mm"]'
    got = forces(loaded(LINE.replace(RIGHT, box)), strip)
    assert got[:, 1].sum() == pytest.approx(0.02 + 2 * 0.01, rel=1e-12)


def test_an_area_load_is_shared_by_area(strip):
    got = forces(loaded(AREA), strip)
    assert got[:, 2] == pytest.approx(-5 * strip.node_areas, rel=1e-12)
    assert got[:, 2].sum() == pytest.approx(-5 * 0.04 * 0.02, rel=1e-12)


def test_weight_by_the_layers(strip):
    design = loaded('kind = "weight"')
    region = regions(design, strip)
    got = forces(design, strip)
    areas = strip.triangle_areas
    mass = 0.3 * areas.sum() + 1.0 * areas[region.triangle_in_pattern].sum()  # 1000 kg/m³
    assert got[:, 2].sum() == pytest.approx(-9.80665 * mass, rel=1e-12)
    moon = 'kind = "weight"\ngravity = "1.6 m/s^2"\ndirection = [3, 0, 4]'
    assert forces(loaded(moon), strip).sum(axis=0) == pytest.approx(
        1.6 * mass * np.array([0.6, 0.0, 0.8]), rel=1e-12
    )


def test_loads_add_up(strip):
    both = forces(loaded(POINT, AREA), strip)
    parts = forces(loaded(POINT), strip) + forces(loaded(AREA), strip)
    assert np.array_equal(both, parts)


def test_loads_alone_need_no_actuation_and_no_active_layer(strip):
    text = LAMINATE.replace("[actuation]\neps_pre = -0.3\n", "")
    design = loaded(AREA, text=text)
    assert design.eps_pre == 0.0
    passive = loaded(AREA, text=text.replace('"active"', '"inert"'))
    report = describe(passive, strip)
    assert report["warnings"] == []
    assert report["actuation"]["strain_range"] == [0.0, 0.0]
    assert report["loads"]["net_force"][2] == pytest.approx(-5 * 0.04 * 0.02, rel=1e-12)
    assert "loads         0.004 N in all, net (0, 0, -0.004) N" in format_description(report)


def test_hash_of_loads():
    assert loaded(POINT).hash != loaded().hash
    assert loaded(POINT).hash == loaded(POINT.replace("4 mN", "0.004 N")).hash
    assert loaded(POINT).hash != loaded(POINT.replace("4 mN", "5 mN")).hash


FREE = LAMINATE[: LAMINATE.index("[[supports]]")] + LAMINATE[LAMINATE.index("[mesh]") :]
ENDS = "\n".join(
    f'[[loads]]\nkind = "line"\nx = ["{x} mm", "{x} mm"]\ny = ["-10 mm", "10 mm"]\n'
    f'force_per_length = ["{f} N/m", "0 N/m", "0 N/m"]'
    for x, f in ((-20, -1), (20, 1))
)


def test_a_free_sheet_bears_loads_that_balance(strip):
    design = Design.from_toml(f"{FREE}{ENDS}")
    assert forces(design, strip).sum() == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(
    ("tables", "what"),
    [([AREA], "force of (0, 0, -0.004) N"), (["CORNERS"], "moment of (")],
)
def test_loads_that_a_free_sheet_cannot_bear(strip, tables, what):
    corners = [f'kind = "point"\nnode = {n}\nforce = ["0 N", "0 N", "{f} N"]' for n, f in
               ((0, 1), (20, -1))]  # fmt: skip
    with pytest.raises(InputError) as caught:
        forces(loaded(*(corners if tables == ["CORNERS"] else tables), text=FREE), strip)
    message = str(caught.value)
    assert message.startswith("loads: the sheet is free")
    assert what in message
    assert "[[supports]]" in message


@pytest.mark.parametrize(
    ("table", "fragments"),
    [
        (POINT.replace("20 mm", "30 mm"), ["loads[0].at", "(30, 0) mm", "within 2.83 mm"]),
        (f'kind = "point"\nnode = 9999\nforce = [{ZERO}]', ["loads[0].node", "0 to 230"]),
        (LINE.replace('"20 mm", "20 mm"', '"7 mm", "9 mm"').replace("-10", "-9").replace(
            '"10', '"9'), ["loads[0]: acts on no edge of the rim"]),
    ],
)  # fmt: skip
def test_loads_that_meet_nothing(strip, table, fragments):
    with pytest.raises(InputError) as caught:
        forces(loaded(table), strip)
    for fragment in fragments:
        assert fragment in str(caught.value)


def test_a_place_between_nodes_is_told(strip):
    with pytest.raises(InputError, match=r"loads\[0\].at: several nodes .*allowed: "):
        forces(loaded(POINT.replace('"0 mm"', '"1 mm"')), strip)


BROKEN = {
    "kind": (POINT.replace("point", "pint"), ["loads[0].kind", "did you mean point?", "weight"]),
    "no kind": (POINT.replace('kind = "point"\n', ""), ["loads[0].kind: is required"]),
    "no force": (POINT[: POINT.index("force")], ["loads[0].force: is required"]),
    "two components": (
        POINT.replace('"0 N", "0 N", "4 mN"', '"0 N", "4 mN"'),
        ["loads[0].force: has 2 entries", "≥ 3"],
    ),
    "unit": (POINT.replace("4 mN", "4 mm"), ["loads[0].force[2]", "not a unit of force"]),
    "no place": (POINT.replace('at = ["20 mm", "0 mm"]', ""), ["loads[0].at", "at or node"]),
    "two places": (f"{POINT}\nnode = 3", ["loads[0].node", "exclude each other"]),
    "line unit": (
        LINE.replace("1 N/m", "1 N"),
        ["loads[0].force_per_length[1]", "force per length", '"0.8 N/m"'],
    ),
    "line place": (LINE.replace(RIGHT, ""), ["loads[0].x", "x and y, or nodes"]),
    "line half a place": (
        LINE.replace('y = ["-10 mm", "10 mm"]', ""),
        ["loads[0].y", "x and y, or nodes"],
    ),
    "line two places": (f"{LINE}\nnodes = [0, 1]", ["loads[0].nodes", "exclude each other"]),
    "line reversed": (LINE.replace('"-10 mm", "10', '"20 mm", "10'), ["loads[0].y", "smaller"]),
    "gravity": ('kind = "weight"\ngravity = 9.81', ["loads[0].gravity", "an acceleration"]),
    "direction": ('kind = "weight"\ndirection = [0, 0, 0]', ["loads[0].direction", "[0, 0, -1]"]),
    "area": (AREA.replace("-5 Pa", "-5 N"), ["loads[0].force_per_area[2]", "pressure"]),
}


@pytest.mark.parametrize("case", BROKEN)
def test_broken_loads(case):
    table, fragments = BROKEN[case]
    with pytest.raises(InputError) as caught:
        loaded(table)
    for fragment in fragments:
        assert fragment in str(caught.value)
    assert "\n" not in str(caught.value)


def test_nothing_that_moves():
    bare = LAMINATE.replace("[actuation]\neps_pre = -0.3\n", "")
    with pytest.raises(InputError, match="actuation: is required, unless the design has loads"):
        Design.from_toml(bare)
    passive = LAMINATE.replace('"active"', '"inert"')
    with pytest.raises(InputError, match="layers: no layer is active"):
        Design.from_toml(passive)
    with pytest.raises(InputError, match="actuation: no layer is active"):
        loaded(AREA, text=passive)


def test_the_published_model_has_no_loads():
    with pytest.raises(InputError, match=r"loads\[0\].kind: belongs to the laminate model"):
        loaded(AREA, text=LAMINATE.replace('"laminate"', '"published"'))


RING = """\
name = "ring"
model = "laminate"
[outline]
kind = "disc"
radius = "10 m"
[[outline.cutouts]]
kind = "disc"
radius = "6 m"
[[layers]]
name = "shell"
role = "inert"
thickness = "3 cm"
young_modulus = "21 MPa"
poisson_ratio = 0.0
[[supports]]
kind = "nodes"
nodes = [0, 1, 2, 3, 4]
clamp = true
[[loads]]
kind = "line"
nodes = [200, 201, 202, 203, 204]
force_per_length = ["0 N/m", "0 N/m", "0.8 N/m"]
[mesh]
file = "ring.txt"
unit = "m"
"""


def test_the_two_faces_of_a_slit_are_told_apart_by_their_nodes(tmp_path):
    write_mesh(tmp_path / "ring.txt", ring_sector(6.0, 10.0, 4, 40))
    design = Design.from_toml(RING, tmp_path)
    mesh = design.build_mesh()
    region = regions(design, mesh)
    assert np.flatnonzero(held_components(design, mesh, region).all(axis=1)).tolist() == [*range(5)]
    edges, conormal = directed_edges(design, mesh, region)
    assert len(edges) == 4
    assert np.array_equal(conormal, np.tile([0.0, -1.0, 0.0], (4, 1)))
    got = load_forces(design, mesh, region)
    assert got[200:, 2] == pytest.approx([0.4, 0.8, 0.8, 0.8, 0.4], rel=1e-12)
    assert got.sum() == pytest.approx(4 * 0.8, rel=1e-12)
    at = RING.replace("nodes = [200, 201, 202, 203, 204]", 'at = ["8 m", "0 m"]')
    at = at.replace('"line"', '"point"').replace("force_per_length", "force").replace("N/m", "N")
    with pytest.raises(InputError, match=r"name one by node .*allowed: 2, 202"):
        forces(Design.from_toml(at, tmp_path), mesh)
