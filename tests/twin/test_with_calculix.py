"""What CalculiX itself says: the deck is exact, the laminate model agrees, *EXPANSION is not."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from twin_designs import BILAYER, FILM

import sheetmorph as sm
from sheetmorph.solve.constraints import align_to_reference
from sheetmorph.twin.abaqus import abaqus_deck
from sheetmorph.twin.agreement import agree
from sheetmorph.twin.calculix import DeckOptions, Law
from sheetmorph.twin.natural import VOIGT
from sheetmorph.twin.sheet import Sheet
from sheetmorph.twin.solve import JOB, Twin, TwinOptions, solve_twin, write_twin

pytestmark = pytest.mark.skipif(
    shutil.which("ccx") is None, reason="CalculiX is not installed (apt-get install calculix-ccx)"
)

STRIP = """
name = "strip"
model = "laminate"

[outline]
kind = "rectangle"
width = "24 mm"
height = "3 mm"

[[layers]]
name = "film"
role = "active"
thickness = "0.3 mm"
young_modulus = "1 MPa"
poisson_ratio = 0.33

[[layers]]
name = "inert"
role = "inert"
thickness = "0.6 mm"
young_modulus = "3 MPa"
poisson_ratio = 0.33

[actuation]
eps_pre = -0.001
profile = "uniform"

[mesh]
size = "1.5 mm"
"""


def options(steps: int, law: Law = "natural") -> TwinOptions:
    return TwinOptions(DeckOptions(law, steps), time_limit=300.0)


def oblique(along: float, across: float) -> np.ndarray:
    """The stretch of a film along 30° and across."""
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    turn = np.array([[c, -s], [s, c]])
    return turn @ np.diag([along, across]) @ turn.T


OBLIQUE = {"actuation.transverse": -0.5, "actuation.direction": "30 deg"}


@pytest.mark.parametrize("thickening", ["volume_conserved", "none"])
def test_a_free_film_takes_its_natural_shape(tmp_path: Path, thickening: str) -> None:
    design = sm.Design.from_toml(FILM).with_values({**OBLIQUE, "laminate.thickening": thickening})
    twin = solve_twin(design, tmp_path, options(2))
    assert twin.completed
    flat = twin.mesh.nodes
    wanted = np.column_stack([flat[:, :2] @ oblique(0.8, 1.1), flat[:, 2]])
    found = align_to_reference(twin.positions[-1:], wanted)[0]
    np.testing.assert_allclose(found, wanted, atol=2e-8)


def turn_about_y(degrees: float) -> np.ndarray:
    angle = np.deg2rad(degrees)
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def stress_under(
    gradient: np.ndarray, folder: Path, law: Law = "natural", **values: object
) -> np.ndarray:
    """Stress xx, yy, zz, xy, xz, yz [Pa] at the points of a film that is so deformed, (n, 6)."""
    design = sm.Design.from_toml(FILM).with_values(values)
    folder.mkdir(exist_ok=True)
    _, solid, _ = write_twin(design, folder, DeckOptions(law, 1))
    moves = 1e3 * (solid.nodes @ gradient.T - solid.nodes)
    boundary = "*BOUNDARY\n" + "".join(
        f"{node},{axis + 1},{axis + 1},{value:.12g}\n"
        for node, move in enumerate(moves, 1)
        for axis, value in enumerate(move)
    )
    path = folder / f"{JOB}.inp"
    text = re.sub(r"\*CLOAD\n(\d.*\n)*", "", path.read_text("utf-8"))
    model, _, actuated, *_ = text.split("*STEP")
    actuated = actuated.replace("*NODE FILE", boundary + "*NODE FILE")
    actuated = actuated.replace("*END STEP", "*EL PRINT, ELSET=G1\nS\n*END STEP")
    path.write_text(model + "*STEP" + actuated, "utf-8")
    subprocess.run(["ccx", JOB], cwd=folder, check=True, capture_output=True, timeout=100)
    rows = [line.split() for line in (folder / f"{JOB}.dat").read_text("utf-8").splitlines()]
    values_there = [row[2:] for row in rows if len(row) == 8 and row[0].isdigit()]
    assert values_there
    return np.array(values_there, dtype=float)


def test_any_deformation_has_the_stress_of_the_law(tmp_path: Path) -> None:
    """Saint-Venant and Kirchhoff's law from a natural state with shear, in true stress."""
    gradient = np.eye(3) + 0.2 * np.random.default_rng(0).normal(size=(3, 3))
    found = stress_under(gradient, tmp_path, **OBLIQUE)
    natural = np.diag([0.0, 0.0, 1 / 0.88])
    natural[:2, :2] = oblique(0.8, 1.1)
    elastic = gradient @ np.linalg.inv(natural)
    green = 0.5 * (elastic.T @ elastic - np.eye(3))
    lame, shear = 1e6 * 0.3 / (1.3 * 0.4), 1e6 / 2.6
    second = lame * np.trace(green) * np.eye(3) + 2 * shear * green
    true = elastic @ second @ elastic.T / np.linalg.det(elastic)
    wanted = [true[i, j] for i, j in VOIGT]
    np.testing.assert_allclose(found, np.broadcast_to(wanted, found.shape), rtol=2e-6, atol=1.0)


@pytest.mark.parametrize("degrees", [0.0, 30.0, 90.0])
def test_a_film_in_its_natural_shape_has_no_stress_however_it_is_turned(
    tmp_path: Path, degrees: float
) -> None:
    gradient = turn_about_y(degrees) @ np.diag([0.8, 0.8, 1 / 0.64])
    assert np.abs(stress_under(gradient, tmp_path)).max() < 1e-2  # of 1 MPa


def test_expansion_of_a_still_film_is_the_engineering_strain(tmp_path: Path) -> None:
    gradient = np.eye(3)
    gradient[:2, :2] = oblique(0.8, 1.1)
    assert np.abs(stress_under(gradient, tmp_path, "expansion", **OBLIQUE)).max() < 1e-2


def test_expansion_sees_a_turn_as_strain(tmp_path: Path) -> None:
    """CalculiX takes the thermal strain e from F itself, and so from a turned one too.

    With F = (1 + e) R and R a turn by 90°, (F − e I)ᵀ (F − e I) = ((1 + e)² + e²) I in the
    plane of the turn: of e = −0.2 there is left a strain of ½ (0.68 − 1) = −0.16.
    """
    still = stress_under(0.8 * np.eye(3), tmp_path / "still", "expansion")
    assert np.abs(still).max() < 1e-2
    turned = stress_under(0.8 * turn_about_y(90.0), tmp_path / "turned", "expansion")
    found = float(np.abs(turned).max())
    if found < 1e-2:
        pytest.skip("this version of CalculiX has another law of expansion")
    lame, shear = 1e6 * 0.3 / (1.3 * 0.4), 1e6 / 2.6
    stress = 2 * lame * -0.16 + 2 * shear * -0.16  # second Piola and Kirchhoff's
    assert found == pytest.approx(abs(stress) / 0.8, rel=0.01)


def test_a_narrow_strip_has_timoshenkos_curvature(tmp_path: Path) -> None:
    twin = solve_twin(sm.Design.from_toml(STRIP), tmp_path, options(1))
    m, n, h = 0.5, 1 / 3, 0.9e-3
    wanted = 6e-3 * (1 + m) ** 2 / (h * (3 * (1 + m) ** 2 + (1 + m * n) * (m**2 + 1 / (m * n))))
    x, y, z = twin.positions[-1].T
    inner = np.abs(x) < 8e-3
    columns = np.column_stack([x**2 / 2, y**2 / 2, x * y, x, y, np.ones_like(x)])[inner]
    curvature = np.linalg.lstsq(columns, z[inner], rcond=None)[0][0]
    assert abs(curvature) == pytest.approx(wanted, rel=0.01)


@pytest.fixture(scope="module")
def rolled(tmp_path_factory: pytest.TempPathFactory) -> tuple[sm.Design, Twin]:
    """A strip that shrinks by 10 % and turns by 100° in all."""
    design = sm.Design.from_toml(STRIP).with_values({"actuation.eps_pre": -0.1})
    return design, solve_twin(design, tmp_path_factory.mktemp("rolled"), options(5))


@pytest.mark.slow
def test_the_laminate_model_agrees_at_large_rotation(rolled: tuple[sm.Design, Twin]) -> None:
    design, twin = rolled
    found = agree(design, twin).to_json()
    assert found["twin"]["ended"] == "completed"
    assert found["node_rms_percent_of_size"] < 0.5
    assert found["aspect_ratio"]["twin"] == pytest.approx(found["aspect_ratio"]["shape"], rel=0.02)


@pytest.mark.slow
def test_the_usual_deck_curls_less(rolled: tuple[sm.Design, Twin], tmp_path: Path) -> None:
    design, twin = rolled
    usual = solve_twin(design, tmp_path, options(5, "expansion"))
    assert usual.completed
    heights = [np.ptp(each.positions[-1][:, 2]) for each in (usual, twin)]
    assert heights[0] < 0.9 * heights[1]


def test_what_both_programs_know_of_the_abaqus_deck_is_read(tmp_path: Path) -> None:
    """CalculiX reads the deck of the paper without its ties and output, S3 for S3R."""
    text = "".join(abaqus_deck(Sheet.of(sm.Design.from_toml(BILAYER))))
    model, step = text.split("*STEP")
    model = re.sub(r"\*(TIE|AMPLITUDE)[^*]*", "", model).replace("TYPE=S3R", "TYPE=S3")
    model = re.sub(r"\*HEADING\n.*\n", "", model)
    loads = re.findall(r"(?:\*TEMPERATURE|\*CLOAD)[^*]*", step)
    loads = [re.sub(r", AMPLITUDE=\w+", "", part) for part in loads]
    (tmp_path / "shared.inp").write_text(
        model + "*STEP, NLGEOM\n*STATIC\n1e-3, 1e-3, 1e-6, 1e-3\n" + "".join(loads) + "*END STEP\n"
    )
    said = subprocess.run(
        ["ccx", "shared"], cwd=tmp_path, capture_output=True, text=True, timeout=100
    ).stdout
    assert "*ERROR reading" not in said
    assert "*WARNING reading" not in said
    assert "number of equations" in said
