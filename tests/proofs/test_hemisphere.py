"""Sze's hemisphere with a hole."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from sheetmorph.proofs.proof import Proof


@pytest.mark.slow
def test_every_load_step_and_the_order(proven: Callable[[str], Proof]) -> None:
    proof = proven("hemisphere")
    assert len(proof.checks) == 2 * 2 * 20 + 1
    assert max(c.error for c in proof.checks if "-pulled-" in c.id) < 0.006
