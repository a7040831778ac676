"""Targets by name and from files, and what is said about those that are none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sheetmorph.compare.scan import Scan
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import InputError
from sheetmorph.geometry.writers import write_stl
from sheetmorph.inverse import surfaces
from sheetmorph.inverse.targets import USUAL_SIZE, read_target, target_of


def test_names_take_their_numbers() -> None:
    bowl = read_target("bowl:0.4")
    assert (bowl.name, bowl.text) == ("bowl", "bowl:0.4")
    assert bowl.aspect_ratio == pytest.approx(0.4, rel=1e-9)
    assert bowl.width == pytest.approx(USUAL_SIZE, rel=1e-9)
    assert read_target("Saddle", size=0.2).width == pytest.approx(0.2, rel=1e-9)
    assert read_target("letter:u:0.3").name == "letter-U"
    slender = read_target("canoe:3:0.2").surface.box
    assert slender[1, 0] - slender[0, 0] == pytest.approx(
        3 * (slender[1, 1] - slender[0, 1]), rel=1e-6
    )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("bowll", ["bowl", "no surface of this name"]),
        ("bowl:1.5", ["h/d is out of range", "0.02 to 1"]),
        ("cylinder:0.7", ["h/d is out of range", "0.02 to 0.5"]),
        ("canoe:0.5", ["length/width is out of range"]),
        ("bowl:nan", ["out of range"]),
        ("bowl:deep", ["no number", "NAME:h/d"]),
        ("bowl:0.4:0.4", ["too many numbers"]),
        ("letter", ["letter", "C, H"]),
        ("letter:W", ["letter", "C, H"]),
        ("missing.stl", ["missing.stl"]),
    ],
)
def test_what_is_no_target_is_told(text: str, words: list[str]) -> None:
    with pytest.raises(InputError) as error:
        read_target(text)
    assert all(word in str(error.value) for word in words)


def test_names_have_no_unit() -> None:
    with pytest.raises(InputError, match="--size"):
        read_target("bowl", unit=1e-3)


def test_files_are_in_millimetres_unless_said_otherwise(tmp_path: Path) -> None:
    surface = surfaces.bowl(0.3)
    write_stl(tmp_path / "cup.stl", surface.triangles, 60.0 * surface.points)
    name = str(tmp_path / "cup.stl")
    assert read_target(name).width == pytest.approx(0.06, rel=1e-5)
    assert read_target(name).name == "cup"
    assert read_target(name, unit=0.01).width == pytest.approx(0.6, rel=1e-5)
    assert read_target(name, size=0.05).width == pytest.approx(0.05, rel=1e-5)


def test_of_a_thick_sheet_the_outer_face_is_taken() -> None:
    sheet = surfaces.bowl(0.3)
    inner, outer = sheet.points * [1, 1, 1.0], sheet.points * 1.02 - [0, 0, 0.02]
    count = len(sheet.points)
    rim = sheet.rim_edges
    walls = np.concatenate(
        [
            np.column_stack([rim[:, 0], rim[:, 1], rim[:, 0] + count]),
            np.column_stack([rim[:, 1], rim[:, 1] + count, rim[:, 0] + count]),
        ]
    )
    faces = np.concatenate([sheet.triangles, sheet.triangles[:, ::-1] + count, walls])
    target = target_of(Scan(Surface(np.concatenate([inner, outer]), faces), "thick", (), 1.0), "t")
    assert any("outer face" in note for note in target.notes)
    assert target.surface.area == pytest.approx(1.02**2 * sheet.area, rel=0.06)
