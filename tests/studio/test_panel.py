"""The panel says what the design says, and what it sends back is understood."""

from __future__ import annotations

from typing import Any

import pytest

import sheetmorph as sm
from sheetmorph.design.presets import PRESETS, preset_text
from sheetmorph.studio.panel import panel


def sent_back(entry: dict[str, Any]) -> object:
    """What the browser sends for an entry that was not changed (panel.js: commit)."""
    value = entry["value"]
    if entry["type"] == "pair":
        return [f"{part} {entry['unit']}" for part in value]
    if entry["type"] == "quantity" and entry["unit"]:
        return f"{value} {entry['unit']}"
    return value


@pytest.mark.parametrize("preset", PRESETS)
def test_sending_all_values_back_changes_nothing(preset: str) -> None:
    design = sm.Design.from_toml(preset_text(preset))
    values = {
        entry["key"]: sent_back(entry)
        for group in panel(design)
        for entry in group["entries"]
        if entry["given"]
    }
    assert len(values) > 20
    assert design.with_values(values).hash == design.hash


def test_values_units_ranges_and_words() -> None:
    design = sm.Design.from_toml(preset_text("bowl"))
    entries = {entry["key"]: entry for group in panel(design) for entry in group["entries"]}
    length = entries["pattern.0.arm_length"]
    assert (length["value"], length["unit"], length["type"]) == (44.1, "mm", "quantity")
    assert (length["low"], length["high"]) == (0.01, 10_000.0)
    assert "to the end of an arm" in length["help"]
    assert entries["pattern.0.arms"]["type"] == "whole"
    assert entries["pattern.0.tip"]["choices"] == ["square", "round"]
    assert entries["outline.centre"]["value"] == [0.0, 0.0]
    assert entries["actuation.temperature"]["value"] is None
    assert entries["layers.1.young_modulus"]["unit"] == "MPa"
    assert entries["actuation.eps_pre"]["low"] == -0.95
    assert entries["model"]["choices"] == ["published", "laminate"]


def test_a_bound_on_the_panel_is_a_bound_of_the_design() -> None:
    design = sm.Design.from_toml(preset_text("bowl"))
    entries = {entry["key"]: entry for group in panel(design) for entry in group["entries"]}
    for key in ("actuation.eps_pre", "pattern.0.arms", "layers.0.poisson_ratio"):
        beyond = entries[key]["high"] + 1
        with pytest.raises(sm.InputError, match=key.split(".")[-1]):
            design.with_values({key: int(beyond) if key.endswith("arms") else beyond})


def test_options_of_the_other_model_are_not_shown() -> None:
    keys = {group["key"] for group in panel(sm.Design.from_toml(preset_text("bowl")))}
    assert "published" in keys
    assert "laminate" not in keys
