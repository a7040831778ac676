"""Packets: what goes in comes out, and nothing else is read."""

from __future__ import annotations

import io

import numpy as np
import pytest

from sheetmorph.studio.frames import arrays_of, framed, head_of, pack, read_frame


def test_a_packet_holds_head_and_arrays() -> None:
    arrays = {
        "x": np.arange(6.0).reshape(2, 3) / 7.0,
        "n": np.array([[1, 2], [3, 70000]]),
        "yes": np.array([True, False]),
    }
    packet = pack({"kind": "scene", "name": "ä"}, arrays)
    head, found = head_of(packet), arrays_of(packet)
    assert (head["kind"], head["name"]) == ("scene", "ä")
    np.testing.assert_array_equal(found["x"], arrays["x"].astype(np.float32))
    np.testing.assert_array_equal(found["n"], arrays["n"])
    np.testing.assert_array_equal(found["yes"], [1, 0])


@pytest.mark.parametrize("text", ["", "a", "ab", "abc", "äöü"])
def test_arrays_lie_at_multiples_of_four_bytes(text: str) -> None:
    packet = pack({"text": text}, {"x": np.ones(3)})
    start = 4 + int.from_bytes(packet[:4], "little")
    assert start % 4 == 0
    assert len(packet) == start + 12


def test_numbers_that_are_not_finite_are_refused() -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        pack({"value": float("nan")})


def test_a_stream_gives_packets_until_it_is_cut_off() -> None:
    packets = [pack({"k": k}) for k in range(3)]
    data = b"".join(map(framed, packets))
    stream = io.BytesIO(data[:-1])
    assert [read_frame(stream) for _ in range(3)] == [*packets[:2], None]
    assert read_frame(io.BytesIO(b"")) is None


def test_what_is_no_packet_is_refused() -> None:
    for wrong in (b"", b"ab", b"\x02\x00\x00\x00[]", b"\x03\x00\x00\x00{{{"):
        with pytest.raises(ValueError, match=r"cut off|no table|Expecting"):
            head_of(wrong)
