"""Which designs can be made on a bench: a flat film that shrinks, with parts glued on it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sheetmorph.core.errors import InputError
from sheetmorph.design.sections import EVERYWHERE

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design


def check_makeable(design: Design) -> None:
    """Refuse a design that can be computed but not made from a film and printed parts.

    Raises:
        InputError: it has no active film, an active layer that covers a part of the sheet, a
            sheet that is curved before actuation, or a strain by a table.
    """
    if design.spec.mesh.curved:
        raise InputError(
            "the sheet is curved before it is actuated; what is cut and glued must be flat",
            file=design.file,
            key="mesh.curved",
            allowed="a flat sheet",
        )
    active = [index for index, layer in enumerate(design.layers) if layer.role == "active"]
    if not active:
        raise InputError(
            "no layer is active, so there is no film to heat; the design can be computed only",
            file=design.file,
            key="layers",
            allowed="at least one layer with role = active",
        )
    for index in active:
        if design.layers[index].where != EVERYWHERE:
            raise InputError(
                f"{design.layers[index].name} is active and lies in a part of the pattern; a film "
                "that shrinks is cut as the whole sheet, so this can be computed only",
                file=design.file,
                key=f"layers[{index}].where",
                value=design.layers[index].where,
                allowed=EVERYWHERE,
            )
    if design.actuation.profile in ("radial", "field"):
        raise InputError(
            "a strain by a table is no film that can be heated as a whole; this can be computed "
            "only",
            file=design.file,
            key="actuation.profile",
            value=design.actuation.profile,
        )
