"""On what something was computed: versions of libraries, platform, threads."""

from __future__ import annotations

import os
import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

DECIDING = (
    "numpy",
    "scipy",
    "numba",
    "llvmlite",
    "shapely",
    "pythoncdt",
    "py-mkl-pardiso",
    "rslab",
)
"""Libraries whose version may change the last bits of a result."""

SETTINGS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_CBWR")


def surroundings(threads: int) -> dict[str, Any]:
    """What decides the last bits of a result beside the design and the version of sheetmorph.

    Args:
        threads: of the linear solver.

    Returns:
        `threads`, `settings` (those of the environment that are set), `python`, `platform`,
        `processor` and `libraries` (name to version, of those that are installed).
    """
    return {
        "threads": threads,
        "settings": {name: os.environ[name] for name in SETTINGS if name in os.environ},
        **_machine(),
    }


@cache
def _machine() -> dict[str, Any]:
    libraries = {}
    for name in DECIDING:
        try:
            libraries[name] = version(name)
        except PackageNotFoundError:
            continue
    return {
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "processor": processor(),
        "libraries": libraries,
    }


def processor() -> str:
    """Name of the processor, as far as the system tells it."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:  # noqa: PTH123
            names = [line.split(":", 1)[1].strip() for line in lines if "model name" in line]
    except OSError:
        names = []
    return names[0] if names else platform.processor() or "unknown"
