"""Messages as bytes: a head of JSON, then arrays. Nothing in them is ever run or unpickled.

A packet is the length of its head as an unsigned 32-bit number (little-endian), the head as
UTF-8, spaces up to a multiple of four bytes, and a body. A stream of packets has the length of
each packet in front of it.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

MAX_PACKET = 512 * 2**20
_LENGTH = struct.Struct("<I")


def pack(head: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]] | None = None) -> bytes:
    """A packet.

    Args:
        head: what JSON can say; numbers must be finite.
        arrays: sent as 32-bit numbers: floats as they are, whole numbers and truth values
            unsigned. The head says under `arrays` for each its type, shape and place in the body.
    """
    parts: list[bytes] = []
    told, offset = {}, 0
    for name, array in (arrays or {}).items():
        whole = array.dtype.kind in "bui"
        data = np.ascontiguousarray(array, dtype="<u4" if whole else "<f4").tobytes()
        told[name] = {"type": "u4" if whole else "f4", "shape": array.shape, "at": offset}
        parts.append(data)
        offset += len(data)
    content = {**head, "arrays": told} if arrays else dict(head)
    text = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    line = text.encode()
    line += b" " * (-len(line) % 4)
    return b"".join([_LENGTH.pack(len(line)), line, *parts])


def head_of(packet: bytes) -> dict[str, Any]:
    """The head of a packet.

    Raises:
        ValueError: it is none.
    """
    if len(packet) < _LENGTH.size:
        raise ValueError("the packet is cut off")
    (length,) = _LENGTH.unpack_from(packet)
    head = json.loads(packet[_LENGTH.size : _LENGTH.size + length])
    if not isinstance(head, dict):
        raise ValueError("the head of the packet is no table")
    return head


def arrays_of(packet: bytes) -> dict[str, NDArray[Any]]:
    """The arrays of a packet; they are views of its bytes."""
    (length,) = _LENGTH.unpack_from(packet)
    start, found = _LENGTH.size + length, {}
    for name, told in head_of(packet).get("arrays", {}).items():
        count = int(np.prod(told["shape"]))
        data = np.frombuffer(packet, f"<{told['type']}", count, start + told["at"])
        found[name] = data.reshape(told["shape"])
    return found


def framed(packet: bytes) -> bytes:
    """A packet as it goes into a stream."""
    return _LENGTH.pack(len(packet)) + packet


def read_frame(stream: IO[bytes]) -> bytes | None:
    """The next packet of a stream; None at its end."""
    start = stream.read(_LENGTH.size)
    if len(start) < _LENGTH.size:
        return None
    (length,) = _LENGTH.unpack(start)
    packet = stream.read(length)
    return packet if len(packet) == length else None
