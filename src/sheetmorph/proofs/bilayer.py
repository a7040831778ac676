"""Known answers for strips of two layers that shrink differently."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sheetmorph.geometry.mesh import Floats


@dataclass(frozen=True)
class Bilayer:
    """Two layers, the first one below.

    Attributes:
        thicknesses: before actuation [m].
        moduli: Young's [Pa].
        mismatch: engineering strain of the lower layer left alone; the upper one has none.
        thickening: the lower layer keeps its volume, while its width stays.
    """

    thicknesses: tuple[float, float]
    moduli: tuple[float, float]
    mismatch: float
    thickening: bool = False

    @property
    def _natural(self) -> tuple[Floats, Floats]:
        """Stretches of the layers left alone, and heights of the faces above the middle [m]."""
        stretches = np.array([1.0 + self.mismatch, 1.0])
        heights = np.array(self.thicknesses) / (stretches if self.thickening else 1.0)
        faces = np.concatenate([[0.0], np.cumsum(heights)])
        return stretches, faces - 0.5 * faces[-1]


def timoshenko_curvature(layers: Bilayer) -> float:
    """Curvature of a narrow strip [1/m], positive where its ends rise: the upper face is concave.

    Timoshenko, Analysis of bi-metal thermostats, 1925; for small mismatch.
    """
    (lower, upper), (soft, stiff) = layers.thicknesses, layers.moduli
    m, n = lower / upper, soft / stiff
    shape = 3.0 * (1.0 + m) ** 2 + (1.0 + m * n) * (m * m + 1.0 / (m * n))
    return 6.0 * layers.mismatch * (1.0 + m) ** 2 / (shape * (lower + upper))


def circle_of_the_law(layers: Bilayer) -> float:
    """Curvature of the middle surface of a strip without Poisson's effect [1/m].

    The minimum, over the stretch λ and the curvature κ, of the layers' energy as the laminate
    model has it: the strain ½ (λ² − f²) − z λ² κ over f², f the stretch of the layer left alone.
    """
    stretches, faces = layers._natural
    matrix, right = np.zeros((2, 2)), np.zeros(2)
    for k, (modulus, f) in enumerate(zip(layers.moduli, stretches, strict=True)):
        low, high = faces[k], faces[k + 1]
        i0, i1, i2 = high - low, (high**2 - low**2) / 2.0, (high**3 - low**3) / 3.0
        weight = modulus * f / f**4
        matrix += weight * np.array([[i0, -i1], [-i1, i2]])
        right += weight * 0.5 * f * f * np.array([i0, -i1])
    half_metric, second = np.linalg.solve(matrix, right)
    return float(second / (2.0 * half_metric))


def circle_of_exact_fibres(layers: Bilayer) -> float:
    """The same with the exact length λ (1 − z κ) of the fibre at the height z [1/m]."""
    from scipy.optimize import minimize

    stretches, faces = layers._natural
    points, weights = np.polynomial.legendre.leggauss(6)
    thick = float(np.ptp(faces))

    def energy(unknown: Floats) -> float:
        total = 0.0
        for k, (modulus, f) in enumerate(zip(layers.moduli, stretches, strict=True)):
            half, centre = 0.5 * (faces[k + 1] - faces[k]), 0.5 * (faces[k + 1] + faces[k])
            length = unknown[0] * (1.0 - (centre + half * points) * unknown[1] / thick)
            strain = 0.5 * ((length / f) ** 2 - 1.0)
            total += modulus / max(layers.moduli) * f * half / thick * float(weights @ strain**2)
        return total

    start = [float(stretches.mean()), circle_of_the_law(layers) * thick]
    found = minimize(energy, start, method="BFGS", options={"gtol": 1e-11})
    return float(found.x[1]) / thick


def curvature_of_a_wide_strip(
    natural: float, width: float, thickness: float, poisson_ratio: float
) -> float:
    """Lengthwise curvature of a long strip that would curve alike both ways [1/m].

    Its cross-section is a beam on the elastic foundation that the lengthwise curvature makes of
    the membrane (Mansfield, The bending and stretching of plates, 1989, on anticlastic bending;
    Ashwell, 1950): D w'''' + E h κ² w = 0, with κ of least energy. Narrow strips have the
    natural curvature, wide ones 1 + ν times as much, for only their edges curve across.

    Args:
        natural: the natural curvature [1/m].
        width, thickness: [m].
        poisson_ratio: of all layers.
    """
    from scipy.optimize import brentq

    points, weights = np.polynomial.legendre.leggauss(200)
    y, share = 0.5 * width * points, 0.5 * width * weights
    softness = thickness**2 / (12.0 * (1.0 - poisson_ratio**2))  # D / (E h)

    def moment(curvature: float) -> float:
        rate = (curvature**2 / (4.0 * softness)) ** 0.25
        wave = np.append(y, 0.5 * width) * rate
        even = np.cosh(wave) * np.cos(wave), np.sinh(wave) * np.sin(wave)
        slopes = (
            np.sinh(wave) * np.cos(wave) - np.cosh(wave) * np.sin(wave),
            np.cosh(wave) * np.sin(wave) + np.sinh(wave) * np.cos(wave),
        )
        bend = -2.0 * rate**2 * even[1], 2.0 * rate**2 * even[0]
        rim = np.array([[bend[0][-1], bend[1][-1]], [-slopes[1][-1], slopes[0][-1]]])
        wanted = natural - poisson_ratio * (curvature - natural)
        a, b = np.linalg.solve(rim, [wanted, 0.0])
        deflection, across = a * even[0] + b * even[1], a * bend[0] + b * bend[1]
        bending = (curvature - natural) * width + poisson_ratio * share @ (across[:-1] - natural)
        return float(softness * bending + curvature * share @ deflection[:-1] ** 2)

    return float(brentq(moment, 0.5 * natural, (1.0 + 2.0 * poisson_ratio) * natural))
