"""A fit finds known parameters back, says how well it knows them, and survives being killed."""

from __future__ import annotations

import json
import pickle
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import sheetmorph as sm
from sheetmorph.calibrate.curves import Curve, read_curve
from sheetmorph.calibrate.evaluations import Evaluations
from sheetmorph.calibrate.fit import CalibrateOptions, calibrate
from sheetmorph.calibrate.misfit import (
    CurveTarget,
    Evaluation,
    ScanTarget,
    Task,
    independent_residuals,
    noise_alone,
    shape_of,
)
from sheetmorph.calibrate.parameter_texts import read_parameters
from sheetmorph.calibrate.parameters import NAMED, Parameter, with_parameters
from sheetmorph.calibrate.polish import polish
from sheetmorph.calibrate.repose import Points, repose
from sheetmorph.calibrate.search import apart, descend, minimise, spread
from sheetmorph.calibrate.targets import MeasuredScan
from sheetmorph.calibrate.uncertainty import allowed_rise, profile
from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.scan import Scan, read_surface
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.geometry.surface import vertex_normals

EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "published"
TRUTH = {"eps_pre": -0.47, "gamma": 1.2, "moduli_ratio": 1.5, "stretch_factor": 6.0}


def subdivided(surface: Surface, times: int) -> Surface:
    import trimesh

    points, triangles = surface.points, surface.triangles
    for _ in range(times):
        points, triangles = trimesh.remesh.subdivide(points, triangles)
    return Surface(points, triangles)


def noisy(shape: Surface, share: float, seed: int) -> Surface:
    """Every vertex shifted along its normal by chance, by a share of the size."""
    shift = np.random.default_rng(seed).normal(0.0, share * shape.size, (len(shape.points), 1))
    normals = vertex_normals(shape.points, shape.triangles)
    return Surface(shape.points + shift * normals, shape.triangles)


def scanned(result: sm.Result, *, known: bool, times: int = 2, seed: int = 0) -> MeasuredScan:
    """A scan with 1 % noise in an unknown pose, and of unknown size unless it is known."""
    surface = noisy(subdivided(shape_of(result), times), 0.01, seed)
    turn = Rotation.random(random_state=seed).as_matrix()
    pose = Similarity(1.0 if known else 370.0, turn, np.array([0.3, -0.2, 0.1]))
    return MeasuredScan(Scan(surface.moved(pose), "synthetic", (), 1.0 if known else None))


def curve_of(result: sm.Result, noise: float = 0.0, seed: int = 0, count: int = 40) -> Curve:
    at = np.linspace(0.05, 1.0, count)
    zero = Curve("film.csv", "actuation", at, np.zeros(count)).differences(result)
    return Curve(
        "film.csv",
        "actuation",
        at,
        np.abs(zero + np.random.default_rng(seed).normal(0.0, noise * zero.max(), count)),
    )


def made_with(design: sm.Design, *names: str) -> sm.Result:
    parameters = [Parameter(name, -1e9, 1e9) for name in names]
    return sm.simulate(with_parameters(design, parameters, [TRUTH[name] for name in names]))


# Names, bounds, keys.


def test_named_parameters_set_and_read_the_same_number(small_design: sm.Design) -> None:
    for parameter in read_parameters(NAMED, small_design):
        value = parameter.from_share(0.37)
        changed = with_parameters(small_design, [parameter], [value])
        assert parameter.own(changed) == pytest.approx(value, rel=1e-12)
        assert parameter.to_share(value) == pytest.approx(0.37, abs=1e-8)
        assert (parameter.from_share(-0.1), parameter.from_share(1.1)) == (
            parameter.low,
            parameter.high,
        )
    assert small_design.eps_pre == -0.4


def test_a_key_of_the_design_is_a_parameter_in_its_unit(small_design: sm.Design) -> None:
    found = read_parameters(["layers.print.thickness=0.4 mm:1.2 mm"], small_design)[0]
    assert (found.low, found.high, found.unit) == (0.4e-3, 1.2e-3, "m")
    assert found.own(small_design) == 0.7e-3
    changed = with_parameters(small_design, [found], [0.9e-3])
    assert changed.layers[1].thickness == 0.9e-3
    plain = read_parameters(["published.coupling=0:2"], small_design)[0]
    assert with_parameters(small_design, [plain], [1.5]).published.coupling == 1.5


@pytest.mark.parametrize(
    ("texts", "told"),
    [
        ([], "nothing to fit"),
        (["eps_pro=-0.8:-0.2"], "did you mean eps_pre"),
        (["eps_pre=-0.2:-0.8"], "not in order"),
        (["eps_pre=-0.5"], "two bounds"),
        (["eps_pre=-0.5:x"], "number"),
        (["eps_pre=-2:-0.2"], "does not allow"),
        (["gamma=-1:2"], "does not allow"),
        (["moduli_ratio=0:2"], "above zero"),
        (["eps_pre", "eps_pre"], "twice"),
        (["eps_pre", "actuation.eps_pre=-0.5:-0.1"], "same key"),
        (["layers.1.thicknes=1 mm:2 mm"], "did you mean thickness"),
        (["layers.7.thickness=1 mm:2 mm"], "write it there first"),
        (["layers.1.thickness=1:2"], "does not allow"),
        (["layers.1.thickness"], "needs bounds"),
        (["outline.kind=1:2"], "not a number"),
        (["published.mean_edge_length=1 mm:2 mm"], "write it there first"),
        (["solver.max_steps=1:2"], "whole number"),
        (["eps_pre=nan:1"], "number"),
        ([f"layers.{i}.density=1 kg/m^3:2 kg/m^3" for i in range(2)] * 4, "too many"),
    ],
)
def test_what_cannot_be_fitted_is_refused(
    small_design: sm.Design, texts: list[str], told: str
) -> None:
    with pytest.raises(InputError, match=told):
        read_parameters(texts, small_design)


def test_options_have_bounds() -> None:
    for wrong in ({"starts": -1}, {"confidence": 1.0}, {"workers": 0}, {"curve_weight": np.nan}):
        with pytest.raises(InputError, match=next(iter(wrong))):
            CalibrateOptions(**wrong)  # type: ignore[arg-type]


# Curves.


def test_a_curve_is_read(tmp_path: Path, small_result: sm.Result) -> None:
    file = tmp_path / "film.csv"
    file.write_text("# a film\nactuation, h/d, std\n0.5, 0.1, 0.01\n1.0, 0.2, 0.02\n")
    curve = read_curve(file)
    np.testing.assert_array_equal(curve.at, [0.5, 1.0])
    np.testing.assert_allclose(curve.weights, [0.8, 0.2])
    file.write_text("time [s],h/d\n10,0.1\n30,0.2\n20,0.1\n")
    np.testing.assert_allclose(read_curve(file).at, [0.0, 1.0, 0.5])
    assert "even actuation" in read_curve(file).notes[0]
    file.write_text("time_s,h_over_d\n10,0.1\n20,\n30,0.2\n")
    film = read_curve(file)
    np.testing.assert_allclose(film.at, [0.0, 1.0])
    assert (film.width, curve.width) == ("side", "feret_max")
    loaded = small_result.load_fraction == 1.0
    side = small_result.aspect_ratios("side")[loaded][-1]
    assert film.differences(small_result)[-1] == pytest.approx(side - 0.2, abs=1e-9)


@pytest.mark.parametrize(
    "text",
    ["", "actuation,h/d\n", "a,b\n1,2\n", "actuation,h/d\n0.1,x\n", "actuation,h/d\n2,0.1\n1,0.2\n",
     "actuation,h/d,std\n0,0.1,0\n1,0.2,1\n", "actuation,h/d\n0.5,0.1\n0.5,0.1\n",
     "actuation\n1\n", "actuation,h/d\n0.1,nan\n", "actuation,h/d\n0,-1\n1,2\n"],
)  # fmt: skip
def test_a_broken_curve_is_refused(tmp_path: Path, text: str) -> None:
    file = tmp_path / "film.csv"
    file.write_text(text)
    with pytest.raises(InputError, match=r"film\.csv"):
        read_curve(file)


def test_a_curve_in_eps_pre_is_the_same_curve(small_result: sm.Result) -> None:
    curve = curve_of(small_result)
    assert np.abs(curve.differences(small_result)).max() < 1e-12
    other = Curve("film.csv", "eps_pre", -0.4 * curve.at, curve.aspect_ratio)
    assert np.abs(other.differences(small_result)).max() < 1e-12


# Poses.


@pytest.mark.parametrize("fixed", [True, False])
def test_a_scan_is_laid_on_its_shape_again(small_result: sm.Result, fixed: bool) -> None:
    shape = shape_of(small_result)
    scale = 1.0 if fixed else 25.0
    away = Similarity(scale, Rotation.from_rotvec([0.1, 0.5, -0.3]).as_matrix(), np.ones(3))
    scan = shape.moved(away)
    shift = Similarity(
        1.0 if fixed else 1.07, Rotation.from_rotvec([0.05, -0.04, 0.03]).as_matrix(), np.zeros(3)
    )
    fit = repose(
        scan,
        Points.sampled(scan, 1500),
        shape,
        Points.on_triangles(shape, 1500),
        shift.after(away.inverse()),
        fixed_scale=fixed,
    )
    assert fit.rms < 1e-5 * shape.size
    assert fit.pose.scale == pytest.approx(1 / scale, rel=1e-9 if fixed else 1e-4)
    assert fit.rms_in_scan == pytest.approx(scale * fit.rms, rel=1e-3)


def test_points_on_triangles_integrate_linear_functions(small_result: sm.Result) -> None:
    shape = shape_of(small_result)
    for count in (1, 3000):
        stand = Points.on_triangles(shape, count)
        assert len(stand.points) >= count
        assert stand.weights.sum() == pytest.approx(1.0)
        np.testing.assert_allclose(stand.weights @ stand.points, shape.centroid, atol=1e-12)


def test_independent_residuals(small_result: sm.Result) -> None:
    """Noise of every vertex counts for many, a smooth error for few, a curve for its rows."""
    shape = subdivided(shape_of(small_result), 2)
    stretched = Surface(shape.points * [1.05, 1.0, 1.0], shape.triangles)
    worth = []
    for surface in (noisy(shape, 0.01, 0), stretched):
        target = ScanTarget("s", surface.points, surface.triangles, Similarity.identity(), True)
        worth.append(independent_residuals(target, small_result))
    assert 500 < worth[0] <= 2000
    assert 2 <= worth[1] < 60
    assert independent_residuals(CurveTarget(curve_of(small_result)), small_result) == 40


# The search and the intervals, on a misfit that is known in closed form.


@dataclass
class Bowl:
    """Misfit² = 1 % ² · (1 + quadratic form about a centre)."""

    parameters: tuple[Parameter, ...]
    centre: np.ndarray
    form: np.ndarray
    failing: Callable[[np.ndarray], bool] = lambda x: False

    def evaluate(self, values: tuple[float, ...]) -> Evaluation:
        away = np.asarray(values) - self.centre
        if self.failing(np.asarray(values)):
            return Evaluation(tuple(values), 1.4, status="step_too_small")
        return Evaluation(tuple(values), 0.01 * float(np.sqrt(1.0 + away @ self.form @ away)))


FORM = np.array([[9.0, 5.0], [5.0, 4.0]])


def bowl(**more: object) -> Bowl:
    both = (Parameter("a", -3.0, 3.0), Parameter("b", -3.0, 3.0))
    return Bowl(both, np.array([0.7, -0.4]), FORM, **more)  # type: ignore[arg-type]


def test_the_way_down_and_the_intervals_are_right() -> None:
    evaluations = Evaluations(bowl(), "x")  # type: ignore[arg-type]
    begun = apart(bowl().parameters, evaluations.many(spread(bowl().parameters, 12, 0)), 2)
    assert len(begun) == 2
    ends = [descend(evaluations, start, 1e-3) for start in begun]
    for end in ends:
        np.testing.assert_allclose(end.values, [0.7, -0.4], atol=0.02)
    rise = 0.05
    for index, interval in enumerate(profile(evaluations, evaluations.best(), rise)):
        half = np.sqrt(rise * np.linalg.inv(FORM)[index, index])
        centre = bowl().centre[index]
        assert interval.low == pytest.approx(centre - half, abs=0.08 * half)
        assert interval.high == pytest.approx(centre + half, abs=0.08 * half)
        assert not interval.low_open and not interval.high_open


def test_a_parameter_that_the_data_does_not_limit_is_told() -> None:
    task = bowl()
    task.form = np.array([[4.0, 0.0], [0.0, 1e-6]])
    evaluations = Evaluations(task, "x")  # type: ignore[arg-type]
    best = evaluations((0.7, -0.4))
    limited, unlimited = profile(evaluations, best, 0.05)
    assert not limited.low_open and not limited.high_open
    assert unlimited.low_open and unlimited.high_open
    assert (unlimited.low, unlimited.high) == (-3.0, 3.0)


def test_the_allowed_rise_is_that_of_linear_regression() -> None:
    """Half-width of the interval of a mean: t·s/√n, and s² = n·m²/(n − 1)."""
    from scipy.stats import t

    n = 12
    half = t.ppf(0.975, n - 1) * np.sqrt(1 / (n - 1))  # in units of the least rms
    assert allowed_rise(n, 1, 0.95) == pytest.approx(half**2)


def test_bounds_hold_and_failures_are_walked_around() -> None:
    task = bowl(failing=lambda x: bool(x[0] > 1.0))
    task.centre = np.array([-4.0, 0.5])  # beyond the bounds
    evaluations = Evaluations(task, "x")  # type: ignore[arg-type]
    start = evaluations((0.0, 0.0))
    descend(evaluations, start, 1e-3)
    assert all(abs(v) <= 3.0 for found in evaluations.here() for v in found.values)
    assert evaluations.best().values[0] == -3.0
    point = minimise(
        lambda x: float(x @ x), np.array([0.9]), radius=0.1, final_radius=1e-3, max_evaluations=40
    )
    assert point[0] < 2e-3


# The journal.


def test_the_journal_is_taken_up_even_with_a_torn_line(tmp_path: Path) -> None:
    file = tmp_path / "evaluations.jsonl"
    with Evaluations(bowl(), "x", journal=file) as first:  # type: ignore[arg-type]
        first.many([(0.1, 0.2), (0.3, 0.4)])
    with file.open("ab") as stream:
        stream.write(b'{"epoch": "x", "values": [0.5')
    again = Evaluations(bowl(), "x", journal=file, resume=True)  # type: ignore[arg-type]
    assert [found.values for found in again.here()] == [(0.1, 0.2), (0.3, 0.4)]
    assert again.here() == first.here()
    again((0.3, 0.4))
    assert again.fresh == 0
    again((0.5, 0.6))
    assert len(file.read_text("utf-8").splitlines()) == 4
    assert all(json.loads(line) for line in file.read_text("utf-8").splitlines())


@pytest.mark.parametrize(
    "line", ["{}", "[]", '{"epoch":"x","values":[1,2],"misfit":NaN}', "\x00", "[" * 5000]
)
def test_a_damaged_or_foreign_journal_is_refused(tmp_path: Path, line: str) -> None:
    file = tmp_path / "evaluations.jsonl"
    with pytest.raises(InputError, match="no unfinished fit"):
        Evaluations(bowl(), "x", journal=file, resume=True)  # type: ignore[arg-type]
    Evaluations(bowl(), "x", journal=file)((0.1, 0.2))  # type: ignore[arg-type]
    with pytest.raises(InputError, match="another design"):
        Evaluations(bowl(), "y", journal=file, resume=True)  # type: ignore[arg-type]
    with file.open("a") as stream:
        stream.write(line + "\n")
    with pytest.raises(InputError, match="line 3"):
        Evaluations(bowl(), "x", journal=file, resume=True)  # type: ignore[arg-type]


# Fits of a real simulation.

QUICK = CalibrateOptions(starts=3, descents=1)


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
    assert noise_alone(target, near)
    evaluations = Evaluations(replace(task, targets=(target.by_points(near),)), "x")
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
        noise_alone(
            ScanTarget("s", scan.points, scan.triangles, Similarity.identity(), True), small_result
        )
        for scan in (noisy(shape, 0.01, 0), stretched, noisy(stretched, 0.003, 0))
    ]
    assert told == [True, False, False]


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
