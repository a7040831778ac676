"""What a section of the paper is, and the helpers that several sections need."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sheetmorph.geometry.mesh import Floats
from sheetmorph.paper.rows import Findings
from sheetmorph.paper.runs import Outcome, Outcomes, Run, Setting
from sheetmorph.study.result import Result

GRID, WINDOW = 64, 10
"""Voxels per side and window of SSIM, as in the released numbers."""


@dataclass(frozen=True)
class Section:
    """A part of the paper that is redone on its own.

    Attributes:
        key: for `--only`.
        title: for people.
        where: its place in the paper.
        runs: the simulations it needs.
        evaluate: from their outcomes to what was found.
    """

    key: str
    title: str
    where: str
    runs: Callable[[Setting], tuple[Run, ...]]
    evaluate: Callable[[Setting, Outcomes], Findings]


def no_runs(setting: Setting) -> tuple[Run, ...]:
    """The runs of a section that simulates nothing."""
    del setting
    return ()


def failures(outcomes: Outcomes, *runs: Run) -> str:
    """Why some of these runs have no shape at full actuation; empty where all have."""
    return " ".join(f"{run}: {outcomes[run].failure}" for run in runs if outcomes[run].failure)


def result_of(outcome: Outcome) -> Result:
    """The result of a run that succeeded."""
    assert outcome.result is not None and not outcome.failure  # noqa: S101
    return outcome.result


Signs = tuple[float, float, float]
AS_IT_IS: Signs = (1.0, 1.0, 1.0)
MIRRORED: Signs = (1.0, 1.0, -1.0)
"""Mirrored at the plane of the flat sheet."""
OTHER_MIRRORS: tuple[Signs, ...] = ((-1.0, -1.0, -1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0))
"""Mirrored in z and turned by 180° about z; turned by 180° about the middle lines along x and y."""


def placed(outcome: Outcome, signs: Signs) -> Floats:
    """The shape with its coordinates about the middle of the flat sheet times the signs [m]."""
    nodes = result_of(outcome).mesh.nodes
    middle = 0.5 * (nodes.min(axis=0) + nodes.max(axis=0))
    return np.asarray((outcome.shape - middle) * np.array(signs) + middle)


def similarity(a: Outcome, b: Outcome, signs: Signs = AS_IT_IS) -> float:
    """Mean SSIM of two shapes as they lie, 0 to 1; no scaling and no alignment.

    Args:
        signs: how b is laid onto a, see `placed`.
    """
    from sheetmorph.compare.similarity import ssim
    from sheetmorph.compare.surface import Surface

    other = placed(b, signs)
    if a.shape.shape == other.shape and np.abs(a.shape - other).max() < 1e-9:
        return 1.0
    first = Surface(a.shape, result_of(a).mesh.triangles.astype(np.int64))
    second = Surface(other, result_of(b).mesh.triangles.astype(np.int64))
    return float(ssim(first, second, GRID, WINDOW).value)


def largest_move(a: Outcome, b: Outcome, signs: Signs = AS_IT_IS) -> float:
    """Largest distance of a node in two shapes of one mesh [m]; signs as for `similarity`."""
    return float(np.linalg.norm(a.shape - placed(b, signs), axis=1).max())


def rising(values: Floats) -> bool:
    """Every value is above the one before."""
    return bool((np.diff(values) > 0).all())


def listed(values: list[float], digits: int = 2) -> str:
    """Numbers in a row of words, with real minus signs."""
    return ", ".join(f"{value:.{digits}f}" for value in values).replace("-", "−")


WITHOUT_MESHES = (
    "The paper's meshes are not here (name their folder with --reference): this was computed "
    "on meshes made here with the mean edge lengths of the paper."
)
