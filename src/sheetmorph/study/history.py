"""The actuation history: h and d of runs against actuation, of films against time."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.surface import Width, in_plane_width
from sheetmorph.measure.film_history import FilmHistory
from sheetmorph.study.result import Result

MAX_TIMES = 1_000_000
"""Of the common clock of several films."""

WIDTHS: tuple[Width, ...] = get_args(Width)


@dataclass(frozen=True, eq=False)
class RunHistory:
    """h and d of the S states of a run.

    Attributes:
        name: of the run.
        actuation: free shrinkage eps_pre, shape (S,).
        load_fraction: of the perturbation load, shape (S,).
        height: h, of the middle surface [m], shape (S,).
        widths: d by its name, see `geometry.surface.in_plane_width` [m], shape (S,) each.
    """

    name: str
    actuation: Floats
    load_fraction: Floats
    height: Floats
    widths: dict[Width, Floats]

    def ratio(self, width: Width) -> Floats:
        """h/d, shape (S,)."""
        return np.asarray(self.height / self.widths[width])


@dataclass(frozen=True, eq=False)
class MeanHistory:
    """Several films on one clock of T times.

    Attributes:
        time: [s], shape (T,).
        mean: of h/d, shape (T,).
        deviation: standard deviation of one film (with n − 1), NaN for one film, shape (T,).
        count: films at each time, shape (T,).
    """

    time: Floats
    mean: Floats
    deviation: Floats
    count: NDArray[np.int64]


def history_of(result: Result, name: str, azimuth: float = 0.0) -> RunHistory:
    """h and d of a run for every width.

    Args:
        result: the run.
        name: what to call it.
        azimuth: of the camera for the width "side" [rad].
    """
    x = result.positions
    return RunHistory(
        name,
        result.actuation,
        result.load_fraction,
        np.asarray(np.ptp(x[..., 2], axis=-1)),
        {width: in_plane_width(x, width, azimuth) for width in WIDTHS},
    )


def mean_of(films: Sequence[FilmHistory], interval: float) -> MeanHistory:
    """Mean and standard deviation of h/d over films, whose clocks all begin at the same event.

    Frames that cannot be relied on are left out; a film counts at the times between its first
    and its last good frame, between which it is interpolated linearly.

    Args:
        films: one at least, with a good frame each.
        interval: between the times [s].

    Raises:
        InputError: more than `MAX_TIMES` times.
    """
    good = [(film.time[film.good], film.ratio[film.good]) for film in films]
    good = [pair for pair in good if len(pair[0])]
    first = min(time.min() for time, _ in good)
    last = max(time.max() for time, _ in good)
    if not (last - first) / interval < MAX_TIMES:
        raise InputError(
            "the films are too long for this interval",
            key="--interval",
            value=interval,
            allowed=f"up to {MAX_TIMES} times from {first:g} s to {last:g} s",
        )
    clock = first + interval * np.arange(round((last - first) / interval) + 1)
    values = np.array(
        [np.interp(clock, time, ratio, left=np.nan, right=np.nan) for time, ratio in good]
    )
    there = np.isfinite(values)
    count = there.sum(axis=0)
    kept = count > 0
    clock, values, there, count = clock[kept], values[:, kept], there[:, kept], count[kept]
    mean = np.where(there, values, 0.0).sum(axis=0) / count
    squares = (np.where(there, values - mean, 0.0) ** 2).sum(axis=0)
    deviation = np.full(len(clock), np.nan)
    several = count > 1
    deviation[several] = np.sqrt(squares[several] / (count[several] - 1))
    return MeanHistory(clock, mean, deviation, count)


def runs_csv(runs: Sequence[RunHistory]) -> str:
    """A row per state of every run: actuation, load, h, and d and h/d for every width."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(
        ["run", "state", "actuation", "load_fraction", "h_mm"]
        + [f"d_{width}_mm" for width in WIDTHS]
        + [f"h_over_d_{width}" for width in WIDTHS]
    )
    for run in runs:
        for k in range(len(run.actuation)):
            lengths = [run.height[k], *(run.widths[width][k] for width in WIDTHS)]
            ratios = [run.height[k] / run.widths[width][k] for width in WIDTHS]
            writer.writerow(
                [run.name, k, f"{run.actuation[k] + 0.0:.6g}", f"{run.load_fraction[k]:.6g}"]
                + [f"{1e3 * length:.5g}" for length in lengths]
                + [f"{ratio:.5f}" for ratio in ratios]
            )
    return stream.getvalue()


def mean_csv(mean: MeanHistory) -> str:
    """A row per time: mean, standard deviation and number of films."""
    lines = ["time_s,h_over_d_mean,h_over_d_std,films"]
    for k in range(len(mean.time)):
        spread = f"{mean.deviation[k]:.5f}" if np.isfinite(mean.deviation[k]) else ""
        lines.append(f"{mean.time[k]:.6g},{mean.mean[k]:.5f},{spread},{mean.count[k]}")
    return "\n".join(lines) + "\n"
