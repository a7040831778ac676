"""Other shapes that the sheet of a tab can have, for a look at each."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from sheetmorph.geometry import surface

if TYPE_CHECKING:
    from sheetmorph.studio.worker import Desk

MODES = 2
"""Modes that are kicked at each bifurcation; `sheetmorph branches` tries more."""


def find_shapes(job: dict[str, Any], desk: Desk, memory: Any) -> None:
    """Tell the shapes of a design at full actuation, by the search of `sheetmorph branches`."""
    from sheetmorph.branches.search import SearchOptions, find_branches
    from sheetmorph.studio.tasks import designed

    design = designed(job)
    options = SearchOptions(modes=MODES, random=0)
    found = find_branches(design, options, mesh=memory.mesh(design), on_event=desk.listen)
    told = [
        {
            "number": branch.number,
            "stable": branch.stable,
            "energy_mJ": 1e3 * branch.energy,
            "aspect_ratio": float(surface.aspect_ratio(branch.positions)),
            "height_mm": 1e3 * float(np.ptp(branch.positions[:, 2])),
        }
        for branch in found.branches
    ]
    shapes = np.array([1e3 * branch.positions for branch in found.branches])
    desk.answer("shapes", {"shapes": told}, {"shapes": shapes})
