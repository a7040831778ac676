"""The simulations behind the paper's results: which designs, how changed, run side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.core.processes import one_thread_each, processes
from sheetmorph.design.presets import preset_text
from sheetmorph.design.spec import Design
from sheetmorph.geometry import surface
from sheetmorph.geometry.mesh import Floats
from sheetmorph.study.result import Result
from sheetmorph.study.simulate import simulate

LETTERS = {"bowl": "A", "canoe": "B", "petals": "C"}
"""The paper's names of the three designs."""

ACTUATIONS = {
    "bowl": (-0.20, -0.30, -0.77),
    "canoe": (-0.08, -0.15, -0.30),
    "petals": (-0.10, -0.30, -0.50),
}
"""eps_pre of the rows of Figs 5–7."""

WIDTHS: tuple[surface.Width, ...] = ("feret_max", "feret_min", "x")


_RELEASED: dict[str, dict[str, object]] = {
    "bowl": {
        "pattern.0.centre": ["0.010775 mm", "0 mm"],
        "supports.0.x": ["-9.989225 mm", "10.010775 mm"],
        "published.mean_edge_length": "3.2 mm",
    },
    "canoe": {
        "outline.width": "155.28731 mm",
        "outline.centre": ["77.643655 mm", "50 mm"],
        "pattern.0.centre": ["49.773655 mm", "50 mm"],
        "pattern.1.centre": ["105.513655 mm", "50 mm"],
        "pattern.2.start": ["49.773655 mm", "50 mm"],
        "pattern.2.end": ["105.513655 mm", "50 mm"],
        "supports.0.x": ["57.7 mm", "98.7 mm"],
        "supports.0.y": ["45.8 mm", "53.8 mm"],
        "published.mean_edge_length": "4.0 mm",
    },
    "petals": {
        "outline.height": "101.88534 mm",
        "outline.centre": ["50 mm", "50.94267 mm"],
        "pattern.0.centre": ["50 mm", "50.94267 mm"],
        "supports.0.x": ["40 mm", "60 mm"],
        "supports.0.y": ["40.94267 mm", "60.94267 mm"],
        "published.mean_edge_length": "5.8 mm",
    },
}
"""What the released meshes need beside the presets: their places and mean edge lengths."""


@dataclass(frozen=True)
class Setting:
    """What is there to work with.

    Attributes:
        reference: folder with the paper's meshes; None to mesh the presets.
        scan: scan of the petals; None where there is none.
        coarsen: factor on the mesh sizes of the presets; 1 but in trials.
    """

    reference: Path | None = None
    scan: Path | None = None
    coarsen: float = 1.0


@dataclass(frozen=True)
class Run:
    """One simulation.

    Attributes:
        design: bowl, canoe or petals.
        values: keys of the design that are set, with their values, sorted.
        adhesive: thickness [m] and Young's modulus [Pa] of a layer of glue; None without.
        own_mesh: mesh the preset even where the paper's mesh is there.
        timed: run once to warm up, and measure the second time.
    """

    design: str
    values: tuple[tuple[str, object], ...] = ()
    adhesive: tuple[float, float] | None = None
    own_mesh: bool = False
    timed: bool = False

    @classmethod
    def of(cls, design: str, values: Mapping[str, object] | None = None, **options: Any) -> Run:
        """A run from a mapping of keys to values."""
        return cls(design, tuple(sorted((values or {}).items())), **options)

    def __str__(self) -> str:
        changed = [f"{key.rpartition('.')[2]} {value}" for key, value in self.values]
        if self.adhesive is not None:
            thickness, modulus = self.adhesive
            changed.append(f"adhesive {1e3 * thickness:g} mm, {1e-6 * modulus:g} MPa")
        return ", ".join([self.design, *changed])


@dataclass(frozen=True, eq=False)
class Outcome:
    """What became of a run, small enough to be sent between processes.

    Attributes:
        result: with its last state alone; None where the run could not begin.
        actuation: eps_pre of all states, shape (S,).
        aspect_ratio: h/d of all states by each of `WIDTHS`.
        failure: why there is no shape at full actuation; empty where there is one.
        cpu_seconds, seconds: processor and wall time.
    """

    result: Result | None
    actuation: Floats
    aspect_ratio: dict[str, Floats]
    failure: str
    cpu_seconds: float
    seconds: float

    @property
    def shape(self) -> Floats:
        """Positions of the last state [m], shape (V, 3)."""
        assert self.result is not None  # noqa: S101  asked only of runs that succeeded
        return np.asarray(self.result.positions[-1])


Outcomes = Mapping[Run, Outcome]


def design_of(run: Run, setting: Setting) -> Design:
    """The design of a run, on the paper's mesh where it is there.

    Raises:
        InputError: the mesh or a value is not usable.
    """
    values: dict[str, object] = dict(run.values)
    folder = None
    text = preset_text(run.design)
    if setting.reference is not None and not run.own_mesh:
        folder = setting.reference
        values = {
            **_RELEASED[run.design],
            "perturbation.force_per_node": "9.81e-7 N",
            "perturbation.ramp_down_steps": 10,
            "mesh.file": f"{run.design}_mesh.txt",
            "mesh.unit": "m",
            "published.hinge_orientation": "file_order",
            **values,
        }
    elif setting.coarsen != 1.0 and "mesh.size" not in values:
        size = Design.from_toml(text).spec.mesh.size
        assert size is not None  # noqa: S101  presets are meshed by size
        values["mesh.size"] = f"{1e3 * size * setting.coarsen:.6g} mm"
    design = Design.from_toml(text, folder).with_values(values)
    return design if run.adhesive is None else _with_adhesive(design, *run.adhesive)


def _with_adhesive(design: Design, thickness: float, modulus: float) -> Design:
    """The design with a layer of glue between film and pattern."""
    import tomlkit

    document = tomlkit.parse(design.source)
    layer = tomlkit.table()
    layer.update(
        {
            "name": "adhesive",
            "role": "inert",
            "thickness": f"{1e3 * thickness:.6g} mm",
            "young_modulus": f"{1e-6 * modulus:.6g} MPa",
            "poisson_ratio": 0.38,
            "density": "1150 kg/m^3",
            "where": "pattern",
        }
    )
    document["layers"].insert(1, layer)
    return Design.from_toml(tomlkit.dumps(document), design.folder)


def perform(run: Run, setting: Setting) -> Outcome:
    """Simulate. Whatever goes wrong is told in the outcome, not raised."""
    start, cpu = perf_counter(), process_time()
    none = np.empty(0)
    try:
        design = design_of(run, setting)
        if run.timed:
            simulate(design)
            start, cpu = perf_counter(), process_time()
        result = simulate(design)
    except Exception as error:
        text = str(error) if isinstance(error, InputError) else f"{type(error).__name__}: {error}"
        return Outcome(
            None, none, {}, text or "failed", process_time() - cpu, perf_counter() - start
        )
    spent = process_time() - cpu, perf_counter() - start
    failure = ""
    if result.status != "completed":
        reached = 100 * float(result.summary["actuation_reached"])
        told = result.summary["detail"] or result.status.replace("_", " ")
        failure = f"The run ended at {reached:.0f} % of the actuation: {told}."
    ratios: dict[str, Floats] = {
        name: np.asarray(surface.aspect_ratio(result.positions, name)) for name in WIDTHS
    }
    last = replace(
        result,
        positions=result.positions[-1:],
        ramp=result.ramp[-1:],
        load_fraction=result.load_fraction[-1:],
        residual=result.residual[-1:],
    )
    return Outcome(last, result.actuation, ratios, failure, *spent)


@dataclass(frozen=True)
class Job:
    """A function and its arguments, for `perform_all`; `name` is what progress tells."""

    name: str
    work: Callable[..., Any]
    arguments: tuple[Any, ...] = field(default=())


def perform_all(jobs: Sequence[Job], workers: int) -> Iterator[tuple[int, Any]]:
    """Do the jobs side by side, each on one thread; yields index and result as they end.

    With one worker they are done here, one after the other. A job whose process dies yields
    the exception that says so.
    """
    if workers <= 1 or len(jobs) <= 1:
        for index, job in enumerate(jobs):
            yield index, job.work(*job.arguments)
        return
    from concurrent.futures import as_completed
    from concurrent.futures.process import BrokenProcessPool

    with one_thread_each(), processes(min(workers, len(jobs))) as pool:
        futures = {pool.submit(job.work, *job.arguments): k for k, job in enumerate(jobs)}
        try:
            for future in as_completed(futures):
                try:
                    yield futures[future], future.result()
                except BrokenProcessPool as error:
                    yield futures[future], error
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
