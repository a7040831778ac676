"""The search and the intervals, on a misfit that is known in closed form; the journal."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from sheetmorph.calibrate.evaluations import Evaluations
from sheetmorph.calibrate.misfit import Evaluation
from sheetmorph.calibrate.parameters import Parameter
from sheetmorph.calibrate.search import apart, descend, minimise, spread
from sheetmorph.calibrate.uncertainty import allowed_rise, profile
from sheetmorph.core.errors import InputError


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
