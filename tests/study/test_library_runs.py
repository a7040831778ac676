"""Every example of the page on patterns morphs to the end, into a stable shape."""

from __future__ import annotations

import pytest

import sheetmorph as sm
from pages import page_examples


@pytest.mark.slow
@pytest.mark.parametrize("example", page_examples(), ids=lambda example: example.caption)
def test_every_example_completes(example) -> None:  # type: ignore[no-untyped-def]
    result = sm.simulate(example.design().with_values({"mesh.size": "3.5 mm"}))
    assert result.status == "completed"
    assert result.summary["stable"]
    assert result.summary["aspect_ratio"] > 0.05
