"""Which way hinges run, and meshes that do not fit their outline."""

from __future__ import annotations

import numpy as np
import pytest
from sheets import SHEET

from sheetmorph.core.errors import InputError
from sheetmorph.design.meshing import farther_side, hinge_coupling, hinge_orientation
from sheetmorph.design.presets import preset_text
from sheetmorph.design.regions import regions
from sheetmorph.design.spec import Design
from sheetmorph.geometry.topology import build_mesh


def oriented(mesh, pattern):
    return mesh.with_hinges_reversed(farther_side(mesh, pattern) < 0)


def described(mesh, pattern):
    """Hinges that have a side, by the places of their nodes, in an order without numbering."""
    decided = mesh.hinges[farther_side(mesh, pattern) != 0]
    places = np.round(mesh.nodes[decided, :2] * 1e9).astype(np.int64).reshape(-1, 8)
    return places[np.lexsort(places.T)]


@pytest.mark.parametrize("with_pattern", [True, False])
def test_no_numbering_changes_the_orientation(design, strip, with_pattern):
    bare = design.with_values({"pattern": [], "layers.1": None})
    pattern = (design if with_pattern else bare).pattern_polygon()
    rng = np.random.default_rng(7)
    wanted = described(oriented(strip, pattern), pattern)
    for _ in range(3):
        order = rng.permutation(len(strip.nodes))
        new = np.argsort(order)
        triangles = rng.permutation(new[strip.triangles])
        edges = rng.permutation(new[strip.edges])
        flip = rng.random(len(edges)) < 0.5
        edges[flip] = edges[flip][:, ::-1]
        other = build_mesh(strip.nodes[order], triangles, edges)
        assert np.array_equal(described(oriented(other, pattern), pattern), wanted)


def test_c_is_farther_from_the_pattern(design, strip):
    mesh = oriented(strip, design.pattern_polygon())
    beyond = np.maximum(np.abs(mesh.nodes[:, :2]) - [0.01, 0.003], 0.0)
    away = np.linalg.norm(beyond, axis=1)
    assert (away[mesh.hinges[:, 2]] >= away[mesh.hinges[:, 3]] - 1e-6).all()
    assert (farther_side(mesh, design.pattern_polygon()) >= 0).all()


def test_no_preferred_side_no_coupling(design, strip):
    mesh = oriented(strip, design.pattern_polygon())
    side = farther_side(mesh, design.pattern_polygon())
    coupling = hinge_coupling(design, mesh, regions(design, mesh))
    assert (coupling[side == 0] == 0).all()
    assert (coupling[side != 0] == 1).all()
    assert 0 < (side == 0).sum() < len(side)
    as_listed = design.with_values({"published.hinge_orientation": "file_order"})
    assert (hinge_coupling(as_listed, mesh, regions(design, mesh)) == 1).all()


def test_default_orientation_by_source(design, tmp_path):
    listed, plain = tmp_path / "a.txt", tmp_path / "b.txt"
    listed.write_text("*shellNodes\n*FaceNodes\n*Edges\n")
    plain.write_text("*shellNodes\n*FaceNodes\n")
    assert hinge_orientation(design, None) == "away_from_pattern"
    assert hinge_orientation(design, listed) == "file_order"
    assert hinge_orientation(design, plain) == "away_from_pattern"
    assert hinge_orientation(design, tmp_path / "a.msh") == "away_from_pattern"
    fixed = design.with_values({"published.hinge_orientation": "file_order"})
    assert hinge_orientation(fixed, None) == "file_order"


def test_a_mesh_made_here_is_oriented(design):
    mesh = design.build_mesh()
    assert (farther_side(mesh, design.pattern_polygon()) >= 0).all()
    assert mesh.triangle_areas.sum() == pytest.approx(0.04 * 0.02, rel=1e-6)


@pytest.mark.parametrize(
    ("text", "unit", "fits"),
    [(SHEET, "mm", True), (SHEET, "m", False), (SHEET.replace("20, ", "30, "), "mm", False)],
)
def test_a_mesh_must_fit_the_outline(base, tmp_path, text, unit, fits):
    (tmp_path / "sheet.txt").write_text(text)
    source = f'file = "sheet.txt"\nunit = "{unit}"'
    design = Design.from_toml(base.replace('size = "2 mm"', source), tmp_path)
    if fits:
        mesh = design.build_mesh()
        assert mesh.counts == (4, 5, 2)
        assert mesh.edges[4].tolist() == [2, 0]
    else:
        with pytest.raises(InputError, match=r"does not fit the outline.*check mesh\.unit"):
            design.build_mesh()


def test_designs_that_differ_in_actuation_alone_have_one_mesh() -> None:
    design = Design.from_toml(preset_text("bowl", "x")).with_values({"mesh.size": "10 mm"})
    mesh = design.build_mesh()
    weaker = design.with_values({"actuation.eps_pre": -0.1, "layers.0.thickness": "0.2 mm"})
    np.testing.assert_array_equal(weaker.build_mesh().nodes, mesh.nodes)
    assert weaker.build_mesh().nodes is mesh.nodes
    for key, value in (
        ("mesh.size", "9 mm"),
        ("mesh.boundary_size", "4 mm"),
        ("mesh.symmetry", "auto"),
        ("pattern.0.half_width", "6.1 mm"),
        ("outline.radius", "51 mm"),
    ):
        other = design.with_values({key: value}).build_mesh()
        assert other.nodes.shape != mesh.nodes.shape or (other.nodes != mesh.nodes).any(), key
