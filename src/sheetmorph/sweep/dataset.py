"""A finished sweep, read back: a table, and the shape behind each of its rows."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sheetmorph.core.errors import InputError
from sheetmorph.sweep import states as stored
from sheetmorph.sweep import table as tables
from sheetmorph.sweep.extra import needed

if TYPE_CHECKING:
    import pyarrow as pa


@dataclass(eq=False)
class Sweep:
    """The folder of a sweep.

    It has a length and an entry for every design, which is all that a map-style data set of
    PyTorch needs: `torch.utils.data.DataLoader(Sweep.load("stars"), batch_size=None)`.

    Attributes:
        folder: where the files lie.
        about: what the table says of itself: format, versions, the sweep file, the design.
    """

    folder: Path
    about: dict[str, Any]
    _files: dict[int, Any] = field(default_factory=dict, repr=False)

    @classmethod
    def load(cls, folder: str | Path) -> Sweep:
        """Open a sweep; an unfinished one has the rows that were in the table last.

        Raises:
            InputError: there is none.
        """
        place = Path(folder)
        path = place / tables.FILE
        if not path.is_file():
            raise InputError(f"this folder holds no {tables.FILE} of a sweep", file=place)
        return cls(place, tables.read_about(path))

    @cached_property
    def table(self) -> pa.Table:
        """One row per design, see docs/sweeps.md for the columns."""
        with needed():
            import pyarrow.parquet as pq
        return pq.read_table(self.folder / tables.FILE)

    @cached_property
    def units(self) -> dict[str, str]:
        """SI units of the columns that have one."""
        return {
            entry.name: entry.metadata[b"unit"].decode()
            for entry in self.table.schema
            if entry.metadata and b"unit" in entry.metadata
        }

    def __len__(self) -> int:
        return int(self.table.num_rows)

    def __getitem__(self, place: int) -> dict[str, Any]:
        """Row and shape of a design.

        Returns:
            "row": from column to value; and, where states were kept, `nodes` (V, 3),
            `triangles` (T, 3), `in_pattern` (T,), `positions` (S, V, 3) [m], `ramp` (S,), all
            of length zero for designs without a shape.
        """
        if not -len(self) <= place < len(self):
            raise IndexError(place)
        row = self.table.slice(place % len(self), 1).to_pylist()[0]
        return {"row": row, **self._states(row["index"])}

    def rows_with_shape(self) -> list[int]:
        """Places of the rows whose states were kept."""
        numbers = self.table["index"].to_pylist()
        found = self._states(numbers[0]) if numbers else {}
        if not found:
            return []
        start = self._files[os.getpid()]["state_start"][()]
        return [place for place, k in enumerate(numbers) if start[k + 1] > start[k]]

    def _states(self, number: int) -> dict[str, Any]:
        path = self.folder / stored.FILE
        if not path.is_file():
            return {}
        process = os.getpid()  # an open HDF5 file must not be shared by processes
        if process not in self._files:
            self._files[process] = stored.open_states(path)
        return stored.read_states(self._files[process], number)

    def __getstate__(self) -> dict[str, Any]:
        return {"folder": self.folder, "about": self.about, "_files": {}}
