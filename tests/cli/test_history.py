"""The command `history`: what it writes, what it refuses."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from small import SMALL

import sheetmorph as sm
from rendered_films import Oven, film_of, write_series, write_video
from sheetmorph.cli import entry, main
from sheetmorph.cli.history import history


@pytest.fixture(autouse=True)
def command(monkeypatch: pytest.MonkeyPatch) -> None:
    if "history" not in entry.cli.commands:
        monkeypatch.setitem(entry.cli.commands, "history", history)


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run, a video and a series of pictures of it."""
    folder = tmp_path_factory.mktemp("history")
    result = sm.simulate(sm.Design.from_toml(SMALL))
    result.save(folder / "run")
    filmed = film_of(result, Oven(roll=2.0, elevation=4.0, noise=6.0, blur=1.0), 5, (400, 300))
    write_video(folder / "oven.mp4", filmed.images)
    write_series(folder / "series", filmed.images[1:])
    np.savetxt(folder / "truth.txt", filmed.ratio)
    return folder


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def names(folder: Path) -> set[str]:
    return {str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()}


def test_runs_alone(place, tmp_path, capsys):
    run = str(place / "run")
    assert main(["history", run, f"{run}/result.h5", "-o", str(tmp_path / "out")]) == 0
    assert names(tmp_path / "out") == {"history.csv", "history.png"}
    table = rows(tmp_path / "out" / "history.csv")
    assert {row["run"] for row in table} == {"run", "run-2"}
    last = sm.Result.load(run).aspect_ratio[-1]
    assert float(table[-1]["h_over_d_feret_max"]) == pytest.approx(last, abs=1e-5)
    assert f"h/d {last:.3f} (feret_max)" in capsys.readouterr().out


def test_a_run_beside_films(place, tmp_path, capsys):
    out = tmp_path / "out"
    arguments = ["history", str(place / "run"), "--film", str(place / "oven.mp4")]
    arguments += ["--film", str(place / "series"), "--start", "0 s", "-o", str(out)]
    tilt = ["--tilt", "4 deg", "--roll", "2 deg", "--reference", "20 mm=50,100,150,100"]
    assert main([*arguments, *tilt]) == 0
    assert names(out) == {
        *("history.csv", "history.png", "films.csv", "films/oven.csv", "films/oven.png"),
        *("films/series.csv", "films/series.png"),
    }
    truth = np.loadtxt(place / "truth.txt")
    table = rows(out / "films" / "oven.csv")
    ratio = np.array([float(row["h_over_d"]) for row in table])
    assert (abs(ratio - truth)[1:] < np.maximum(0.03 * truth, 0.012)[1:]).all()
    last = table[-1]
    assert float(last["d_mm"]) == pytest.approx(0.2 * float(last["d_px"]), rel=1e-3)
    text = capsys.readouterr().out
    assert "oven: h/d" in text and "mm; 5 of 5 frames" in text and "(side)" in text
    # The tables can be read again, without their films.
    again = ["history", "--film", str(out / "films" / "oven.csv"), "-o", str(tmp_path / "b")]
    assert main(again) == 0
    assert names(tmp_path / "b") == {"history.png", "films/oven.csv"}
    copied = rows(tmp_path / "b" / "films" / "oven.csv")
    assert [row["h_over_d"] for row in copied] == [row["h_over_d"] for row in table]
    assert float(copied[-1]["h_mm"]) == pytest.approx(float(last["h_mm"]), rel=1e-3)


def test_only_its_own_files_are_replaced(place, tmp_path, capsys):
    out = tmp_path / "out"
    (out / "films").mkdir(parents=True)
    (out / "films" / "mine.txt").write_text("mine")
    first = ["history", "--film", str(place / "oven.mp4"), "-o", str(out), "-q"]
    assert main(first) == 0
    assert main(first) == 2
    assert "--force" in capsys.readouterr().err
    second = ["history", str(place / "run"), "-o", str(out), "-q", "--force"]
    assert main(second) == 0
    assert names(out) == {"history.csv", "history.png", "films/mine.txt"}
    assert capsys.readouterr().out == ""


def test_without_a_reference_sizes_are_pixels(place, tmp_path, capsys):
    out = str(tmp_path / "out")
    assert main(["history", "--film", str(place / "oven.mp4"), "-o", out]) == 0
    captured = capsys.readouterr()
    assert "px (no --reference)" in captured.out
    assert "add --tilt auto" in captured.err
    row = rows(tmp_path / "out" / "films" / "oven.csv")[-1]
    assert row["h_mm"] == row["d_mm"] == "" and float(row["d_px"]) > 50


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "name a RUN, or a film"),
        (["{p}/none"], "none"),
        (["--film", "{p}/none.mp4"], "no such film"),
        (["--film", "{p}/truth.txt"], "no video"),
        (["--film", "{v}", "--reference", "50 mm"], "--reference"),
        (["--film", "{v}", "--reference", "50=1,2,3,4"], "--reference"),
        (["--film", "{v}", "--reference", "0 mm=1,2,30,40"], "above zero"),
        (["--film", "{v}", "--reference", "50 mm=1,2,3000,4"], "must lie in the picture"),
        (["--film", "{v}", "--reference", "50 mm=9,9,9,9"], "one point"),
        (["--film", "{v}", "--region", "0,0,9999,9"], "--region"),
        (["--film", "{v}", "--region", "a,b,c,d"], "--region"),
        (["--film", "{v}", "--threshold", "300"], "--threshold"),
        (["--film", "{v}", "--threshold", "250"], "found in no frame"),
        (["--film", "{v}", "--interval", "0 s"], "--interval"),
        (["--film", "{v}", "--interval", "1"], "--interval"),
        (["--film", "{v}", "--start", "99 s"], "no frame could be read"),
        (["--film", "{v}", "--rate", "0"], "--rate"),
        (["--film", "{v}", "--tilt", "50 deg"], "--tilt"),
        (["--film", "{v}", "--tilt", "4"], "--tilt"),
        (["--film", "{v}", "--roll", "5,5,5,5"], "--roll"),
        (["--film", "{v}", "--tilt-shape", "run"], "needs a RUN"),
        (["--film", "{v}", "--thickness", "1 mm"], "needs a RUN or --reference"),
        (["--film", "{v}", "--distance", "600 mm"], "needs a RUN or --reference"),
        (["{p}/run", "--film", "{v}", "--distance", "9 mm"], "too near"),
        (["{p}/run", "--width", "diagonal"], "--width"),
        (["{p}/run", "--azimuth", "1 mm"], "--azimuth"),
        (["{p}/run", "-o", "{v}"], "this is a file"),
        (["{p}/run", "-o", " "], "wants a folder"),
    ],
)
def test_bad_input(place, tmp_path, capsys, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    filled = [a.format(p=place, v=place / "oven.mp4") for a in arguments]
    assert main(["history", *filled]) == 2
    captured = capsys.readouterr()
    assert words in captured.err
    assert captured.err.count("\n") == 1 and "Traceback" not in captured.err
    assert list(tmp_path.iterdir()) == []


def test_help(capsys):
    assert main(["history", "--help"]) == 0
    text = capsys.readouterr().out
    assert "Examples:" in text and "--reference" in text


def test_pictures_of_the_user_are_neither_replaced_nor_deleted(place, tmp_path, capsys):
    out = tmp_path / "out"
    (out / "films").mkdir(parents=True)
    mine = [out / "films" / name for name in ("oven.png", "1.png", "table.csv")]
    for path in mine:
        path.write_text("mine")
    command = ["history", "--film", str(place / "oven.mp4"), "-o", str(out), "-q", "--force"]
    assert main(command) == 2
    assert "oven.png: this file would be replaced" in capsys.readouterr().err
    mine.pop(0).unlink()
    for _ in range(2):
        assert main(command) == 0
        assert [path.read_text("utf-8") for path in mine] == ["mine", "mine"]
    assert (out / "films" / "oven.png").is_file()
    into_itself = ["history", "--film", str(out / "films"), "-o", str(out), "-q", "--force"]
    assert main(into_itself) == 2
    assert "choose another folder" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "more", "wanted"),
    [
        ("time_s,h_over_d\n0,0.1\n1,0.2\n", ["--interval", "0 s"], "--interval: must be above"),
        ("time_s,h_over_d\n0,0.1\n1e13,0.2\n", [], "too long for this interval"),
        ("time_s,h_over_d\n0,0.1\n2,0.2\n1,0.3\n", [], "line 4, time_s: the times must increase"),
        ("time_s;h_over_d\n0;0,1\n", [], "separated by commas"),
        ("time_s,h_over_d\n0,high\n", [], "line 2, h_over_d: this is no number"),
    ],
)
def test_tables_that_cannot_be(text, more, wanted, tmp_path, capsys):
    (tmp_path / "t.csv").write_text(text)
    said = main(["history", "--film", str(tmp_path / "t.csv"), "-o", str(tmp_path / "o"), *more])
    assert said == 2
    assert wanted in capsys.readouterr().err
    assert not (tmp_path / "o").exists()
