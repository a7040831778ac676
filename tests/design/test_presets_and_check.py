"""Presets are valid designs of the paper's sheets; `describe` sums a design up."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.design.check import describe, format_description
from sheetmorph.design.presets import PRESETS, preset_text
from sheetmorph.design.spec import Design


@pytest.mark.parametrize("name", PRESETS)
def test_presets_are_valid_and_can_be_meshed(name):
    design = Design.from_toml(preset_text(name))
    assert design.name == name
    report = describe(design)
    assert json.loads(json.dumps(report)) == report
    assert report["mesh"]["mean_edge_length"] == pytest.approx(design.spec.mesh.size, rel=0.1)
    assert report["mesh"]["smallest_angle"] > math.radians(20)
    assert report["warnings"] == []
    area = sum(region["area"] for region in report["regions"].values())
    assert area == pytest.approx(design.outline_polygon().area, rel=0.01)
    assert (report["supports"]["held_nodes"] == 0) == (name == "blank")


def test_paper_presets_are_the_examples_but_for_the_mesh(examples):
    for name in ("bowl", "canoe", "petals"):
        preset, example = (
            Design.from_toml(preset_text(name)),
            Design.load(examples / f"{name}.toml"),
        )
        assert preset.layers == example.layers
        assert preset.actuation == example.actuation
        assert preset.pattern_polygon().area == pytest.approx(
            example.pattern_polygon().area, rel=1e-3
        )


def test_a_preset_under_another_name():
    assert Design.from_toml(preset_text("bowl", "my bowl")).name == "my bowl"
    with pytest.raises(InputError, match="is not a name for a design"):
        preset_text("bowl", 'x"\nname="y')
    with pytest.raises(InputError, match="did you mean petals"):
        preset_text("petal")


def test_numbers_of_a_design(design, strip):
    report = describe(design, strip)
    assert report["hash"] == design.hash
    assert report["mesh"]["nodes"] == 21 * 11
    # 25 nodes in the box of 5 mm around the middle (2 mm apart), the rest move in space.
    assert report["supports"] == {"held_nodes": 25, "free_dofs": 3 * (231 - 25)}
    assert report["regions"]["film"]["flexural_rigidity"] == pytest.approx(2.25e-6)
    assert report["perturbation"]["total_force"] == pytest.approx(231e-6)
    assert report["actuation"]["strain_range"] == pytest.approx([-0.3, 0.0])
    text = format_description(report)
    for fragment in ("231 nodes", "film + PLA", "D 2.25e-06 N·m", "25 nodes held", "-0.3"):
        assert fragment in text


def test_numbers_of_a_free_sheet_without_pattern(design, strip):
    bare = design.with_values(
        {"pattern": [], "layers.1": None, "supports": None, "perturbation.shape": "bowl"}
    )
    report = describe(bare, strip)
    assert list(report["regions"]) == ["film"]
    assert report["supports"] == {"held_nodes": 0, "free_dofs": 3 * 231 - 6}
    assert "free sheet" in format_description(report)


def test_warnings(design, strip):
    report = describe(design.with_values({"actuation.eps_pre": 0}), strip)
    assert any("stays flat" in warning for warning in report["warnings"])
    narrow = design.with_values({"pattern.0.half_width": "1.2 mm"})
    report = describe(narrow, strip)
    assert any("finer mesh" in warning for warning in report["warnings"])
    assert "warning" in format_description(report)
    assert np.isfinite(report["mass"])


@pytest.mark.parametrize(("name", "warned"), [("canoe", True), ("petals", False), ("blank", False)])
def test_supports_that_break_the_symmetry_of_the_mesh_are_told(name, warned):
    design = Design.from_toml(preset_text(name)).with_values({"mesh.symmetry": "auto"})
    report = describe(design)
    assert any("symmetry" in warning for warning in report["warnings"]) == warned
    assert report["mesh"]["symmetry"] == str(design.symmetry)
