"""Designs whose sheet and pattern stand in a drawing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely

import sheetmorph as sm
from sheetmorph.core.errors import InputError
from sheetmorph.design.from_drawing import design_text
from sheetmorph.drawing.ink import Ink
from sheetmorph.drawing.write_dxf import dxf_bytes
from sheetmorph.drawing.write_svg import svg_bytes

LEAF = Path(__file__).parents[2] / "examples" / "leaf" / "leaf.svg"
SHEET = shapely.box(-0.03, -0.02, 0.03, 0.02)
PATTERN = shapely.box(-0.02, -0.004, 0.02, 0.004)
SLIT = shapely.LineString([(-0.01, 0.01), (0.01, 0.01)])
INKS = (Ink("SHEET", (SHEET,)), Ink("PATTERN", (PATTERN,)), Ink("SLITS", (SLIT,)))


@pytest.fixture(params=["dxf", "svg"])
def drawing(request, tmp_path) -> Path:
    file = tmp_path / f"plate.{request.param}"
    file.write_bytes(dxf_bytes(INKS) if request.param == "dxf" else svg_bytes(INKS))
    return file


def design_of(drawing: Path, **values: object) -> sm.Design:
    text = design_text(drawing, "plate", None, None, None)
    design = sm.Design.from_toml(text, drawing.parent)
    return design.with_values(values) if values else design


def test_a_drawing_becomes_a_design(drawing):
    design = design_of(drawing)
    assert design.outline_polygon().symmetric_difference(SHEET).area < 1e-12
    assert design.pattern_polygon().symmetric_difference(PATTERN).area < 1e-12
    assert design.layout.slits.hausdorff_distance(SLIT) < 1e-9
    mesh = design.build_mesh()
    on_slit = np.abs(mesh.nodes[:, 1] - 0.01) < 1e-9
    on_slit &= np.abs(mesh.nodes[:, 0]) < 0.01 - 1e-6
    places = np.unique(mesh.nodes[on_slit].round(9), axis=0)
    assert len(places) > 0
    assert on_slit.sum() == 2 * len(places)


def test_the_leaf_runs_as_it_is_drawn():
    text = design_text(LEAF, "leaf", None, None, None)
    design = sm.Design.from_toml(text, LEAF.parent)
    assert "strokes = true" in text
    assert len(design.pattern_polygon().geoms) == 1
    assert design.notes
    assert all(note.startswith("leaf.svg: ") for note in design.notes)
    assert np.degrees(design.build_mesh().minimum_angles.min()) > 25


def test_the_hash_follows_what_is_drawn(drawing):
    design = design_of(drawing)
    renamed = drawing.with_name(f"other{drawing.suffix}")
    renamed.write_bytes(drawing.read_bytes())
    assert design_of(renamed).hash == design.hash
    inks = (INKS[0], Ink("PATTERN", (PATTERN.buffer(1e-3),)), INKS[2])
    drawing.write_bytes(dxf_bytes(inks) if drawing.suffix == ".dxf" else svg_bytes(inks))
    assert design_of(drawing).hash != design.hash


def test_a_portable_design_needs_no_drawing(drawing):
    design = design_of(drawing)
    alone = sm.Design.from_toml(design.to_portable_toml())
    assert alone.outline_polygon().equals_exact(design.outline_polygon())
    assert alone.pattern_polygon().equals_exact(design.pattern_polygon())
    assert alone.layout.slits.equals_exact(design.layout.slits)
    assert "drawing" not in {shape.kind for shape in (alone.outline, *alone.pattern)}


def test_results_of_drawings_are_read_without_them(drawing, tmp_path):
    design = design_of(drawing, **{"mesh.size": "4 mm", "actuation.eps_pre": -0.05})
    result = sm.simulate(design)
    assert result.status == "completed"
    elsewhere = tmp_path / "elsewhere"
    result.save(elsewhere)
    drawing.unlink()
    again = sm.Result.load(elsewhere)
    assert again.design.pattern_polygon().equals_exact(design.pattern_polygon())


def broken(drawing: Path, old: str, new: str) -> str:
    text = design_text(drawing, "plate", None, None, None)
    assert old in text
    file = drawing.parent / "plate.toml"
    file.write_text(text.replace(old, new))
    with pytest.raises(InputError) as caught:
        sm.Design.load(file)
    message = str(caught.value)
    assert message.startswith(f"{file}: ")
    assert "\n" not in message
    return message


def test_broken_references(drawing):
    name = drawing.name
    assert "outline.file" in broken(drawing, name, "gone.svg")
    assert "leads out" in broken(drawing, name, f"../{drawing.parent.name}/{name}")
    assert "PATTERN" in broken(drawing, '"PATTERN"', '"PATERN"')
    assert "outline.select" in broken(drawing, '"SHEET"', '"SHET"')
    assert "slit_select" in broken(drawing, '"SLITS"', '"SLIDS"')
    assert "unit" in broken(drawing, 'select = "SHEET"', 'select = "SHEET"\nunit = "parsec"')
    text = design_text(drawing, "plate", None, None, None)
    drawing.write_bytes(drawing.read_bytes()[:200])
    with pytest.raises(InputError, match=rf"outline.*{name}"):
        sm.Design.from_toml(text, drawing.parent)


def test_roles_that_are_not_found_are_asked_for(tmp_path):
    file = tmp_path / "odd.dxf"
    file.write_bytes(dxf_bytes((Ink("A", (SHEET,)), Ink("B", (PATTERN,)))))
    with pytest.raises(InputError, match=r"--sheet.*A, B"):
        design_text(file, "odd", None, None, None)
    text = design_text(file, "odd", "A", "B", None)
    assert sm.Design.from_toml(text, tmp_path).pattern_polygon().area == pytest.approx(320e-6)


def test_slits_drawn_short_of_the_rim_are_joined_within_the_gap(tmp_path):
    short = shapely.LineString([(0.0, 0.01), (0.0, 0.0199)])
    file = tmp_path / "short.svg"
    file.write_bytes(svg_bytes((*INKS[:2], Ink("SLITS", (short,)))))
    text = design_text(file, "short")
    with pytest.raises(InputError, match=r"outline\.slits: .*close to another line"):
        sm.Design.from_toml(text, tmp_path).build_mesh()
    text = design_text(file, "short", gap=2e-4)
    design = sm.Design.from_toml(text, tmp_path)
    assert design.layout.slits.length == pytest.approx(0.01)
    assert any("0.1 mm short of the edge" in note for note in design.notes)
    mesh = design.build_mesh()
    alone = sm.Design.from_toml(design.to_portable_toml())
    assert alone.layout.slits.hausdorff_distance(design.layout.slits) < 1e-15
    on_rim = np.isclose(mesh.nodes[:, 1], 0.02, atol=1e-9) & np.isclose(mesh.nodes[:, 0], 0.0)
    assert on_rim.sum() == 2
