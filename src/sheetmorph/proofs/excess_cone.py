"""The cone with more than a full turn around its tip, which becomes a saddle of straight rays."""

from __future__ import annotations

import numpy as np

from sheetmorph.geometry.mesh import Floats

TERMS = 5
"""Terms of the latitude's series; five give five digits up to a growth of 1.2."""


def steepest_ray(ratio: float) -> float:
    """Height of the highest ray over its length, for two ridges and two valleys.

    The rays' directions run along a closed curve on the unit sphere, 2π λθ/λr long, of least
    ∫ κ² ds with its geodesic curvature κ: Müller, Ben Amar, Guven, Conical defects in growing
    sheets, Physical Review Letters 101, 2008. Here by a series of its latitude
    β = Σ a_k cos(2 (2k + 1) t), t = s λr/λθ, and its heading ψ from the east: dβ/ds = sin ψ,
    κ = dψ/ds + tan β cos ψ.

    Args:
        ratio: λθ/λr, above 1.
    """
    from scipy.optimize import minimize

    t = (np.arange(64) + 0.5) * 0.5 * np.pi / 64.0
    n = 2.0 * (2.0 * np.arange(TERMS) + 1.0)
    wave = np.outer(t, n)

    def curve(a: Floats) -> tuple[Floats, Floats]:
        """Geodesic curvature, and the rate of the longitude along the curve."""
        latitude = np.cos(wave) @ a
        rise = np.sin(wave) @ (-n * a) / ratio
        turn = np.cos(wave) @ (-n * n * a) / ratio**2
        east = np.sqrt(np.maximum(1.0 - rise * rise, 1e-9))  # trials may be too steep
        return turn / east + east * np.tan(latitude), east / np.cos(latitude)

    start = np.zeros(TERMS)
    start[0] = np.sqrt(4.0 / 3.0 * (ratio - 1.0))
    found = minimize(
        lambda a: float((curve(a)[0] ** 2).mean()),
        start,
        method="SLSQP",
        constraints=[{"type": "eq", "fun": lambda a: ratio * float(curve(a)[1].mean()) - 1.0}],
        options={"ftol": 1e-14, "maxiter": 500},
    )
    return float(np.sin(found.x.sum()))
