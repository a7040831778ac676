"""What is told of weight, table, contact and crossings: by the command line and by the report."""

from __future__ import annotations

from dataclasses import replace

import pytest
from small import SMALL

from sheetmorph.cli.run import _surroundings
from sheetmorph.design.spec import Design
from sheetmorph.show.citations import references
from sheetmorph.show.numbers import banner_of, tables_of
from sheetmorph.study.simulate import simulate

TABLE = {
    "reaction_N": 0.02,
    "nodes_in_contact": 1,
    "lowest_m": 2e-4,
    "gap_m": 1e-4,
    "range_m": 1e-4,
}
TOUCHING = [{"touches": False, "gap_m": 0.0}, {"touches": True, "gap_m": 3e-4}]

CASES = {
    "nothing": ({}, ""),
    "weight": ({"weight_N": 0.025}, "  weight     0.025 N\n"),
    "table": (
        {"weight_N": 0.025, "table": TABLE},
        "  table      bears 0.02 N of 0.025 N on 1 node\n",
    ),
    "contact": ({"self_contact": TOUCHING}, "  contact    the sheet touches itself\n"),
    "crossing": (
        {"crossing_pairs": 14},
        (
            "  warning    the sheet passes through itself in 14 pairs of triangles; "
            "contact.self_contact = true keeps its parts apart\n"
        ),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_lines_of_the_command(name: str) -> None:
    summary, expected = CASES[name]
    assert _surroundings({"crossing_pairs": 0, **summary}) == expected


def test_the_report_tells_of_them_and_doubts_a_shape_that_crosses() -> None:
    result = simulate(Design.from_toml(SMALL))
    assert banner_of(result).good
    crossing = replace(result, summary={**result.summary, "crossing_pairs": 1})
    banner = banner_of(crossing)
    assert not banner.good
    assert any("in a pair of triangles" in line for line in banner.lines)
    summary = {"table": TABLE, "weight_N": 0.02, "self_contact": TOUCHING, "crossing_pairs": 0}
    (around,) = (table for table in tables_of(summary) if table.title == "Around the sheet")
    told = {row.label: f"{row.value} {row.unit}".strip() for row in around.rows}
    assert told["Borne by the table"] == "20 mN"
    assert told["Lowest node above the table"] == "0.2 mm"
    assert told["Touches itself"] == "yes"
    assert told["Pairs of triangles that cross"] == "0"


def test_who_is_cited() -> None:
    def keys(**summary: object) -> set[str]:
        return {citation.key for citation in references(summary)}

    assert {"li2020", "li2021"} <= keys(self_contact=TOUCHING)
    assert "li2020" in keys(table=TABLE)
    assert not {"li2020", "li2021"} & keys(model="laminate")
