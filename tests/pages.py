"""The examples of docs/patterns.md, as the script that draws them reads them."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def page_examples():  # type: ignore[no-untyped-def]
    script = ROOT / "docs" / "make_pattern_pictures.py"
    spec = importlib.util.spec_from_file_location("make_pattern_pictures", script)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look there for their module
    spec.loader.exec_module(module)
    return module.read_examples(ROOT / "docs" / "patterns.md")
