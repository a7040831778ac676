"""HDF5 files: whole or absent, even where the disk has no room; damaged ones end no reader.

The HDF5 library (1.14 and 2.0) ends the process with a segmentation fault when it closes a file
that it could not write to its end. So it never learns of it: it writes into a file of ours, which
keeps in memory what the disk does not take, and says so when the library is done.

Reading, it goes round for ever in a heap of texts of variable length whose last piece says that
it is empty. So the heaps are walked through before the library sees the file.
"""

from __future__ import annotations

import io
import mmap
import os
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sheetmorph.core.files import REMEDY, replacing


@contextmanager
def writing_hdf5(
    path: str | Path, remedy: str = REMEDY
) -> Iterator[tuple[Any, Callable[[], None]]]:
    """Write an HDF5 file, whole or not at all.

    Args:
        path: the file.
        remedy: what to do where it cannot be written.

    Yields:
        The open `h5py.File`, and a function that raises where the disk has taken no more; call
        it now and then while much is written, for what is not taken stays in memory.

    Raises:
        OutputError: it cannot be written.
    """
    import h5py

    with replacing(path, remedy) as partial, partial.open("r+b", buffering=0) as stream:
        sink = Sink(stream)
        try:
            with h5py.File(sink, "w") as file:
                yield file, sink.check
        except RuntimeError as error:  # of h5py, where it does not say OSError
            sink.check()
            raise OSError(str(error)) from error
        sink.check()


def open_hdf5(path: Path) -> Any:
    """The open `h5py.File`, for reading.

    Raises:
        OSError: it is none, or damaged.
    """
    import h5py

    _check_heaps(path)
    return h5py.File(path, "r")


_HEAP = b"GCOL\x01\0\0\0"
_PIECE = 16
"""Bytes at the head of a heap, and of each piece in it, which are filled up to eights."""


def _check_heaps(path: Path) -> None:
    """Walk through all global heaps (HDF5 file format specification, III.E)."""
    with path.open("rb") as stream:
        if os.fstat(stream.fileno()).st_size == 0:
            return
        with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
            start = data.find(_HEAP)
            while start >= 0:
                _check_heap(data, start)
                start = data.find(_HEAP, start + 1)


def _check_heap(data: mmap.mmap, start: int) -> None:
    if start + _PIECE > len(data):
        raise OSError("a heap of texts is cut off")
    (size,) = struct.unpack_from("<Q", data, start + 8)
    place, end = start + _PIECE, start + size
    if not start + _PIECE <= end <= len(data):
        raise OSError("a heap of texts is damaged")
    while place + _PIECE <= end:
        number, _, _, length = struct.unpack_from("<HHIQ", data, place)
        # What is free comes last, and counts its own head.
        place += length if number == 0 else _PIECE + -(-length // 8) * 8
        if place > end or (number == 0 and place != end):
            raise OSError("a heap of texts is damaged")


class Sink:
    """A binary file that never refuses to be written; what it could not keep, it remembers.

    Args:
        stream: an unbuffered file, open for reading and writing.
    """

    def __init__(self, stream: io.FileIO) -> None:
        self._stream, self._at, self._end = stream, 0, 0
        self._failure: OSError | None = None
        self._kept: list[tuple[int, bytes]] = []

    def check(self) -> None:
        """Raise what the system said first against writing.

        Raises:
            OSError: the disk took no more.
        """
        if self._failure is not None:
            raise self._failure

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Move, as every file does."""
        self._at = offset + (0, self._at, self._end)[whence]
        return self._at

    def tell(self) -> int:
        """The place of the next byte."""
        return self._at

    def write(self, data: Any) -> int:
        """Write all of it: on the disk, or into memory once the disk has refused."""
        view = memoryview(data).cast("B")
        if self._failure is None:
            try:
                self._stream.seek(self._at)
                rest = view
                while rest:
                    rest = rest[self._stream.write(rest) :]
            except OSError as error:
                self._failure = error
        if self._failure is not None:
            self._kept.append((self._at, bytes(view)))
        self._at += len(view)
        self._end = max(self._end, self._at)
        return len(view)

    def readinto(self, buffer: Any) -> int:
        """Read what was written, wherever it is."""
        view, begin = memoryview(buffer).cast("B"), self._at
        self._stream.seek(begin)
        done = 0
        while done < len(view) and (count := self._stream.readinto(view[done:])):
            done += count
        view[done:] = bytes(len(view) - done)
        for place, data in self._kept:
            low, high = max(place, begin), min(place + len(data), begin + len(view))
            if low < high:
                view[low - begin : high - begin] = data[low - place : high - place]
        self._at += len(view)
        return len(view)

    def read(self, size: int) -> bytes:
        """Read so many bytes."""
        data = bytearray(size)
        self.readinto(data)
        return bytes(data)

    def truncate(self, size: int) -> int:
        """Set the length."""
        if self._failure is None:
            try:
                self._stream.truncate(size)
            except OSError as error:
                self._failure = error
        self._end = size
        return size

    def flush(self) -> None:
        """Nothing is held back."""
