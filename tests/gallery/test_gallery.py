"""Every design of the gallery gives the numbers that its page shows."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import sheetmorph as sm

ROOT = Path(__file__).resolve().parents[2]
DESIGNS = ROOT / "examples" / "gallery"
NUMBERS = json.loads((DESIGNS / "numbers.json").read_text("utf-8"))
PAGE = (ROOT / "docs" / "gallery.md").read_text("utf-8")


def test_every_design_has_numbers_a_picture_and_a_place_on_the_page() -> None:
    names = {path.stem for path in DESIGNS.glob("*.toml")}
    assert names == set(NUMBERS) and len(names) >= 16
    pictures = ROOT / "docs" / "pictures" / "gallery"
    assert {path.stem for path in pictures.glob("*.png")} == names
    for name in names:
        assert f"(../examples/gallery/{name}.toml)" in PAGE
        assert f"(pictures/gallery/{name}.png)" in PAGE
    assert sum(path.stat().st_size for path in pictures.glob("*.png")) < 3_000_000


@pytest.mark.parametrize("name", sorted(NUMBERS))
def test_a_design_keeps_its_numbers(name: str) -> None:
    pinned = NUMBERS[name]
    result = sm.simulate(sm.Design.load(DESIGNS / f"{name}.toml"))
    summary = result.summary
    assert (summary["model"], summary["status"]) == (pinned["model"], "completed")
    assert summary["stable"] and summary["crossing_pairs"] == 0
    assert summary["nodes"] == pinned["nodes"]
    found = {
        "aspect_ratio": summary["aspect_ratio"],
        "height_mm": 1e3 * summary["height_m"],
        "energy_mJ": 1e3 * summary["energy_J"]["total"],
        "largest_angle_deg": float(np.degrees(np.abs(result.dihedral[-1]).max())),
    }
    assert found == {key: pytest.approx(pinned[key], rel=1e-6) for key in found}
    assert f"h/d {summary['aspect_ratio']:.3f}" in PAGE
