"""Kernels compiled by Numba and kept on disk, wherever that is possible."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit


def kernel(function: Callable[..., Any]) -> Any:
    """Compile a function on its first call, without Python objects.

    The machine code is kept beside the source, or in the user's cache folder, or in the folder
    that NUMBA_CACHE_DIR names. Where none of them can be written, it is compiled in every
    process anew: slower by some seconds, but it runs.
    """
    options = {"error_model": "numpy", "nogil": True}
    try:
        return njit(cache=True, **options)(function)
    except RuntimeError:  # Numba found no place for its cache
        return njit(**options)(function)
