"""The proofs of the laminate model on the command line: `verify` without a design."""

from __future__ import annotations

from pathlib import Path

import click

from sheetmorph.cli.shared import at_work
from sheetmorph.core.errors import ComputationError, InputError


def remake_proofs(
    output: Path | None, only: tuple[str, ...], reference: str | None, force: bool, quiet: bool
) -> None:
    """Do the proofs and write their page.

    Raises:
        InputError: an option cannot be used, or the folder holds other things.
        ComputationError: a number lies beyond its limit, or a proof could not be done.
    """
    from sheetmorph.proofs.prove import Outcome, chosen_proofs, prove_all
    from sheetmorph.show.proofs import check_proofs_folder, write_proofs

    folder = output or Path("proofs")
    place = None if reference is None else Path(reference)
    if place is not None and not place.is_dir():
        raise InputError("is not a folder", key="--reference", value=reference)
    chosen_proofs(only)

    def tell(outcome: Outcome) -> str:
        if outcome.proof is None:
            return f"  not done  {outcome.name}: {outcome.lack}"
        checks = outcome.proof.checks
        good = sum(check.passed for check in checks)
        word = "holds" if outcome.passed else "FAILS"
        return (
            f"  {word:8}  {outcome.name}: {good} of {len(checks)} checks, {outcome.seconds:.1f} s"
        )

    with at_work(folder, quiet, lambda: check_proofs_folder(folder, force)) as listener:
        try:
            outcomes = prove_all(only, place, on_event=listener)
        except KeyboardInterrupt:
            raise click.exceptions.Abort("interrupted; nothing was written") from None
        page = write_proofs(outcomes, folder)
    if not quiet:
        click.echo("\n".join(tell(outcome) for outcome in outcomes))
        click.echo(str(page))
    bad = [outcome.name for outcome in outcomes if not outcome.passed]
    if bad:
        raise ComputationError(
            f"{len(bad)} of {len(outcomes)} proofs do not hold: {', '.join(bad)}"
        )
