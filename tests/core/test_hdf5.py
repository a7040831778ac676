"""Heaps of texts are walked through before the HDF5 library does it, which may not come back."""

from __future__ import annotations

import random
import struct
from pathlib import Path

import h5py
import pytest

from sheetmorph.core.hdf5 import open_hdf5

HEAP = b"GCOL\x01\0\0\0"


def texts(path: Path, seed: int) -> bytes:
    """A file with texts of variable length, some of them replaced; its bytes."""
    chance = random.Random(seed)
    with h5py.File(path, "w") as file:
        for k in range(seed):
            file.attrs[f"a{k}"] = "x" * chance.randrange(300)
            if chance.random() < 0.2:
                file.attrs[f"a{chance.randrange(k + 1)}"] = "y" * chance.randrange(500)
        file["long"] = ["z" * chance.randrange(1, 9000) for _ in range(chance.randrange(1, 9))]
    return path.read_bytes()


def last_piece(data: bytes, start: int) -> int:
    """Place of the free piece at the end of the first heap."""
    place = start + 16
    while True:
        number, _, _, length = struct.unpack_from("<HHIQ", data, place)
        if number == 0:
            return place
        place += 16 + -(-length // 8) * 8


@pytest.mark.parametrize("seed", [0, 1, 2, 5, 12, 30, 60])
def test_sound_heaps_are_opened(tmp_path: Path, seed: int) -> None:
    assert texts(tmp_path / "a.h5", seed).count(HEAP) >= 1
    with open_hdf5(tmp_path / "a.h5") as file:
        assert len(file.attrs) == seed


@pytest.mark.parametrize("length", [0, 8, 15, 10**6, 2**64 - 16])
def test_a_free_piece_of_another_length_is_refused(tmp_path: Path, length: int) -> None:
    """With 0 the library would go round for ever."""
    data = bytearray(texts(tmp_path / "a.h5", 5))
    piece = last_piece(data, data.index(HEAP))
    struct.pack_into("<Q", data, piece + 8, length)
    (tmp_path / "a.h5").write_bytes(data)
    with pytest.raises(OSError, match="heap of texts is damaged"):
        open_hdf5(tmp_path / "a.h5")


@pytest.mark.parametrize("size", [0, 15, 10**9, 2**64 - 1])
def test_a_heap_of_another_size_is_refused(tmp_path: Path, size: int) -> None:
    data = bytearray(texts(tmp_path / "a.h5", 5))
    struct.pack_into("<Q", data, data.index(HEAP) + 8, size)
    (tmp_path / "a.h5").write_bytes(data)
    with pytest.raises(OSError, match="heap of texts is damaged"):
        open_hdf5(tmp_path / "a.h5")


def test_what_is_cut_off_in_a_heap_is_refused(tmp_path: Path) -> None:
    data = texts(tmp_path / "a.h5", 5)
    for more in (8, 12, 20):
        (tmp_path / "a.h5").write_bytes(data[: data.index(HEAP) + more])
        with pytest.raises(OSError, match="heap of texts is"):
            open_hdf5(tmp_path / "a.h5")
    (tmp_path / "a.h5").write_bytes(b"")
    with pytest.raises(OSError, match="file signature not found"):
        open_hdf5(tmp_path / "a.h5")
