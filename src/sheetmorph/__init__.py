"""sheetmorph: the 3D shape into which a flat, patterned, layered sheet morphs.

>>> import sheetmorph as sm
>>> result = sm.simulate(sm.Design.load("bowl.toml"))  # doctest: +SKIP
>>> result.positions  # (states, nodes, 3) in metres  # doctest: +SKIP
"""

from __future__ import annotations

from typing import TYPE_CHECKING

__version__ = "0.1.0"

__all__ = [
    "ComputationError",
    "Design",
    "InputError",
    "OutputError",
    "Result",
    "SheetMesh",
    "SheetmorphError",
    "Sweep",
    "View",
    "__version__",
    "simulate",
    "view",
]

_HOMES = {
    "ComputationError": "core.errors",
    "Design": "design.spec",
    "InputError": "core.errors",
    "OutputError": "core.errors",
    "Result": "study.result",
    "SheetMesh": "geometry.mesh",
    "SheetmorphError": "core.errors",
    "Sweep": "sweep.dataset",
    "View": "studio.notebook",
    "simulate": "study.simulate",
    "view": "studio.notebook",
}

if TYPE_CHECKING:
    from sheetmorph.core.errors import ComputationError, InputError, OutputError, SheetmorphError
    from sheetmorph.design.spec import Design
    from sheetmorph.geometry.mesh import SheetMesh
    from sheetmorph.studio.notebook import View, view
    from sheetmorph.study.result import Result
    from sheetmorph.study.simulate import simulate
    from sheetmorph.sweep.dataset import Sweep


def __getattr__(name: str) -> object:
    """Import what is asked for when it is asked for, so that `--help` stays fast."""
    if name not in _HOMES:
        raise AttributeError(f"module 'sheetmorph' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"sheetmorph.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return __all__
