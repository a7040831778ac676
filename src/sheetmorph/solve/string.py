"""The lowest way from one minimum to another, and the saddle on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import ComputationError
from sheetmorph.solve.critical import stationary
from sheetmorph.solve.stability import negative_eigenvalues
from sheetmorph.solve.system import System

Floats = NDArray[np.float64]

ARMIJO = 1e-4
SETTLED = 0.003
"""Change of the highest energy in a sweep, over the barrier, below which the saddle is sought."""
DAMPING = 0.5
"""Part of a Newton step that an image takes: in the metric C whole ones overshoot."""
UNEVEN = 1.6
"""Longest over shortest distance of neighbours beyond which images are spread anew: splines
between thin shells stretch them, so that this is not done without need."""
PATIENCE = 5
"""Sweeps for which it has to stay below."""
ATTEMPT = 20
"""Sweeps after which it is sought in any case: coarse strings may keep trembling."""
OFF = 0.3
"""A saddle whose energy is farther from the highest on the string, over the barrier, is another."""


@dataclass(frozen=True)
class StringOptions:
    """How the way is sought.

    Attributes:
        tolerance: largest residual force at the saddle [N].
        images: states on the string, the two minima included.
        sweeps: most times that the images are put back at equal distances.
        descents: steps of all images after each.
        halvings: of a step.
    """

    tolerance: float
    images: int = 15
    sweeps: int = 60
    descents: int = 4
    halvings: int = 12


@dataclass(frozen=True, eq=False)
class Passage:
    """A way between two minima.

    Attributes:
        images: states on the way, shape (N, n).
        energies: their energies, shape (N,) [J].
        top: the saddle; the highest state on the string where none was found, shape (n,).
        energy: of the top [J].
        negative: negative eigenvalues of the Hessian there.
        converged: True where the top is an equilibrium.
        sweeps: how often all images were put back.
    """

    images: Floats
    energies: Floats
    top: Floats
    energy: float
    negative: int
    converged: bool
    sweeps: int

    @property
    def height(self) -> float:
        """Energy of the top over that of the first minimum [J]."""
        return self.energy - float(self.energies[0])

    @property
    def back(self) -> float:
        """Energy of the top over that of the second minimum [J]."""
        return self.energy - float(self.energies[-1])


def passage(
    system: System,
    first: Floats,
    second: Floats,
    options: StringOptions,
    weights: Floats | None = None,
    shares: Floats | None = None,
) -> Passage:
    """Find the lowest way between two minima.

    The string method (E, Ren and Vanden-Eijnden 2007) with a metric of its own: each image descends
    along C⁻¹ g, the part along the string taken out, where C is the positive semidefinite part of
    the Hessian, so that stiff directions do not bound the step. The way thus found is that of
    steepest descent in the metric C; its saddle is the same. Images are put back at equal
    distances by cubic splines. Where the highest energy has settled, Newton's method without
    safeguards goes to the saddle, which counts where it has one negative eigenvalue and about
    the highest energy on the string.

    Args:
        system: the problem, at its ramp and load.
        first, second: the minima, shape (n,).
        options: limits.
        weights: of the squares in distances along the string, shape (n,); ones when None.
        shares: of the second minimum in the images of the first guess, from 0 to 1 for each degree
            of freedom, shape (images, n); equal steps on the straight line when None.

    Raises:
        ComputationError: the two are the same state, or the energy is not finite between them.
    """
    weight = np.ones(len(first)) if weights is None else weights
    if not float(weight @ (second - first) ** 2) > 0.0:
        raise ComputationError("there is no way between a state and itself")
    if shares is None:
        shares = np.linspace(0.0, 1.0, options.images)[:, None]
    images = (1.0 - shares) * first + shares * second
    highest, calm, sweep = np.inf, 0, 0
    for sweep in range(1, options.sweeps + 1):
        images = _spread(images, weight)
        for _ in range(options.descents):
            images = _descended(system, images, options, weight)
        energies = np.array([system.value(x) for x in images])
        if not np.isfinite(energies).all():
            raise ComputationError("the energy between two states is not a finite number")
        barrier = energies.max() - max(energies[0], energies[-1])
        calm = calm + 1 if abs(energies.max() - highest) <= SETTLED * barrier else 0
        highest = float(energies.max())
        if calm >= PATIENCE or (sweep % ATTEMPT == 0 and barrier > 0.0):
            saddle = _saddle(system, images, energies, options.tolerance, weight)
            if saddle is not None:
                return Passage(images, energies, *saddle, True, sweep)
            calm = 0
    energies = np.array([system.value(x) for x in images])
    top = images[int(energies.argmax())]
    return Passage(
        images,
        energies,
        top,
        float(energies.max()),
        negative_eigenvalues(system, top),
        False,
        sweep,
    )


def _descended(system: System, images: Floats, options: StringOptions, weight: Floats) -> Floats:
    """Each image but the ends one step down across the string, no longer than to its neighbours."""
    moved = images.copy()
    levels = np.array([system.value(x) for x in images])
    for k in range(1, len(images) - 1):
        x = images[k]
        energy, gradient, data = system.hessian(x, convex=True)
        along = _tangent(images[k - 1 : k + 2], levels[k - 1 : k + 2])
        along[system.held.held] = 0.0
        shift = 0.0
        while not system.factorise(data, shift):
            shift = max(30.0 * shift, 1e-12 * float(np.abs(data[system.held.diagonal]).max()))
        down = -system.solve(gradient)
        stiff = _product(system, data, along, shift)
        if (norm := float(along @ stiff)) > 0.0:
            down = down + along * (float(along @ gradient) / norm)
        slope = float(down @ gradient)
        reach = 0.5 * float(np.sqrt(weight @ (images[k + 1] - images[k - 1]) ** 2))
        size = float(np.sqrt(weight @ down**2))
        step = min(DAMPING, reach / size) if size > 0.0 else DAMPING
        for _ in range(options.halvings):
            if system.value(x + step * down) <= energy + ARMIJO * step * slope:
                moved[k] = x + step * down
                break
            step *= 0.5
    return moved


def _tangent(images: Floats, levels: Floats) -> Floats:
    """Direction of the string at the middle of three images, towards the higher neighbour.

    Central differences make kinks; so both sides count at the highest and the lowest images alone
    (Henkelman and Jónsson 2000).
    """
    back, ahead = images[1] - images[0], images[2] - images[1]
    fall, rise = levels[1] - levels[0], levels[2] - levels[1]
    if fall * rise > 0.0:
        return np.asarray(ahead if rise > 0.0 else back)
    most, least = max(abs(fall), abs(rise)), min(abs(fall), abs(rise))
    ahead_first = levels[2] > levels[0]
    parts = (most, least) if ahead_first else (least, most)
    return np.asarray(parts[0] * ahead + parts[1] * back if most > 0.0 else ahead + back)


def _product(system: System, data: Floats, vector: Floats, shift: float) -> Floats:
    from sheetmorph.solve.linear import symmetric_product

    pattern = system.energy.pattern
    product = symmetric_product(pattern.indptr, pattern.indices, data, vector)
    return np.asarray(product + shift * vector)


def _spread(images: Floats, weight: Floats) -> Floats:
    """The images at equal distances along the curve through them, where they are too uneven."""
    from scipy.interpolate import CubicSpline

    lengths = np.sqrt(np.diff(images, axis=0) ** 2 @ weight)
    places = np.concatenate([[0.0], np.cumsum(lengths)])
    if lengths.max() <= UNEVEN * lengths.min() or not (np.diff(places) > 0.0).all():
        return images
    spread = CubicSpline(places, images)(np.linspace(0.0, places[-1], len(images)))
    spread[0], spread[-1] = images[0], images[-1]
    return np.asarray(spread)


def _saddle(
    system: System, images: Floats, energies: Floats, tolerance: float, weight: Floats
) -> tuple[Floats, float, int] | None:
    """The saddle next to the highest place of the curve; None where Newton finds another point."""
    from scipy.interpolate import CubicSpline

    places = np.linspace(0.0, 1.0, len(images))
    fine = np.linspace(0.0, 1.0, 20 * len(images))
    curve = CubicSpline(places, energies)
    guess = CubicSpline(places, images)(fine[int(curve(fine).argmax())])
    x = stationary(system, guess, tolerance, most=50)
    if x is None:
        return None
    energy = system.value(x)
    highest, ends = float(energies.max()), max(energies[0], energies[-1])
    if not abs(energy - highest) <= OFF * (highest - ends):
        return None
    negative = negative_eigenvalues(system, x)
    return (x, energy, negative) if negative == 1 else None
