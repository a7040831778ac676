"""Plates that buckle when heated."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from sheetmorph.core.errors import ComputationError
from sheetmorph.proofs.buckling import SQUARE, critical_strain
from sheetmorph.proofs.proof import Proof


@pytest.mark.slow
def test_strains_modes_and_orders(proven: Callable[[str], Proof]) -> None:
    proof = proven("buckling")
    found = {check.id: check.found for check in proof.checks}
    assert len(found) == 4 * 3
    assert max(value for key, value in found.items() if key.endswith("mode")) < 5e-3
    for family in ("structured", "irregular"):  # from below, as Morley's triangle has it
        assert 3.97 < found[f"square-{family}"] < 4.0
        assert 1.21 < found[f"disc-{family}"] < 1.2235


def test_a_plate_that_is_cooled_does_not_buckle() -> None:
    with pytest.raises(ComputationError, match="does not buckle"):
        critical_strain(SQUARE.replace("eps_pre = ", "eps_pre = -"))
