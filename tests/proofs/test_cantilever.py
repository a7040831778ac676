"""Sze's cantilever."""

from __future__ import annotations

from collections.abc import Callable

from sheetmorph.proofs.proof import Proof


def test_every_load_step_and_the_order(proven: Callable[[str], Proof]) -> None:
    proof = proven("cantilever")
    assert len(proof.checks) == 41
    assert max(c.error for c in proof.checks if c.id.startswith("w")) < 0.002
