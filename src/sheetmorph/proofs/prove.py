"""All proofs, one after the other or side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from time import perf_counter

from sheetmorph.core.errors import ComputationError, InputError, nearest
from sheetmorph.core.events import Listener, Progress, silent
from sheetmorph.proofs.proof import Proof

PROOFS = (
    "cantilever",
    "timoshenko",
    "wide_strip",
    "layers",
    "bistable_disc",
    "growth",
    "heavy_elastica",
    "buckling",
    "slit_annulus",
    "hemisphere",
)
"""Names of the proofs, each a module of this room with a function `prove`, in their order."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """A proof that was tried.

    Attributes:
        name: of the proof.
        proof: what it found; None where it could not be done.
        lack: why not, for people.
        seconds: wall time.
    """

    name: str
    proof: Proof | None
    lack: str
    seconds: float

    @property
    def passed(self) -> bool:
        """True when it was done and all checks lie within their limits."""
        return self.proof is not None and self.proof.passed


def chosen_proofs(only: Sequence[str]) -> tuple[str, ...]:
    """The proofs of these names, all by default.

    Raises:
        InputError: there is no such proof.
    """
    for name in only:
        if name not in PROOFS:
            guess = nearest(name, list(PROOFS))
            hint = f"; did you mean {guess}?" if guess else ""
            raise InputError(
                f"there is no such proof{hint}", key="--only", value=name, allowed=", ".join(PROOFS)
            )
    return tuple(name for name in PROOFS if not only or name in only)


def prove(name: str, reference: Path | None = None) -> Outcome:
    """Do one proof; what it lacks or where it fails is part of the outcome."""
    began = perf_counter()
    try:
        found = import_module(f"sheetmorph.proofs.{name}").prove(reference)
        return Outcome(name, found, "", perf_counter() - began)
    except (ComputationError, InputError) as error:
        return Outcome(name, None, str(error), perf_counter() - began)


def prove_all(
    only: Sequence[str] = (), reference: Path | None = None, *, on_event: Listener = silent
) -> list[Outcome]:
    """Do the chosen proofs.

    Args:
        only: names; all by default.
        reference: folder with the published tables; found as for designs when None.
        on_event: told of the progress.

    Raises:
        InputError: there is no such proof.
    """
    names = chosen_proofs(only)
    outcomes = []
    for index, name in enumerate(names):
        on_event(Progress(index / len(names), name.replace("_", " ")))
        outcomes.append(prove(name, reference))
    return outcomes
