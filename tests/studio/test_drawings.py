"""Drawings become polygons in the design: where they lie, what is free, what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from small import SMALL

import sheetmorph as sm
from sheetmorph.design.presets import preset_text
from sheetmorph.studio.drawings import with_drawing

DRAWING = """<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="80mm"
 viewBox="0 0 100 80">
<rect id="sheet" x="10" y="10" width="80" height="60" fill="none" stroke="black"
 stroke-width="0.1"/>
<rect id="pattern" x="30" y="34" width="40" height="12"/>
<g id="two"><rect x="12" y="12" width="5" height="5"/><rect x="50" y="50" width="5" height="5"/></g>
<path id="rib" d="M 20 40 H 80" fill="none" stroke="black" stroke-width="6"/>
<path id="slits" d="M 20 20 H 40" fill="none" stroke="red" stroke-width="0.1"/></svg>"""


@pytest.fixture
def drawing(tmp_path: Path) -> Path:
    file = tmp_path / "drawing.svg"
    file.write_text(DRAWING, encoding="utf-8")
    return file


def test_sheet_and_pattern_keep_their_places(drawing: Path) -> None:
    text = with_drawing(preset_text("bowl"), drawing, {"sheet": "sheet", "pattern": "pattern"})
    design = sm.Design.from_toml(text)  # without a folder: the text needs no file
    assert design.outline_polygon().area == pytest.approx(80e-3 * 60e-3, rel=1e-6)
    assert design.pattern_polygon().bounds == pytest.approx((0.03, 0.034, 0.07, 0.046), abs=1e-7)
    assert design.is_free
    assert design.perturbation.shape == "bowl"
    assert "# it shrinks (or swells) when actuated" in text  # comments stay
    assert sm.simulate(design.with_values({"actuation.eps_pre": -0.1})).status == "completed"


def test_a_pattern_alone_is_centred_on_the_sheet(drawing: Path) -> None:
    text = with_drawing(preset_text("bowl"), drawing, {"pattern": "pattern"})
    design = sm.Design.from_toml(text)
    assert design.pattern_polygon().bounds == pytest.approx((-0.02, -0.006, 0.02, 0.006), abs=1e-7)
    assert len(design.supports) == 1


def test_a_sheet_alone_is_centred_and_cuts_the_pattern_off(drawing: Path) -> None:
    text = with_drawing(preset_text("bowl"), drawing, {"sheet": "sheet"})
    design = sm.Design.from_toml(text)
    assert design.outline_polygon().bounds == pytest.approx((-0.04, -0.03, 0.04, 0.03), abs=1e-7)
    assert design.pattern_polygon().bounds[3] == pytest.approx(0.03, abs=1e-6)


def test_wide_strokes_are_ribs(drawing: Path) -> None:
    design = sm.Design.from_toml(with_drawing(SMALL, drawing, {"sheet": "sheet", "pattern": "rib"}))
    assert design.pattern_polygon().area == pytest.approx(60e-3 * 6e-3, rel=1e-3)


def test_slits_come_along(drawing: Path) -> None:
    roles = {"sheet": "sheet", "pattern": "pattern", "slits": "slits"}
    design = sm.Design.from_toml(with_drawing(SMALL, drawing, roles))
    assert design.layout.slits.length == pytest.approx(20e-3, rel=1e-6)


@pytest.mark.parametrize(
    ("roles", "said"),
    [
        ({}, "choose what the drawing is to be"),
        ({"sheet": "nothing"}, "nothing in the drawing has that name"),
        ({"sheet": "two"}, "in 2 pieces"),
        ({"sheet": "sheet", "unit": "parsec"}, "unit"),
    ],
)
def test_what_cannot_be_used_is_told(drawing: Path, roles: dict[str, str], said: str) -> None:
    with pytest.raises(sm.InputError, match=said):
        with_drawing(SMALL, drawing, roles)
