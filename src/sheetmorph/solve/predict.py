"""Where the next state of a path is expected: tangents at states and extrapolation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.solve.minimise import Minimum
from sheetmorph.solve.system import System

if TYPE_CHECKING:
    from sheetmorph.solve.path import PathState

Floats = NDArray[np.float64]

DIFFERENCE = 1e-4
"""Part of a leg over which forces are differenced where they are not linear along it."""

DOUBT = 0.03
"""Last correction of a tangent, over its size, beyond which the Hessian is factorised anew."""


def predict(system: System, known: Sequence[PathState], s: float) -> Floats:
    """Extrapolate: the cubic through the last two states of the leg and their tangents.

    With one state on the leg, along its tangent; without tangents, along the chord. Where the
    terms of the cubic do not fall off, as after a jump to another branch, the best of cubic,
    tangent and last state by energy.
    """
    last = known[-1]
    ds = s - last.s
    along = ds * last.tangent
    past = known[-2] if len(known) > 1 and known[-2].leg == last.leg else None
    if past is None:
        return last.x + along
    h = last.s - past.s
    chord = (last.x - past.x) / h
    if not last.tangent.any():
        return last.x + ds * chord
    if past.s == 0.0:
        return last.x + along
    second = (4.0 * last.tangent + 2.0 * past.tangent - 6.0 * chord) / h
    third = 6.0 * (last.tangent + past.tangent - 2.0 * chord) / (h * h)
    bend = ds * ds * (second / 2.0 + ds * third / 6.0)
    linear, reach = last.x + along, float(np.abs(along).max())
    if np.abs(bend).max() <= 0.5 * reach and reach <= 3.0 * ds * np.abs(chord).max():
        return linear + bend
    guesses = (system.toward(last.x, guess) for guess in (linear + bend, linear))
    return min((*guesses, last.x), key=system.value)


def tangent_of(
    here: System, place: tuple[float, float], along: tuple[float, float], found: Minimum
) -> Floats:
    """dx/ds at an equilibrium: the response to the change of the forces along the leg.

    Where the forces at fixed positions are linear in both fractions, one more gradient gives
    their derivative exactly; elsewhere a central difference does. The factor at hand is that of
    the last Newton step, a little way off; two corrections with the Hessian applied by
    differences of gradients make up for it, for a tenth of the price of a factorisation. Where
    the second still changes much, as for thin sheets that bend far with few Newton steps, the
    Hessian is factorised at the state itself: cubic prediction needs good tangents.
    """
    x, now = found.x, found.gradient
    (ramp, load), (rise, drop) = place, along
    if here.linear_in_ramp:
        rate = here.at(ramp + rise, load + drop).gradient(x)[1] - now
    else:
        ahead, behind = (
            here.at(ramp + part * rise, load + part * drop).gradient(x)[1]
            for part in (DIFFERENCE, -DIFFERENCE)
        )
        rate = (ahead - behind) / (2.0 * DIFFERENCE)
    tangent, doubt = _response(here, x, now, rate)
    if doubt > DOUBT:
        _, _, data = here.hessian(x)
        if here.factorise(data):
            tangent, _ = _response(here, x, now, rate)
    return tangent if np.isfinite(tangent).all() else np.zeros_like(x)


def _response(here: System, x: Floats, now: Floats, rate: Floats) -> tuple[Floats, float]:
    """Minus the inverse of the Hessian at x times a rate of the gradient, by the factor at hand.

    Returns:
        The response, shape (n,), and how much of it the last correction was.
    """
    tangent, doubt = -here.solve(rate), 0.0
    for _ in range(2):
        largest = float(np.abs(tangent).max())
        if not largest > 0.0:
            break
        reach = 1e-6 * float(np.ptp(x)) / largest
        _, moved = here.gradient(x + reach * tangent)
        change = here.solve(rate + (moved - now) / reach)
        tangent, doubt = tangent - change, float(np.abs(change).max()) / largest
    return tangent, doubt
