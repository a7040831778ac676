"""`results.parquet`: one row per design, columns with types and units."""

from __future__ import annotations

import json
import platform
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sheetmorph import __version__
from sheetmorph.core.errors import InputError, OutputError
from sheetmorph.core.files import replacing
from sheetmorph.sweep.extra import needed

if TYPE_CHECKING:
    import pyarrow as pa

    from sheetmorph.sweep.plan import Plan

FILE = "results.parquet"
FORMAT = "sheetmorph sweep"
GROUP = 10_000
"""Rows that are in memory at once."""

ABOUT = b"sheetmorph"
"""Key of the file's metadata under which JSON says what it is."""

_UNITS = {"_m": "m", "_N": "N", "_J": "J"}
_LAST = ("status", "reason", "remedy", "version", "design_hash", "solver")


def write_table(
    plan: Plan, rows: Callable[[], Iterable[Mapping[str, Any]]], path: Path, *, complete: bool
) -> None:
    """Write the table, whole or not at all.

    Args:
        plan: of the sweep.
        rows: the rows in order, as often as it is called.
        path: of the file.
        complete: whether all designs are in it.

    Raises:
        OutputError: it cannot be written.
        InputError: pyarrow is not installed.
    """
    with needed():
        import pyarrow as pa
        import pyarrow.parquet as pq
    schema = _schema(plan, rows(), complete)
    with replacing(path) as partial:
        try:
            with pq.ParquetWriter(partial, schema, compression="zstd") as writer:
                for group in _groups(rows()):
                    columns = {name: [row.get(name) for row in group] for name in schema.names}
                    writer.write_table(pa.table(columns, schema=schema))
        except pa.ArrowInvalid as error:
            raise OutputError(f"{path}: cannot be written ({error})") from error


def read_about(path: Path) -> dict[str, Any]:
    """What a table says of itself: `format`, `complete`, `fingerprint`, `sweep`, versions.

    Raises:
        InputError: it is no table of a sweep.
    """
    with needed():
        import pyarrow as pa
        import pyarrow.parquet as pq
    try:
        metadata = pq.read_schema(path).metadata or {}
        about = json.loads(metadata[ABOUT])
        if about["format"] == FORMAT:
            return dict(about)
    except (OSError, ValueError, KeyError, TypeError, pa.ArrowException):
        pass
    raise InputError("this is no table of a sweep", file=path)


def _schema(plan: Plan, rows: Iterable[Mapping[str, Any]], complete: bool) -> pa.Schema:
    """Columns of all the rows: inputs, then numbers, then what is said about them."""
    import pyarrow as pa

    arrow = {bool: pa.bool_(), int: pa.int64(), float: pa.float64(), str: pa.string()}
    units = {axis.key: axis.unit for axis in plan.axes}
    kinds: dict[str, type | None] = dict.fromkeys(("index", "id", *units))
    kinds |= {"status": str, "reason": str, "remedy": str, "version": str, "design_hash": str}
    kinds |= {"seconds": float}
    for row in rows:
        for name, value in row.items():
            if value is not None:
                kinds[name] = _common(kinds.get(name), type(value))
            elif name not in kinds:
                kinds[name] = None
    fields = []
    for name in sorted(kinds, key=lambda name: _place(name, units)):
        unit = units[name] if name in units else _unit(name)
        kind = kinds[name] or float
        fields.append(pa.field(name, arrow[kind], metadata={"unit": unit} if unit else None))
    about = {
        "format": FORMAT,
        "complete": complete,
        "designs": len(plan),
        "fingerprint": plan.fingerprint,
        "inputs": [axis.key for axis in plan.axes],
        "sweep": plan.text,
        "design": plan.base.source if plan.base else None,
        "version": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
    }
    return pa.schema(fields, metadata={ABOUT: json.dumps(about)})


def _common(one: type | None, other: type) -> type:
    if one is None or one is other:
        return other
    return float if {one, other} == {int, float} else str


def _place(name: str, inputs: Mapping[str, str]) -> tuple[int, str]:
    """Order of the columns; it does not depend on which designs came first."""
    if name in ("index", "id"):
        return 0, "" if name == "index" else name
    if name in inputs:
        return 1, f"{list(inputs).index(name):04d}"
    if name in _LAST:
        return 3, f"{_LAST.index(name)}"
    return (4 if name.split(".")[0] == "seconds" else 2), name


def _unit(name: str) -> str:
    first = name.split(".")[0]
    if first == "seconds":
        return "s"
    return next((unit for end, unit in _UNITS.items() if first.endswith(end)), "")


def _groups(rows: Iterable[Mapping[str, Any]]) -> Iterator[list[Mapping[str, Any]]]:
    group: list[Mapping[str, Any]] = []
    for row in rows:
        group.append(row)
        if len(group) == GROUP:
            yield group
            group = []
    if group:
        yield group
