"""Rules for mass, weight, table and contact: what must be known, and what bears the sheet."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sheetmorph.design.fields import problem
from sheetmorph.design.support_tables import FreeSupport

if TYPE_CHECKING:
    from sheetmorph.design.schema import DesignSchema


def check_surroundings(design: DesignSchema) -> None:
    """Refuse weights without densities, sheets that fall, and contact that cannot begin."""
    _check_densities(design)
    free = all(isinstance(support, FreeSupport) for support in design.supports)
    if free and design.gravity is not None:
        _check_rest(design)
    if free and design.contact.table and design.gravity is None:
        raise problem(
            "nothing holds a free sheet down on the table",
            key="contact.table",
            allowed="a [gravity] table too, or a [[supports]] table",
        )
    contact = design.contact
    if design.solver.kind == "dynamic" and (contact.self_contact or contact.table):
        raise problem(
            "the dynamic solver knows no contact",
            key="contact",
            allowed="solver.kind = quasi_static, or no table",
        )
    outline = design.outline
    if contact.self_contact and (outline.slits or getattr(outline, "slit_select", None)):
        raise problem(
            "the two lips of a slit touch from the beginning, so contact cannot tell them apart",
            key="contact.self_contact",
            allowed="cuts with a width (outline.cutouts), or false",
        )


def _check_densities(design: DesignSchema) -> None:
    moving = design.solver.kind == "dynamic"
    if design.gravity is None and not moving:
        return
    for index, layer in enumerate(design.layers):
        if "density" not in layer.model_fields_set:
            raise problem(
                f"is required for the {'mass' if moving else 'weight'} of this layer",
                key=f"layers[{index}].density",
                allowed='such as "1050 kg/m^3", or a material that has one',
            )


def _check_rest(design: DesignSchema) -> None:
    """A free sheet lies flat on the table, or it falls."""
    assert design.gravity is not None  # noqa: S101
    if not design.contact.table:
        raise problem(
            "a free sheet falls",
            key="gravity",
            allowed="[contact] table = true, or a [[supports]] table",
        )
    down = design.gravity.down
    if max(abs(down[0]), abs(down[1])) > 1e-9 * abs(down[2]):
        raise problem(
            "a free sheet lies flat on the table",
            key="gravity.orientation" if design.gravity.direction is None else "gravity.direction",
            value=design.gravity.orientation if design.gravity.direction is None else list(down),
            allowed="as_drawn or turned_over, or a [[supports]] table",
        )
    if design.contact.table_distance > 0.0:
        raise problem(
            "a free sheet begins on the table",
            key="contact.table_distance",
            allowed="0 mm, or a [[supports]] table",
        )
