"""Pictures of material data: a shrink curve with its measurements, moduli of cantilever tests."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sheetmorph.design.shrink_fit import Group, ShrinkFit
from sheetmorph.geometry.mesh import Floats
from sheetmorph.measure.cantilever import CantileverResult, Summary
from sheetmorph.show import style
from sheetmorph.show.style import Sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDTH, HEIGHT = 1000, 760
ZERO_CELSIUS = 273.15

_MARKS = {
    "x": ("o", style.BILAYER, "along x"),
    "y": ("s", style.BOTTOM, "along y"),
    "": ("o", style.BILAYER, "measured"),
}
_MANY = 4000
_STIFF = ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa"))


def write_shrink_picture(fit: ShrinkFit, path: Path) -> Path:
    """L/L0 against T/Tg and °C: means with error bars per direction, the fit, its scatter.

    The picture of the paper's Fig. 3E. Without a Tg the axis is in °C alone.

    Raises:
        OutputError: the picture cannot be written.
    """
    with style.style():
        sheet = Sheet(WIDTH, HEIGHT)
        rows = len(fit.data.temperatures)
        sheet.title(
            "Shrinkage" if fit.fitted[-1] <= fit.fitted[0] else "Swelling",
            f"{style.shortened(fit.data.name, 40)}  ·  {rows} measurements at "
            f"{len(fit.temperatures)} temperatures",
        )
        glass = fit.data.glass_temperature
        scaled = _Scale(glass)
        axes = sheet.inset(104, 134, WIDTH - 104 - 44, HEIGHT - 134 - (176 if glass else 120))
        _draw_curve(axes, fit, scaled)
        _draw_means(axes, fit, scaled)
        _draw_plateau(axes, fit, scaled)
        low, high = scaled(fit.temperatures[[0, -1]])
        axes.set_xlim(low - 0.03 * (high - low), high + 0.03 * (high - low))
        axes.set_xlabel(scaled.label, labelpad=8)
        axes.set_ylabel("length L/L₀  [–]", labelpad=8)
        _tidy(axes)
        if glass is not None:
            top = axes.secondary_xaxis("top", functions=(scaled.to_celsius, scaled.from_celsius))
            top.set_xlabel("temperature [°C]", labelpad=8)
            top.spines["top"].set_visible(False)
        axes.legend(loc="lower left" if fit.trend == "falls" else "upper left", frameon=False)
        sheet.foot(_directions_text(fit))
        return sheet.save(path)


def write_cantilever_picture(result: CantileverResult, path: Path) -> Path:
    """E and nominal stiffness of every sample, with mean and standard deviation.

    Raises:
        OutputError: the picture cannot be written.
    """
    with style.style():
        sheet = Sheet(WIDTH, 700)
        bent = (
            "bent by their weight" if result.rows.loading == "self_weight" else "force at the tip"
        )
        theory = "large deflections" if result.large_deflection else "small deflections"
        sheet.title("Cantilever test", f"{len(result.stiffness)} samples, {bent}, {theory}")
        width = (WIDTH - 3 * 84 - 24) / 2
        left = sheet.inset(100, 210, width, 700 - 210 - 156)
        right = sheet.inset(100 + width + 100, 210, width, 700 - 210 - 156)
        factor, unit = stiff_unit(result.modulus.mean)
        error = result.modulus_uncertainty
        _draw_samples(
            left,
            result,
            result.young_modulus / factor,
            scaled(result.modulus, factor),
            None if error is None else error / factor,
        )
        if not result.large_deflection and result.overestimate.max() > 0.01:
            exact = result.young_modulus / (1.0 + result.overestimate) / factor
            places = np.arange(1, len(exact) + 1)
            left.plot(
                *(places, exact, "o"),
                ms=8,
                mfc="none",
                mec=style.HELD,
                mew=1.6,
                ls="none",
                label="exact for large deflections",
                zorder=4,
            )
        left.set_ylabel(f"Young's modulus E  [{unit}]", labelpad=8)
        _draw_samples(right, result, result.stiffness, result.nominal_stiffness, None)
        right.set_ylabel("nominal stiffness K  [N/m]", labelpad=8)
        _head(left, f"E = {spread(result.modulus, factor)} {unit}")
        _head(right, f"K = {spread(result.nominal_stiffness, 1.0)} N/m")
        handles, labels = left.get_legend_handles_labels()
        sheet.figure.legend(
            handles, labels, loc="lower left", bbox_to_anchor=(20 / WIDTH, 56 / 700), ncols=4,
            frameon=False, fontsize=style.SMALL, handletextpad=0.6, columnspacing=1.6,
        )  # fmt: skip
        sheet.foot("± is the standard deviation of the samples, with n − 1 in the denominator")
        return sheet.save(path)


def scaled(summary: Summary, factor: float) -> Summary:
    """A summary in a unit that is `factor` in SI."""
    return Summary(summary.mean / factor, summary.deviation / factor, summary.count)


def stiff_unit(modulus: float) -> tuple[float, str]:
    """A unit of pressure in which a modulus [Pa] reads well, and its size in Pa."""
    return next(((size, unit) for size, unit in _STIFF if abs(modulus) >= 0.3 * size), _STIFF[-1])


def spread(summary: Summary, factor: float) -> str:
    """Mean ± standard deviation as text, to two digits of the deviation, three of the mean."""
    mean, deviation = summary.mean / factor, summary.deviation / factor
    if deviation > 0.0 and mean > 0.0:
        wanted = max(1 - np.floor(np.log10(deviation)), 2 - np.floor(np.log10(mean)))
        digits = int(np.clip(wanted, 0, 9))
        return f"{mean:.{digits}f} ± {deviation:.{digits}f}"
    return f"{mean:.4g} ± 0"


class _Scale:
    """Temperatures [K] as T/Tg, or in °C where there is no Tg."""

    def __init__(self, glass: float | None) -> None:
        self.glass = glass
        self.label = "temperature [°C]" if glass is None else f"T/Tg  [–],  Tg = {glass:.4g} K"

    def __call__(self, temperatures: Any) -> Any:
        if self.glass is None:
            return np.asarray(temperatures) - ZERO_CELSIUS
        return np.asarray(temperatures) / self.glass

    def to_celsius(self, shown: Any) -> Any:
        return np.asarray(shown) * (self.glass or 1.0) - ZERO_CELSIUS

    def from_celsius(self, degrees: Any) -> Any:
        return (np.asarray(degrees) + ZERO_CELSIUS) / (self.glass or 1.0)


def _draw_curve(axes: Axes, fit: ShrinkFit, scale: _Scale) -> None:
    from scipy.interpolate import PchipInterpolator

    fine = np.linspace(fit.temperatures[0], fit.temperatures[-1], 600)
    line = PchipInterpolator(fit.temperatures, fit.fitted)(fine)
    if fit.scatter is not None:
        width = np.interp(fine, fit.temperatures, fit.scatter)
        axes.fill_between(
            scale(fine),
            line - width,
            line + width,
            color=style.FAINT,
            alpha=0.6,
            lw=0,
            label="± standard deviation",
            zorder=1,
        )
    axes.plot(scale(fine), line, "-", color=style.INK, lw=2, label="monotone fit", zorder=2)
    if len(fit.data.temperatures) <= _MANY:
        axes.plot(
            *(scale(fit.data.temperatures), fit.data.length_ratios, "."),
            ms=4,
            color=style.MUTED,
            alpha=0.45,
            ls="none",
            zorder=2,
            clip_on=False,
        )


def _draw_means(axes: Axes, fit: ShrinkFit, scale: _Scale) -> None:
    groups: dict[str, Group] = fit.by_direction or {"": fit.together}
    for way, group in groups.items():
        mark, colour, label = _MARKS[way]
        there = group.counts > 0
        axes.errorbar(
            scale(fit.temperatures[there]), group.means[there],
            yerr=np.nan_to_num(group.deviations[there]),
            fmt=mark, ms=7.5, mfc="white" if way == "y" else style.colour(colour),
            color=style.colour(colour), mew=1.6, elinewidth=1.4, capsize=4, label=label,
            zorder=4 if way == "y" else 3, clip_on=False,
        )  # fmt: skip


def _draw_plateau(axes: Axes, fit: ShrinkFit, scale: _Scale) -> None:
    if fit.plateau is None or fit.plateau <= fit.temperatures[0]:
        return
    place = float(scale(fit.plateau))
    axes.axvline(place, color=style.MUTED, lw=1.4, ls=(0, (5, 4)), zorder=1)
    begin = f"T/Tg = {place:.3f}" if fit.data.glass_temperature else f"{place:.4g} °C"
    falls = fit.trend == "falls"
    axes.annotate(
        f"levels off at {begin}",
        (place, 1.0 if falls else 0.0),
        xycoords=("data", "axes fraction"),
        xytext=(-8, -8 if falls else 8),
        textcoords="offset points",
        ha="right",
        va="top" if falls else "bottom",
        rotation=90,
        fontsize=style.SMALL,
        color=style.MUTED,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 2.0},
    )


def _draw_samples(
    axes: Axes, result: CantileverResult, values: Floats, summary: Summary, error: Floats | None
) -> None:
    from matplotlib.ticker import MaxNLocator

    places = np.arange(1, len(values) + 1)
    low, high = summary.mean - summary.deviation, summary.mean + summary.deviation
    axes.axhspan(low, high, color=style.FAINT, alpha=0.6, lw=0, label="± standard deviation")
    axes.axhline(summary.mean, color=style.INK, lw=2, label="mean")
    blue = style.colour(style.BILAYER)
    axes.errorbar(
        places, values, yerr=error, fmt="o", ms=7 if len(values) < 200 else 3, color=blue,
        elinewidth=1.4, capsize=4, label="sample", zorder=3,
    )  # fmt: skip
    names = [style.shortened(name, 9) for name in result.rows.samples]
    named = len(names) <= 8 and max(map(len, names)) > 2
    if named:
        axes.set_xticks(places, names, rotation=35, ha="right", rotation_mode="anchor")
    else:
        axes.xaxis.set_major_locator(MaxNLocator(10, integer=True))
    axes.set_xlim(0.4, len(values) + 0.6)
    reach = max(high, float(np.max(values + (0.0 if error is None else error))))
    axes.set_ylim(0.0, 1.1 * reach)
    if not named:
        axes.set_xlabel("sample", labelpad=6)
    _tidy(axes)


def _head(axes: Axes, text: str) -> None:
    axes.set_title(text, fontsize=16, loc="left", pad=12)


def _tidy(axes: Axes) -> None:
    axes.grid(color=style.FAINT, lw=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _directions_text(fit: ShrinkFit) -> str:
    """The line below the picture; `ShrinkFit.anisotropy_text` says more."""
    found = fit.anisotropy
    if found is None:
        return "Error bars: standard deviation of repeats"
    text = (
        f"x and y differ by {100 * abs(found.difference):.2g} % of L₀ on average, "
        f"{100 * abs(found.largest):.2g} % at most"
    )
    if found.significant is None:
        return text
    return f"{text}: {'more than' if found.significant else 'within'} the scatter"
