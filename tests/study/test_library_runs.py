"""Every example of the page on patterns morphs to the end, into a stable shape."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

import sheetmorph as sm

ROOT = Path(__file__).resolve().parents[2]


def page_examples():  # type: ignore[no-untyped-def]
    script = ROOT / "docs" / "make_pattern_pictures.py"
    spec = importlib.util.spec_from_file_location("make_pattern_pictures", script)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look there for their module
    spec.loader.exec_module(module)
    return module.read_examples(ROOT / "docs" / "patterns.md")


@pytest.mark.slow
@pytest.mark.parametrize("example", page_examples(), ids=lambda example: example.caption)
def test_every_example_completes(example) -> None:  # type: ignore[no-untyped-def]
    result = sm.simulate(example.design().with_values({"mesh.size": "3.5 mm"}))
    assert result.status == "completed"
    assert result.summary["stable"]
    assert result.summary["aspect_ratio"] > 0.05
