"""Strains over the plan, from a table of places: actuation that is graded in space.

A file has one row per place under the titles `x [mm], y [mm], strain` (any unit of length); the
strain is an engineering strain, the same in all directions, as a number or under `[%]`. Lines that
begin with `#` are comments.
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

KEY = "actuation.field"
FEWEST = 4


@dataclass(frozen=True, eq=False)
class StrainField:
    """Free strains at n places of the plan.

    Attributes:
        name: for messages.
        places: [m], shape (n, 2), all different and not on one line.
        strain: engineering strain, shape (n,).
    """

    name: str
    places: Floats
    strain: Floats

    def at(self, points: Floats) -> Floats:
        """Strain at points of the plan [m], shape (N,).

        Linear between the places (on their Delaunay triangulation); outside of it, that of the
        nearest place.

        Args:
            points: shape (N, 2).
        """
        from scipy.interpolate import LinearNDInterpolator
        from scipy.spatial import cKDTree

        size = float(np.ptp(self.places, axis=0).max())
        found = np.asarray(LinearNDInterpolator(self.places / size, self.strain)(points / size))
        outside = ~np.isfinite(found)
        if outside.any():
            found[outside] = self.strain[cKDTree(self.places).query(points[outside])[1]]
        return found


def load_field(design: Design) -> StrainField:
    """The field that a design names.

    Raises:
        InputError: no such file, or no usable table; the message names the line.
    """
    name = design.actuation.field
    assert name is not None  # noqa: S101  the schema wants one with profile = "field"
    return load_table(design, name, KEY, parse_field)


def parse_field(text: str, name: str) -> StrainField:
    """Read a field from the text of a CSV file.

    Raises:
        InputError: other columns, fewer than four rows, places that coincide or lie on one line,
            or strains out of range; the message names the line.
    """
    table = parse_table(text)
    table.only(("x", "y", "strain"))
    x, y = table.numbers("x", "length"), table.numbers("y", "length")
    limits = f"above {LEAST:g} to {MOST:g}"
    strain = table.numbers("strain", "dimensionless", above=LEAST, most=MOST, limits=limits)
    places = np.column_stack([x, y])
    if len(places) < FEWEST:
        raise InputError(f"needs at least {FEWEST} rows")
    _, first, counts = np.unique(places, axis=0, return_index=True, return_counts=True)
    if (counts > 1).any():
        again = int(first[np.argmax(counts > 1)])
        raise InputError(f"line {table.lines[again]}: this place is there twice")
    spread = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    if not spread[1] > 1e-9 * spread[0]:
        raise InputError("all places lie on one line")
    return StrainField(name, places, strain)


def field_text(places: Floats, strain: Floats, comment: str = "") -> str:
    """The text of such a file, from which `parse_field` gets the same numbers.

    Args:
        places: [m], shape (n, 2).
        strain: shape (n,).
        comment: a line for people.
    """
    head = f"# {comment}\n" if comment else ""
    rows = "\n".join(
        f"{x!r},{y!r},{e!r}" for (x, y), e in zip(places.tolist(), strain.tolist(), strict=True)
    )
    return f"{head}x [m],y [m],strain\n{rows}\n"
