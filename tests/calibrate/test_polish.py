"""How a fit ends where noise alone is left: one way, with all points of the scan."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from synthetic import QUICK, TRUTH, curve_of, made_with, noisy, scanned, subdivided

import sheetmorph as sm
from sheetmorph.calibrate.evaluations import Evaluations
from sheetmorph.calibrate.fit import calibrate
from sheetmorph.calibrate.misfit import (
    CurveTarget,
    Evaluation,
    ScanTarget,
    Task,
    shape_of,
    where_noise_is_left,
)
from sheetmorph.calibrate.parameter_texts import read_parameters
from sheetmorph.calibrate.parameters import Parameter, with_parameters
from sheetmorph.calibrate.polish import polish
from sheetmorph.calibrate.search import apart, descend, spread
from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.surface import Surface

BOUNDS = {"eps_pre": "-0.8:-0.2", "gamma": "0:6", "moduli_ratio": "0.7:3"}


def task_of(design: sm.Design, names: tuple[str, ...], scan: Surface, most: int) -> Task:
    texts = [f"{name}={BOUNDS[name]}" for name in names]
    target = ScanTarget("s", scan.points, scan.triangles, Similarity.identity(), True, most=most)
    return Task(design, read_parameters(texts, design), (target,))


def polished(task: Task, start: tuple[float, ...]) -> Evaluation:
    """As a fit ends: one way, where noise alone is left."""
    near = sm.simulate(with_parameters(task.design, task.parameters, start))
    target = task.targets[0]
    assert isinstance(target, ScanTarget)
    one_way = where_noise_is_left(target, near)
    assert one_way is not None and one_way.one_way
    evaluations = Evaluations(replace(task, targets=(one_way,)), "x")
    best = polish(evaluations, evaluations(start), 1e-3)
    assert best is not None
    return best


@pytest.mark.slow
@pytest.mark.parametrize(
    ("truth", "times", "seeds"),
    [
        ({"eps_pre": -0.47}, 2, 4),
        ({"moduli_ratio": 1.5}, 4, 4),
        ({"eps_pre": -0.47, "gamma": 3.0}, 5, 2),
    ],
    ids=["eps_pre", "moduli_ratio", "eps_pre and gamma"],
)
def test_parameters_are_found_within_3_percent_whatever_the_noise(
    small_design: sm.Design, truth: dict[str, float], times: int, seeds: int
) -> None:
    """1 % of the size at every point, several seeds; as many points as the parameter needs.

    A point's noise shifts the fit by the bound of Cramér and Rao: `docs/calibration.md` has the
    table of how many points are needed. The search is done once; noise is what differs.
    """
    names = tuple(truth)
    parameters = [Parameter(name, -1e9, 1e9) for name in names]
    exact = sm.simulate(with_parameters(small_design, parameters, list(truth.values())))
    shape = subdivided(shape_of(exact), times)
    first = noisy(subdivided(shape_of(exact), 2), 0.01, 0)
    searched = Evaluations(task_of(small_design, names, first, 2000), "x")
    spots = spread(searched.task.parameters, 5, 0)
    begun = apart(searched.task.parameters, searched.many(spots), 1)
    start = descend(searched, begun[0], 1e-2).values
    for seed in range(seeds):
        scan = noisy(shape, 0.01, seed)
        best = polished(task_of(small_design, names, scan, len(scan.points)), start)
        np.testing.assert_allclose(best.values, list(truth.values()), rtol=0.03)


@pytest.mark.slow
def test_a_whole_fit_ends_one_way_where_noise_is_left(
    small_design: sm.Design, tmp_path: Path
) -> None:
    scan = scanned(made_with(small_design, "eps_pre"), known=True, times=2, seed=3)
    parameters = read_parameters(["eps_pre=-0.8:-0.2"], small_design)
    file = tmp_path / "evaluations.jsonl"
    fit = calibrate(small_design, parameters, scans=[scan], options=QUICK, journal=file)
    assert fit.best.values[0] == pytest.approx(TRUTH["eps_pre"], rel=0.03)
    assert fit.intervals[0].low < TRUTH["eps_pre"] < fit.intervals[0].high
    assert "one way" in fit.notes[0]
    assert len(fit.evaluations) > len(fit.intervals[0].profile)  # those of the search, too
    again = calibrate(
        small_design, parameters, scans=[scan], options=QUICK, journal=file, resume=True
    )
    assert (again.best.values, again.simulations) == (fit.best.values, 0)


def test_without_noise_the_polish_finds_all_digits(small_design: sm.Design) -> None:
    names = ("eps_pre", "gamma")
    shape = subdivided(shape_of(made_with(small_design, *names)), 1)
    evaluations = Evaluations(task_of(small_design, names, shape, 2000), "x")
    best = polish(evaluations, evaluations((-0.46, 1.35)), 1e-4)
    assert best is not None
    np.testing.assert_allclose(best.values, [TRUTH[name] for name in names], rtol=1e-4)


def test_the_polish_keeps_to_the_bounds_and_tells_what_it_cannot_do(
    small_design: sm.Design,
) -> None:
    curve = CurveTarget(curve_of(made_with(small_design, "eps_pre")))
    parameters = read_parameters(["eps_pre=-0.45:-0.2"], small_design)
    task = Task(small_design, parameters, (curve,))
    evaluations = Evaluations(task, "x")
    best = polish(evaluations, evaluations((-0.4,)), 1e-3)
    assert best is not None and best.values == (-0.45,)
    short = replace(task, design=small_design.with_values({"solver.max_steps": 2}))
    evaluations = Evaluations(short, "x")
    assert polish(evaluations, evaluations((-0.4,)), 1e-3) is None
    other = read_parameters(["mesh.size=2.5 mm:4 mm"], small_design)
    evaluations = Evaluations(replace(task, parameters=other), "x")
    assert polish(evaluations, evaluations((3e-3,)), 1e-3) is None


def test_noise_is_told_from_a_wrong_model(small_result: sm.Result) -> None:
    shape = subdivided(shape_of(small_result), 2)
    stretched = Surface(shape.points * [1.05, 1.0, 1.0], shape.triangles)
    told = [
        where_noise_is_left(
            ScanTarget("s", scan.points, scan.triangles, Similarity.identity(), True), small_result
        )
        for scan in (noisy(shape, 0.01, 0), stretched, noisy(stretched, 0.003, 0))
    ]
    assert [one is not None for one in told] == [True, False, False]
