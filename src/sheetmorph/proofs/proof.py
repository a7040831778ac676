"""What a proof consists of: checks with a stated limit, and curves to draw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from sheetmorph.geometry.mesh import Floats

Kind = Literal["relative", "absolute", "at least", "at most"]


@dataclass(frozen=True)
class Check:
    """One number against a known one.

    Attributes:
        id: unique within its proof, such as "strip-m0.3-n3".
        what: the quantity, for people.
        expected: the known value, or the bound.
        found: what was computed; not a number where the computation failed.
        limit: largest relative or absolute error; not used by the bounds.
        kind: how the two are compared.
        unit: of both numbers, "" for plain ones.
    """

    id: str
    what: str
    expected: float
    found: float
    limit: float = 0.0
    kind: Kind = "relative"
    unit: str = ""

    @property
    def error(self) -> float:
        """Relative or absolute error; for bounds, by how much they are missed (≤ 0 is none)."""
        if self.kind == "at least":
            return self.expected - self.found
        if self.kind == "at most":
            return self.found - self.expected
        off = abs(self.found - self.expected)
        return off if self.kind == "absolute" else off / abs(self.expected)

    @property
    def passed(self) -> bool:
        """True when the number is within its limit; a number that is none is not."""
        return bool(self.error <= self.limit)


@dataclass(frozen=True, eq=False)
class Curve:
    """Points (x, y) of a plot: a known answer as a line, results as marks.

    Attributes:
        label: for the legend.
        x, y: shape (n,) each.
        style: "line" for what is known, "marks" for what was computed, "dashes" for guides.
    """

    label: str
    x: Floats
    y: Floats
    style: Literal["line", "marks", "dashes"] = "marks"


@dataclass(frozen=True, eq=False)
class Plot:
    """A picture of curves.

    Attributes:
        name: file name without ending, unique among all proofs.
        title, x_label, y_label: with units.
        curves: in the order of the legend.
        log: axes that are logarithmic, "", "x", "y" or "xy".
    """

    name: str
    title: str
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    log: Literal["", "x", "y", "xy"] = ""


@dataclass(frozen=True, eq=False)
class Proof:
    """A case with a known answer.

    Attributes:
        name: key of the case, such as "timoshenko".
        title: for people.
        statement: what is known, how it is computed here and on which meshes; paragraphs.
        source: where the known answer comes from.
        checks: numbers and limits.
        plots: pictures.
    """

    name: str
    title: str
    statement: str
    source: str
    checks: tuple[Check, ...]
    plots: tuple[Plot, ...] = ()
    notes: tuple[str, ...] = field(default=())

    @property
    def passed(self) -> bool:
        """True when every check is within its limit."""
        return all(check.passed for check in self.checks)


def convergence_order(sizes: Sequence[float] | Floats, errors: Sequence[float] | Floats) -> float:
    """Order p of errors ∝ size^p, the slope of a line through all points in logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(np.abs(errors)), 1)[0])
