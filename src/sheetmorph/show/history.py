"""The plot of the actuation history: runs against actuation beside films against time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sheetmorph.geometry.surface import Width
from sheetmorph.measure.film_history import FilmHistory
from sheetmorph.show import style
from sheetmorph.show.style import Sheet
from sheetmorph.study.history import MeanHistory, RunHistory

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDTH, HEIGHT = 1200, 700
_LEFT, _RIGHT, _TOP, _BOTTOM, _GAP = 108, 40, 116, 128, 44

COLOURS = (
    *(style.BILAYER, (201, 86, 20), style.BALANCED, style.BOTTOM),
    *((168, 124, 16), (90, 100, 110)),
)
MARKERS = "osD^vP"
LINES = ("-", "--", ":", "-.")
_LEGEND: Any = {"alignment": "left", "framealpha": 0.85, "edgecolor": "none"}

WIDTH_NAMES: dict[Width, str] = {
    "feret_max": "largest width seen from above",
    "feret_min": "smallest width seen from above",
    "x": "extent along x",
    "y": "extent along y",
    "side": "width in the side view",
}


def write_history(
    path: Path,
    runs: Sequence[RunHistory],
    films: Sequence[FilmHistory],
    mean: MeanHistory | None,
    width: Width,
) -> Path:
    """Plot h/d: hollow markers for runs, solid ones for films (the paper's Fig. 8D).

    A film knows time and a run knows actuation, so each has an axis of its own; the two panels
    share h/d. Several films are shown as mean and standard deviation.

    Raises:
        OutputError: the picture cannot be written.
    """
    with style.style():
        sheet = Sheet(WIDTH, HEIGHT)
        sheet.title("Height over width", _subtitle(runs, films))
        room = WIDTH - _LEFT - _RIGHT
        both = bool(runs) and bool(films)
        panel = 0.5 * (room - _GAP) if both else float(room)
        tall = HEIGHT - _TOP - _BOTTOM
        highest = _highest(runs, films, width)
        x = float(_LEFT)
        if runs:
            axes = sheet.inset(x, _BOTTOM, panel, tall)
            _draw_runs(axes, runs, width)
            _finish(axes, highest, True)
            x += panel + _GAP
        if films:
            axes = sheet.inset(x, _BOTTOM, panel, tall)
            _draw_films(axes, films, mean)
            if runs:
                _draw_ends(axes, runs, width)
            _finish(axes, highest, not runs)
        sheet.foot(_foot(runs, films, width))
        return sheet.save(path)


def _subtitle(runs: Sequence[RunHistory], films: Sequence[FilmHistory]) -> str:
    parts = []
    if runs:
        parts.append("computed: " + ", ".join(style.shortened(run.name, 30) for run in runs))
    if films:
        parts.append("filmed: " + ", ".join(style.shortened(film.name, 30) for film in films))
    return style.shortened("  ·  ".join(parts), 110)


def _foot(runs: Sequence[RunHistory], films: Sequence[FilmHistory], width: Width) -> str:
    parts = []
    if runs:
        parts.append(f"computed: d is the {WIDTH_NAMES[width]}")
    if films:
        parts.append("filmed: height and width of the outline")
        left_out = sum(int((~film.good).sum()) for film in films)
        if left_out:
            parts.append(f"{left_out} doubtful frame{'s' if left_out > 1 else ''} left out")
    return "; ".join(parts)


def _highest(runs: Sequence[RunHistory], films: Sequence[FilmHistory], width: Width) -> float:
    values = [float(np.nanmax(run.ratio(width))) for run in runs]
    values += [float(film.ratio[film.good].max()) for film in films if film.good.any()]
    return max([*values, 0.01])


def _draw_runs(axes: Axes, runs: Sequence[RunHistory], width: Width) -> None:
    ends = [float(run.actuation[-1]) for run in runs]
    reach = max(ends, key=abs) or -1.0
    for k, run in enumerate(runs):
        ink = style.colour(COLOURS[k % len(COLOURS)])
        axes.plot(
            run.actuation,
            run.ratio(width),
            "-" + MARKERS[k % len(MARKERS)],
            color=ink,
            lw=1.8,
            ms=7,
            mfc="white",
            mew=1.5,
            label=style.shortened(run.name, 30),
            clip_on=False,
            zorder=3,
        )
    axes.set_xlim(-0.02 * reach, 1.06 * reach)
    axes.set_xlabel("actuation εₚᵣₑ, free strain of the film  [–]", labelpad=8)
    axes.legend(loc="lower right", title="computed", **_LEGEND)


def _draw_films(axes: Axes, films: Sequence[FilmHistory], mean: MeanHistory | None) -> None:
    several = len(films) > 1 and mean is not None
    for k, film in enumerate(films):
        ink = style.MUTED if several else style.INK
        good = film.good
        axes.plot(
            film.time[good],
            film.ratio[good],
            LINES[k % len(LINES)] if several else "o",
            color=ink,
            alpha=0.55 if several else 1.0,
            lw=1.2,
            ms=7,
            label=style.shortened(film.name, 30) if not several or k < 4 else None,
            clip_on=False,
            zorder=3,
        )
    if several and mean is not None:
        axes.errorbar(
            mean.time,
            mean.mean,
            np.nan_to_num(mean.deviation),
            fmt="o",
            color=style.INK,
            ms=7,
            capsize=4,
            lw=1.4,
            label=f"mean ± std of {len(films)} films",
            clip_on=False,
            zorder=4,
        )
    axes.set_xlabel("time  [s]", labelpad=8)
    axes.legend(loc="lower right", title="filmed", **_LEGEND)


def _draw_ends(axes: Axes, runs: Sequence[RunHistory], width: Width) -> None:
    """A dashed line at h/d of every run at its end, to which a film should come."""
    for k, run in enumerate(runs):
        value = float(run.ratio(width)[-1])
        ink = style.colour(COLOURS[k % len(COLOURS)])
        axes.axhline(value, color=ink, lw=1.4, ls=(0, (5, 3)), zorder=1)
        axes.annotate(
            f"computed end {value:.3f}" if k < 3 else "",
            (1.0, value),
            (-4, 5),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            ha="right",
            va="bottom",
            color=ink,
            fontsize=style.SMALL,
        )


def _finish(axes: Axes, highest: float, labelled: bool) -> None:
    axes.set_ylim(0.0, 1.15 * highest)
    axes.grid(color=style.FAINT, lw=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    if labelled:
        axes.set_ylabel("h/d  [–]", labelpad=8)
    else:
        axes.tick_params(labelleft=False)
