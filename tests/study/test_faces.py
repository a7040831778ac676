"""Which face of the film the inert layers lie on."""

from __future__ import annotations

import numpy as np
import pytest
from small import SMALL

import sheetmorph as sm

FILM = SMALL[SMALL.index('[[layers]]\nname = "film"') : SMALL.index('[[layers]]\nname = "print"')]
PRINT = SMALL[SMALL.index('[[layers]]\nname = "print"') : SMALL.index("[actuation]")]


def test_a_sheet_turned_over_gets_the_mirrored_shape() -> None:
    upright = sm.simulate(sm.Design.from_toml(SMALL))
    text = SMALL.replace(FILM + PRINT, PRINT + FILM).replace('"up"', '"down"')
    turned = sm.simulate(sm.Design.from_toml(text))
    mirrored = turned.positions[-1] * np.array([1.0, 1.0, -1.0])
    assert upright.summary["height_m"] > 1e-3
    assert np.abs(upright.positions[-1] - mirrored).max() < 1e-9


def test_the_coupling_follows_the_face() -> None:
    """With the opposite sign of the coupling, the sheet turned over takes the upright shape."""
    upright = sm.simulate(sm.Design.from_toml(SMALL))
    over = SMALL.replace(FILM + PRINT, PRINT + FILM) + "[published]\ncoupling = -1.0\n"
    turned = sm.simulate(sm.Design.from_toml(over))
    assert np.abs(upright.positions[-1] - turned.positions[-1]).max() < 1e-9


def test_equal_layers_on_both_faces_are_one_thick_layer_in_the_middle() -> None:
    half = PRINT.replace('"0.7 mm"', '"0.35 mm"')
    both = SMALL.replace(FILM + PRINT, half.replace('"print"', '"under"') + FILM + half)
    design = sm.Design.from_toml(both)
    problem_stack = sm.simulate(design).regions.cells[1].stack
    y1, y2, h1, h2 = 1e6 / (1 - 0.33**2), 3e6 / (1 - 0.33**2), 0.3e-3, 0.35e-3
    offset = (h1 + h2) / 2
    rigidity = y1 * h1**3 / 12 + 2 * y2 * (h2**3 / 12 + h2 * offset**2)
    assert problem_stack.flexural_rigidity == pytest.approx(rigidity, rel=1e-12)
    assert problem_stack.face == 0


def test_results_carry_their_regions(tmp_path) -> None:  # type: ignore[no-untyped-def]
    result = sm.simulate(sm.Design.from_toml(SMALL))
    assert np.array_equal(result.regions.edge_in_pattern, result.edge_in_pattern)
    result.save(tmp_path / "r.h5")
    again = sm.Result.load(tmp_path / "r.h5")
    assert np.array_equal(again.regions.triangle_cell, result.regions.triangle_cell)
