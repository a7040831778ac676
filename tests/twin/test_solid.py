"""Wedges: volumes, shared nodes, the reference plane, and layers that cannot be laid out."""

from __future__ import annotations

import numpy as np
import pytest
from twin_designs import BILAYER

import sheetmorph as sm
from sheetmorph.twin.sheet import Sheet
from sheetmorph.twin.solid import Solid, extrude


def volumes(solid: Solid) -> np.ndarray:
    a, b, c, d, e, f = (solid.nodes[solid.wedges[:, k]] for k in range(6))
    area = 0.5 * np.cross(b - a, c - a)[:, 2]
    return area * (d + e + f - a - b - c)[:, 2] / 3.0


def twin(**values: object) -> tuple[Sheet, Solid]:
    keys = {key.replace("__", "."): value for key, value in values.items()}
    sheet = Sheet.of(sm.Design.from_toml(BILAYER).with_values(keys))
    return sheet, extrude(sheet)


def test_volumes_are_areas_times_thicknesses() -> None:
    sheet, solid = twin()
    found = volumes(solid)
    assert (found > 0).all()
    areas = sheet.mesh.triangle_areas
    assert found[solid.layer == 0].sum() == pytest.approx(areas.sum() * 0.4e-3)
    ribs = areas[sheet.triangle_cell == 1].sum()
    assert ribs > 0
    assert found[solid.layer == 1].sum() == pytest.approx(ribs * 1e-3)


def test_middle_nodes_lie_in_the_middle() -> None:
    _, solid = twin()
    ends = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]
    for k, (a, b) in enumerate(ends, 6):
        corners = solid.nodes[solid.wedges[:, a]] + solid.nodes[solid.wedges[:, b]]
        np.testing.assert_allclose(solid.nodes[solid.wedges[:, k]], 0.5 * corners, atol=1e-15)


def test_layers_share_the_nodes_of_their_face_and_no_others_coincide() -> None:
    _, solid = twin()
    assert len(np.unique(np.round(solid.nodes, 9), axis=0)) == len(solid.nodes)
    film = np.unique(solid.wedges[solid.layer == 0])
    rib = np.unique(solid.wedges[solid.layer == 1])
    common = np.intersect1d(film, rib)
    np.testing.assert_allclose(solid.nodes[common, 2], 0.2e-3)
    at_face = rib[np.isclose(solid.nodes[rib, 2], 0.2e-3)]
    np.testing.assert_array_equal(at_face, common)


def test_the_surface_is_the_middle_of_the_film() -> None:
    sheet, solid = twin()
    np.testing.assert_allclose(solid.nodes[solid.surface], sheet.mesh.nodes, atol=1e-15)


def test_a_layer_that_the_reference_plane_cuts_off_its_middle_becomes_two() -> None:
    # Two layers everywhere: the reference plane lies in the thicker one.
    sheet, solid = twin(layers__1__where="everywhere", pattern=None, actuation__profile="uniform")
    np.testing.assert_allclose(solid.nodes[solid.surface], sheet.mesh.nodes, atol=1e-15)
    counts = np.bincount(solid.layer)
    np.testing.assert_array_equal(counts, np.array([1, 2]) * len(sheet.mesh.triangles))
    assert volumes(solid).sum() == pytest.approx(12e-3 * 8e-3 * 1.4e-3)


def test_a_rib_below_the_film_lies_below() -> None:
    film, rib = BILAYER.index("[[layers]]"), BILAYER.rindex("[[layers]]")
    end = BILAYER.index("[[pattern]]")
    text = BILAYER[:film] + BILAYER[rib:end] + BILAYER[film:rib] + BILAYER[end:]
    sheet = Sheet.of(sm.Design.from_toml(text))
    solid = extrude(sheet)
    np.testing.assert_allclose(solid.nodes[solid.surface, 2], 0.0, atol=1e-15)
    assert solid.nodes[:, 2].min() == pytest.approx(-1.2e-3)
    assert solid.nodes[:, 2].max() == pytest.approx(0.2e-3)


def test_a_rib_within_the_film_is_refused() -> None:
    start, end = BILAYER.index("[[layers]]"), BILAYER.rindex("[[layers]]")
    film = BILAYER[start:end].replace('"film"', '"second"')
    text = BILAYER.replace("[[pattern]]", film + "[[pattern]]")
    with pytest.raises(sm.InputError, match=r"layers\[1\]: a layer of the pattern between two"):
        Sheet.of(sm.Design.from_toml(text))


def test_eigenstrains_and_factors_are_those_of_the_design() -> None:
    sheet, _ = twin(layers__0__eigenstrain_factor=0.5)
    np.testing.assert_array_equal(sheet.factors, [0.5, 0.0])
    ribs = sheet.triangle_cell == 1
    np.testing.assert_array_equal(sheet.eigenstrain[ribs], 0.0)
    assert (sheet.eigenstrain[~ribs, 0] < 0).all()
