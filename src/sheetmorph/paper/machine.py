"""What a report was computed on."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from sheetmorph import __version__

LIBRARIES = ("numpy", "scipy", "numba", "libigl")


def machine() -> dict[str, str]:
    """What the computations run on: processor, system, versions."""
    facts = {
        "processor": _processor(),
        "processors": str(os.cpu_count() or 1),
        "other work": _load(),
        "system": f"{platform.system()} {platform.machine()}",
        "Python": platform.python_version(),
        "sheetmorph": __version__,
    }
    for name in LIBRARIES:
        try:
            facts[name] = version(name)
        except PackageNotFoundError:
            continue
    return facts


def _load() -> str:
    """How many processes wanted a processor in the last minute; times suffer above their number."""
    if not hasattr(os, "getloadavg"):
        return "not known"
    return f"{os.getloadavg()[0]:.1f} processes wanted to run, mean of the last minute"


def _processor() -> str:
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return platform.processor() or platform.machine()
    for line in text.splitlines():
        name, _, value = line.partition(":")
        if name.strip() == "model name":
            return value.strip()
    return platform.processor() or platform.machine()
