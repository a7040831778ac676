"""Pictures of a fit: the misfit over its parameters, and the profiles that give intervals."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sheetmorph.geometry.mesh import Floats
from sheetmorph.show import style
from sheetmorph.show.style import Sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

    from sheetmorph.calibrate.misfit import Evaluation
    from sheetmorph.calibrate.parameters import Parameter
    from sheetmorph.calibrate.result import Calibration

WIDTH, HEIGHT = 1000, 760
PICTURES = ("misfit.png", "profile.png")
"""What is drawn; `profile.png` only where there are intervals."""

_BLUE = style.colour(style.SHAPE)
_ORANGE = style.colour(style.SCAN)
_CLEAR = 3.0  # the axis ends at so many times the misfit of start and optimum


def write_pictures(fit: Calibration, folder: str | Path) -> list[Path]:
    """Draw a fit into a folder.

    Returns:
        The paths of the pictures.

    Raises:
        OutputError: a picture cannot be written.
    """
    place = Path(folder)
    with style.style():
        paths = [write_misfit(fit, place / PICTURES[0])]
        if fit.intervals:
            paths.append(write_profile(fit, place / PICTURES[1]))
    return paths


def write_misfit(fit: Calibration, path: Path) -> Path:
    """The misfit over one parameter, over two as a map, over more in pairs."""
    return {1: _curve, 2: _map}.get(len(fit.parameters), _pairs)(fit, path)


def write_profile(fit: Calibration, path: Path) -> Path:
    """For every parameter the least misfit that the others allow, with its interval."""
    count = len(fit.parameters)
    columns = min(count, 2)
    rows = -(-count // columns)
    width, height = (WIDTH - 24) // columns, 430 if count > 1 else 520
    sheet = Sheet(WIDTH, 130 + rows * height)
    sheet.title("Profiles", _subtitle(fit, f"{_percent(fit.options.confidence)} intervals"))
    for index, parameter in enumerate(fit.parameters):
        row, column = divmod(index, columns)
        bottom = sheet.height - 96 - (row + 1) * height
        axes = sheet.inset(24 + column * width + 82, bottom + 78, width - 122, height - 128)
        interval, factor = fit.intervals[index], parameter.shown[0]
        best, low, high = (
            factor * value for value in (fit.best.values[index], interval.low, interval.high)
        )
        points = np.array(interval.profile)
        if count == 1:  # then every design lies on the profile
            done = [found for found in fit.evaluations if found.completed]
            points = np.array(sorted((found.values[0], found.misfit) for found in done))
        limit = 100 * fit.best.misfit * np.sqrt(1.0 + fit.rise)
        shown = points[100 * points[:, 1] < max(_CLEAR * limit, 100 * fit.start.misfit)]
        axes.plot(
            factor * shown[:, 0], 100 * shown[:, 1], "-o", color=_BLUE, lw=2, ms=4.5, zorder=3
        )
        axes.axhline(limit, color=_ORANGE, lw=1.4, ls="--", zorder=2)
        axes.axvspan(low, high, color=_BLUE, alpha=0.12, lw=0, zorder=1)
        axes.plot(
            [best], [100 * fit.best.misfit], "o", ms=10, mfc=_BLUE, mec="white", mew=1.5, zorder=5
        )
        axes.margins(x=0.08, y=0.12)
        _finish(axes, parameter, "misfit  [% of the size]" if column == 0 else "")
        digits = _digits(parameter)
        first = ("≤ " if interval.low_open else "") + style.signed(low, digits)
        last = ("≥ " if interval.high_open else "") + style.signed(high, digits)
        told = f"{style.signed(best, digits)}   [{first}, {last}]"
        axes.set_title(told, fontsize=style.TEXT, loc="left")
    sheet.foot("Others fitted anew at every point; dashed: the allowed rise of the misfit")
    return sheet.save(path)


def _curve(fit: Calibration, path: Path) -> Path:
    parameter = fit.parameters[0]
    sheet = Sheet(WIDTH, HEIGHT)
    sheet.title("Misfit", _subtitle(fit))
    axes = sheet.inset(116, 138, WIDTH - 116 - 40, HEIGHT - 138 - 112)
    done = [found for found in fit.evaluations if found.completed]
    factor = parameter.shown[0]
    x = factor * np.array([found.values[0] for found in done])
    y = np.array([100 * found.misfit for found in done])
    order = np.argsort(x)
    axes.plot(x[order], y[order], "-o", color=_BLUE, lw=1.6, ms=5, mfc="white", mew=1.4, zorder=3,
              label="simulated designs", clip_on=False)  # fmt: skip
    if fit.intervals:
        interval = fit.intervals[0]
        label = f"{_percent(fit.options.confidence)} interval"
        ends = factor * interval.low, factor * interval.high
        axes.axvspan(*ends, color=_BLUE, alpha=0.14, lw=0, zorder=1, label=label)
    _marks(axes, fit, lambda found: (factor * found.values[0], 100 * found.misfit))
    failed = [factor * found.values[0] for found in fit.evaluations if not found.completed]
    if failed:
        axes.plot(failed, np.full(len(failed), 0.97), "x", color=style.HELD, ms=8, mew=2,
                  transform=axes.get_xaxis_transform(), label="did not reach the end")  # fmt: skip
    _finish(axes, parameter, "misfit  [% of the size]")
    axes.set_xlim(*_span(parameter, fit.start.values[0]))
    axes.set_ylim(0.0, 1.08 * float(y.max()))
    axes.legend(loc="upper center", frameon=False, ncols=1)
    sheet.foot(
        "Misfit: root mean square distance both ways, over the size of the scan"
        if fit.start.scales[:1] != (0.0,)
        else "Misfit: root mean square difference of h/d, over the largest h/d"
    )
    return sheet.save(path)


def _map(fit: Calibration, path: Path) -> Path:
    sheet = Sheet(WIDTH, HEIGHT + 60)
    sheet.title("Misfit", _subtitle(fit))
    box = (116, 150, 570, HEIGHT + 60 - 150 - 100)
    axes = sheet.inset(*box)
    limits = _draw_map(axes, fit, 0, 1)
    _finish(axes, fit.parameters[0], _label(fit.parameters[1]))
    bar = (box[0] + box[2] + 36, box[1] + 0.36 * box[3], 22, 0.54 * box[3])
    sheet.colour_bar(bar, style.ANGLE_MAP, limits, limits, "misfit [%]")
    handles, labels = axes.get_legend_handles_labels()
    sheet.figure.legend(
        handles, labels, loc="lower left", frameon=False, fontsize=style.SMALL,
        bbox_to_anchor=((box[0] + box[2] + 16) / sheet.width, 140 / sheet.height),
    )  # fmt: skip
    sheet.foot("Interpolated between the simulated designs; blank where there are none")
    return sheet.save(path)


def _pairs(fit: Calibration, path: Path) -> Path:
    """Panels of two parameters each: the designs, dark where the misfit is small."""
    count = len(fit.parameters)
    cell = max(220, min(400, (WIDTH - 100) // (count - 1)))
    side = 110 + cell * (count - 1)
    sheet = Sheet(max(side + 60, 720), side + 160)
    sheet.title("Misfit", _subtitle(fit))
    for row in range(1, count):
        for column in range(row):
            axes = sheet.inset(
                110 + column * cell, 130 + (count - 1 - row) * cell, cell - 44, cell - 44
            )
            limits = _draw_map(axes, fit, column, row, filled=False)
            _finish(axes, fit.parameters[column], "")
            if row < count - 1:
                axes.set_xlabel("")
                axes.tick_params(labelbottom=False)
            if column == 0:
                axes.set_ylabel(_label(fit.parameters[row]), labelpad=6)
            else:
                axes.tick_params(labelleft=False)
    bar = (110 + (count - 2) * cell + cell // 2, 130 + cell + 40, 20, max(100, cell - 110))
    sheet.colour_bar(bar, style.ANGLE_MAP, limits, limits, "misfit [%]")
    sheet.foot("A point: a simulated design; square: the design as it was; star: the optimum")
    return sheet.save(path)


def _draw_map(
    axes: Axes, fit: Calibration, first: int, second: int, *, filled: bool = True
) -> tuple[float, float]:
    """Misfit over two parameters; returns the ends of its colours [%]."""
    parameters = (fit.parameters[first], fit.parameters[second])
    done = [found for found in fit.evaluations if found.completed]
    factors = (parameters[0].shown[0], parameters[1].shown[0])
    points = np.array([(found.values[first], found.values[second]) for found in done])
    misfit = np.array([100 * found.misfit for found in done])
    low, high = float(misfit.min()), float(np.quantile(misfit, 0.9))
    high = max(high, 1.05 * low, low + 1e-9)
    places = np.array(
        [[p.to_share(v) for p, v in zip(parameters, point, strict=True)] for point in points]
    )
    if filled and len(done) > 5 and np.linalg.matrix_rank(places - places.mean(axis=0)) == 2:
        _fill(axes, parameters, places, misfit, (low, high))
    x, y = (points * factors).T
    axes.scatter(
        x, y, c=np.clip(misfit, low, high), s=20, cmap=style.ANGLE_MAP,
        vmin=low, vmax=high, edgecolors=style.INK if filled else "none", linewidths=0.6, zorder=3,
        label="simulated designs" if filled else None,
    )  # fmt: skip

    def place(found: Evaluation) -> tuple[float, float]:
        return factors[0] * found.values[first], factors[1] * found.values[second]

    failed = [place(found) for found in fit.evaluations if not found.completed]
    if failed:
        axes.plot(
            *zip(*failed, strict=True), "x", color=style.HELD, ms=7, mew=1.8, zorder=3,
            label="did not reach the end",
        )  # fmt: skip
    _marks(axes, fit, place)
    axes.set_xlim(*_span(parameters[0], fit.start.values[first]))
    axes.set_ylim(*_span(parameters[1], fit.start.values[second]))
    _ticks(axes.yaxis, parameters[1])
    return low, high


def _fill(
    axes: Axes,
    parameters: tuple[Parameter, Parameter],
    places: Floats,
    misfit: Floats,
    limits: tuple[float, float],
) -> None:
    from scipy.interpolate import RBFInterpolator
    from scipy.spatial import Delaunay

    # Designs of a descent lie so close together that the smooth surface needs but one of them.
    _, kept = np.unique(np.round(places, 2), axis=0, return_index=True)
    surface = RBFInterpolator(places[kept], np.log(misfit[kept]), smoothing=1e-6)
    share = np.linspace(0.0, 1.0, 121)
    grid = np.stack(np.meshgrid(share, share), axis=-1).reshape(-1, 2)
    values = np.exp(surface(grid))
    # Beyond the designs nothing is known.
    values[Delaunay(places).find_simplex(grid) < 0] = np.nan
    values = np.clip(values.reshape(121, 121), *limits)
    x, y = ([p.shown[0] * p.from_share(float(s)) for s in share] for p in parameters)
    levels = np.linspace(*limits, 15)
    axes.contourf(x, y, values, levels=levels, cmap=style.ANGLE_MAP, zorder=1)
    axes.contour(x, y, values, levels=levels, colors="white", linewidths=0.4, alpha=0.6, zorder=2)


def _marks(axes: Axes, fit: Calibration, place: Any) -> None:
    """The design as it was, and the optimum."""
    common: dict[str, Any] = {"ls": "none", "mec": "white", "mew": 1.6, "clip_on": False}
    if fit.start.completed:
        x, y = place(fit.start)
        axes.plot([x], [y], "s", ms=11, mfc=style.INK, label="the design as it was", zorder=6,
                  **common)  # fmt: skip
    x, y = place(fit.best)
    axes.plot([x], [y], "*", ms=21, mfc=_ORANGE, label="optimum", zorder=7, **common)


def _finish(axes: Axes, parameter: Parameter, label: str) -> None:
    axes.set_xlabel(_label(parameter), labelpad=8)
    if label:
        axes.set_ylabel(label, labelpad=8)
    _ticks(axes.xaxis, parameter)
    axes.grid(color=style.FAINT, lw=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _ticks(axis: Axis, parameter: Parameter) -> None:
    """Ticks as plain numbers: mathematical text is not set here."""
    from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

    if not parameter.logarithmic:
        axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]))
        return
    scale = axis.axes.set_xscale if axis is axis.axes.xaxis else axis.axes.set_yscale
    scale("log")
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def _label(parameter: Parameter) -> str:
    return f"{parameter.name}  [{parameter.shown[1] or '–'}]"


def _digits(parameter: Parameter) -> int:
    """Decimals that tell a thousandth of the bounds apart."""
    reach = parameter.low if parameter.logarithmic else parameter.high - parameter.low
    return int(np.clip(2 - np.floor(np.log10(parameter.shown[0] * reach)), 0, 12))


def _span(parameter: Parameter, own: float) -> tuple[float, float]:
    """Ends of an axis that shows the bounds, and the design's own value."""
    factor = parameter.shown[0]
    low, high = factor * min(parameter.low, own), factor * max(parameter.high, own)
    if parameter.logarithmic:
        return low, high
    return low - 0.02 * (high - low), high + 0.02 * (high - low)


def _subtitle(fit: Calibration, *more: str) -> str:
    data = ", ".join(fit.targets[:2]) + (", …" if len(fit.targets) > 2 else "")
    told = f"{100 * fit.start.misfit:.2f} → {100 * fit.best.misfit:.2f} %"
    names = (style.shortened(fit.design.name, 30), style.shortened(data, 44))
    return "  ·  ".join([*names, told, *more])


def _percent(share: float) -> str:
    return f"{100 * share:g} %"
