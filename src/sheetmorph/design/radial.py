"""Strains over the distance from a centre, from a table: growth that makes caps and saddles.

A file has one row per distance under the titles `r [mm], e_radial, e_hoop` (any unit of length);
the strains are engineering strains, as numbers or under `[%]`. Lines that begin with `#` are
comments.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.core.columns import parse_table
from sheetmorph.core.errors import InputError
from sheetmorph.design.strain_table import LEAST, MOST, load_table
from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design

KEY = "actuation.radial_profile"
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class RadialProfile:
    """Free strains along and around a centre, against the distance from it; n rows.

    Attributes:
        name: for messages.
        radii: [m], increasing, shape (n,).
        radial: engineering strain along the radius, shape (n,).
        hoop: engineering strain around the centre, shape (n,).
    """

    name: str
    radii: Floats
    radial: Floats
    hoop: Floats

    def at(self, radius: Floats) -> tuple[Floats, Floats]:
        """Strains at distances [m], by piecewise cubics that keep the monotony of the rows.

        Raises:
            InputError: a distance lies outside the table.
        """
        from scipy.interpolate import PchipInterpolator

        low, high = float(self.radii[0]), float(self.radii[-1])
        outside = (radius < low - _ROUNDING * high) | (radius > high * (1.0 + _ROUNDING))
        if outside.any():
            far = float(radius[np.argmax(outside)])
            raise InputError(
                f"the table {self.name} does not reach {1e3 * far:.6g} mm from the centre",
                key=KEY,
                allowed=f"{1e3 * low:.6g} to {1e3 * high:.6g} mm",
            )
        inside = np.clip(radius, low, high)
        strains = PchipInterpolator(self.radii, np.column_stack([self.radial, self.hoop]))(inside)
        return strains[:, 0], strains[:, 1]


def load_radial(design: Design) -> RadialProfile:
    """The radial profile that a design names.

    Raises:
        InputError: no such file, or no usable table; the message names the line.
    """
    name = design.actuation.radial_profile
    assert name is not None  # noqa: S101  the schema wants one with profile = "radial"
    return load_table(design, name, KEY, parse_radial)


def parse_radial(text: str, name: str) -> RadialProfile:
    """Read a radial profile from the text of a CSV file.

    Raises:
        InputError: other columns, fewer than two rows, distances that do not increase, or
            strains out of range; the message names the line.
    """
    table = parse_table(text)
    table.only(("r", "e_radial", "e_hoop"))
    radii = table.numbers("r", "length", least=0.0, limits="≥ 0")
    limits = f"above {LEAST:g} to {MOST:g}"
    radial, hoop = (
        table.numbers(title, "dimensionless", above=LEAST, most=MOST, limits=limits)
        for title in ("e_radial", "e_hoop")
    )
    if len(radii) < 2:
        raise InputError("needs at least two rows")
    falls = np.flatnonzero(np.diff(radii) <= 0)
    if len(falls):
        raise InputError(f"line {table.lines[int(falls[0]) + 1]}: r must increase")
    return RadialProfile(name, radii, radial, hoop)
