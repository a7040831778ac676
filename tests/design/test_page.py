"""The examples of docs/design-file.md are designs, each in the place of what a small one says."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from laminates import LAMINATE

from sheetmorph.design.schema import DesignSchema

PAGE = Path(__file__).resolve().parents[2] / "docs" / "design-file.md"
BLOCKS = re.findall(r"^```toml\n(.*?)^```", PAGE.read_text("utf-8"), re.MULTILINE | re.DOTALL)
PLAIN = [block for block in BLOCKS if "file = " not in block and "slit_select" not in block]


def test_the_page_has_examples():
    assert len(PLAIN) >= 15


@pytest.mark.parametrize("block", PLAIN, ids=lambda block: block.split("\n", 1)[0])
def test_example(block, base):
    said = tomllib.loads(block)
    refused = []
    for text in (base, LAMINATE):
        data = tomllib.loads(text)
        if "outline" in said:
            data.pop("pattern")
            data["layers"] = data["layers"][:1]
        if "pattern" in said:
            data["outline"] = {"kind": "disc", "radius": "60 mm"}
            parts = {piece.get("part", "pattern") for piece in said["pattern"]}
            film, print_ = data["layers"]
            data["layers"] = [film, *(print_ | {"name": part, "where": part} for part in parts)]
        try:
            DesignSchema.model_validate(data | said)
        except ValueError as error:
            refused.append(error)
    assert len(refused) < 2, refused
