"""Moments of a motion on disk as they are reached, so that a run that dies can go on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.solve.inertia import Moment
from sheetmorph.study.journal import Journal, read_arrays
from sheetmorph.study.ledger import Ledger

_VECTORS = ("x", "velocity", "acceleration")
_SCALARS = ("index", "time", "step", "residual", "dissipated")


@dataclass(eq=False)
class MotionJournal:
    """A journal with a record for each moment that is kept.

    A record holds the moment, the rows of the history since the one before, and the largest
    energy so far: all that the rest of the motion depends on.

    Attributes:
        journal: where; None keeps nothing.
        design_hash: of the design.
        written: number of records.
        rows: number of rows of the history in them.
    """

    journal: Journal | None
    design_hash: str
    written: int = 0
    rows: int = 0

    def begin(self) -> None:
        """Start anew."""
        if self.journal is not None:
            self.journal.begin(self.design_hash)

    def write(self, moment: Moment, ledger: Ledger) -> None:
        """Keep a moment.

        Raises:
            OutputError: it cannot be written.
        """
        if self.journal is None:
            return
        arrays: dict[str, Any] = {name: getattr(moment, name) for name in _VECTORS}
        arrays |= {name: np.float64(getattr(moment, name)) for name in _SCALARS}
        arrays["rows"] = np.array(ledger.rows[self.rows :])
        self.journal.write_arrays(self.written, arrays)
        self.written, self.rows = self.written + 1, len(ledger.rows)

    def read(self, ledger: Ledger, size: int) -> list[Moment]:
        """The moments of the unfinished run, in order; their rows go into the ledger.

        Args:
            ledger: an empty one.
            size: number of degrees of freedom.

        Raises:
            InputError: there is no journal, or it is of another design or version.
        """
        if self.journal is None:
            raise InputError("there is no journal from which to go on")
        moments: list[Moment] = []
        for path in self.journal.records(self.design_hash):
            data = read_arrays(path, (*_VECTORS, *_SCALARS, "rows"))
            if any(data[name].shape != (size,) for name in _VECTORS):
                raise InputError("this state does not fit the design's mesh", file=path)
            x, velocity, acceleration = (data[name] for name in _VECTORS)
            index, time, step, residual, dissipated = (float(data[name]) for name in _SCALARS)
            moments.append(
                Moment(int(index), time, x, velocity, acceleration, step, residual, dissipated)
            )
            ledger.take(data["rows"])
        self.written, self.rows = len(moments), len(ledger.rows)
        return moments
