"""One column of a sweep over another, coloured by a third."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.show import style
from sheetmorph.show.style import Sheet
from sheetmorph.show.sweep_columns import Column, read_column
from sheetmorph.sweep.dataset import Sweep

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = ("#1f6fa8", "#c8102e", "#268c76", "#8854a0", "#b8860b", "#5c6975")
NUMBERS_MAP = "viridis"


def draw_scatter(sweep: Sweep, x: str, y: str, colour: str | None, path: Path) -> Path:
    """Draw a dot for every design; rings for those that did not complete.

    Args:
        sweep: what is drawn.
        x, y: columns along the axes.
        colour: column that colours the dots; None for one colour.
        path: of the PNG file.

    Raises:
        InputError: no such column, or no design has values in all of them.
        OutputError: it cannot be written.
    """
    across, up = read_column(sweep, x), read_column(sweep, y)
    by = read_column(sweep, colour) if colour else None
    shown = ~(np.isnan(across.values) | np.isnan(up.values))
    if by is not None:
        shown &= ~np.isnan(by.values)
    if not shown.any():
        raise InputError("no design has values in all these columns")
    done = np.array([status == "completed" for status in sweep.table["status"].to_pylist()])
    with style.style():
        sheet = Sheet(1000, 660)
        axes = sheet.inset(110, 96, 640, 470)
        colours = _colours(sheet, axes, by, shown)
        for chosen, filled in ((shown & done, True), (shown & ~done, False)):
            axes.scatter(
                across.values[chosen],
                up.values[chosen],
                s=_size(int(shown.sum())),
                facecolors=colours[chosen] if filled else "none",
                edgecolors="white" if filled else colours[chosen],
                linewidths=0.4 if filled else 1.5,
            )
        _finish(axes, across, up)
        _words(sheet, sweep, shown, done)
        return sheet.save(path)


def _colours(
    sheet: Sheet, axes: Axes, by: Column | None, shown: np.ndarray[tuple[int], np.dtype[np.bool_]]
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Colour of every design, with a bar or a legend that says what it means."""
    from matplotlib.colors import to_rgb

    if by is None:
        return np.tile(to_rgb(COLOURS[0]), (len(shown), 1))
    if by.names:
        palette = np.array([to_rgb(COLOURS[k % len(COLOURS)]) for k in range(len(by.names))])
        for k in np.unique(by.values[shown]).astype(int):
            axes.scatter([], [], s=60, color=palette[k], label=style.shortened(by.names[k], 22))
        axes.legend(
            loc="upper left",
            bbox_to_anchor=(1.02, 1.0),
            frameon=False,
            fontsize=style.SMALL,
            title=by.label,
            alignment="left",
        )
        return np.asarray(palette[np.nan_to_num(by.values).astype(int)])
    low, high = float(by.values[shown].min()), float(by.values[shown].max())
    if low == high:
        low, high = low - 0.5, high + 0.5
    sheet.colour_bar((790, 96, 22, 430), NUMBERS_MAP, (low, high), (low, high), "")
    sheet.text(790, 544, style.shortened(by.label, 26), fontsize=style.SMALL)
    return np.asarray(
        style.mapped(np.nan_to_num(by.values, nan=low), NUMBERS_MAP, (low, high)) / 255
    )


def _size(count: int) -> float:
    return float(np.clip(9000 / count, 12, 70))


def _finish(axes: Axes, across: Column, up: Column) -> None:
    axes.set_xlabel(across.label)
    axes.set_ylabel(up.label)
    axes.set_facecolor("white")
    axes.grid(color=style.FAINT, lw=0.5)
    axes.set_axisbelow(True)
    for column, axis in ((across, axes.xaxis), (up, axes.yaxis)):
        if column.names:
            axis.set_ticks(range(len(column.names)), [style.shortened(n, 14) for n in column.names])
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _words(sheet: Sheet, sweep: Sweep, shown: object, done: object) -> None:
    kept, completed = np.asarray(shown), np.asarray(done)
    rings = int((kept & ~completed).sum())
    line = f"{int(kept.sum())} of {len(sweep)} designs"
    if rings:
        line += f"; rings: {rings} that did not complete"
    sheet.title(style.shortened(sweep.folder.resolve().name, 60), line)
