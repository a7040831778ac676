"""Shrink curves from raw rows: a monotone fit to repeated measurements, with their scatter."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.design.shrink_rows import DIRECTIONS, ShrinkData
from sheetmorph.design.shrinkage import ShrinkCurve
from sheetmorph.geometry.mesh import Floats

SAME_TEMPERATURE = 0.5
"""Rows within this range [K] are repeats at one temperature."""

SIGNIFICANT = 0.05
"""Probability of chance below which the two directions count as different."""


@dataclass(frozen=True, eq=False)
class Group:
    """Means of the rows of one direction, or of all, at each temperature; m temperatures.

    Attributes:
        counts: number of rows, shape (m,).
        means: of L/L0, shape (m,); nan where there is no row.
        deviations: standard deviation (n − 1 in the denominator), shape (m,); nan where
            there are fewer than two rows.
    """

    counts: Floats
    means: Floats
    deviations: Floats


@dataclass(frozen=True)
class Anisotropy:
    """How much the two directions differ, on average over the temperatures that have both.

    Attributes:
        difference: mean of (L/L0 along x) − (L/L0 along y).
        standard_error: of that mean; from the scatter of each cell by itself.
        probability: two-sided, of a difference as large by chance (Welch's t); None where
            there are no repeats, or no scatter, to judge by.
        temperatures: number of temperatures that have both directions.
        largest: difference of the means that is largest in size.
        largest_at: temperature there [K].
    """

    difference: float
    standard_error: float | None
    probability: float | None
    temperatures: int
    largest: float
    largest_at: float

    @property
    def significant(self) -> bool | None:
        """True when chance would rarely do as much; None when that cannot be told."""
        return None if self.probability is None else self.probability < SIGNIFICANT


@dataclass(frozen=True, eq=False)
class ShrinkFit:
    """A monotone curve through measured rows; m temperatures.

    Attributes:
        data: the rows.
        temperatures: [K], increasing, shape (m,).
        together: all rows.
        by_direction: those of "x" and of "y", where the file names directions.
        fitted: L/L0 of the curve, shape (m,).
        scatter: standard deviation of single rows, shape (m,): that of the rows at the
            temperature, or the pooled one where there is one row; None without any repeat.
        trend: whether the curve "falls" or "rises" with temperature.
        residual_rms: of the rows about the curve.
        pooled_deviation: of the rows about the means of their temperatures; None without
            any repeat.
        onset: the highest measured temperature up to which the curve stays at its first
            value, to 1 % of its range or the pooled deviation [K].
        plateau: the lowest from which on it stays at its last value in that sense [K]; None
            where only the last has it, so that the curve does not level off.
        anisotropy: None where there are not both directions at any temperature.
    """

    data: ShrinkData
    temperatures: Floats
    together: Group
    by_direction: dict[str, Group]
    fitted: Floats
    scatter: Floats | None
    trend: Literal["falls", "rises"]
    residual_rms: float
    pooled_deviation: float | None
    onset: float
    plateau: float | None
    anisotropy: Anisotropy | None

    @property
    def curve(self) -> ShrinkCurve:
        """The curve for designs."""
        return ShrinkCurve(self.data.name, self.temperatures, self.fitted, self.scatter)

    @property
    def anisotropy_text(self) -> str:
        """How much x and y differ, in a sentence."""
        found = self.anisotropy
        if found is None:
            return "x and y cannot be compared: no temperature has rows of both"
        share, where = 100 * abs(found.difference), 273.15
        text = (
            f"x and y differ by {share:.2g} % of L0 on average over {found.temperatures} "
            f"temperatures (at most {100 * abs(found.largest):.2g} %, at "
            f"{found.largest_at - where:.4g} °C), "
        )
        if found.probability is None:
            return text + "without repeats or scatter to judge by"
        verdict = "more than the scatter explains" if found.significant else "within the scatter"
        return text + f"{verdict} (p = {found.probability:.2g})"


def fit_shrinkage(data: ShrinkData) -> ShrinkFit:
    """Fit a monotone curve to measured rows.

    Means over the rows of each temperature are made monotone by isotonic regression, weighted
    by the number of rows (least squares under the constraint of order, see Barlow et al.,
    Statistical Inference under Order Restrictions, 1972). Whether the curve falls or rises is
    what fits better. Between the points `ShrinkCurve` interpolates, also monotone.

    Raises:
        InputError: fewer than two temperatures.
    """
    from scipy.optimize import isotonic_regression

    places, temperatures = _grouped(data.temperatures)
    if len(temperatures) < 2:
        raise InputError("needs at least two temperatures", value=len(temperatures))
    together = _group(places, data.length_ratios, len(temperatures))
    fits = {
        rising: isotonic_regression(together.means, weights=together.counts, increasing=rising).x
        for rising in (False, True)
    }
    misfit = {
        rising: float(together.counts @ (fit - together.means) ** 2) for rising, fit in fits.items()
    }
    rising = misfit[True] < misfit[False]
    fitted = np.asarray(fits[rising], dtype=np.float64)
    pooled = _pooled_deviation(together)
    scatter = None
    if pooled is not None:
        scatter = np.where(together.counts > 1, together.deviations, pooled)
    near = max(0.01 * abs(float(fitted[-1] - fitted[0])), pooled or 0.0)
    level = temperatures[np.abs(fitted - fitted[-1]) <= near]
    directions = np.array(data.directions)
    by_direction = {
        way: _group(
            places[directions == way], data.length_ratios[directions == way], len(temperatures)
        )
        for way in DIRECTIONS
        if (directions == way).any()
    }
    return ShrinkFit(
        data=data,
        temperatures=temperatures,
        together=together,
        by_direction=by_direction,
        fitted=fitted,
        scatter=scatter,
        trend="rises" if rising else "falls",
        residual_rms=float(np.sqrt(np.mean((data.length_ratios - fitted[places]) ** 2))),
        pooled_deviation=pooled,
        onset=float(temperatures[np.abs(fitted - fitted[0]) <= near][-1]),
        plateau=float(level[0]) if len(level) > 1 else None,
        anisotropy=_anisotropy(temperatures, by_direction),
    )


def _grouped(temperatures: Floats) -> tuple[np.ndarray[tuple[int], np.dtype[np.intp]], Floats]:
    """Place of each row's temperature among those that count as one, and their means [K]."""
    order = np.argsort(temperatures, kind="stable")
    places = np.zeros(len(temperatures), dtype=np.intp)
    first, place = temperatures[order[0]], 0
    for index in order.tolist():
        if temperatures[index] - first > SAME_TEMPERATURE:
            first, place = temperatures[index], place + 1
        places[index] = place
    # The mean of equal numbers, to the last bit, is that number: sum the excess alone.
    lowest = np.full(place + 1, np.inf)
    np.minimum.at(lowest, places, temperatures)
    excess = np.bincount(places, temperatures - lowest[places]) / np.bincount(places)
    return places, lowest + excess


def _group(places: np.ndarray[tuple[int], np.dtype[np.intp]], ratios: Floats, size: int) -> Group:
    counts = np.bincount(places, minlength=size).astype(np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):
        means = np.bincount(places, ratios, minlength=size) / counts
        squares = np.bincount(places, (ratios - means[places]) ** 2, minlength=size)
        deviations = np.where(counts > 1, np.sqrt(squares / np.maximum(counts - 1, 0)), np.nan)
    return Group(counts, means, deviations)


def _pooled_deviation(group: Group) -> float | None:
    repeated = group.counts > 1
    if not repeated.any():
        return None
    freedom = group.counts[repeated] - 1
    return float(np.sqrt(freedom @ group.deviations[repeated] ** 2 / freedom.sum()))


def _anisotropy(temperatures: Floats, groups: dict[str, Group]) -> Anisotropy | None:
    if len(groups) < 2:
        return None
    x, y = groups["x"], groups["y"]
    both = (x.counts > 0) & (y.counts > 0)
    if not both.any():
        return None
    differences = (x.means - y.means)[both]
    worst = int(np.argmax(np.abs(differences)))
    error, probability = None, None
    if (x.counts[both] > 1).all() and (y.counts[both] > 1).all():
        error, probability = _welch(differences, [x, y], both)
    return Anisotropy(
        float(differences.mean()),
        error,
        probability,
        int(both.sum()),
        float(differences[worst]),
        float(temperatures[both][worst]),
    )


def _welch(
    differences: Floats, groups: list[Group], both: np.ndarray[tuple[int], np.dtype[np.bool_]]
) -> tuple[float, float | None]:
    """Standard error of the mean difference, and its probability by Welch's approximation."""
    from scipy.stats import t

    counts = np.concatenate([group.counts[both] for group in groups])
    deviations = np.concatenate([group.deviations[both] for group in groups])
    terms = deviations**2 / counts / len(differences) ** 2
    error = math.sqrt(terms.sum())
    if error < 1e-12:
        return error, None
    freedom = terms.sum() ** 2 / (terms**2 / (counts - 1)).sum()
    return error, float(2.0 * t.sf(abs(differences.mean()) / error, freedom))
