"""Finished designs on disk as they come, so that a sweep that dies can go on.

The journal is one SQLite file: a batch of designs is in it whole or not at all, the number of
a design is its key, and a second sweep at work in the folder is kept out by its lock.
"""

from __future__ import annotations

import io
import json
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError, OutputError
from sheetmorph.core.files import GO_ON, REMEDY, writing
from sheetmorph.sweep.task import Outcome

FILE = "unfinished.sqlite"
_SCHEMA = """
CREATE TABLE IF NOT EXISTS about (name TEXT PRIMARY KEY, value TEXT);
CREATE TABLE IF NOT EXISTS designs (number INTEGER PRIMARY KEY, line TEXT, arrays BLOB);
"""


class Journal:
    """The designs of an unfinished sweep; a context manager, or call `close`."""

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        """Use `begin` or `resume`."""
        self.path, self._connection = path, connection

    @classmethod
    def begin(cls, folder: Path, fingerprint: str) -> Self:
        """An empty journal; one that is there is removed.

        Raises:
            OutputError: it cannot be written.
            InputError: another sweep is at work in the folder.
        """
        path = folder / FILE
        if path.exists():
            cls._open(path).close()  # refused while another sweep holds it
        with writing(folder):
            _delete(path)
            folder.mkdir(parents=True, exist_ok=True)
        try:
            journal = cls._open(path)
            with journal._writing(REMEDY) as connection:
                connection.execute("INSERT INTO about VALUES ('fingerprint', ?)", (fingerprint,))
        except OutputError:
            with suppress(OSError):  # there is nothing in it to go on from
                _delete(path)
            raise
        return journal

    @classmethod
    def resume(cls, folder: Path, fingerprint: str) -> Self:
        """The journal that an unfinished sweep left.

        Raises:
            InputError: there is none, it is of another sweep or version, or it is damaged.
        """
        path = folder / FILE
        if not path.is_file():
            raise InputError(
                "there is no unfinished sweep to resume here; run without --resume", file=folder
            )
        journal = cls._open(path)
        query = "SELECT value FROM about WHERE name = 'fingerprint'"
        known = journal._connection.execute(query).fetchone()
        if known is None or known[0] != fingerprint:
            journal.close()
            raise InputError(
                "the unfinished sweep here is of another design, other values or another version; "
                "run with --force to start anew, or into another folder with -o",
                file=folder,
            )
        return journal

    @classmethod
    def _open(cls, path: Path) -> Self:
        try:
            connection = sqlite3.connect(path, timeout=0.5, isolation_level=None)
        except sqlite3.Error as error:
            raise OutputError(f"{path}: cannot be opened ({error}); {REMEDY}") from error
        try:
            connection.execute("PRAGMA locking_mode = EXCLUSIVE")
            connection.execute("BEGIN EXCLUSIVE")
            connection.execute("COMMIT")  # the lock stays
            connection.executescript(_SCHEMA)
        except sqlite3.DatabaseError as error:
            connection.close()
            if "locked" in str(error):
                raise InputError("another sweep is at work in this folder", file=path) from None
            if isinstance(error, sqlite3.OperationalError):
                raise OutputError(f"{path}: cannot be written ({error}); {REMEDY}") from error
            raise InputError(
                f"the unfinished sweep here is damaged ({error}); run with --force to start anew",
                file=path,
            ) from None
        return cls(path, connection)

    def keep(self, outcomes: Sequence[Outcome]) -> None:
        """Keep designs: all of them are on disk when this returns.

        Raises:
            OutputError: they cannot be written.
        """
        lines = [
            (int(one.row["index"]), json.dumps(one.row, ensure_ascii=False), _packed(one.arrays))
            for one in outcomes
        ]
        with self._writing() as connection:
            connection.executemany("INSERT OR IGNORE INTO designs VALUES (?, ?, ?)", lines)

    def numbers(self) -> set[int]:
        """The designs that are here."""
        return {row[0] for row in self._connection.execute("SELECT number FROM designs")}

    def rows(self) -> Iterator[dict[str, Any]]:
        """The rows of the table, in order."""
        for (line,) in self._connection.execute("SELECT line FROM designs ORDER BY number"):
            yield json.loads(line)

    def arrays(self) -> Iterator[tuple[int, dict[str, NDArray[Any]] | None]]:
        """Numbers and states of the designs, in order."""
        query = "SELECT number, arrays FROM designs ORDER BY number"
        for number, packed in self._connection.execute(query):
            yield number, _unpacked(packed)

    def remove(self) -> None:
        """Delete the journal."""
        self.close()
        self.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Let go of the file."""
        self._connection.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    @contextmanager
    def _writing(self, remedy: str = GO_ON) -> Iterator[sqlite3.Connection]:
        try:
            self._connection.execute("BEGIN IMMEDIATE")
            yield self._connection
            self._connection.execute("COMMIT")
        except sqlite3.DatabaseError as error:
            raise OutputError(f"{self.path}: cannot be written ({error}); {remedy}") from error


def _delete(path: Path) -> None:
    """Delete a journal, and that of SQLite beside it."""
    for old in (path, path.with_name(FILE + "-journal")):
        old.unlink(missing_ok=True)


def _packed(arrays: dict[str, NDArray[Any]] | None) -> bytes | None:
    if arrays is None:
        return None
    stream = io.BytesIO()
    np.savez(stream, **arrays)  # type: ignore[arg-type]  # its signature takes any array
    return stream.getvalue()


def _unpacked(packed: bytes | None) -> dict[str, NDArray[Any]] | None:
    if packed is None:
        return None
    with np.load(io.BytesIO(packed), allow_pickle=False) as data:
        return {name: data[name] for name in data.files}
