"""The pictures of a fit show its designs, its optimum and its intervals."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from small import SMALL

import sheetmorph as sm
from sheetmorph.calibrate.fit import CalibrateOptions
from sheetmorph.calibrate.misfit import Evaluation
from sheetmorph.calibrate.parameters import Parameter
from sheetmorph.calibrate.result import Calibration
from sheetmorph.calibrate.search import spread
from sheetmorph.calibrate.uncertainty import Interval
from sheetmorph.show.calibration import write_pictures

PARAMETERS = (
    Parameter("eps_pre", -0.8, -0.2),
    Parameter("stretch_factor", 1.0, 100.0, True),
    Parameter("layers.1.thickness", 4e-4, 1.2e-3, unit="m"),
)
BEST = (-0.47, 6.0, 8e-4)


def misfit(shares: np.ndarray) -> float:
    away = shares - [p.to_share(v) for p, v in zip(PARAMETERS, BEST, strict=True)]
    return 0.015 * float(np.sqrt(1 + 20 * (away**2).sum() + 15 * away[0] * away[1]))


def made_up(count: int, *, intervals: bool = True) -> Calibration:
    """A fit of so many parameters whose misfit is a bowl; a few designs failed."""
    found = []
    for values in (BEST, (-0.6, 20.0, 6e-4), *spread(PARAMETERS, 40, 1)):
        shares = np.array([p.to_share(v) for p, v in zip(PARAMETERS, values, strict=True)])
        failed = values[0] < -0.77
        status = "step_too_small" if failed else "completed"
        shares[count:] = [p.to_share(v) for p, v in zip(PARAMETERS, BEST, strict=True)][count:]
        found.append(
            Evaluation(tuple(values[:count]), 1.5 if failed else misfit(shares), status=status)
        )
    sides = []
    for parameter, best in zip(PARAMETERS[:count], BEST, strict=False):
        middle = parameter.to_share(best)
        places = np.clip(middle + np.linspace(-0.15, 0.15, 9), 0, 1)
        values = [parameter.from_share(float(p)) for p in places]
        sides.append(
            Interval(
                values[1],
                values[-2],
                False,
                parameter.logarithmic,
                tuple((v, 0.015 * float(np.sqrt(1 + 20 * (p - middle) ** 2)))
                      for v, p in zip(values, places, strict=True)),
            )
        )  # fmt: skip
    design = sm.Design.from_toml(SMALL)
    return Calibration(
        design=design,
        fitted=None,  # type: ignore[arg-type]  # the pictures do not look at it
        parameters=PARAMETERS[:count],
        targets=("scan of a petal.stl",),
        start=found[1],
        best=found[0],
        evaluations=tuple(found),
        intervals=tuple(sides) if intervals else (),
        residuals=30.0,
        rise=0.15,
        before=(),
        after=(),
        options=CalibrateOptions(),
        simulations=40,
        notes=(),
        seconds=1.0,
    )


@pytest.mark.parametrize("count", [1, 2, 3])
def test_the_pictures_are_drawn(tmp_path: Path, count: int) -> None:
    paths = write_pictures(made_up(count), tmp_path)
    assert [path.name for path in paths] == ["misfit.png", "profile.png"]
    for path in paths:
        with Image.open(path) as picture:
            pixels = np.asarray(picture.convert("RGB")).astype(int)
        assert pixels.shape[0] > 400 and pixels.shape[1] > 700
        assert (pixels != 255).any(axis=2).mean() > 0.02


def test_the_optimum_is_where_the_star_is(tmp_path: Path) -> None:
    """The orange star of the map lies at the optimum's place within the axes."""
    path = write_pictures(made_up(2), tmp_path)[0]
    with Image.open(path) as picture:
        pixels = np.asarray(picture.convert("RGB")).astype(int)
    orange = np.abs(pixels - [235, 142, 44]).sum(axis=2) < 20
    _, columns = np.nonzero(orange[:, :686])  # the legend lies right of the axes
    share = (columns.mean() - 116) / 570
    low, high = -0.8 - 0.012, -0.2 + 0.012
    assert low + share * (high - low) == pytest.approx(-0.47, abs=0.01)


def test_without_intervals_and_with_few_designs(tmp_path: Path) -> None:
    few = made_up(2, intervals=False)
    few = dataclasses.replace(few, evaluations=few.evaluations[:3])
    assert [path.name for path in write_pictures(few, tmp_path)] == ["misfit.png"]
