"""Parameters by name or key, curves, poses: what goes into a fit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from synthetic import curve_of, noisy, subdivided

import sheetmorph as sm
from sheetmorph.calibrate.curves import Curve, read_curve
from sheetmorph.calibrate.fit import CalibrateOptions
from sheetmorph.calibrate.misfit import CurveTarget, ScanTarget, independent_residuals, shape_of
from sheetmorph.calibrate.parameter_texts import read_parameters
from sheetmorph.calibrate.parameters import NAMED, with_parameters
from sheetmorph.calibrate.repose import Points, repose
from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import InputError


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
