"""Actuation by a field of strains: reading, interpolation, both models, the hash."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.design.actuation import thermal_strain, triangle_eigenstrain
from sheetmorph.design.regions import regions
from sheetmorph.design.spec import Design
from sheetmorph.design.strain_field import StrainField, field_text, parse_field

SHEET = """
name = "graded"
model = "{model}"
[outline]
kind = "rectangle"
width = "40 mm"
height = "30 mm"
[[layers]]
name = "film"
role = "active"
thickness = "0.3 mm"
young_modulus = "1 MPa"
[actuation]
profile = "field"
field = "field.csv"
[mesh]
size = "6 mm"
"""
CORNERS = np.array([[-0.03, -0.03], [0.03, -0.03], [0.03, 0.03], [-0.03, 0.03], [0.0, 0.0]])


def plane(points: np.ndarray) -> np.ndarray:
    return -0.2 + 3.0 * points[:, 0] - 2.0 * points[:, 1]


def design(folder: Path, model: str, text: str | None = None) -> Design:
    content = field_text(CORNERS, plane(CORNERS)) if text is None else text
    (folder / "field.csv").write_text(content, encoding="utf-8")
    return Design.from_toml(SHEET.format(model=model), folder)


def test_text_gives_the_same_numbers() -> None:
    random = np.random.default_rng(1)
    places, strain = random.normal(size=(30, 2)), random.uniform(-0.5, 0.0, 30)
    again = parse_field(field_text(places, strain, "a comment"), "field.csv")
    assert (again.places == places).all()
    assert (again.strain == strain).all()


def test_linear_inside_and_nearest_outside() -> None:
    field = StrainField("field.csv", CORNERS, plane(CORNERS))
    inside = np.random.default_rng(2).uniform(-0.029, 0.029, (50, 2))
    assert field.at(inside) == pytest.approx(plane(inside), abs=1e-12)
    assert field.at(CORNERS) == pytest.approx(plane(CORNERS), abs=1e-12)
    outside = np.array([[0.05, 0.04]])
    assert field.at(outside) == pytest.approx(plane(CORNERS[2:3]), abs=1e-15)


def test_laminate_has_it_at_the_centroids_alike_in_all_directions(tmp_path: Path) -> None:
    made = design(tmp_path, "laminate")
    mesh = made.build_mesh()
    strain = triangle_eigenstrain(made, mesh, regions(made, mesh))
    wanted = plane(mesh.triangle_centroids[:, :2])
    assert strain[:, 0] == pytest.approx(wanted, abs=1e-12)
    assert strain[:, 1] == pytest.approx(wanted, abs=1e-12)
    assert np.abs(strain[:, 2]).max() == 0.0


def test_published_has_the_mean_of_the_triangles_beside_an_edge(tmp_path: Path) -> None:
    made = design(tmp_path, "published").with_values({"actuation.eps_pre": 0.5})
    mesh = made.build_mesh()
    strain = thermal_strain(made, mesh, regions(made, mesh))
    by_triangle = 0.5 * plane(mesh.triangle_centroids[:, :2])
    beside: list[list[float]] = [[] for _ in mesh.edges]
    for triangle, edges in enumerate(mesh.triangle_edges):
        for edge in edges:
            beside[edge].append(by_triangle[triangle])
    assert strain == pytest.approx(np.array([np.mean(values) for values in beside]), abs=1e-12)


def test_hash_is_that_of_the_content(tmp_path: Path) -> None:
    first = design(tmp_path, "published").hash
    assert design(tmp_path, "published").hash == first
    other = field_text(CORNERS, 0.9 * plane(CORNERS))
    assert design(tmp_path, "published", other).hash != first


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x [mm], y [mm], e\n0,0,0\n", ["strain"]),
        ("x [mm], y [mm], strain\n0,0,0\n1,0,0\n0,1,0\n", ["4 rows"]),
        ("x [mm], y [mm], strain\n0,0,0\n1,1,0\n2,2,0\n3,3,0\n", ["one line"]),
        ("x [mm], y [mm], strain\n0,0,0\n1,0,0\n0,1,0\n0,0,0\n", ["line 2", "twice"]),
        ("x [mm], y [mm], strain\n0,0,0\n1,0,0\n0,1,0\n1,1,-2\n", ["line 5", "-0.95"]),
    ],
)
def test_bad_tables_are_told(tmp_path: Path, text: str, words: list[str]) -> None:
    made = design(tmp_path, "published", text)
    mesh = made.build_mesh()
    with pytest.raises(InputError) as error:
        thermal_strain(made, mesh, regions(made, mesh))
    assert all(word in str(error.value) for word in [*words, "field.csv"])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('field = "field.csv"', "", ["actuation.field", "table"]),
        ('profile = "field"', 'profile = "linear"\neps_pre = -0.2', ["actuation.field", "linear"]),
        ('profile = "field"', 'profile = "field"\ntransverse = 0.5', ["actuation.transverse"]),
        ("field.csv", "../field.csv", ["actuation.field"]),
    ],
)
def test_bad_keys_are_told(tmp_path: Path, old: str, new: str, words: list[str]) -> None:
    (tmp_path / "field.csv").write_text(field_text(CORNERS, plane(CORNERS)), encoding="utf-8")
    with pytest.raises(InputError) as error:
        made = Design.from_toml(SHEET.format(model="laminate").replace(old, new), tmp_path)
        mesh = made.build_mesh()
        triangle_eigenstrain(made, mesh, regions(made, mesh))
    assert all(word in str(error.value) for word in words)
