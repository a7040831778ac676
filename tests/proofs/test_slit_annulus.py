"""Sze's slit annular plate."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from sheetmorph.proofs.proof import Proof


@pytest.mark.slow
def test_every_load_step_and_the_order(proven: Callable[[str], Proof]) -> None:
    proof = proven("slit_annulus")
    assert len(proof.checks) == 2 * 2 * 23 + 2
    stiff = [c for c in proof.checks if c.kind == "relative"]
    assert all(c.found < c.expected for c in stiff)
    assert max(c.error for c in stiff if "-outer-" in c.id) < 0.015
