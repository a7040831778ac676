"""Checks, orders, and what becomes of proofs that fail or cannot be done."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from sheetmorph.cli import main
from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.proofs import cantilever, prove
from sheetmorph.proofs.proof import Check, Curve, Plot, Proof, convergence_order


@pytest.mark.parametrize(
    ("check", "passed"),
    [
        (Check("a", "a", 2.0, 2.019, 0.01), True),
        (Check("a", "a", 2.0, 2.021, 0.01), False),
        (Check("a", "a", -2.0, -1.981, 0.01), True),
        (Check("a", "a", 2.0, 2.02, 0.01, "absolute"), False),
        (Check("a", "a", 1.9, 2.0, kind="at least"), True),
        (Check("a", "a", 1.9, 1.89, kind="at least"), False),
        (Check("a", "a", 1e-9, 2e-9, kind="at most"), False),
        (Check("a", "a", 2.0, float("nan"), 0.5), False),
        (Check("a", "a", 1.9, float("nan"), kind="at least"), False),
    ],
)
def test_a_check_holds_within_its_limit_alone(check: Check, passed: bool) -> None:
    assert check.passed is passed


def test_the_order_is_a_slope() -> None:
    sizes = np.array([0.4, 0.2, 0.1])
    assert convergence_order(sizes, 3.0 * sizes**1.7) == pytest.approx(1.7)


def made_up(found: float) -> Proof:
    plot = Plot("made_up", "Title", "x [m]", "y", (Curve("c", np.arange(1.0, 4), np.ones(3)),), "x")
    check = Check("one", "a number", 1.0, found, 0.01)
    return Proof("cantilever", "Made up", "A statement.", "nowhere", (check,), (plot,))


def run(tmp_path: Path, *more: str) -> int:
    return main(["verify", "--only", "cantilever", "-o", str(tmp_path / "p"), *more])


def test_the_page_says_what_holds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cantilever, "prove", lambda reference: made_up(1.005))
    assert run(tmp_path) == 0
    page = (tmp_path / "p" / "proofs.md").read_text("utf-8")
    assert "## Made up" in page
    assert "| a number | 1 | 1.005 | 0.5 % | 1 % | holds |" in page
    assert (tmp_path / "p" / "made_up.png").stat().st_size > 1000
    assert run(tmp_path) == 2  # not over what is there
    assert run(tmp_path, "--force") == 0


def test_a_number_beyond_its_limit_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cantilever, "prove", lambda reference: made_up(1.02))
    assert run(tmp_path) == 1
    told = capsys.readouterr()
    assert "0 of 1 checks" in told.out
    assert "1 of 1 proofs do not hold: cantilever" in told.err
    numbers = json.loads((tmp_path / "p" / "proofs.json").read_text("utf-8"))
    assert numbers["proofs"][0]["passed"] is False


@pytest.mark.parametrize("error", [ComputationError("it stopped"), InputError("no table")])
def test_a_proof_that_cannot_be_done_is_none(
    error: Exception, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(reference: Path | None) -> Proof:
        raise error

    monkeypatch.setattr(cantilever, "prove", fail)
    outcome = prove.prove("cantilever")
    assert outcome.proof is None
    assert not outcome.passed
    assert run(tmp_path) == 1
    assert f"Not done: {error}" in (tmp_path / "p" / "proofs.md").read_text("utf-8")


@pytest.mark.parametrize(
    "arguments",
    [
        ["verify", "--only", "cantilevr"],
        ["verify", "--fe", "calculix"],
        ["verify", "--reference", "/nowhere/at/all"],
        ["verify", "design.toml", "--only", "cantilever", "--fe", "abaqus"],
        ["verify", "-o", " "],
    ],
)
def test_bad_words_are_refused(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


def test_a_folder_of_others_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "p").mkdir()
    (tmp_path / "p" / "proofs.md").write_text("mine", encoding="utf-8")
    assert run(tmp_path, "--force") == 2
    assert (tmp_path / "p" / "proofs.md").read_text("utf-8") == "mine"


def test_a_picture_of_others_is_left_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cantilever, "prove", lambda reference: made_up(1.0))
    (tmp_path / "p").mkdir()
    (tmp_path / "p" / "made_up.png").write_text("mine", encoding="utf-8")
    assert run(tmp_path, "--force") == 2
    assert (tmp_path / "p" / "made_up.png").read_text("utf-8") == "mine"
    assert not (tmp_path / "p" / "proofs.md").exists()
