"""Kernels compiled by Numba and kept on disk, wherever that is possible."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

from numba import njit


def kernel(function: Callable[..., Any]) -> Any:
    """Compile a function on its first call, without Python objects.

    The machine code is kept beside the source, or in the user's cache folder, or in the folder
    that NUMBA_CACHE_DIR names. Where none of them can be written, it is compiled in every
    process anew: slower by some seconds, but it runs. So it is where the disk is full.
    """
    options = {"error_model": "numpy", "nogil": True}
    try:
        return _forgiving(njit(cache=True, **options)(function))
    except RuntimeError:  # Numba found no place for its cache
        return njit(**options)(function)


def _forgiving(compiled: Any) -> Any:
    """Let a cache that cannot be written (the disk is full) be no reason to fail.

    Numba gives up then, and offers no hook: this goes into its innards where they are as known
    and leaves them alone where they are not.
    """
    cache = getattr(compiled, "_cache", None)
    save = getattr(cache, "save_overload", None)
    if cache is not None and save is not None:

        def save_if_possible(*what: Any) -> None:
            with suppress(OSError):
                save(*what)

        cache.save_overload = save_if_possible
    return compiled
