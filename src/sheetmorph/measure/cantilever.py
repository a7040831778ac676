"""Young's modulus and nominal stiffness from cantilever tests, by weight or a force at the tip.

A file of readings has one row per sample, with the columns `length`, `width`, `thickness`,
`deflection`, and `density` (the strip bends by its own weight) or `force` (at its tip), each with
its unit in brackets; `± length [mm]` and so on give uncertainties.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sheetmorph.core.columns import Table, parse_table, read_text
from sheetmorph.core.errors import InputError
from sheetmorph.core.units import Kind
from sheetmorph.geometry.mesh import Floats
from sheetmorph.measure.elastica import LARGEST, Loading, load_exponent, load_number

GRAVITY = 9.80665
"""Standard gravity [m/s²]."""

MAX_ROWS = 10_000
SMALL = 0.1
"""Tip deflection over length from which on the small-deflection formulas are told to be off."""

_QUANTITIES: dict[str, tuple[Kind, float, float, str]] = {
    "length": ("length", 1e-6, 100.0, "1 um to 100 m"),
    "width": ("length", 1e-6, 100.0, "1 um to 100 m"),
    "thickness": ("length", 1e-8, 1.0, "10 nm to 1 m"),
    "deflection": ("length", 1e-9, 100.0, "1 nm to 100 m"),
    "density": ("density", 0.1, 30_000.0, "0.1 kg/m^3 to 30000 kg/m^3"),
    "force": ("force", 1e-9, 1e6, "1 nN to 1e6 N"),
}
_LOADS: dict[Loading, str] = {"self_weight": "density", "end_load": "force"}
_ALIASES = {"tip deflection": "deflection", "± tip deflection": "± deflection"}


@dataclass(frozen=True, eq=False)
class CantileverRows:
    """Readings of strips that are clamped level at one end; n rows.

    Attributes:
        loading: "self_weight" or "end_load".
        samples: names of the samples, n of them.
        readings: `length`, `width`, `thickness`, `deflection` [m], and `density` [kg/m³] or
            `force` [N], each of shape (n,).
        uncertainties: standard uncertainties of some of them, in their units, shape (n,).
    """

    loading: Loading
    samples: tuple[str, ...]
    readings: dict[str, Floats]
    uncertainties: dict[str, Floats]

    @property
    def second_moment(self) -> Floats:
        """I = b h³/12 [m⁴], shape (n,)."""
        return np.asarray(self.readings["width"] * self.readings["thickness"] ** 3 / 12.0)

    @property
    def load(self) -> Floats:
        """Total load [N], shape (n,): the weight ρ g b h L, or the force."""
        r = self.readings
        if self.loading == "end_load":
            return r["force"]
        return np.asarray(r["density"] * GRAVITY * r["width"] * r["thickness"] * r["length"])

    @property
    def deflection_ratio(self) -> Floats:
        """δ/L, shape (n,)."""
        return np.asarray(self.readings["deflection"] / self.readings["length"])


@dataclass(frozen=True)
class Summary:
    """Mean and standard deviation of samples.

    Attributes:
        mean: of the rows.
        deviation: standard deviation, with n − 1 in the denominator.
        count: n.
    """

    mean: float
    deviation: float
    count: int

    @classmethod
    def of(cls, values: Floats) -> Summary:
        """Summary of at least two values, shape (n,)."""
        return cls(float(np.mean(values)), float(np.std(values, ddof=1)), len(values))


@dataclass(frozen=True, eq=False)
class CantileverResult:
    """What the rows say about the material; n rows.

    Attributes:
        rows: the readings.
        large_deflection: True when the moduli are exact for large deflections.
        young_modulus: E of each row [Pa], shape (n,).
        modulus_uncertainty: of each E, by those of the readings to first order [Pa], shape
            (n,); None where no uncertainty is given.
        stiffness: nominal stiffness, total load over deflection [N/m], shape (n,).
        overestimate: by what fraction the small-deflection formula makes E too large, (n,).
        modulus: mean and standard deviation of E [Pa].
        nominal_stiffness: those of the stiffness [N/m].
        second_moment: those of I [m⁴].
    """

    rows: CantileverRows
    large_deflection: bool
    young_modulus: Floats
    modulus_uncertainty: Floats | None
    stiffness: Floats
    overestimate: Floats
    modulus: Summary
    nominal_stiffness: Summary
    second_moment: Summary

    @property
    def warnings(self) -> tuple[str, ...]:
        """What to know before these numbers are used, in sentences."""
        found = []
        ratio = self.rows.deflection_ratio
        worst = int(np.argmax(self.overestimate))
        if ratio[worst] > SMALL and not self.large_deflection:
            found.append(
                f"the deflection is up to {ratio[worst]:.2g} of the length, not small: the formula "
                f"makes E too large by up to {100 * self.overestimate[worst]:.1f} % (on average "
                f"{100 * float(self.overestimate.mean()):.1f} %); --large-deflection corrects it"
            )
        slender = self.rows.readings["thickness"] / self.rows.readings["length"]
        if slender.max() > 0.1:
            found.append(
                f"a strip is {slender.max():.2g} as thick as long: shear and the clamp make E "
                "too small"
            )
        return tuple(found)


def read_cantilever(path: str | Path) -> CantileverRows:
    """Readings of a CSV file, see `parse_cantilever`.

    Raises:
        InputError: the file cannot be read, or as for `parse_cantilever`.
    """
    file = Path(path)
    text = read_text(file)
    try:
        return parse_cantilever(text)
    except InputError as error:
        raise error.located(file) from None


def parse_cantilever(text: str) -> CantileverRows:
    """Readings from the text of a CSV file.

    Raises:
        InputError: a column or a unit is missing, a cell is no positive number, a deflection
            is larger than 0.9 of its length, or there are fewer than two rows; the message
            names line and column.
    """
    table = parse_table(text, max_rows=MAX_ROWS)
    known = [*_QUANTITIES, *_ALIASES, *(f"± {name}" for name in _QUANTITIES), "sample", "note"]
    table.only(known)
    loading = _loading(table)
    names = ["length", "width", "thickness", _LOADS[loading], "deflection"]
    readings = {name: _column(table, name) for name in names}
    ratio = readings["deflection"] / readings["length"]
    if (ratio > LARGEST).any():
        row = int(np.argmax(ratio > LARGEST))
        raise InputError(
            f"line {table.lines[row]}, column deflection: is {ratio[row]:.2g} of the length: the "
            "strip hangs, and its modulus cannot be told",
            allowed=f"≤ {LARGEST} of the length",
        )
    if len(table) < 2:
        raise InputError("has one row; a standard deviation needs at least two")
    uncertainties = {
        name: _column(table, f"± {name}", name) for name in names if _has(table, f"± {name}")
    }
    labels = (word or str(number) for number, word in enumerate(table.words("sample"), 1))
    return CantileverRows(loading, tuple(labels), readings, uncertainties)


def evaluate_cantilever(
    rows: CantileverRows, *, large_deflection: bool = False
) -> CantileverResult:
    """Young's modulus and nominal stiffness of every row, and their statistics.

    By the formulas of the paper ("Young's Modulus and Nominal Stiffness"), which hold for small
    deflections: E = q L⁴/(8 I δ) with the weight per length q = ρ g b h, or E = P L³/(3 I δ). The
    nominal stiffness is q L/δ = 8 E I/L³, or P/δ = 3 E I/L³.

    Args:
        rows: the readings.
        large_deflection: take E from the elastica instead, exact for a thin strip that is
            clamped level. The nominal stiffness is a ratio of readings and stays as it is.
    """
    length, ratio = rows.readings["length"], rows.deflection_ratio
    factor = 8.0 if rows.loading == "self_weight" else 3.0
    small = factor * ratio
    exact = load_number(ratio, rows.loading)
    # Γ = (total load) L²/(E I) in both tests.
    number = exact if large_deflection else small
    young_modulus = rows.load * length**2 / (rows.second_moment * number)
    exponent = load_exponent(ratio, rows.loading) if large_deflection else np.ones(len(ratio))
    stiffness = rows.load / rows.readings["deflection"]
    return CantileverResult(
        rows=rows,
        large_deflection=large_deflection,
        young_modulus=young_modulus,
        modulus_uncertainty=_propagated(rows, young_modulus, exponent),
        stiffness=stiffness,
        overestimate=exact / small - 1.0,
        modulus=Summary.of(young_modulus),
        nominal_stiffness=Summary.of(stiffness),
        second_moment=Summary.of(rows.second_moment),
    )


def _loading(table: Table) -> Loading:
    density, force = "density" in table, "force" in table
    if density and force:
        raise InputError(
            f"line {table.head}: density (self-weight) and force (at the tip) exclude each "
            "other; keep one of them"
        )
    if not density and not force:
        raise InputError(
            f"line {table.head}: there is no column density [kg/m^3] (bent by its own weight) or "
            "force [N] (at the tip)"
        )
    return "self_weight" if density else "end_load"


def _has(table: Table, name: str) -> bool:
    return any(title in table for title in (name, *_titles_like(name)))


def _titles_like(name: str) -> list[str]:
    return [alias for alias, meant in _ALIASES.items() if meant == name]


def _column(table: Table, name: str, quantity: str | None = None) -> Floats:
    """A column [SI], by its name or another name for it; shape (n,)."""
    title = next((alias for alias in _titles_like(name) if alias in table), name)
    kind, least, most, limits = _QUANTITIES[quantity or name]
    if quantity is not None:
        return table.numbers(title, kind, least=0.0, most=most, limits="≥ 0")
    return table.numbers(title, kind, least=least, most=most, limits=limits)


def _propagated(rows: CantileverRows, young_modulus: Floats, exponent: Floats) -> Floats | None:
    """Uncertainty of E [Pa] to first order, of independent readings; shape (n,)."""
    if not rows.uncertainties:
        return None
    # E ∝ (load) L² / (b h³ Γ(δ/L)), where Γ grows with the power `exponent` of its argument.
    powers: dict[str, Floats | float] = {"deflection": -exponent}
    if rows.loading == "self_weight":
        powers |= {"density": 1.0, "length": 3.0 + exponent, "thickness": -2.0, "width": 0.0}
    else:
        powers |= {"force": 1.0, "length": 2.0 + exponent, "thickness": -3.0, "width": -1.0}
    squares = sum(
        (powers[name] * error / rows.readings[name]) ** 2
        for name, error in rows.uncertainties.items()
    )
    return np.asarray(young_modulus * np.sqrt(squares))
