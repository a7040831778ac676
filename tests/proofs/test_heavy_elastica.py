"""A strip under its own weight."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from sheetmorph.proofs.proof import Proof


@pytest.mark.slow
def test_droop_and_reach_of_every_row_and_the_orders(proven: Callable[[str], Proof]) -> None:
    proof = proven("heavy_elastica")
    errors = {check.id: check.error for check in proof.checks}
    assert sum(key.startswith("table") for key in errors) == 7
    assert len(errors) == 4 * 12 + 2 + 7
    level = [error for key, error in errors.items() if key.endswith(("-w-20", "-h-20"))]
    assert max(level) < 2e-4
