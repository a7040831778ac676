"""What a fit of parameters returns: values with intervals, and how close the shape came."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sheetmorph import __version__
from sheetmorph.calibrate.misfit import Evaluation
from sheetmorph.calibrate.parameters import Parameter
from sheetmorph.calibrate.uncertainty import Interval
from sheetmorph.design.spec import Design
from sheetmorph.study.result import Result

if TYPE_CHECKING:
    from sheetmorph.calibrate.fit import CalibrateOptions
    from sheetmorph.compare.comparison import Comparison

METHOD = (
    "Sobol points, COBYQA from the best of them, Gauss-Newton at the end; intervals by profiles of "
    "the squared misfit, with a threshold from the F distribution for the number of independent "
    "residuals"
)


@dataclass(frozen=True, eq=False)
class Calibration:
    """A fit that came to its end.

    Attributes:
        design: the design that was fitted, with its own values.
        fitted: the simulation at the optimum.
        parameters: what was varied, p of them.
        targets: names of the data.
        start: the design's own values, measured.
        best: the optimum, measured.
        evaluations: all that was measured, in order.
        intervals: of the parameters, p or none.
        residuals: number of independent residuals in the data.
        rise: of the squared misfit at the ends of the intervals, relative.
        before, after: every scan against the shape of the design as it is, and as fitted.
        options: how the search went.
        simulations: how many designs were simulated; those of a resumed journal are not.
        notes: what the reader should know.
        seconds: the whole took.
    """

    design: Design
    fitted: Result
    parameters: tuple[Parameter, ...]
    targets: tuple[str, ...]
    start: Evaluation
    best: Evaluation
    evaluations: tuple[Evaluation, ...]
    intervals: tuple[Interval, ...]
    residuals: float
    rise: float
    before: tuple[Comparison, ...]
    after: tuple[Comparison, ...]
    options: CalibrateOptions
    simulations: int
    notes: tuple[str, ...]
    seconds: float

    @property
    def failed(self) -> int:
        """How many candidates did not reach their end."""
        return sum(not found.completed for found in self.evaluations)

    def fitted_toml(self) -> str:
        """The fitted design as a file, with a comment on where its values come from."""
        origin = f"the design {self.design.name} ({self.design.hash[:12]})"
        lines = [
            f"Calibrated by sheetmorph {__version__} from {origin},",
            f"against {', '.join(self.targets)}:",
            *(f"  {_with_interval(self, index)}" for index in range(len(self.parameters))),
            f"Misfit {100 * self.start.misfit:.3f} % before, {100 * self.best.misfit:.3f} % after.",
        ]
        # A name may hold any printable character; a comment ends with its line.
        head = "".join(f"# {''.join(c for c in line if c.isprintable())}\n" for line in lines)
        name = f"{self.design.name[:88]}-calibrated"
        return f"{head}\n{self.fitted.design.with_values({'name': name}).to_portable_toml()}"

    def to_json(self) -> dict[str, Any]:
        """The numbers of `calibration.json`."""
        return {
            "design": self.design.name,
            "design_hash": self.design.hash,
            "version": __version__,
            "status": "completed",
            "method": METHOD,
            "parameters": [self._parameter(index) for index in range(len(self.parameters))],
            "misfit_percent": {
                "start": 100 * self.start.misfit,
                "fit": 100 * self.best.misfit,
            },
            "start_status": self.start.status,
            "targets": [
                {
                    "name": name,
                    "kind": "scan" if index < len(self.after) else "curve",
                    "misfit_percent": {
                        which: 100 * found.parts[index] if found.parts else None
                        for which, found in (("start", self.start), ("fit", self.best))
                    },
                }
                for index, name in enumerate(self.targets)
            ],
            "scans": [
                {"name": name, "start": before.to_json(), "fit": after.to_json()}
                for name, before, after in zip(self.targets, self.before, self.after, strict=False)
            ],
            "confidence": self.options.confidence,
            "independent_residuals": self.residuals,
            "allowed_rise_of_squared_misfit": self.rise,
            "evaluations": len(self.evaluations),
            "simulations": self.simulations,
            "failed": self.failed,
            "notes": list(self.notes),
            "seconds": self.seconds,
        }

    def _parameter(self, index: int) -> dict[str, Any]:
        parameter = self.parameters[index]
        told: dict[str, Any] = {
            "name": parameter.name,
            "meaning": parameter.meaning,
            "unit": parameter.unit,
            "start": self.start.values[index],
            "value": self.best.values[index],
            "bounds": [parameter.low, parameter.high],
        }
        if self.intervals:
            interval = self.intervals[index]
            told["interval"] = [interval.low, interval.high]
            told["limited_by_data"] = [not interval.low_open, not interval.high_open]
            told["profile"] = [[value, 100 * misfit] for value, misfit in interval.profile]
        return told

    def summary(self) -> str:
        """The fit in a few lines."""
        lines = [_with_interval(self, index) for index in range(len(self.parameters))]
        lines.append(
            f"misfit {100 * self.start.misfit:.3f} → {100 * self.best.misfit:.3f} % of the size"
        )
        for name, before, after in zip(self.targets, self.before, self.after, strict=False):
            old, new = before.to_json(), after.to_json()
            way = {
                key: f"{old['rms_mm'][key]:.2f} → {new['rms_mm'][key]:.2f} mm"
                for key in ("scan_to_shape", "shape_to_scan")
            }
            lines.append(
                f"{name}: RMS {way['scan_to_shape']} (scan to shape), {way['shape_to_scan']} "
                f"(shape to scan); SSIM {old['ssim']:.3f} → {new['ssim']:.3f}"
            )
        for index in range(len(self.after), len(self.targets)):
            old_rms = self.start.rms[index] if self.start.rms else float("nan")
            lines.append(
                f"{self.targets[index]}: rms of h/d {old_rms:.4f} → {self.best.rms[index]:.4f}"
            )
        return "\n".join(lines)


def remarks(
    parameters: Sequence[Parameter],
    best: Evaluation,
    intervals: Sequence[Interval],
    start: Evaluation,
) -> list[str]:
    """What a reader of a fit should know about its bounds and its start."""
    notes = []
    for parameter, value in zip(parameters, best.values, strict=True):
        share = parameter.to_share(value)
        if share < 2e-3 or share > 1 - 2e-3:
            notes.append(
                f"{parameter.name} ended at its bound {value:.4g}; widen the bounds if it may lie "
                "beyond."
            )
    for parameter, interval in zip(parameters, intervals, strict=False):
        sides = [
            side
            for side, is_open in (("below", interval.low_open), ("above", interval.high_open))
            if is_open
        ]
        if sides:
            notes.append(
                f"The data does not limit {parameter.name} from {' or from '.join(sides)} within "
                "its bounds."
            )
    if not start.completed:
        notes.append(f"The design's own values could not be simulated to the end: {start.status}.")
    return notes


def _with_interval(fit: Calibration, index: int) -> str:
    parameter = fit.parameters[index]
    factor, unit = parameter.shown

    def text(value: float) -> str:
        return f"{factor * value:.4g}".replace("-", "−")

    told = f"{parameter.name} = {text(fit.best.values[index])}{f' {unit}' if unit else ''}"
    if fit.intervals:
        interval = fit.intervals[index]
        low = ("≤ " if interval.low_open else "") + text(interval.low)
        high = ("≥ " if interval.high_open else "") + text(interval.high)
        told += f" [{low}, {high}]"
    return f"{told} (was {text(fit.start.values[index])})"
