"""The energy term of the tutorial works as it is printed."""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from sheetmorph.energy.taylor import taylor_slopes
from sheetmorph.energy.total import Total
from sheetmorph.geometry.mesh import SheetMesh

PAGE = Path(__file__).resolve().parents[2] / "docs" / "adding-an-energy-term.md"


def test_the_printed_term_has_taylor_slopes_of_two_and_three(
    small_mesh: SheetMesh, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = re.search(r"^## 3\..*?```python\n(.*?)^```", PAGE.read_text("utf-8"), re.S | re.M)
    assert code is not None
    file = tmp_path / "area.py"
    file.write_text(code[1], encoding="utf-8")
    spec = importlib.util.spec_from_file_location("area", file)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "area", module)
    spec.loader.exec_module(module)

    rng = np.random.default_rng(0)
    total = Total.of([module.AreaSpring.specimen(small_mesh, rng)], len(small_mesh.nodes))
    x = small_mesh.nodes.ravel() + 1e-3 * rng.standard_normal(small_mesh.nodes.size)
    direction = 1e-2 * rng.standard_normal(x.size)
    slopes = taylor_slopes(total.at(0.6, 1.0), x, direction, np.geomspace(1e-2, 1e-4, 9))
    assert slopes.gradient == pytest.approx(2.0, abs=0.1)
    assert slopes.hessian == pytest.approx(3.0, abs=0.1)
