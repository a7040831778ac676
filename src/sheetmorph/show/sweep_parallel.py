"""The parallel-coordinates page of a sweep: a line for every design across all columns."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.core.files import write_text
from sheetmorph.geometry.mesh import Floats
from sheetmorph.show import style
from sheetmorph.show.citations import Citation
from sheetmorph.show.page import rendered
from sheetmorph.show.sweep_columns import Column, input_names, read_column
from sheetmorph.sweep.dataset import Sweep

TEMPLATE = "parallel.html"
USUAL = ("energy_J.total", "height_m", "aspect_ratio")
"""Columns that are shown beside the inputs; the last one colours the lines."""
MOST_AXES = 12
MOST_LINES = 3000
LISTED = 40
FEW = 6
"""Different numbers of a column up to which each of them is written at its axis."""
_TOP, _BOTTOM, _STEP, _SIDE = 62.0, 460.0, 150.0, 80.0

_REFERENCES = (
    Citation(
        "inselberg1985",
        "A. Inselberg",
        "The plane with parallel coordinates",
        "The Visual Computer 1, 1985, 69–91",
        "the kind of picture",
    ),
)


def write_parallel(sweep: Sweep, names: Sequence[str], path: Path) -> Path:
    """Write the page; it refers to nothing outside itself.

    Args:
        sweep: what is shown.
        names: columns from left to right, the last one of which colours the lines; the inputs
            and some results when empty.
        path: of the page.

    Raises:
        InputError: no such column, or too many.
        OutputError: it cannot be written.
    """
    columns = [read_column(sweep, name) for name in names or usual_columns(sweep)]
    if len(columns) > MOST_AXES:
        raise InputError(f"{len(columns)} columns are too many", allowed=f"≤ {MOST_AXES}")
    heights = [_heights(column) for column in columns]
    status = sweep.table["status"].to_pylist()
    index = sweep.table["index"].to_pylist()
    rows = np.linspace(0, len(sweep) - 1, min(len(sweep), MOST_LINES)).round().astype(int)
    across = [_SIDE + _STEP * k for k in range(len(columns))]
    colours = style.mapped(_share(columns[-1]), style.ANGLE_MAP, (0.0, 1.0))
    lines = []
    for row in rows.tolist():
        bare = np.isnan(columns[-1].values[row])
        lines.append(
            {
                "d": _path(across, [height[row] for height in heights]),
                "colour": style.MUTED if bare else "#" + bytes(colours[row]).hex(),
                "failed": status[row] != "completed",
                "title": f"design {index[row]}: {status[row]}",
            }
        )
    text = rendered(
        TEMPLATE,
        title=style.shortened(sweep.folder.resolve().name, 60),
        lead=f"{len(sweep)} designs, by sheetmorph {sweep.about['version']}",
        told=_told(sweep, len(rows), columns[-1], status),
        lines=lines,
        opacity=round(float(np.clip(30 / len(rows), 0.12, 0.75)), 2),
        axes=[_axis(column, x) for column, x in zip(columns, across, strict=True)],
        width=2 * _SIDE + _STEP * (len(columns) - 1) + 30,
        height=_BOTTOM + 24,
        top=_TOP,
        bottom=_BOTTOM,
        heads=["design", "status", *(column.label for column in columns)],
        places=[[_number(height[row]) for height in heights] for row in rows.tolist()],
        cells=[
            [str(index[row]), status[row], *(column.text(row) for column in columns)]
            for row in rows.tolist()
        ],
        listed=LISTED,
        references=_REFERENCES,
    )
    write_text(path, text)
    return path


def usual_columns(sweep: Sweep) -> list[str]:
    """The inputs, as far as they vary and can be shown, and some results."""
    found = []
    for name in [*input_names(sweep), *USUAL]:
        if name not in sweep.table.column_names:
            continue
        try:
            column = read_column(sweep, name)
        except InputError:
            continue  # texts of too many kinds, or no value at all
        if np.nanmin(column.values) < np.nanmax(column.values):
            found.append(name)
    return [*found[: MOST_AXES - 1], *found[-1:]] if len(found) > MOST_AXES else found


def _told(sweep: Sweep, lines: int, last: Column, status: Sequence[str]) -> str:
    text = (
        f"Drag along an axis to keep the designs in that range, click it to let go. "
        f"Colour: {last.label}."
    )
    if lines < len(sweep):
        text += f" {lines} designs, spread evenly, stand for all."
    failed = sum(one != "completed" for one in status)
    if failed:
        text += f" Broken lines: designs that did not complete ({failed}), as far as they went."
    return text


def _limits(column: Column) -> tuple[float, float]:
    low, high = float(np.nanmin(column.values)), float(np.nanmax(column.values))
    return (low, high) if low < high else (low - 0.5, high + 0.5)


def _share(column: Column) -> Floats:
    low, high = _limits(column)
    return np.nan_to_num((column.values - low) / (high - low))


def _heights(column: Column) -> Floats:
    """Heights in the picture, NaN where there is no value."""
    low, high = _limits(column)
    return np.asarray(_BOTTOM - (_BOTTOM - _TOP) * (column.values - low) / (high - low))


def _path(across: Sequence[float], heights: Sequence[float]) -> str:
    """A line that is broken where a value is missing."""
    parts, pen = [], "M"
    for x, y in zip(across, heights, strict=True):
        if np.isnan(y):
            pen = "M"
            continue
        parts.append(f"{pen}{x:.0f} {y:.1f}")
        pen = "L"
    return "".join(parts)


def _axis(column: Column, x: float) -> dict[str, Any]:
    low, high = _limits(column)
    if column.names:
        ticks = [(float(k), style.shortened(name, 14)) for k, name in enumerate(column.names)]
    else:
        own = np.unique(column.values[~np.isnan(column.values)])
        values = own if len(own) <= FEW else np.linspace(low, high, 5)
        if (own == own.round()).all():
            values = np.unique(values.round())
        ticks = [(v, f"{v:.3g}".replace("-", "−")) for v in values]
    table, _, name = column.label.rpartition(".")
    return {
        "x": x,
        "label": [style.shortened(part, 24) for part in (table, name) if part],
        "ticks": [
            {"y": round(_BOTTOM - (_BOTTOM - _TOP) * (v - low) / (high - low), 1), "text": text}
            for v, text in ticks
        ],
    }


def _number(height: float) -> float | None:
    return None if np.isnan(height) else round(float(height), 1)
