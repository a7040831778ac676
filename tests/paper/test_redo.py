"""The redone paper: verdicts by rule, runs that fail, sections on coarse meshes."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path

import numpy as np
import pytest

import sheetmorph as sm
from sheetmorph.core.errors import InputError
from sheetmorph.core.events import Notice, Progress
from sheetmorph.paper import checks
from sheetmorph.paper import redo as paper
from sheetmorph.paper.history import ratio_at, reached_at
from sheetmorph.paper.numbers import COST_TABLE
from sheetmorph.paper.rows import (
    VERDICTS,
    Findings,
    Rule,
    at_least,
    claims,
    judged,
    near,
    reaching,
    same_order,
    within,
)
from sheetmorph.paper.runs import Job, Run, Setting, design_of, perform, perform_all
from sheetmorph.paper.sections import (
    MIRRORED,
    OTHER_MIRRORS,
    Section,
    largest_move,
    no_runs,
    similarity,
)

EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "published"
COARSE = Setting(coarsen=2.5)


@pytest.mark.parametrize(
    ("rule", "paper_value", "ours", "verdict"),
    [
        (near(0.1, 0.2), 0.8, 0.85, "agrees"),
        (near(0.1, 0.2), 0.8, 0.65, "agrees in part"),
        (near(0.1, 0.2), 0.8, 1.1, "differs"),
        (near(0.1, 0.2, relative=True), 100.0, 109.0, "agrees"),
        (near(0.1, 0.2, relative=True), 100.0, 119.0, "agrees in part"),
        (near(0.1, 0.2, relative=True), -100.0, -79.0, "differs"),
        (at_least(0.1), 1.2, 1.2, "agrees"),
        (at_least(0.1), 1.2, 1.15, "agrees in part"),
        (at_least(0.1), 1.2, 0.7, "differs"),
        (within(1e-8, 1e-6), "the same", 1e-9, "agrees"),
        (within(1e-8, 1e-6), "the same", 1e-7, "agrees in part"),
        (within(1e-8, 1e-6), "the same", 1.0, "differs"),
        (reaching(0.97, 0.8), "alike", 0.98, "agrees"),
        (reaching(0.97, 0.8), "alike", 0.9, "agrees in part"),
        (reaching(0.97, 0.8), "alike", 0.5, "differs"),
        (same_order(), 1e-14, 2e-14, "agrees"),
        (same_order(), 1e-14, 2e-15, "agrees in part"),
        (same_order(), 1e-14, 2e-12, "differs"),
        (claims(("a", True), ("b", True)), "x", "y", "agrees"),
        (claims(("a", True), ("b", False)), "x", "y", "agrees in part"),
        (claims(("a", False)), "x", "y", "differs"),
    ],
)
def test_verdicts_follow_from_the_numbers(
    rule: Rule, paper_value: float | str, ours: float | str, verdict: str
) -> None:
    row = judged("key", "what", "where", paper_value, ours, rule)
    assert row.verdict == verdict
    assert row.reason


def test_what_cannot_be_judged() -> None:
    rule = near(1, 2)
    assert judged("a", "", "", 1.0, None, rule, lack="No scan.").verdict == "not redone"
    assert judged("a", "", "", 1.0, math.nan, rule).ours is None
    assert judged("a", "", "", None, 1.0, rule).verdict == "not comparable"
    other = judged("a", "", "", 1.0, 1.0, rule, differently="Seconds against strain.")
    assert (other.verdict, other.reason) == ("not comparable", "Seconds against strain.")
    # What is not there is not redone, whatever else.
    assert judged("a", "", "", 1.0, None, rule, differently="x").verdict == "not redone"


@pytest.mark.parametrize("name", ["bowl", "canoe", "petals"])
def test_designs_are_those_of_the_examples(
    name: str, reference: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SHEETMORPH_REFERENCE_DATA", str(reference))
    ours = design_of(Run.of(name), Setting(reference))
    assert ours.hash == sm.Design.load(EXAMPLES / f"{name}.toml").hash


def test_the_released_result_is_met(reference: Path) -> None:
    run = Run.of("petals", {"actuation.eps_pre": -0.30})
    outcome = perform(run, Setting(reference))
    assert not outcome.failure
    with np.load(reference / "petals_eps-0.30.npz") as released:
        assert np.abs(outcome.shape - released["positions"]).max() < 1e-10
    assert outcome.actuation[-1] == pytest.approx(-0.30)
    assert outcome.aspect_ratio["feret_max"][0] == pytest.approx(0.0)


def test_glue_lies_between_film_and_print() -> None:
    design = design_of(Run.of("bowl", adhesive=(1e-4, 2e6)), Setting())
    assert [layer.name for layer in design.layers] == ["polystyrene", "adhesive", "PLA"]
    assert design.layers[1].thickness == pytest.approx(1e-4)
    assert design.layers[1].young_modulus == pytest.approx(2e6)
    assert design.layers[1].where == "pattern"


def test_shapes_are_compared_where_they_lie() -> None:
    values = {"published.coupling": 0.0, "actuation.eps_pre": -0.3}
    up = perform(Run.of("petals", values), COARSE)
    down = perform(Run.of("petals", {**values, "perturbation.direction": "down"}), COARSE)
    assert largest_move(up, down, MIRRORED) < 1e-9
    assert similarity(up, down, MIRRORED) == 1.0
    assert largest_move(up, down) > 1e-2
    assert similarity(up, down) < 0.9


def test_downward_petals_are_upward_ones_turned(reference: Path) -> None:
    """A half-turn runs every hinge of the released mesh the other way."""
    setting, values = Setting(reference), {"actuation.eps_pre": -0.30}
    up = perform(Run.of("petals", values), setting)
    down = perform(Run.of("petals", {**values, "perturbation.direction": "down"}), setting)
    assert similarity(up, down, OTHER_MIRRORS[0]) > 0.9999
    assert similarity(up, down, MIRRORED) < 0.98


def test_a_history_is_read_between_its_states() -> None:
    actuation, ratio = np.array([0.0, -0.1, -0.3]), np.array([0.0, 0.2, 0.4])
    assert reached_at(actuation, ratio, 0.25) == pytest.approx(-0.05)
    assert reached_at(actuation, ratio, 0.75) == pytest.approx(-0.2)
    assert ratio_at(actuation, ratio, -0.2) == pytest.approx(0.3)


def test_the_elastica_is_that_of_the_table() -> None:
    loads, tips = checks.elastica()
    # Mattiasson (1981)
    np.testing.assert_allclose(
        np.interp([1.0, 2.0, 5.0], loads, tips), [0.30172, 0.49346, 0.71379], atol=2e-4
    )


def test_a_section_on_coarse_presets() -> None:
    seen: list[object] = []
    done = paper.redo_paper(COARSE, only=["thermal"], workers=1, on_event=seen.append)
    assert [chapter.section.key for chapter in done.chapters] == ["thermal"]
    assert len(done.outcomes) == 3
    assert {row.verdict for row in done.rows} <= set(VERDICTS)
    assert done.counts["not redone"] == 0
    assert any("not here" in note for note in done.chapters[0].findings.notes)
    shares = [event.fraction for event in seen if isinstance(event, Progress)]
    assert shares == sorted(shares)
    again = paper.redo_paper(COARSE, only=["thermal"], workers=1)
    assert again.to_json()["rows"] == done.to_json()["rows"]


def test_numbers_are_json() -> None:
    done = paper.redo_paper(Setting(), only=["constants", "elements"], workers=1)
    data = json.loads(json.dumps(done.to_json(), allow_nan=False))
    assert data["format"] == "sheetmorph paper"
    assert data["meshes"] == "made here"
    wanted = {"section", "id", "what", "where", "paper", "ours", "unit", "verdict", "reason"}
    assert all(set(row) == wanted for row in data["rows"])
    identities = [row["id"] for row in data["rows"]]
    assert len(set(identities)) == len(identities)
    by_id = {row["id"]: row for row in data["rows"]}
    assert by_id["c1-film"]["ours"] == pytest.approx(8.375e4, rel=1e-4)
    assert by_id["stiffness-ratio"]["ours"] == pytest.approx(9.0, rel=1e-9)
    assert by_id["fe-ssim-A"]["verdict"] == "not redone"


def test_runs_that_fail_are_rows(tmp_path: Path) -> None:
    for name in paper.MESH_FILES:
        (tmp_path / name).write_text("no mesh\n")
    told: list[object] = []
    setting = paper.find_setting(tmp_path)
    done = paper.redo_paper(setting, only=["history", "shapes"], workers=1, on_event=told.append)
    rows = {row.id: row for row in done.rows}
    assert rows["aspect-petals"].verdict == "not redone"
    assert rows["stable-bowl"].verdict == "not redone"
    assert "bowl_mesh.txt" in rows["stable-bowl"].reason
    assert done.counts["agrees"] == 0
    assert sum(isinstance(event, Notice) for event in told) == 9
    json.dumps(done.to_json(), allow_nan=False)


def test_a_run_that_ends_early_is_a_row() -> None:
    values = {"solver.max_steps": 2}
    outcome = perform(Run.of("petals", values), COARSE)
    assert outcome.result is not None
    assert "of the actuation" in outcome.failure
    run = Run.of("petals", dict(COST_TABLE.runs(COARSE)[2].values), timed=True)
    others = dict.fromkeys(COST_TABLE.runs(COARSE), outcome)
    assert run in others
    rows = {row.id: row for row in COST_TABLE.evaluate(COARSE, others).rows}
    assert rows["cost-petals"].verdict == "not redone"


def test_a_section_that_fails_is_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    def fall(setting: Setting, outcomes: object) -> Findings:
        raise ZeroDivisionError("by nothing")

    section = Section("fall", "Falls", "nowhere", no_runs, fall)  # type: ignore[arg-type]
    monkeypatch.setattr(paper, "SECTIONS", (section,))
    findings, _ = paper.evaluate("fall", Setting(), {})
    assert [row.verdict for row in findings.rows] == ["not redone"]
    assert "by nothing" in findings.rows[0].reason


def test_processes_share_the_jobs_and_may_die() -> None:
    jobs = [Job(str(k), math.sqrt, (float(k * k),)) for k in range(4)]
    assert sorted(perform_all(jobs, 2)) == [(k, float(k)) for k in range(4)]
    threads = dict(perform_all([Job("", os.getenv, ("OMP_NUM_THREADS",))] * 2, 2))
    assert threads == {0: "1", 1: "1"}
    died = dict(perform_all([Job("", os._exit, (3,)), Job("", os._exit, (3,))], 2))
    assert all(isinstance(one, Exception) for one in died.values())


def test_where_the_meshes_are_looked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("SHEETMORPH_REFERENCE_DATA", raising=False)
    assert paper.find_setting() == Setting()
    with pytest.raises(InputError, match=r"bowl_mesh\.txt"):
        paper.find_setting(tmp_path)
    with pytest.raises(InputError, match="--scan"):
        paper.find_setting(scan=tmp_path / "none.stl")
    monkeypatch.setenv("SHEETMORPH_REFERENCE_DATA", str(tmp_path / "none"))
    with pytest.raises(InputError, match="SHEETMORPH_REFERENCE_DATA"):
        paper.find_setting()


def test_sections_by_name() -> None:
    assert [s.key for s in paper.chosen_sections(["cost", "shapes"])] == ["shapes", "cost"]
    assert len(paper.chosen_sections([])) == len(set(paper.KEYS)) == 12
    with pytest.raises(InputError, match="did you mean mesh"):
        paper.chosen_sections(["meshs"])
