"""A fit finds known parameters back, says how well it knows them, and survives being killed."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import pytest
from synthetic import QUICK, TRUTH, curve_of, made_with, scanned

import sheetmorph as sm
from sheetmorph.calibrate.fit import CalibrateOptions, calibrate
from sheetmorph.calibrate.misfit import CurveTarget, ScanTarget, Task, shape_of
from sheetmorph.calibrate.parameter_texts import read_parameters
from sheetmorph.calibrate.targets import MeasuredScan
from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.scan import read_surface
from sheetmorph.core.errors import ComputationError, InputError


def test_h_over_d_alone_gives_the_actuation_back(small_design: sm.Design) -> None:
    curve = curve_of(made_with(small_design, "eps_pre"), 0.01)
    fit = calibrate(
        small_design,
        read_parameters(["eps_pre=-0.8:-0.2"], small_design),
        curves=[curve],
        options=QUICK,
    )
    assert fit.best.values[0] == pytest.approx(TRUTH["eps_pre"], rel=0.03)
    assert fit.intervals[0].low < TRUTH["eps_pre"] < fit.intervals[0].high
    assert fit.start.values == (-0.4,) and fit.best.misfit < 0.3 * fit.start.misfit
    told = fit.to_json()
    json.dumps(told, allow_nan=False)
    assert told["parameters"][0]["interval"] == [fit.intervals[0].low, fit.intervals[0].high]
    design = sm.Design.from_toml(fit.fitted_toml())
    assert design.eps_pre == fit.best.values[0] and design.name == "small-calibrated"
    assert "film.csv" in fit.fitted_toml().splitlines()[1]


def test_a_fit_that_is_interrupted_goes_on(small_design: sm.Design, tmp_path: Path) -> None:
    curve = curve_of(made_with(small_design, "eps_pre"))
    parameters = read_parameters(["eps_pre=-0.8:-0.2"], small_design)
    file = tmp_path / "evaluations.jsonl"
    options = CalibrateOptions(starts=3, descents=1, profile=False)

    def stop(event: object) -> None:
        if ": 5 designs" in getattr(event, "text", ""):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        calibrate(small_design, parameters, curves=[curve], options=options, journal=file,
                  on_event=stop)  # fmt: skip
    assert len(file.read_text("utf-8").splitlines()) == 6
    whole = calibrate(small_design, parameters, curves=[curve], options=options)
    rest = calibrate(
        small_design, parameters, curves=[curve], options=options, journal=file, resume=True
    )
    assert rest.best.values == whole.best.values
    assert rest.simulations == whole.simulations - 5
    with pytest.raises(InputError, match="other data"):
        calibrate(small_design, parameters, curves=[curve_of(sm.simulate(small_design))],
                  options=options, journal=file, resume=True)  # fmt: skip


def test_simulations_that_fail_are_counted_and_told(small_design: sm.Design) -> None:
    curve = curve_of(sm.simulate(small_design))
    parameters = read_parameters(["eps_pre=-0.8:-0.2"], small_design)
    short = small_design.with_values({"solver.max_steps": 2})
    with pytest.raises(ComputationError, match="too_many_steps"):
        calibrate(short, parameters, curves=[curve], options=QUICK)
    task = Task(short, parameters, (CurveTarget(curve),))
    found = task.evaluate([-0.4])
    assert 1.0 < found.misfit < 2.0 and not found.completed
    together = read_parameters(["published.stretch_factor=1:2"], small_design)
    assert Task(small_design, together, (CurveTarget(curve),)).evaluate([-1.0]).misfit == 2.0


def test_nothing_to_fit_to(small_design: sm.Design) -> None:
    with pytest.raises(InputError, match="nothing to fit"):
        calibrate(small_design, read_parameters(["eps_pre"], small_design))


def test_a_task_goes_to_another_process(small_result: sm.Result) -> None:
    shape = shape_of(small_result)
    target = ScanTarget("s", shape.points, shape.triangles, Similarity.identity(), True)
    task = Task(
        small_result.design,
        read_parameters(["eps_pre"], small_result.design),
        (target, CurveTarget(curve_of(small_result))),
    )
    here = task.evaluate([-0.35])
    there = pickle.loads(pickle.dumps(task)).evaluate([-0.35])  # noqa: S301
    assert (there.values, there.misfit, there.parts) == (here.values, here.misfit, here.parts)
    assert task.evaluate([-0.4]).misfit < 1e-3 < here.misfit < 0.2


@pytest.mark.slow
def test_two_processes_find_the_same(small_design: sm.Design) -> None:
    curve = curve_of(made_with(small_design, "eps_pre"), 0.01)
    parameters = read_parameters(["eps_pre=-0.8:-0.2"], small_design)
    fits = [
        calibrate(small_design, parameters, curves=[curve],
                  options=CalibrateOptions(starts=3, workers=workers, profile=False))
        for workers in (1, 2)
    ]  # fmt: skip
    assert fits[0].best.values == fits[1].best.values


@pytest.mark.slow
def test_a_noisy_scan_of_unknown_size_gives_the_actuation_back(small_design: sm.Design) -> None:
    result = made_with(small_design, "eps_pre")
    fit = calibrate(
        small_design,
        read_parameters(["eps_pre=-0.8:-0.2"], small_design),
        scans=[scanned(result, known=False, times=1)],
        options=QUICK,
    )
    assert fit.best.values[0] == pytest.approx(TRUTH["eps_pre"], rel=0.03)
    assert fit.intervals[0].low < TRUTH["eps_pre"] < fit.intervals[0].high
    assert fit.after[0].to_json()["ssim"] >= fit.before[0].to_json()["ssim"] - 0.01


@pytest.mark.slow
def test_a_curve_of_h_over_d_tells_two_parameters_apart(small_design: sm.Design) -> None:
    names = ("eps_pre", "stretch_factor")
    curve = curve_of(made_with(small_design, *names), 0.01, count=12)
    fit = calibrate(
        small_design,
        read_parameters(["eps_pre=-0.8:-0.2", "stretch_factor=1:100"], small_design),
        curves=[curve],
        options=CalibrateOptions(starts=6, descents=1),
    )
    for name, interval in zip(names, fit.intervals, strict=True):
        assert interval.low < TRUTH[name] < interval.high
    for name, value in zip(names, fit.best.values, strict=True):
        assert value == pytest.approx(TRUTH[name], rel=0.05)


EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "published"


@pytest.mark.slow
def test_the_petals_come_closer_to_their_scan(
    reference: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SHEETMORPH_REFERENCE_DATA", str(reference))
    design = sm.Design.load(EXAMPLES / "petals.toml")
    scan = MeasuredScan(read_surface(reference / "petals_scan_outer.stl"))
    fit = calibrate(
        design,
        read_parameters(["eps_pre=-0.8:-0.2"], design),
        scans=[scan],
        options=CalibrateOptions(starts=4, descents=1, profile=False),
    )
    assert fit.best.values[0] == pytest.approx(-0.517, abs=0.006)
    assert fit.best.misfit < 0.992 * fit.start.misfit
    before, after = (one[0].to_json()["rms_mm"] for one in (fit.before, fit.after))
    assert after["scan_to_shape"] < before["scan_to_shape"] - 0.05
    assert after["shape_to_scan"] < before["shape_to_scan"]
