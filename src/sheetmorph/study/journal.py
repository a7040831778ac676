"""States on disk as they are reached, so that a run that dies can go on."""

from __future__ import annotations

import json
import shutil
import zipfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sheetmorph import __version__
from sheetmorph.core.errors import InputError
from sheetmorph.core.files import GO_ON, REMEDY, replacing, write_text, writing
from sheetmorph.solve.path import PathState

FOLDER = "states"
_SCALARS = ("leg", "s", "step", "ramp", "load", "residual", "negative_pivots")


@dataclass(frozen=True)
class Journal:
    """The folder `states` of a run: one file per state, each whole or absent.

    Attributes:
        folder: where the states lie.
        outdated: files of an earlier run, removed when a new one begins.
    """

    folder: Path
    outdated: tuple[Path, ...] = ()

    @classmethod
    def of_run(cls, run_folder: Path, outdated: Iterable[Path] = ()) -> Journal:
        """The journal of a results folder; it may not exist yet."""
        return cls(run_folder / FOLDER, tuple(outdated))

    @property
    def exists(self) -> bool:
        """True when a run was begun here and not finished, and has states to go on from."""
        return (self.folder / "journal.json").is_file() and self._file(0).is_file()

    def begin(self, design_hash: str) -> None:
        """Start an empty journal; an old one and the outputs of its run are removed.

        Raises:
            OutputError: it cannot be written; the outputs are still there.
        """
        self.remove()
        write_text(
            self.folder / "journal.json",
            json.dumps({"design_hash": design_hash, "version": __version__}),
        )
        for path in self.outdated:
            with writing(path):
                path.unlink(missing_ok=True)

    def write(self, index: int, state: PathState) -> None:
        """Keep one state.

        Raises:
            OutputError: it cannot be written.
        """
        arrays: dict[str, Any] = {name: np.float64(getattr(state, name)) for name in _SCALARS}
        self.write_arrays(index, arrays | {"x": state.x, "tangent": state.tangent})

    def write_arrays(self, index: int, arrays: dict[str, Any]) -> None:
        """Keep one record of arrays.

        Raises:
            OutputError: it cannot be written.
        """
        with replacing(self._file(index), GO_ON if index else REMEDY) as partial:
            np.savez(partial, **arrays)

    def read(self, design_hash: str, size: int) -> list[PathState]:
        """The states of the unfinished run, in order; at least the first.

        Args:
            design_hash: of the design that is to go on.
            size: number of degrees of freedom.

        Raises:
            InputError: there is no journal, or it is of another design or version.
        """
        return [_read_state(path, size) for path in self.records(design_hash)]

    def records(self, design_hash: str) -> list[Path]:
        """The files of the unfinished run, in order; at least the first.

        Raises:
            InputError: as for `read`.
        """
        try:
            about = json.loads((self.folder / "journal.json").read_text("utf-8"))
            known, version = str(about["design_hash"]), str(about["version"])
        except (OSError, ValueError, KeyError, TypeError):
            raise InputError(
                "there is no unfinished run to resume here; run without --resume",
                file=self.folder.parent,
            ) from None
        if known != design_hash or version != __version__:
            what = "design" if known != design_hash else f"version of sheetmorph ({version})"
            raise InputError(
                f"the unfinished run here is of another {what}; run without --resume, or into "
                "another folder with -o",
                file=self.folder.parent,
            )
        files: list[Path] = []
        for index in range(100_000):
            path = self._file(index)
            if not path.is_file():
                break
            files.append(path)
        if not files:
            raise InputError(
                "the unfinished run here has no states yet; run without --resume",
                file=self.folder.parent,
            )
        return files

    def _file(self, index: int) -> Path:
        return self.folder / f"state_{index:05d}.npz"

    def remove(self) -> None:
        """Delete the journal; what is killed meanwhile leaves nothing that calls itself one."""
        with writing(self.folder):
            (self.folder / "journal.json").unlink(missing_ok=True)
        shutil.rmtree(self.folder, ignore_errors=True)


def read_arrays(path: Path, names: Iterable[str]) -> dict[str, NDArray[np.float64]]:
    """Arrays of a record by their names.

    Raises:
        InputError: it cannot be read, or lacks one.
    """
    try:
        with np.load(path, allow_pickle=False) as data:
            return {name: np.asarray(data[name], dtype=np.float64) for name in names}
    except (OSError, ValueError, KeyError, zipfile.BadZipFile, EOFError) as error:
        raise InputError(f"this state cannot be read ({error})", file=path) from None


def _read_state(path: Path, size: int) -> PathState:
    values: dict[str, Any] = dict(read_arrays(path, ("x", "tangent", *_SCALARS)))
    x, tangent = values.pop("x"), values.pop("tangent")
    values = {name: float(value) for name, value in values.items()}
    if x.shape != (size,) or tangent.shape != (size,) or not np.isfinite(x).all():
        raise InputError("this state does not fit the design's mesh", file=path)
    return PathState(
        x=x,
        tangent=tangent,
        leg=int(values["leg"]),
        s=values["s"],
        step=values["step"],
        ramp=values["ramp"],
        load=values["load"],
        residual=values["residual"],
        negative_pivots=int(values["negative_pivots"]),
    )
