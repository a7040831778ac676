"""The same design gives the same numbers."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest

import sheetmorph as sm

HERE = """
import hashlib, sys
import sheetmorph as sm
result = sm.simulate(sm.Design.from_toml(sys.stdin.read()))
print(hashlib.sha256(result.positions.tobytes() + result.scalars.tobytes()).hexdigest())
"""


def digest(result: sm.Result) -> str:
    return hashlib.sha256(result.positions.tobytes() + result.scalars.tobytes()).hexdigest()


@pytest.mark.parametrize("model", ["published", "laminate"])
def test_with_one_thread_to_the_last_bit(small_design: sm.Design, model: str) -> None:
    """Again in this process, and in another one with another seed of hashes."""
    design = small_design.with_values({"model": model})
    first, second = (digest(sm.simulate(design)) for _ in range(2))
    assert first == second
    done = subprocess.run(
        [sys.executable, "-c", HERE],
        input=design.to_toml().encode(),
        capture_output=True,
        env={**os.environ, "PYTHONHASHSEED": "7"},
        check=True,
    )
    assert done.stdout.decode().strip() == first


def test_with_more_threads_to_ten_digits(small_design: sm.Design) -> None:
    pytest.importorskip("rslab")
    one, two = (
        sm.simulate(
            small_design.with_values({"solver.linear_solver": "rslab", "solver.threads": threads})
        )
        for threads in (1, 2)
    )
    assert one.positions.shape == two.positions.shape
    extent = np.ptp(one.positions[0])
    np.testing.assert_allclose(two.positions, one.positions, rtol=0.0, atol=1e-10 * extent)
    assert two.summary["computed_with"]["threads"] == 2


def test_what_it_was_computed_with_is_recorded(small_result: sm.Result, tmp_path) -> None:  # type: ignore[no-untyped-def]
    recorded = sm.Result.load(small_result.save(tmp_path / "r.h5")).summary["computed_with"]
    assert recorded["threads"] == 1
    assert recorded["libraries"]["numpy"] == np.__version__
    assert recorded["python"] == sys.version.split()[0]
    assert recorded["platform"] and recorded["processor"]
