"""Proofs as tests: a proof passes when each of its numbers lies within its limit."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from sheetmorph.proofs.proof import Proof
from sheetmorph.proofs.prove import prove


@pytest.fixture(scope="session")
def proven() -> Callable[[str], Proof]:
    """A proof of this name, done once, with every check within its limit."""
    done: dict[str, Proof] = {}

    def of(name: str) -> Proof:
        if name not in done:
            outcome = prove(name)
            assert outcome.proof is not None, outcome.lack
            done[name] = outcome.proof
        proof = done[name]
        failed = [
            f"{c.id}: {c.found:.6g} for {c.expected:.6g}" for c in proof.checks if not c.passed
        ]
        assert not failed, failed
        return proof

    return of
