"""Kernels run where nothing can be cached."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def test_without_a_place_for_the_cache(tmp_path: Path) -> None:
    """Numba finds no place: the kernel is compiled all the same."""
    code = (
        "import numba.core.caching as caching\n"
        "caching.CacheImpl._locator_classes = []\n"
        "caching.CompileResultCacheImpl._locator_classes = []\n"
        "from numba import njit\n"
        "try:\n    njit(cache=True)(lambda x: x)\n"
        "except RuntimeError as error:\n    print('numba:', error)\n"
        "from sheetmorph.energy.stretch import _edge_stretch\n"
        "from sheetmorph.core.compiled import kernel\n"
        "print(kernel(lambda x: x + 1)(2))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "numba: cannot cache" in done.stdout
    assert done.stdout.strip().endswith("3")
