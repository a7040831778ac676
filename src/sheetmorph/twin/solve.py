"""A design through CalculiX: deck, run, and the shapes that come back."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from sheetmorph.core.errors import ComputationError
from sheetmorph.core.events import Listener, Progress, Started, silent
from sheetmorph.core.files import replacing
from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.solve.constraints import align_to_reference
from sheetmorph.twin import ccx
from sheetmorph.twin.calculix import LENGTH, Deck, DeckOptions, write_deck
from sheetmorph.twin.frd import Displacements, read_displacements
from sheetmorph.twin.sheet import Sheet
from sheetmorph.twin.solid import Solid, extrude

JOB = "twin"


@dataclass(frozen=True)
class TwinOptions:
    """How the twin is computed.

    Attributes:
        deck: how the sheet is driven.
        time_limit: after which the solver is stopped [s].
        threads: of the solver.
    """

    deck: DeckOptions = field(default_factory=DeckOptions)
    time_limit: float = 3600.0
    threads: int = 1


@dataclass(frozen=True, eq=False)
class Twin:
    """What the solver found, at the nodes of the plan.

    Attributes:
        mesh: the plan.
        positions: of its nodes at the end of each step that was reached [m], shape (S, V, 3).
        ramp: fraction of the actuation there, shape (S,).
        load: fraction of the perturbation there, shape (S,).
        nodes: of the body.
        elements: of the body.
        law: of the deck.
        version: of the solver.
        ran: how it ended.
    """

    mesh: SheetMesh
    positions: Floats
    ramp: Floats
    load: Floats
    nodes: int
    elements: int
    law: str
    version: str
    ran: ccx.Ran

    @property
    def completed(self) -> bool:
        """True when the whole path was followed."""
        return self.ran.ending == "completed"


def write_twin(design: Design, folder: Path, options: DeckOptions) -> tuple[Sheet, Solid, Deck]:
    """Write the deck of a design, `twin.inp`, into a folder.

    Raises:
        InputError: see `Sheet.of` and `write_deck`.
        OutputError: it cannot be written.
    """
    sheet = Sheet.of(design)
    solid = extrude(sheet)
    deck = write_deck(sheet, solid, options)
    with (
        replacing(folder / f"{JOB}.inp") as partial,
        partial.open("w", encoding="utf-8", newline="\n") as stream,
    ):
        stream.writelines(deck.text)
    return sheet, solid, deck


def solve_twin(
    design: Design,
    folder: Path,
    options: TwinOptions | None = None,
    on_event: Listener = silent,
) -> Twin:
    """Write the deck of a design, run CalculiX on it, and read the shapes.

    Args:
        design: what to simulate.
        folder: for the files of the solver; made when absent.
        options: see there.
        on_event: told of the progress.

    Raises:
        InputError: CalculiX is not installed, or the design cannot be laid out.
        OutputError: the deck cannot be written.
        ComputationError: not one step was reached; says why, and where the log is.
    """
    chosen = options or TwinOptions()
    program = ccx.find_program()
    on_event(Started(f"{design.name} by CalculiX"))
    sheet, solid, deck = write_twin(design, folder, chosen.deck)
    last = len(deck.ramp)

    def told(time: float) -> None:
        on_event(Progress(time / last, f"step {min(int(time) + 1, last)} of {last}"))

    ran = ccx.run(
        program,
        folder,
        JOB,
        time_limit=chosen.time_limit,
        threads=chosen.threads,
        on_time=told,
    )
    states = whole_steps(folder / f"{JOB}.frd", ran.times, last)
    if not states:
        raise ComputationError(
            f"CalculiX reached no step ({ran.message or ran.ending}); see {folder / JOB}.log, "
            "and try more steps or a longer time limit"
        )
    steps = np.array(sorted(states))
    positions = np.array([positions_of(sheet, solid, states[step]) for step in steps])
    if sheet.free:
        positions = align_to_reference(positions, sheet.mesh.nodes)
    return Twin(
        sheet.mesh,
        positions,
        deck.ramp[steps],
        deck.load[steps],
        len(solid.nodes),
        len(solid.wedges),
        chosen.deck.law,
        ccx.version(program),
        ran,
    )


def whole_steps(path: Path, converged: tuple[float, ...], last: int) -> dict[int, Displacements]:
    """The states at the ends of steps, by the number of the step from 0.

    A step takes one unit of time. What was written without having converged is left out.

    Raises:
        InputError: the file is not usable.
    """
    if not converged or not path.exists():
        return {}
    ends = {round(time) - 1 for time in converged if abs(time - round(time)) < 1e-6}
    found: dict[int, Displacements] = {}
    for state in read_displacements(path):
        step = round(state.time) - 1
        if abs(state.time - round(state.time)) < 1e-4 and step in ends and 0 <= step < last:
            found.setdefault(step, state)
    return found


def positions_of(sheet: Sheet, solid: Solid, state: Displacements) -> Floats:
    """Positions of the nodes of the plan, on the reference plane [m], shape (V, 3)."""
    order = np.argsort(state.nodes)
    place = order[np.searchsorted(state.nodes, solid.surface + 1, sorter=order)]
    return np.asarray(sheet.mesh.nodes + LENGTH * state.values[place])
