"""The command `design`: what it writes, what it refuses, and going on after Ctrl-C."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from sheetmorph.cli import entry
from sheetmorph.design.spec import Design
from sheetmorph.study.result import Result

SMALL = [
    *("saddle:0.4", "--family", "ring", "--fix", "radius=0.9", "--fix", "size=0.1"),
    *("--set", "mesh.size=11 mm", "--budget", "12", "--descents", "0", "--workers", "1"),
]


def design(*arguments: str) -> int:
    return entry.main(["design", *arguments])


def told(capsys: pytest.CaptureFixture[str]) -> str:
    return capsys.readouterr().err


def test_interrupted_it_goes_on_to_a_folder_that_the_other_commands_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from sheetmorph.inverse import misfit

    monkeypatch.setenv("SHEETMORPH_RENDERER", "drawn")
    place = tmp_path / "out"
    evaluate, count = misfit.Measure.evaluate, []

    def evaluated(self: misfit.Measure, job: misfit.Job) -> misfit.Evaluation:
        count.append(job)
        if len(count) == 5:
            raise KeyboardInterrupt
        return evaluate(self, job)

    monkeypatch.setattr(misfit.Measure, "evaluate", evaluated)
    assert design(*SMALL, "-o", str(place), "--quiet") == 130
    assert "--resume" in told(capsys)
    assert design(*SMALL, "-o", str(place)) == 2
    assert "unfinished search" in told(capsys)
    assert design(*SMALL, "-o", str(place), "--resume") == 0
    out = capsys.readouterr().out
    assert "saddle:0.4: distance" in out
    assert "(inverse.html, design.toml)" in out
    data = json.loads((place / "inverse.json").read_text("utf-8"))
    assert data["computed"] == data["evaluations"] - 4
    assert data["family"] == "ring"
    assert data["pattern"]["limits_met"]
    assert data["distance_percent"] == pytest.approx(
        100 * data["distance_m"] / data["size_m"], rel=1e-12
    )
    made, run = Design.load(place / "design.toml"), Result.load(place)
    assert run.summary["design_hash"] == made.hash
    assert run.summary["aspect_ratio"] == pytest.approx(data["found"]["aspect_ratio"], rel=1e-9)
    page = (place / "inverse.html").read_text("utf-8")
    assert page.count("<img") == 2
    assert "http" not in page.split("<body>")[1].split("References")[0]
    for name in ("found.png", "best.png", "search.png", "shape.stl", "target.stl"):
        assert (place / name).stat().st_size > 1000
    assert (place / "fabricate" / "assembly.html").is_file()
    assert (place / "fabricate" / "parts" / "PLA.3mf").is_file()

    assert design(*SMALL, "-o", str(place)) == 2
    assert "--force" in told(capsys)
    assert design(*SMALL, "-o", str(place), "--resume", "--no-pictures", "--json") == 0
    again = json.loads(capsys.readouterr().out)
    assert again["computed"] == 0  # all was known
    assert again["values"] == data["values"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["bowll"], ["TARGET", "did you mean bowl?"]),
        (["bowl:3"], ["h/d is out of range", "0.02 to 1"]),
        (["none.stl"], ["none.stl"]),
        (["bowl", "--family", "stars"], ["--family", "did you mean star?"]),
        (["bowl", "--fix", "arms=2"], ["--fix arms", "3 to 8"]),
        (["bowl", "--fix", "arms"], ["--fix wants NAME=NUMBER"]),
        (["bowl", "--fix", "leaves=3"], ["--fix", "allowed: size, arms"]),
        (["bowl", "--size", "80"], ["--size", "unit"]),
        (["bowl", "--size", "80 m"], ["--size", "1 mm to 3 m"]),
        (["bowl", "--unit", "mm"], ["no unit", "--size"]),
        (["bowl", "--minimum-width", "1 m"], ["--minimum-width", "out of range"]),
        (["bowl", "--most-inert", "2"], ["--most-inert"]),
        (["bowl", "--budget", "0"], ["--budget"]),
        (["bowl", "--accuracy", "90"], ["--accuracy"]),
        (["bowl", "--workers", "0"], ["--workers"]),
        (["bowl", "--resume", "--force"], ["--resume and --force"]),
        (["bowl", "--workers", "2", "--scheduler", "tcp://x:1"], ["exclude each other"]),
        (["bowl", "--set", "layers.PLA.thicknes=1 mm"], ["thickness"]),
        (["bowl", "-o", " "], ["-o wants a folder"]),
    ],
)
def test_bad_input_is_told_in_a_line(
    arguments: list[str],
    words: list[str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert design(*arguments, "--no-pictures") == 2
    message = told(capsys)
    assert message.count("\n") == 1
    assert all(word in message for word in words)
    assert not any(tmp_path.iterdir())


def test_a_file_that_is_no_surface_and_files_of_others(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    junk = tmp_path / "junk.stl"
    junk.write_bytes(b"solid nothing at all")
    assert design(str(junk), "--no-pictures", "-o", str(tmp_path / "out")) == 2
    assert "junk.stl" in told(capsys)
    (tmp_path / "design.toml").write_text("mine", "utf-8")
    assert design("bowl", "-o", str(tmp_path), "--force") == 2
    assert "no search for a design wrote it" in told(capsys)
    assert (tmp_path / "design.toml").read_text("utf-8") == "mine"


def test_help_has_examples(capsys: pytest.CaptureFixture[str]) -> None:
    assert design("--help") == 0
    out = capsys.readouterr().out
    assert "sheetmorph design bowl:0.4 --family star" in out
    assert "--minimum-width" in out
