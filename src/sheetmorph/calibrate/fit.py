"""The search for the parameters with which a design's shape comes closest to measurements."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph import __version__
from sheetmorph.calibrate import targets as laid
from sheetmorph.calibrate.curves import Curve
from sheetmorph.calibrate.evaluations import Evaluations
from sheetmorph.calibrate.misfit import (
    MOST,
    Evaluation,
    ScanTarget,
    Task,
    independent_residuals,
    where_noise_is_left,
)
from sheetmorph.calibrate.parameters import Parameter, with_parameters
from sheetmorph.calibrate.polish import polish
from sheetmorph.calibrate.result import Calibration, remarks
from sheetmorph.calibrate.search import apart, descend, spread
from sheetmorph.calibrate.uncertainty import Interval, allowed_rise, profile
from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.core.events import Event, Listener, Notice, Progress, Started, silent
from sheetmorph.design.spec import Design
from sheetmorph.study.result import Result
from sheetmorph.study.simulate import simulate

if TYPE_CHECKING:
    from sheetmorph.calibrate.targets import MeasuredScan

MAX_STARTS = 1000
MAX_WORKERS = 64
BETTER_POSE = 0.98
"""A global alignment replaces the pose when it leaves less than this share of the misfit."""

COARSE = 1e-2
"""To what share of its bounds a parameter is searched before the optimum is polished."""

_ROUNDS = 3


@dataclass(frozen=True)
class CalibrateOptions:
    """How the search goes.

    Attributes:
        starts: points spread over the bounds (Sobol 1967), beside the design's own values;
            by default 4 and 4 more for every parameter.
        descents: of how many of the best of them the way down is followed.
        tolerance: to what share of its bounds a parameter is found.
        confidence: of the intervals.
        profile: whether to find the intervals; they cost more than the fit.
        curve_weight: weight of a curve; a scan has the weight 1.
        workers: processes that simulate side by side; 1 is this process alone.
        seed: of the starts.
        samples: points that stand for a scan at most; more of them average more of its noise.

    Raises:
        InputError: a number is out of range.
    """

    starts: int | None = None
    descents: int = 2
    tolerance: float = 1e-3
    confidence: float = 0.95
    profile: bool = True
    curve_weight: float = 1.0
    workers: int = 1
    seed: int = 0
    samples: int = MOST

    def __post_init__(self) -> None:
        for name, low, high in (
            ("starts", 0, MAX_STARTS),
            ("descents", 1, 20),
            ("tolerance", 1e-6, 0.1),
            ("confidence", 0.5, 0.9999),
            ("curve_weight", 1e-9, 1e9),
            ("workers", 1, MAX_WORKERS),
            ("seed", 0, 2**31),
            ("samples", 100, 1_000_000),
        ):
            value = getattr(self, name)
            if value is not None and not low <= value <= high:
                allowed = f"{low:g} to {high:g}"
                raise InputError("is out of range", key=name, value=value, allowed=allowed)

    def count(self, parameters: int) -> int:
        """How many starting points there are for so many parameters."""
        return 4 + 4 * parameters if self.starts is None else self.starts


def calibrate(
    design: Design,
    parameters: Sequence[Parameter],
    *,
    scans: Sequence[MeasuredScan] = (),
    curves: Sequence[Curve] = (),
    options: CalibrateOptions | None = None,
    journal: Path | None = None,
    resume: bool = False,
    on_event: Listener = silent,
) -> Calibration:
    """Fit parameters of a design to scans and to curves of h/d.

    The misfit is the root mean square distance both ways between the computed shape and a
    scan in its best pose, over the size of the scan: in the scan's own unit, for otherwise a
    shape that shrinks more would seem closer. For a curve it is the rms difference of h/d
    over the largest h/d. Several data are combined as the root of the weighted mean square.

    Starting points are spread over the bounds, the best are followed downhill, and profiles
    of the misfit give an interval for each parameter.

    Args:
        design: what is fitted; its own values are the first candidate.
        parameters: what is varied, see `sheetmorph.calibrate.parameters.read_parameters`.
        scans: surfaces to come close to.
        curves: curves of h/d to come close to.
        options: how the search goes.
        journal: a file that keeps every evaluation as it is made; none when None.
        resume: begin with what the journal holds.
        on_event: told of the progress.

    Raises:
        InputError: nothing to fit, or data that cannot be used; a journal of another fit.
        ComputationError: no candidate could be simulated.
        KeyboardInterrupt: interrupted; the journal is whole.
    """
    began = perf_counter()
    options = options or CalibrateOptions()
    if not parameters or not (scans or curves):
        raise InputError("nothing to fit: give a parameter, and a scan or a curve")
    design.must_be_still("a calibration")
    on_event(Started(f"calibrate {design.name}"))
    on_event(Progress(0.0, "the design as it is"))
    own = simulate(design)
    if own.status == "interrupted":
        raise KeyboardInterrupt
    before, scan_targets = laid.lay(own, scans, options.samples, on_event)
    task = Task(design, tuple(parameters), laid.targets(scan_targets, curves, options.curve_weight))
    fingerprint = _fingerprint(design, parameters, scans, curves, options)
    listener = _Counter(on_event, len(parameters), options)
    evaluations = Evaluations(
        task,
        fingerprint,
        journal=journal,
        resume=resume,
        workers=options.workers,
        on_new=listener.new,
    )
    listener.evaluations = evaluations
    notes = [note for curve in curves for note in curve.notes]
    with evaluations:
        best, result, after, more, passed = _search(
            evaluations, fingerprint, scans, options, listener
        )
        intervals: tuple[Interval, ...] = ()
        residuals = sum(
            independent_residuals(target, result) for target in evaluations.task.targets
        )
        rise = allowed_rise(residuals, len(parameters), options.confidence)
        if options.profile:
            for _ in range(_ROUNDS):
                listener.stage("profiles")
                intervals = profile(evaluations, best, rise)
                lower = evaluations.best()
                if lower.misfit**2 >= best.misfit**2 * (1.0 - 0.05 * rise):
                    break
                best = _refined(evaluations, lower, options.tolerance)
            else:
                more.append("The profiles kept finding better places; raise --starts.")
            fitted = with_parameters(design, parameters, best.values)
            if result.design.hash != fitted.hash:
                result = simulate(fitted)
                after, _ = laid.lay(result, scans, options.samples, on_event)
            evaluations.many(passed)
        start = evaluations(task.own_values())
    return Calibration(
        design=design,
        fitted=result,
        parameters=tuple(parameters),
        targets=tuple(target.name for target in task.targets),
        start=start,
        best=best,
        evaluations=tuple(evaluations.here()),
        intervals=intervals,
        residuals=residuals,
        rise=rise,
        before=before,
        after=after,
        options=options,
        simulations=evaluations.fresh,
        notes=tuple(notes + more + remarks(parameters, best, intervals, start)),
        seconds=perf_counter() - began,
    )


def _search(
    evaluations: Evaluations,
    fingerprint: str,
    scans: Sequence[MeasuredScan],
    options: CalibrateOptions,
    listener: _Counter,
) -> tuple[Evaluation, Result, laid.Comparisons, list[str], list[tuple[float, ...]]]:
    """The optimum; begun anew when a global alignment there finds a better pose.

    Returns:
        The optimum, its shape and comparisons, notes, and designs that the search measured
        otherwise than the optimum, for the pictures.
    """
    notes: list[str] = []
    for attempt in range(_ROUNDS):
        task = evaluations.task
        listener.stage("starting points")
        scattered = evaluations.many(
            [
                task.own_values(),
                *spread(task.parameters, options.count(len(task.parameters)), options.seed),
            ]
        )
        begun = apart(task.parameters, scattered, options.descents)
        if not begun:
            raise ComputationError(
                f"none of {len(scattered)} simulations reached its end "
                f"({', '.join(sorted({found.status for found in scattered}))}); "
                "try narrower bounds"
            )
        listener.stage("descending")
        works = [
            lambda found=found: descend(evaluations, found, max(COARSE, options.tolerance))
            for found in begun
        ]
        ends = evaluations.chains(works)
        listener.stage("polishing")
        # Not the best that is known: a journal that is taken up knows more than the search saw.
        near = min([*scattered, *ends], key=lambda found: found.misfit)
        passed: list[tuple[float, ...]] = []
        noisy = _by_points(task, near)
        if noisy is not None:
            notes.append(
                "What is left of the misfit differs from point to point as noise does: the optimum "
                "has the least distances of the scan's points to the shape, one way."
            )
            passed = [found.values for found in evaluations.here()]
            evaluations.retarget(noisy, f"{fingerprint}-{attempt}-points")
            near = evaluations(near.values)
        best = _refined(evaluations, near, options.tolerance)
        listener.stage("checking the pose")
        result = simulate(with_parameters(task.design, task.parameters, best.values))
        if result.status == "interrupted":
            raise KeyboardInterrupt
        after, targets = laid.lay(result, scans, options.samples, listener.on_event)
        # A task with the poses found here, used if one of them is better than those followed.
        curves = task.targets[len(scans) :]
        other = replace(task, targets=(*targets, *curves))
        alike = [
            replace(new, one_way=isinstance(old, ScanTarget) and old.one_way)
            for new, old in zip(targets, evaluations.task.targets, strict=False)
        ]
        anew = replace(task, targets=(*alike, *curves)).evaluate(best.values) if scans else best
        if anew.misfit >= BETTER_POSE * best.misfit:
            break
        notes.append("A better pose of the scan was found at the optimum; the search was repeated.")
        evaluations.retarget(other, f"{fingerprint}-{attempt + 1}")
    return best, result, after, notes, passed


def _by_points(task: Task, near: Evaluation) -> Task | None:
    """The task with scans measured one way where nothing but noise is left; None where not."""
    result = simulate(with_parameters(task.design, task.parameters, near.values))
    targets = tuple(
        (where_noise_is_left(target, result) if isinstance(target, ScanTarget) else None) or target
        for target in task.targets
    )
    alike = all(new is old for new, old in zip(targets, task.targets, strict=True))
    return None if alike else replace(task, targets=targets)


def _refined(evaluations: Evaluations, near: Evaluation, tolerance: float) -> Evaluation:
    """The optimum near a design: by its residuals, or downhill where those cannot be had."""
    best = polish(evaluations, near, tolerance)
    return descend(evaluations, near, tolerance, radius=COARSE) if best is None else best


def _fingerprint(
    design: Design,
    parameters: Sequence[Parameter],
    scans: Sequence[MeasuredScan],
    curves: Sequence[Curve],
    options: CalibrateOptions,
) -> str:
    """A hash of all on which the search depends; not of the number of processes."""
    about = {**asdict(options), "workers": 0, "version": __version__, "design": design.hash}
    about["parameters"] = [asdict(parameter) for parameter in parameters]
    about["scans"] = [scan.fingerprint for scan in scans]
    digest = hashlib.sha256(json.dumps(about, sort_keys=True).encode())
    for curve in curves:
        digest.update(curve.axis.encode())
        for column in (curve.at, curve.aspect_ratio, curve.weights):
            digest.update(np.ascontiguousarray(column).tobytes())
    return digest.hexdigest()


class _Counter:
    """Tells of the progress: how far the search is can only be guessed."""

    def __init__(self, on_event: Listener, parameters: int, options: CalibrateOptions) -> None:
        self.on_event: Listener = on_event
        starts = options.count(parameters)
        descending = 12 * parameters * options.descents
        profiles = parameters * (10 if parameters == 1 else 80 * (parameters - 1))
        self._expected = 1 + starts + descending + (profiles if options.profile else 0)
        self._stage = ""
        self.evaluations: Evaluations | None = None

    def stage(self, text: str) -> None:
        """A new part of the work begins."""
        self._stage = text
        self._tell()

    def new(self, found: Evaluation) -> None:
        """A candidate was measured."""
        if not found.completed:
            self.on_event(Notice(f"a candidate ended as {found.status}"))
        self._tell()

    def _tell(self) -> None:
        known = self.evaluations.here() if self.evaluations is not None else []
        least = min((found.misfit for found in known), default=float("inf"))
        told = f", misfit {100 * least:.3g} %" if np.isfinite(least) else ""
        fraction = 1.0 - 1.0 / (1.0 + 2.0 * len(known) / self._expected)
        event: Event = Progress(fraction, f"{self._stage}: {len(known)} designs{told}")
        self.on_event(event)
