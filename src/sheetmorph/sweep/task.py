"""What a worker does: one design in, one row and its states out, whatever happens."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from time import perf_counter, thread_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sheetmorph import __version__
from sheetmorph.core.errors import InputError
from sheetmorph.study.result import Result
from sheetmorph.study.simulate import simulate
from sheetmorph.sweep.plan import Task

REFUSED, ERROR, LOST = "refused", "error", "worker_lost"
"""Statuses of designs without a shape, beside those of `sheetmorph.solve.path.Status`."""

_VECTORS = {"bbox_m": "xyz"}


@dataclass(frozen=True, eq=False)
class Outcome:
    """What came of one design.

    Attributes:
        row: of the table, by column.
        arrays: `nodes` (V, 2 or 3), `triangles` (T, 3), `in_pattern` (T,), `positions`
            (S, V, 3) [m] and `ramp` (S,) of the states that are kept; None when there are none.
    """

    row: dict[str, Any]
    arrays: dict[str, NDArray[Any]] | None


def solve(task: Task) -> Outcome:
    """Compute one design, with one thread; what goes wrong becomes a row."""
    began, worked = perf_counter(), thread_time()
    design_hash: str | None = None
    result: Result | None = None
    found: dict[str, Any]
    with one_thread():
        try:
            design = task.make()
            design_hash = design.hash
            result = simulate(design)
        except InputError as error:
            found = {"status": REFUSED, "reason": str(error), "remedy": ""}
        except Exception as error:  # whatever it is, the other designs go on
            found = {"status": ERROR, "reason": f"{type(error).__name__}: {error}", "remedy": ""}
        else:
            summary = dict(result.summary)
            summary.pop("computed_with")  # of the worker: the table is the same on all of them
            found = {
                "status": summary.pop("status"),
                "reason": summary.pop("detail"),
                "remedy": summary.pop("remedy"),
                **_flat(summary),
            }
    head = _head(task, design_hash)
    found.pop("design_hash", None)
    tail = {"seconds": perf_counter() - began, "seconds.cpu": thread_time() - worked}
    return Outcome(
        {**head, **{k: v for k, v in found.items() if k not in head}, **tail},
        None if result is None else _arrays(result, task.states),
    )


def lost(task: Task, reason: str) -> Outcome:
    """The row of a design that took its workers with it.

    Args:
        task: the design.
        reason: for people.
    """
    found = {
        "status": LOST,
        "reason": reason,
        "seconds": None,
        "remedy": "it may want more memory than a worker has; try it alone, with run",
    }
    return Outcome({**_head(task, None), **found}, None)


@contextmanager
def one_thread() -> Iterator[None]:
    """Keep the numerical libraries of this process to one thread."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        yield


def _head(task: Task, design_hash: str | None) -> dict[str, Any]:
    """What names the design: the same whenever and wherever it is computed."""
    return {
        "index": task.index,
        "id": task.id,
        **{key: _cell(value) for key, value in task.inputs.items()},
        "design_hash": design_hash,
        "version": __version__,
    }


def _cell(value: object) -> object:
    """A value that a column of a table can hold."""
    return value if isinstance(value, bool | int | float | str) else json.dumps(value, default=str)


def _flat(summary: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """The numbers of a summary with dotted names: `energy_J.bend`, `bbox_m.x`."""
    flat: dict[str, Any] = {}
    for key, value in summary.items():
        if isinstance(value, Mapping):
            flat |= _flat(value, f"{prefix}{key}.")
        elif isinstance(value, list):
            names = _VECTORS.get(key, [str(place) for place in range(len(value))])
            flat |= {f"{prefix}{key}.{name}": one for name, one in zip(names, value, strict=True)}
        else:
            flat[prefix + key] = value
    return flat


def _arrays(result: Result, states: str) -> dict[str, NDArray[Any]] | None:
    if states == "none":
        return None
    kept = slice(None) if states == "all" else slice(-1, None)
    return {
        "nodes": np.asarray(result.mesh.nodes, dtype=np.float64),
        "triangles": np.asarray(result.mesh.triangles, dtype=np.int32),
        "in_pattern": np.asarray(result.triangle_in_pattern, dtype=np.bool_),
        "positions": np.asarray(result.positions[kept], dtype=np.float64),
        "ramp": np.asarray(result.ramp[kept], dtype=np.float64),
    }
