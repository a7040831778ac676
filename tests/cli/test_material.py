"""The commands `material …`: what they print and write, and how they refuse."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from small import SMALL

from sheetmorph.cli import entry
from sheetmorph.cli.entry import main
from sheetmorph.cli.material import material

EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "materials"
SHRINK = EXAMPLES / "synthetic_shrinkage.csv"
WEIGHT = EXAMPLES / "synthetic_self_weight.csv"
FORCE = EXAMPLES / "synthetic_end_load.csv"


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(entry.cli.commands, "material", material)
    monkeypatch.chdir(tmp_path)


def refused(arguments: list[str], capsys: pytest.CaptureFixture[str], *wanted: str) -> None:
    assert main(["material", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1 and err.startswith("sheetmorph: "), err
    for text in wanted:
        assert text in err


def test_list_and_show(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["material", "list"]) == 0
    told = capsys.readouterr().out
    assert all(name in told for name in ("polystyrene", "PLA", "epoxy"))
    assert main(["material", "list", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["PLA"]["values"]["density"]["value"] == 1250.0
    assert main(["material", "show", "pla"]) == 0
    told = capsys.readouterr().out
    assert "2.6733 GPa (2 GPa to 4 GPa)" in told
    assert "Khouri 2024" in told
    assert "(assumed)" in told
    assert main(["material", "show", "epoxy"]) == 0
    assert "glass temperature           not known" in capsys.readouterr().out
    assert main(["material", "show", "polystyrene", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["shrink_curve"] == "polystyrene"
    assert told["values"]["young_modulus"]["assumed"]


def test_unknown_names(capsys: pytest.CaptureFixture[str]) -> None:
    refused(["show", "polystyrol"], capsys, "did you mean polystyrene?", "PLA, epoxy")
    refused(["bake"], capsys, "No such command")


@pytest.mark.parametrize("command", [[], ["list"], ["show"], ["shrink"], ["cantilever"]])
def test_help_has_an_example(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["material", *command, "--help"]) == 0
    assert f"sheetmorph material {' '.join(command)}" in capsys.readouterr().out


def test_from_rows_to_a_design(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["material", "shrink", str(SHRINK), "-o", "film"]) == 0
    told = capsys.readouterr().out
    assert "levels off at T/Tg = 1.152, 149.0 °C" in told
    assert "within the scatter" in told
    assert {path.name for path in Path("film").iterdir()} == {
        *("shrink.json", "curve.csv", "shrink.png")
    }
    text = SMALL.replace(
        "eps_pre = -0.4", 'temperature = "149 degC"\nshrink_curve = "curve.csv"'
    ).replace('young_modulus = "3 MPa"', 'material = "PLA"')
    Path("film/small.toml").write_text(text, encoding="utf-8")
    assert main(["check", "film/small.toml"]) == 0
    assert "eps_pre -0.5953 ± 0.0026 at 149 °C" in capsys.readouterr().out
    Path("film/raw.csv").write_bytes(SHRINK.read_bytes())
    Path("film/small.toml").write_text(text.replace("curve.csv", "raw.csv"), encoding="utf-8")
    assert main(["check", "film/small.toml"]) == 0
    assert "eps_pre -0.5953 ± 0.0026 at 149 °C" in capsys.readouterr().out


def test_glass_temperature_by_option(capsys: pytest.CaptureFixture[str]) -> None:
    Path("rows.csv").write_text("T/Tg, L/L0\n1, 1\n1.1, 0.5\n1.2, 0.4\n", encoding="utf-8")
    refused(["shrink", "rows.csv"], capsys, 'T/Tg needs a line "# Tg = 366.5 K"')
    refused(["shrink", "rows.csv", "--tg", "warm"], capsys, "--tg")
    refused(["shrink", "rows.csv", "--tg", "-300 degC"], capsys, "--tg", "absolute zero")
    assert main(["material", "shrink", "rows.csv", "--tg", "366.5 K", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["temperatures"] == pytest.approx([366.5, 1.1 * 366.5, 1.2 * 366.5])
    assert Path("material/rows/curve.csv").is_file()


def test_cantilever(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["material", "cantilever", str(FORCE), "-o", "after"]) == 0
    told = capsys.readouterr()
    assert "E  2.65 ± 1.58 GPa" in told.out
    assert "K  142 ± 52 N/m" in told.out
    assert told.err == ""
    assert main(["material", "cantilever", str(WEIGHT), "-o", "before"]) == 0
    told = capsys.readouterr()
    assert "E  2.60 ± 0.32 GPa" in told.out
    assert "K  0.2357 ± 0.0016 N/m" in told.out
    assert told.err.startswith("warning: the deflection is up to 0.29 of the length")
    exact = ["material", "cantilever", str(WEIGHT), "-o", "exact", "--large-deflection", "--json"]
    assert main(exact) == 0
    told = capsys.readouterr()
    assert json.loads(told.out)["young_modulus"]["mean"] == pytest.approx(2.446e9, rel=2e-3)
    assert json.loads(told.out) == json.loads(
        Path("exact/cantilever.json").read_text(encoding="utf-8")
    )
    assert main([*exact[:-1], "--force", "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("command", "file", "own"),
    [("shrink", SHRINK, "curve.csv"), ("cantilever", WEIGHT, "cantilever.csv")],
)
def test_overwriting(
    command: str, file: Path, own: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("out").mkdir()
    Path("out", own).write_text("mine", encoding="utf-8")
    refused([command, str(file), "-o", "out", "--force"], capsys, "wrote it; choose another folder")
    assert Path("out", own).read_text(encoding="utf-8") == "mine"
    Path("out", own).unlink()
    assert main(["material", command, str(file), "-o", "out", "-q"]) == 0
    Path("out/mine.txt").write_text("mine", encoding="utf-8")
    before = Path("out", own).read_bytes()
    refused([command, str(file), "-o", "out"], capsys, "add --force")
    assert main(["material", command, str(file), "-o", "out", "-q", "--force"]) == 0
    assert Path("out", own).read_bytes() == before
    assert Path("out/mine.txt").read_text(encoding="utf-8") == "mine"
    refused([command, str(file), "-o", "out/mine.txt"], capsys, "this is a file")
    refused([command, str(file), "-o", " "], capsys, "-o wants a folder")


@pytest.mark.parametrize("command", ["shrink", "cantilever"])
@pytest.mark.parametrize(
    ("change", "wanted"),
    [
        (lambda t: t.replace("L [mm]", "M [mm]").replace("force [N]", "farce [N]"), "line"),
        (lambda t: t.replace("L0 [mm]", "L0").replace("width [mm]", "width"), "write the unit in"),
        (lambda t: t.replace(", 50, ", ", nan, ").replace(", 14.3, ", ", nan, "), "finite number"),
        (lambda t: t.replace(", 50, ", ", -50, ").replace(", 14.3, ", ", -14.3, "), "out of range"),
        (lambda t: "\n".join(t.splitlines()[: 4 if "L0" in t else 3]), "at least two"),
        (lambda t: "# " + "x" * 5_000_000 + "\n" + t, "too large"),
        (lambda t: t + "\x00\n", "line"),
    ],
    ids=["column", "unit", "nan", "negative", "one row", "huge", "zero byte"],
)
def test_broken_files(
    command: str,
    change,
    wanted: str,
    capsys: pytest.CaptureFixture[str],  # type: ignore[no-untyped-def]
) -> None:
    text = (SHRINK if command == "shrink" else FORCE).read_text("utf-8")
    Path("broken.csv").write_text(change(text), encoding="utf-8")
    refused([command, "broken.csv", "-o", "out"], capsys, "broken.csv: ", wanted)
    assert not Path("out").exists()
    refused([command, "absent.csv"], capsys, "absent.csv: there is no such file")
