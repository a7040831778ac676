"""Handles lie where the shape says, and dragging one sets the key that it says."""

from __future__ import annotations

import math
from typing import Any

import pytest
import shapely

import sheetmorph as sm
from sheetmorph.design.presets import preset_text
from sheetmorph.studio.handles import handles
from sheetmorph.studio.plan import plan

SHAPES: dict[str, dict[str, Any]] = {
    "star": {"arms": 5, "arm_length": "30 mm", "half_width": "4 mm", "hub_radius": "8 mm"},
    "cross": {"arm_length": "25 mm", "half_width": "4 mm", "rotation": "20 deg"},
    "twin_star": {"arm_length": "15 mm", "half_width": "3 mm", "spacing": "30 mm"},
    "bar": {"start": ["-10 mm", "2 mm"], "end": ["20 mm", "12 mm"], "half_width": "3 mm"},
    "lotus": {
        "petals": 5,
        "disc_radius": "9 mm",
        "radius": "30 mm",
        "petal_half_width": "5 mm",
        "rotation": "10 deg",
    },
    "ring": {"radius": "30 mm", "width": "5 mm"},
    "rings": {"count": 2, "spacing": "14 mm", "width": "4 mm", "spokes": 3},
    "spiral": {"turns": 2, "pitch": "9 mm", "half_width": "2.5 mm"},
    "disc": {"radius": "12 mm", "centre": ["3 mm", "-4 mm"]},
    "ellipse": {"half_width": "22 mm", "half_height": "9 mm", "rotation": "30 deg"},
    "rectangle": {"width": "40 mm", "height": "12 mm", "rotation": "-25 deg"},
    "regular_polygon": {"sides": 5, "radius": "20 mm", "rotation": "12 deg"},
    "polygon": {"points": [["0 mm", "0 mm"], ["20 mm", "0 mm"], ["5 mm", "18 mm"]]},
}


def design_with(kind: str) -> sm.Design:
    base = sm.Design.from_toml(preset_text("bowl"))
    return base.with_values({"pattern": [{"kind": kind, **SHAPES[kind], "clip": True}]})


def dragged(handle: dict[str, Any], along: float) -> dict[str, object]:
    """The values that the browser sends when a handle is moved (plan.js: values)."""
    if handle["rule"] == "move":
        x, y = handle["at"]
        return {handle["key"]: [f"{x + along} mm", f"{y} mm"]}
    return {handle["key"]: f"{handle['value'] + along} {handle['unit']}"}


@pytest.mark.parametrize("kind", SHAPES)
def test_a_handle_follows_its_value(kind: str) -> None:
    design = design_with(kind)
    found = [handle for handle in handles(design) if handle["key"].startswith("pattern")]
    assert found, "a kind of shape without a handle has no place in the table"
    for number, handle in enumerate(found):
        moved = design.with_values(dragged(handle, 1.0))
        after = [h for h in handles(moved) if h["key"].startswith("pattern")][number]
        assert after["key"] == handle["key"]
        step = math.dist(after["at"], handle["at"])
        if handle["rule"] == "slide":
            assert after["value"] == pytest.approx(handle["value"] + 1.0, abs=1e-9)
            assert step == pytest.approx(1.0 / handle["factor"], abs=1e-9)
        elif handle["rule"] == "move":
            assert step == pytest.approx(1.0, abs=1e-9)
        else:
            radius = math.dist(handle["at"], handle["origin"])
            assert step == pytest.approx(2 * radius * math.sin(math.radians(0.5)), abs=1e-9)
        assert moved.pattern_polygon().symmetric_difference(design.pattern_polygon()).area > 1e-8


@pytest.mark.parametrize(
    ("kind", "key"),
    [
        ("star", "arm_length"),
        ("star", "half_width"),
        ("lotus", "radius"),
        ("ring", "radius"),
        ("disc", "radius"),
        ("ellipse", "half_height"),
        ("rectangle", "width"),
        ("regular_polygon", "radius"),
        ("bar", "half_width"),
        ("cross", "half_width"),
    ],
)
def test_handles_of_sizes_lie_on_the_rim_of_the_pattern(kind: str, key: str) -> None:
    design = design_with(kind)
    (handle,) = [h for h in handles(design) if h["key"] == f"pattern.0.{key}"]
    rim = design.pattern_polygon().boundary
    assert 1e3 * rim.distance(shapely.Point([v / 1e3 for v in handle["at"]])) < 0.02


def test_the_plan_has_the_areas_of_the_design() -> None:
    design = sm.Design.from_toml(preset_text("bowl"))
    shown = plan(design)

    def area(rings: list[list[list[float]]]) -> float:
        return sum(abs(shapely.Polygon(ring).area) for ring in rings[:1]) - sum(
            abs(shapely.Polygon(ring).area) for ring in rings[1:]
        )

    assert area(shown["sheet"]) == pytest.approx(1e6 * design.outline_polygon().area, rel=1e-3)
    assert area(shown["parts"]["pattern"]) == pytest.approx(
        1e6 * design.pattern_polygon().area, rel=1e-3
    )
    assert shown["supports"] == [[-10.0, 10.0, -10.0, 10.0]]
    assert shown["box"] == pytest.approx([-50.0, -50.0, 50.0, 50.0])


def test_a_polygon_of_many_corners_has_no_handles() -> None:
    points = [[50 * math.cos(t / 20), 50 * math.sin(t / 20)] for t in range(125)]
    outline = {"kind": "polygon", "unit": "mm", "points": points}
    design = sm.Design.from_toml(preset_text("bowl")).with_values({"outline": outline})
    assert not [h for h in handles(design) if h["key"].startswith("outline")]
