"""The pulled-back law is Saint-Venant and Kirchhoff's of the natural state, for any deformation."""

from __future__ import annotations

import numpy as np
import pytest

from sheetmorph.twin.natural import (
    UPPER,
    VOIGT,
    natural_metric,
    natural_strain,
    pulled_back_stiffness,
)

YOUNG, POISSON = 2.0, 0.3
LAME = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
SHEAR = YOUNG / (2 * (1 + POISSON))
STRAINS = [(-0.3, -0.3, 0.0), (-0.4, 0.1, 0.0), (-0.2, -0.1, 0.08)]


def natural_stretch(strain: tuple[float, float, float], thickening: bool) -> np.ndarray:
    e11, e22, e12 = strain
    plane = np.array([[1 + e11, e12], [e12, 1 + e22]])
    stretch = np.zeros((3, 3))
    stretch[:2, :2] = plane
    stretch[2, 2] = 1 / np.linalg.det(plane) if thickening else 1.0
    return stretch


def voigt(tensor: np.ndarray) -> np.ndarray:
    """Strain with doubled shears, in the order of VOIGT."""
    doubled = np.array([1, 1, 1, 2, 2, 2])
    return np.array([tensor[i, j] for i, j in VOIGT]) * doubled


@pytest.mark.parametrize("thickening", [True, False])
@pytest.mark.parametrize("strain", STRAINS)
def test_the_energy_is_that_of_the_natural_state(
    strain: tuple[float, float, float], thickening: bool
) -> None:
    rng = np.random.default_rng(1)
    own = natural_stretch(strain, thickening)
    metric = natural_metric(np.array([strain]), thickening)
    matrix = np.zeros((6, 6))
    for (row, column), value in zip(
        UPPER, pulled_back_stiffness(metric, YOUNG, POISSON)[0], strict=True
    ):
        matrix[row, column] = matrix[column, row] = value
    free = natural_strain(metric)[0] * [1, 1, 1, 2, 2, 2]
    for _ in range(5):
        gradient = np.eye(3) + 0.3 * rng.normal(size=(3, 3))
        elastic = gradient @ np.linalg.inv(own)
        green = 0.5 * (elastic.T @ elastic - np.eye(3))
        wanted = 0.5 * LAME * np.trace(green) ** 2 + SHEAR * (green**2).sum()
        strained = voigt(0.5 * (gradient.T @ gradient - np.eye(3))) - free
        found = 0.5 * strained @ matrix @ strained
        assert found == pytest.approx(np.linalg.det(own) * wanted, rel=1e-12)


def test_a_layer_that_keeps_its_volume_thickens() -> None:
    metric = natural_metric(np.array([[-0.5, -0.5, 0.0]]))
    assert np.sqrt(metric[0, 2, 2]) == pytest.approx(4.0)
    assert natural_metric(np.array([[-0.5, -0.5, 0.0]]), False)[0, 2, 2] == 1.0


def test_the_order_of_constants_is_that_of_the_solver() -> None:
    names = ["".join(str(axis + 1) for place in pair for axis in VOIGT[place]) for pair in UPPER]
    assert names[:10] == [
        *("1111", "1122", "2222", "1133", "2233", "3333"),
        *("1112", "2212", "3312", "1212"),
    ]
    assert len(names) == 21
