"""The studio stays healthy; the long version is benchmarks/studio_soak.py."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest
from driving import Running, open_tab

BENCHMARK = Path(__file__).resolve().parents[2] / "benchmarks" / "studio_soak.py"
pytest.importorskip("psutil", reason="psutil is not installed")


def test_many_tabs_and_changes_leave_no_memory_behind(studio: Running) -> None:
    spec = importlib.util.spec_from_file_location("studio_soak", BENCHMARK)
    assert spec is not None
    assert spec.loader is not None
    soak = importlib.util.module_from_spec(spec)
    before = list(sys.path)
    spec.loader.exec_module(soak)
    sys.path[:] = before
    said: list[str] = []
    grown = soak.soak(studio, tabs=3, changes=24, say=said.append)
    assert grown <= soak.ALLOWED, said
    tab = open_tab(studio)
    assert tab.solved()["numbers"]["status"] == "completed"
    tab.socket.close()
