"""One design in, one row out, whatever happens."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from many import STARS, written

import sheetmorph as sm
from sheetmorph.sweep import task as tasks
from sheetmorph.sweep.plan import Plan
from sheetmorph.sweep.task import lost, solve


def test_a_row_has_all_that_the_summary_has(tmp_path: Path) -> None:
    task = Plan.load(written(tmp_path)).task(2)
    outcome = solve(task)
    expected = sm.simulate(task.make())
    row, summary = outcome.row, expected.summary
    assert row["index"] == 2
    assert row["id"] == task.id
    assert row["status"] == "completed"
    assert row["actuation.eps_pre"] == -0.2
    assert row["layers.print.thickness"] == 0.5e-3
    for name in ("aspect_ratio", "nodes", "stable", "version", "design_hash", "solver", "states"):
        assert row[name] == summary[name]
    assert row["energy_J.bend"] == summary["energy_J"]["bend"]
    assert [row[f"bbox_m.{axis}"] for axis in "xyz"] == summary["bbox_m"]
    assert row["seconds"] > row["seconds.total"] > 0
    assert row["seconds.cpu"] > 0
    assert outcome.arrays is not None
    np.testing.assert_array_equal(outcome.arrays["positions"], expected.positions[-1:])
    np.testing.assert_array_equal(outcome.arrays["nodes"], expected.mesh.nodes)
    np.testing.assert_array_equal(outcome.arrays["triangles"], expected.mesh.triangles)
    np.testing.assert_array_equal(outcome.arrays["in_pattern"], expected.triangle_in_pattern)
    assert outcome.arrays["ramp"].tolist() == [1.0]
    json.dumps(row, allow_nan=False)


def test_all_states_or_none_are_kept(tmp_path: Path) -> None:
    task = Plan.load(written(tmp_path, 'states = "all"\n' + STARS)).task(0)
    kept = solve(task)
    assert kept.arrays is not None
    assert len(kept.arrays["positions"]) == kept.row["states"] > 2
    assert kept.arrays["ramp"][0] == 0
    assert solve(replace(task, states="none")).arrays is None


def test_a_design_that_is_not_allowed_is_a_row(tmp_path: Path) -> None:
    text = STARS.replace('["0.5 mm", "0.9 mm"]', '["0.5 mm", "-1 mm"]')
    outcome = solve(Plan.load(written(tmp_path, text)).task(1))
    assert outcome.arrays is None
    assert outcome.row["status"] == "refused"
    assert "thickness" in outcome.row["reason"]
    assert outcome.row["layers.print.thickness"] == -0.001
    assert outcome.row["design_hash"] is None


def test_a_path_that_fails_keeps_its_last_state(tmp_path: Path) -> None:
    outcome = solve(Plan.load(written(tmp_path), {"solver.max_steps": 2}).task(2))
    assert outcome.row["status"] == "too_many_steps"
    assert "max_steps" in outcome.row["remedy"]
    assert 0 < outcome.row["actuation_reached"] < 1
    assert outcome.arrays is not None
    assert outcome.arrays["ramp"].tolist() == [outcome.row["actuation_reached"]]


def test_an_error_nobody_thought_of_is_a_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(design: sm.Design) -> sm.Result:
        raise ZeroDivisionError("by nought")

    monkeypatch.setattr(tasks, "simulate", broken)
    row = solve(Plan.load(written(tmp_path)).task(0)).row
    assert row["status"] == "error"
    assert row["reason"] == "ZeroDivisionError: by nought"
    assert len(row["design_hash"]) == 64


def test_a_lost_design_has_the_id_it_would_have_had(tmp_path: Path) -> None:
    task = Plan.load(written(tmp_path)).task(1)
    row = lost(task, "its workers died").row
    assert row["id"] == solve(task).row["id"]
    assert (row["status"], row["reason"]) == ("worker_lost", "its workers died")
