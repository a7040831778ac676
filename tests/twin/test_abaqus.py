"""The deck of the paper: constants of Appendix B, shells, ties, strains; other programs read it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from twin_designs import BILAYER, FILM

import sheetmorph as sm
from sheetmorph.twin.abaqus import MooneyRivlin, abaqus_deck
from sheetmorph.twin.keywords import check_deck
from sheetmorph.twin.sheet import Sheet


def test_the_constants_are_those_that_the_paper_states() -> None:
    film, pla = MooneyRivlin.of(0.8911e6, 0.33), MooneyRivlin.of(2.6733e6, 0.33)
    assert film.c1 == film.c2 == pytest.approx(8.38e4, rel=1e-3)
    assert film.d1 == pytest.approx(2.29e-6, rel=1e-3)
    assert pla.c1 == pla.c2 == pytest.approx(2.51e5, rel=1e-3)
    assert pla.d1 == pytest.approx(7.63e-7, rel=1e-3)


def test_the_constants_agree_with_hooke_at_small_strain() -> None:
    young, poisson, small = 2.0, 0.3, 1e-4
    made = MooneyRivlin.of(young, poisson)
    # A uniaxial stretch of a rod that is free at its sides.
    c = np.diag([1 + small, 1 - poisson * small, 1 - poisson * small]) ** 2
    j = np.sqrt(np.linalg.det(c))
    i1 = np.trace(c) * j ** (-2 / 3)
    i2 = 0.5 * (np.trace(c) ** 2 - np.trace(c @ c)) * j ** (-4 / 3)
    energy = made.c1 * (i1 - 3) + made.c2 * (i2 - 3) + (j - 1) ** 2 / made.d1
    assert energy == pytest.approx(0.5 * young * small**2, rel=1e-3)


def test_the_deck_keeps_to_the_grammar() -> None:
    sheet = Sheet.of(sm.Design.from_toml(BILAYER))
    assert check_deck("".join(abaqus_deck(sheet)).splitlines()) == []


def test_another_reader_finds_both_shells(tmp_path: Path) -> None:
    import meshio

    sheet = Sheet.of(sm.Design.from_toml(BILAYER))
    path = tmp_path / "twin.inp"
    path.write_text("".join(abaqus_deck(sheet)), "utf-8")
    found = meshio.read(path, file_format="abaqus")
    ribs = sheet.triangle_cell == 1
    film, rib = found.cells
    assert film.type == rib.type == "triangle"
    np.testing.assert_array_equal(film.data, sheet.mesh.triangles)
    assert len(rib.data) == ribs.sum()
    points = found.points[rib.data]
    np.testing.assert_allclose(points[..., 2], 0.7e-3)
    np.testing.assert_allclose(
        points[..., :2], sheet.mesh.nodes[sheet.mesh.triangles[ribs], :2], atol=1e-12
    )


def test_the_thermal_field_is_the_eigenstrain() -> None:
    sheet = Sheet.of(sm.Design.from_toml(FILM))
    lines = "".join(abaqus_deck(sheet)).splitlines()
    start = lines.index("*TEMPERATURE, AMPLITUDE=ACTUATE") + 1
    values = [float(line.split(",")[1]) for line in lines[start : start + len(sheet.mesh.nodes)]]
    factor = float(lines[lines.index("*EXPANSION, ZERO=0.") + 1])
    np.testing.assert_allclose(factor * np.array(values), -0.2, rtol=1e-7)


def test_inert_layers_have_no_temperature() -> None:
    sheet = Sheet.of(sm.Design.from_toml(BILAYER))
    lines = "".join(abaqus_deck(sheet)).splitlines()
    start = lines.index("*TEMPERATURE, AMPLITUDE=ACTUATE") + 1
    stop = next(k for k in range(start, len(lines)) if lines[k].startswith("*"))
    assert stop - start == len(sheet.mesh.nodes)


def test_what_the_deck_cannot_say_is_refused() -> None:
    design = sm.Design.from_toml(FILM).with_values({"actuation.transverse": 0.5})
    with pytest.raises(sm.InputError, match="alike in all directions"):
        list(abaqus_deck(Sheet.of(design)))
    clamped = FILM + (
        '[[supports]]\nkind = "box"\nx = ["-6 mm", "-4.9 mm"]\n'
        'y = ["-5 mm", "5 mm"]\nclamp = true\n'
    )
    with pytest.raises(sm.InputError, match="neither clamped edges nor loads"):
        list(abaqus_deck(Sheet.of(sm.Design.from_toml(clamped))))


def test_a_layer_at_two_heights_is_refused() -> None:
    text = BILAYER + (
        '\n[[layers]]\nname = "cap"\nrole = "inert"\nthickness = "1 mm"\n'
        'young_modulus = "3 MPa"\nwhere = "cap"\n'
        '\n[[pattern]]\nkind = "rectangle"\nwidth = "12 mm"\nheight = "4 mm"\npart = "cap"\n'
    )
    with pytest.raises(sm.InputError, match="lies at several heights"):
        list(abaqus_deck(Sheet.of(sm.Design.from_toml(text))))
