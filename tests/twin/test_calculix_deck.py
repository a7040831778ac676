"""The deck says what it should: materials, strains, loads and supports, read back from its text."""

from __future__ import annotations

import numpy as np
import pytest
from twin_designs import BILAYER, FILM

import sheetmorph as sm
from sheetmorph.twin import calculix
from sheetmorph.twin.calculix import DeckOptions, write_deck
from sheetmorph.twin.natural import natural_metric, natural_strain, pulled_back_stiffness
from sheetmorph.twin.sheet import Sheet
from sheetmorph.twin.solid import extrude

Blocks = list[tuple[str, list[list[float]]]]


def deck_of(design: sm.Design, **options: object) -> tuple[Sheet, Blocks]:
    """Keyword lines and the numbers below each."""
    sheet = Sheet.of(design)
    deck = write_deck(sheet, extrude(sheet), DeckOptions(**options))  # type: ignore[arg-type]
    blocks: Blocks = []
    for line in "".join(deck.text).splitlines():
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            blocks.append((line, []))
        else:
            cells = [cell for cell in line.split(",") if cell not in ("", "ALL", "U")]
            blocks[-1][1].append([float(cell) for cell in cells])
    return sheet, blocks


def under(blocks: Blocks, keyword: str) -> list[list[list[float]]]:
    return [rows for line, rows in blocks if line.startswith(keyword)]


def test_strains_add_up_to_the_natural_strain() -> None:
    sheet, blocks = deck_of(sm.Design.from_toml(FILM), steps=4)
    steps = under(blocks, "*INITIAL STRAIN INCREASE")
    assert len(steps) == 4
    total = sum(np.array(rows)[:, 2:] for rows in steps)
    wanted = natural_strain(natural_metric(sheet.eigenstrain[:1]))
    np.testing.assert_allclose(total, np.broadcast_to(wanted, total.shape), atol=1e-10)
    assert len(total) == 9 * len(sheet.mesh.triangles)


def test_the_constants_follow_the_ramp() -> None:
    sheet, blocks = deck_of(sm.Design.from_toml(FILM), steps=2)
    (rows,) = under(blocks, "*ELASTIC")
    table = np.concatenate(rows).reshape(3, 22)
    np.testing.assert_allclose(table[:, 21], [0.0, 0.5, 1.0])
    for share, row in zip((0.0, 0.5, 1.0), table, strict=True):
        metric = natural_metric(share * sheet.eigenstrain[:1])
        wanted = pulled_back_stiffness(metric, 1e6, 0.3)[0]
        np.testing.assert_allclose(row[:21], wanted, rtol=1e-10, atol=1e-6)


def test_what_is_inert_has_one_material_and_no_strain() -> None:
    sheet, blocks = deck_of(sm.Design.from_toml(BILAYER), steps=2)
    elements = [rows for line, rows in blocks if line.startswith("*ELEMENT")]
    moving = {row[0] for row in under(blocks, "*INITIAL STRAIN INCREASE")[0]}
    ribs = int((sheet.triangle_cell == 1).sum())
    assert len(moving) == len(sheet.mesh.triangles) - ribs
    assert sum(len(rows) for rows in elements) == len(sheet.mesh.triangles) + ribs


def test_the_load_comes_first_and_fades_last() -> None:
    design = sm.Design.from_toml(FILM).with_values({"perturbation.ramp_down_steps": 2})
    sheet, blocks = deck_of(design, steps=3)
    forces = [np.array(rows)[:, 2] for rows in under(blocks, "*CLOAD")]
    full = sheet.forces[:, 2] / 1e-6
    for part, found in zip((1, 1, 1, 1, 0.5, 0), forces, strict=True):
        np.testing.assert_allclose(found, part * full, rtol=1e-10, atol=1e-15)
    temperatures = [rows[0][0] for rows in under(blocks, "*TEMPERATURE")]
    np.testing.assert_allclose(temperatures, [0, 1 / 3, 2 / 3, 1, 1, 1])


def test_a_free_sheet_has_six_pins_and_lengths_are_millimetres() -> None:
    _, blocks = deck_of(sm.Design.from_toml(FILM), steps=1)
    assert len(under(blocks, "*BOUNDARY")[0]) == 6
    nodes = np.array(under(blocks, "*NODE,")[0])[:, 1:]
    np.testing.assert_allclose(np.ptp(nodes, axis=0), [10.0, 8.0, 1.0])


def test_a_clamped_edge_holds_all_of_its_height() -> None:
    design = sm.Design.from_toml(
        FILM
        + """
[[supports]]
kind = "box"
x = ["-6 mm", "-4.9 mm"]
y = ["-5 mm", "5 mm"]
clamp = true
"""
    )
    sheet, blocks = deck_of(design, steps=1)
    nodes = np.array(under(blocks, "*NODE,")[0])
    edge = nodes[np.isclose(nodes[:, 1], -5.0), 0]
    held = {(int(node), int(axis)) for node, axis, _ in under(blocks, "*BOUNDARY")[0]}
    assert {(int(node), 1) for node in edge} <= held
    assert len(held) == len(edge) + 2 * int(np.isclose(sheet.mesh.nodes[:, 0], -5e-3).sum())


def test_the_usual_deck_has_expansion_and_no_strains() -> None:
    _, blocks = deck_of(sm.Design.from_toml(FILM), steps=2, law="expansion")
    assert under(blocks, "*EXPANSION") == [[[-0.2]]]
    assert under(blocks, "*ELASTIC") == [[[1e6, 0.3]]]
    assert not under(blocks, "*INITIAL STRAIN INCREASE")


def test_a_deck_that_grows_too_long_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(calculix, "MOST_LINES", 100)
    with pytest.raises(sm.InputError, match=r"mesh.size: the deck would have \d+ lines"):
        deck_of(sm.Design.from_toml(FILM), steps=2)


def test_a_smeared_pattern_is_refused() -> None:
    smeared = BILAYER.replace('size = "4 mm"', 'size = "4 mm"\npattern_smoothing = "2 mm"')
    with pytest.raises(sm.InputError, match=r"mesh.pattern_smoothing: .*taper"):
        Sheet.of(sm.Design.from_toml(smeared))
