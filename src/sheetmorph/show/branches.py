"""The shapes of a sheet side by side, and the folder of a search for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from sheetmorph.branches.result import FORMAT, Branch, Branches, write_json, write_states
from sheetmorph.show import guard, scene, stills, style
from sheetmorph.show.flat import actuation_text
from sheetmorph.show.guard import Written
from sheetmorph.show.pictures import borrowed
from sheetmorph.show.render import RenderWorker
from sheetmorph.show.scene import Image, Job, View
from sheetmorph.show.style import Sheet
from sheetmorph.show.texture import REGIONS, UNDER_REGIONS

DATA, STATES, PICTURE = "branches.json", "branches.h5", "branches.png"
OUTPUTS = (DATA, STATES, PICTURE)
"""What a search writes into its folder, and what the next one there replaces."""

MOST, COLUMNS = 12, 4
_CELL, _HEAD, _FOOT, _LABEL, _MARGIN = (320, 250), 104, 52, 76, 24


def check_folder(folder: str | Path, force: bool, inputs: Sequence[Path] = ()) -> None:
    """Refuse a folder that holds branches, or that cannot.

    Raises:
        InputError, OutputError: see `guard.check_folder`.
    """
    marker = Path(folder) / DATA
    guard.check_folder(
        folder,
        OUTPUTS,
        "search for branches",
        ours=lambda _file: guard.wrote(marker, FORMAT),
        force=force,
        inputs=inputs,
    )


def write_branches(
    found: Branches, folder: str | Path, worker: RenderWorker | None = None
) -> Written:
    """Write numbers, states and the picture of a search.

    Args:
        found: what was found.
        folder: where to write; made when absent.
        worker: draws the shapes; one is started and ended here when absent.

    Raises:
        OutputError: a file cannot be written; no half-written file is left.
        ComputationError: SHEETMORPH_RENDERER=vtk, and VTK does not draw.
    """
    place = Path(folder)
    write_json(found, place / DATA)
    write_states(found, place / STATES)
    with borrowed(worker) as painter:
        picture = write_picture(found, place / PICTURE, painter)
        notes = (painter.note,) if painter.note else ()
    return Written((place / DATA, place / STATES, picture), notes)


def write_picture(found: Branches, path: Path, painter: RenderWorker) -> Path:
    """Draw up to twelve shapes at one scale, lowest energy first.

    Raises:
        OutputError: the picture cannot be written.
    """
    shown = found.branches[:MOST]
    images = list(painter.draw(_job(found, shown)))
    columns = min(COLUMNS, len(shown))
    rows = -(-len(shown) // columns)
    wide, high = _CELL
    width = max(2 * _MARGIN + columns * wide, 760)
    with style.style():
        sheet = Sheet(width, _HEAD + rows * (high + _LABEL) + _FOOT)
        sheet.title(style.shortened(found.result.design.name, 40), _subtitle(found))
        for k, (one, image) in enumerate(zip(shown, images, strict=True)):
            x = _MARGIN + (k % columns) * wide
            y = sheet.height - _HEAD - (k // columns + 1) * (high + _LABEL) + _LABEL
            _draw(sheet, found, one, image, x, y)
        hidden = len(found.branches) - len(shown)
        more = f"; {hidden} more in {DATA}" if hidden else ""
        sheet.foot(f"One scale, one view. Energies over that of shape 1{more}")
        return sheet.save(path)


def _job(found: Branches, shown: Sequence[Branch]) -> Job:
    fitted = [scene.perspective().fitted(one.positions, _CELL, 0.06) for one in shown]
    extent = max(camera.extent for camera in fitted)
    distance = max(camera.distance for camera in fitted)
    views = tuple(
        View(
            one.positions,
            stills.white(len(one.positions)),
            (REGIONS, UNDER_REGIONS),
            replace(camera, extent=extent, distance=distance),
            _CELL,
        )
        for one, camera in zip(shown, fitted, strict=True)
    )
    return stills.base_job(found.result, views)


def _subtitle(found: Branches) -> str:
    count = len(found.branches)
    stable = sum(one.stable for one in found.branches)
    reached = actuation_text(found.result.design.eps_pre)
    return f"{_shapes(count)}, {stable} stable, from {len(found.attempts)} seeds  ·  {reached}"


def _shapes(count: int) -> str:
    return "1 shape" if count == 1 else f"{count} shapes"


def _draw(sheet: Sheet, found: Branches, one: Branch, image: Image, x: int, y: int) -> None:
    sheet.image(image, x, y)
    middle = x + 0.5 * _CELL[0]
    kind = "stable" if one.stable else f"unstable ({one.negative})"
    kind += ", leans on a guard" if one.guarded else ""
    above = one.energy - found.branches[0].energy
    energy = joules(one.energy) if one.number == 1 else f"+ {joules(above)}"
    low = float(np.ptp(one.positions[:, 2]))
    ink = style.INK if one.stable else style.HELD
    sheet.text(
        middle,
        y - 16,
        f"{one.number}  {kind}",
        ha="center",
        va="center",
        fontweight="bold",
        color=ink,
    )
    sheet.text(
        middle,
        y - 38,
        f"{energy}   height {style.millimetres(low)}",
        ha="center",
        va="center",
        fontsize=style.SMALL,
    )
    seeds = found.seeds_of(one.number)
    images = len({seed.image for seed in seeds})
    text = f"{len(seeds)} seed{'' if len(seeds) == 1 else 's'}"
    if images > 1:
        text += f", {images} positions"
    sheet.text(
        middle, y - 57, text, ha="center", va="center", fontsize=style.SMALL, color=style.MUTED
    )


def joules(energy: float) -> str:
    """An energy [J] with three digits and a prefix."""
    size = abs(energy)
    for factor, unit in ((1.0, "J"), (1e-3, "mJ"), (1e-6, "µJ"), (1e-9, "nJ"), (1e-12, "pJ")):
        if size >= factor:
            return f"{style.signed(energy / factor, 2)} {unit}"
    return f"{energy:.2g} J".replace("-", "−")
