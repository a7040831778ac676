"""From a target to a design: the search through families of designs."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from time import perf_counter

import numpy as np

from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.core.events import Listener, Notice, Progress, Started, silent
from sheetmorph.design.spec import Design
from sheetmorph.inverse.evaluations import Evaluations, workers
from sheetmorph.inverse.families import FREE, Space, find_family, space_of
from sheetmorph.inverse.free import GRADED, grade, graded_found
from sheetmorph.inverse.journal import Journal
from sheetmorph.inverse.limits import Limits, measured
from sheetmorph.inverse.misfit import (
    THOROUGH,
    Evaluation,
    Job,
    Laid,
    Measure,
    lay,
    pose_of,
    shape_of,
)
from sheetmorph.inverse.result import Found, Step
from sheetmorph.inverse.search_global import evolve, siblings
from sheetmorph.inverse.search_gradient import slide
from sheetmorph.inverse.search_local import descend
from sheetmorph.inverse.targets import Target
from sheetmorph.study.result import Result
from sheetmorph.study.simulate import simulate

APART = 0.15
"""Share of the bounds by which two starts of the same kind differ at least."""
Better = Callable[[Design, Evaluation, tuple[Step, ...]], None]
"""Told of every design that is better than all before, and of those before it."""


@dataclass(frozen=True)
class SearchOptions:
    """How a design is sought.

    Attributes:
        families: names of the families; the best of them wins.
        limits: of fabrication.
        budget: designs of each family on coarse meshes.
        descents: of the best of them that are followed down on their own meshes.
        accuracy: distance, as a share of the size, at which the search ends.
        steps: iterations on the graded field of the free family.
        sheet: size of the sheet [m]; then the target may be scaled freely. None: the target
            has its size, and the sheet follows from it.
        fixed: parameters that do not vary, by name.
        overrides: keys that every design has, as for `Design.with_values`.
        seed: of the random numbers.

    Raises:
        InputError: a number is out of range.
    """

    families: tuple[str, ...] = ("star",)
    limits: Limits = field(default_factory=Limits)
    budget: int = 240
    descents: int = 2
    accuracy: float = 2e-3
    steps: int = 25
    sheet: float | None = None
    fixed: Mapping[str, float] = field(default_factory=dict)
    overrides: Mapping[str, object] = field(default_factory=dict)
    seed: int = 0

    def __post_init__(self) -> None:
        for name, low, high in (
            ("budget", 1, 100_000),
            ("descents", 0, 20),
            ("accuracy", 0.0, 0.5),
            ("steps", 1, 1000),
            ("seed", 0, 2**31),
            ("sheet", 5e-3, 3.0),
        ):
            value = getattr(self, name)
            if value is not None and not low <= value <= high:
                raise InputError(
                    "is out of range", key=name, value=value, allowed=f"{low:g} to {high:g}"
                )


def find_design(
    target: Target,
    options: SearchOptions | None = None,
    *,
    journal: Path | None = None,
    resume: bool = False,
    processes: int = 1,
    scheduler: str | None = None,
    on_event: Listener = silent,
    on_better: Better = lambda design, found, steps: None,
) -> Found:
    """Find the design of some families whose shape comes closest to a target.

    First an evolution over each family, whole numbers among its parameters, on coarse meshes;
    then least squares from the best, on the designs' own meshes.

    Args:
        target: the wanted shape.
        options: how to search.
        journal: keeps every design as it is measured; nothing is kept when None.
        resume: go on with a search that was cut off.
        processes: that simulate side by side.
        scheduler: address of a Dask scheduler to use in their place.
        on_event: told of the progress.
        on_better: told of every design that is better than all before.

    Raises:
        InputError: an option is not allowed, or the journal is of another search.
        OutputError: the journal cannot be written.
        ComputationError: no design reached its end, or the scheduler is lost.
        KeyboardInterrupt: interrupted; the journal holds what was measured.
    """
    began = perf_counter()
    chosen = options or SearchOptions()
    spaces = {name: _space(name, target, chosen) for name in chosen.families if name != FREE}
    on_event(Started(f"{target.name}: {', '.join(chosen.families)}"))
    kept = Journal(journal, fingerprint_of(target, chosen), resume=resume)
    watch = _Watch(spaces, chosen, on_event, on_better)
    graded = None
    if FREE in chosen.families:
        graded = grade(
            target,
            chosen.limits,
            kept,
            steps=chosen.steps,
            sheet=chosen.sheet,
            fixed=dict(chosen.fixed),
            overrides=dict(chosen.overrides),
            on_new=watch.graded,
        )
        spaces[FREE] = graded.space
    measure = Measure(target.surface, spaces, None if chosen.sheet is not None else 1.0)
    with workers(processes, scheduler, on_event) as client:
        evaluations = Evaluations(measure, kept, client=client, on_new=watch)
        best = _searched(evaluations, spaces, chosen, watch)
    on_event(Progress(0.95, "computing the design"))
    space = spaces[best.family]
    design = space.design(best.point, _name(target, best.family))
    result = simulate(design)
    if result.status == "interrupted":
        raise KeyboardInterrupt
    known = kept.known.values()
    return Found(
        target=target,
        family=best.family,
        values=space.values(best.point),
        design=design,
        result=result,
        laid=laid_best(target, result, measure.scale, best),
        made=measured(design, chosen.limits),
        limits=chosen.limits,
        steps=tuple(watch.steps),
        evaluations=len(known),
        fresh=kept.fresh,
        failed=sum(not one.completed for one in known),
        seconds=perf_counter() - began,
        others={} if graded is None else {GRADED: graded_found(target, graded, chosen.limits)},
        notes=(*target.notes, *(() if graded is None else graded.notes)),
    )


def _searched(
    evaluations: Evaluations, spaces: Mapping[str, Space], options: SearchOptions, watch: _Watch
) -> Evaluation:
    """The best of all families, on its own mesh."""
    rough: list[Evaluation] = []
    for space in spaces.values():
        found = evolve(evaluations, space, options.budget, options.seed)
        rough += [*found, *siblings(evaluations, space, found[0])]
    watch.begin_fine()
    starts = _starts(rough, spaces, options.descents + 2)
    fine: list[Evaluation] = []
    for one in starts:
        if _near_enough(fine, options):
            break
        slid = one if options.sheet else slide(evaluations, spaces[one.family], one)
        # A smeared pattern that is narrow may mislead: the start itself stays in the race.
        tries = [Job(one.family, point, coarse=False) for point in {one.point: 0, slid.point: 0}]
        own = [found for found in evaluations.many(tries) if found.completed]
        fine += [min(own, key=_order)] if own else []
    for one in sorted(fine, key=_order)[: options.descents]:
        if not _near_enough(fine, options):
            fine.append(descend(evaluations, spaces[one.family], one, options.accuracy))
    if not fine:
        raise ComputationError(
            "no design of the family reached its end; try another family, or other bounds by --fix"
        )
    return min(fine, key=_order)


def _near_enough(found: list[Evaluation], options: SearchOptions) -> bool:
    return any(one.distance <= options.accuracy for one in found)


def _order(one: Evaluation) -> tuple[float, str, tuple[float, ...]]:
    return one.misfit, one.family, one.point


def laid_best(target: Target, result: Result, scale: float | None, best: Evaluation) -> Laid:
    """The target laid on a run, from the pose that is known and from all others."""
    shape = shape_of(result)
    near = pose_of(best.pose) if best.pose else None
    tries = [lay(target.surface, shape, scale, pose, THOROUGH) for pose in {near, None}]
    return min(tries, key=lambda one: one.distance)


def fingerprint_of(target: Target, options: SearchOptions) -> str:
    """Of all that decides on the course of a search."""
    surface = target.surface
    content = hashlib.sha256(surface.points.tobytes() + surface.triangles.tobytes())
    content.update(json.dumps(asdict(options), sort_keys=True, default=str).encode())
    return content.hexdigest()


def _space(name: str, target: Target, options: SearchOptions) -> Space:
    space = space_of(
        find_family(name),
        target.width,
        options.limits,
        sheet=options.sheet,
        fixed=options.fixed,
        overrides=options.overrides,
    )
    if options.overrides:  # what no design allows is told now, and not by each of them
        space.design(tuple(0.5 * (space.low + space.high)), "middle")
    return space


def _name(target: Target, family: str) -> str:
    words = f"{target.name} {family}"
    return "".join(c if c.isalnum() or c in " ._+-" else "-" for c in words)[:100].lstrip(" ._+-")


def _starts(rough: list[Evaluation], spaces: Mapping[str, Space], count: int) -> list[Evaluation]:
    """Where to go down from: the best of each family and choice of whole numbers, best first.

    Where these are fewer than wanted, others that are not near to them.
    """
    kinds: dict[tuple[object, ...], Evaluation] = {}
    done = sorted((one for one in rough if one.completed), key=_order)
    for one in done:
        pairs = zip(spaces[one.family].parameters, one.point, strict=True)
        kind = (one.family, *(value for parameter, value in pairs if parameter.whole))
        kinds.setdefault(kind, one)
    chosen = list(kinds.values())[:count]
    for one in done:
        if len(chosen) < count and all(_apart(one, other, spaces) for other in chosen):
            chosen.append(one)
    return chosen


def _apart(one: Evaluation, other: Evaluation, spaces: Mapping[str, Space]) -> bool:
    if one.family != other.family:
        return True
    space = spaces[one.family]
    steps = abs(np.array(one.point) - other.point) / (space.high - space.low)
    return bool(steps.max() > APART)


class _Watch:
    """Tells of the progress, and remembers how the best became better."""

    def __init__(
        self,
        spaces: Mapping[str, Space],
        options: SearchOptions,
        on_event: Listener,
        on_better: Better,
    ) -> None:
        self._spaces, self._on_event, self._on_better = spaces, on_event, on_better
        rough = options.budget * len(options.families)
        self._expected = rough + options.descents * 60
        self._fine, self._best = False, float("inf")
        self._field = float("inf")
        self.count = self.fields = 0
        self.steps: list[Step] = []

    def begin_fine(self) -> None:
        """Coarse meshes deceive a little: what counts from now on is measured on fine ones."""
        self._fine, self._best = True, float("inf")

    def graded(self, job: Job, found: Evaluation) -> None:
        """Tell of a field; it is no design with a pattern, and does not count among them."""
        self.fields += 1
        text = f"graded film: {self.fields} fields, distance {100 * found.distance:.2f} %"
        self._on_event(Progress(0.0, text))
        if found.completed and found.misfit < self._field:
            self._field = found.misfit
            self._on_event(Notice(text))

    def __call__(self, job: Job, found: Evaluation) -> None:
        self.count += 1
        if found.completed and not job.slopes and found.misfit < self._best:
            self._best = found.misfit
            stage = "fine" if self._fine else "coarse"
            self.steps.append(Step(self.count, found.misfit, f"{job.family}, {stage}"))
            design = self._spaces[job.family].design(job.point, "best so far", coarse=job.coarse)
            self._on_event(
                Notice(
                    f"{self.count} designs: {100 * found.misfit:.2f} %, {job.family}, {stage} mesh"
                )
            )
            self._on_better(design, found, tuple(self.steps))
        share = min(0.94, 0.94 * self.count / self._expected)
        where = "smeared" if job.slopes else "coarse mesh" if job.coarse else "own mesh"
        best = f"{100 * self._best:.2f} %" if self._best < 1.0 else "none yet"
        self._on_event(Progress(share, f"{job.family}, {where}: {self.count} designs, best {best}"))
