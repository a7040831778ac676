"""The free family: a film whose strain is free on every face, and then a pattern in its place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import ComputationError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.inverse.evaluations import Evaluations
from sheetmorph.inverse.families import SIZE, Space, restricted
from sheetmorph.inverse.flatten import flatten
from sheetmorph.inverse.graded import FIELD, GradedSheet, graded_sheet, optimise, outline_of
from sheetmorph.inverse.journal import Journal
from sheetmorph.inverse.limits import Limits
from sheetmorph.inverse.misfit import THOROUGH, Evaluation, Job, lay, pose_of, shape_of
from sheetmorph.inverse.result import Found
from sheetmorph.inverse.targets import Target
from sheetmorph.inverse.threshold import threshold_space
from sheetmorph.study.simulate import simulate

GRADED = "graded"
DEVELOPABLE = (
    "The target is next to developable: shrinkage that is the same in all directions cannot tell "
    "it from a flat sheet. Ribs can (--family stripes)."
)


@dataclass(frozen=True, eq=False)
class Graded:
    """The film that was found.

    Attributes:
        sheet: outline, mesh, and the target of its size.
        best: the strain of its faces.
        outline: [m], shape (n, 2).
        space: of the patterns that stand for it.
        notes: sentences for the user.
    """

    sheet: GradedSheet
    best: Evaluation
    outline: Floats
    space: Space
    notes: tuple[str, ...]


def grade(
    target: Target,
    limits: Limits,
    journal: Journal,
    *,
    steps: int,
    sheet: float | None,
    fixed: dict[str, float],
    overrides: dict[str, object],
    on_new: Callable[[Job, Evaluation], None],
) -> Graded:
    """Find the strain of every face of a film, and the patterns that may stand for it.

    Args:
        target: the wanted shape.
        limits: of fabrication.
        journal: keeps every field that was computed.
        steps: iterations at most.
        sheet: longer side of the sheet [m], when it is given; the target is scaled with it.
        fixed: parameters of the patterns that do not vary.
        overrides: keys that every design has.
        on_new: told of every field.

    Raises:
        InputError: the target is not one piece of surface with one rim.
        ComputationError: the first field could not be computed.
    """
    flat = flatten(target.surface)
    scale = 1.0
    if sheet is not None:
        scale = sheet / float(np.ptp(flat.plan, axis=0).max())
        flat = replace(flat, plan=scale * flat.plan)
        fixed = {SIZE: sheet, **fixed}
    wanted = scaled(target.surface, scale)
    film = graded_sheet(wanted, flat, f"{target.name} graded", overrides)
    evaluations = Evaluations(film, journal, on_new=on_new)
    best = optimise(evaluations, film, steps)
    outline = outline_of(flat)
    space = threshold_space(film, np.array(best.point), outline, limits, overrides)
    notes = (DEVELOPABLE,) if flat.developable else ()
    return Graded(film, best, outline, restricted(space, fixed), notes)


def graded_found(target: Target, graded: Graded, limits: Limits) -> Found:
    """The film itself as a design, with the file of its strain.

    Raises:
        ComputationError: it could not be computed again.
    """
    strain = np.array(graded.best.point)
    with graded.sheet.design(strain) as design:
        result = simulate(design)
    if result.status == "interrupted":
        raise KeyboardInterrupt
    if result.status != "completed":
        raise ComputationError(f"the graded film ended with {result.status}")
    near = pose_of(graded.best.pose)
    laid = lay(graded.sheet.target, shape_of(result), 1.0, near, THOROUGH)
    return Found(
        target=target,
        family=GRADED,
        values={"strongest": float(strain.min()), "weakest": float(strain.max())},
        design=design,
        result=result,
        laid=laid,
        made=None,
        limits=limits,
        steps=(),
        evaluations=0,
        fresh=0,
        failed=0,
        seconds=graded.best.seconds,
        files={FIELD: graded.sheet.file(strain)},
        notes=graded.notes,
    )


def scaled(surface: Surface, scale: float) -> Surface:
    """A surface in another size."""
    if scale == 1.0:
        return surface
    here = Similarity.identity()
    return surface.moved(Similarity(scale, here.rotation, here.translation))
