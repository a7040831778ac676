"""Rules that tie the tables of a design together: layers, parts, supports, and the model."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from sheetmorph.core.errors import nearest
from sheetmorph.design import actuation_table, support_tables
from sheetmorph.design.fields import Section, problem
from sheetmorph.design.laminate import LayerStack
from sheetmorph.design.sections import EVERYWHERE
from sheetmorph.design.support_tables import FreeSupport, SymmetrySupport

if TYPE_CHECKING:
    from sheetmorph.design.schema import DesignSchema
    from sheetmorph.design.sections import Layer


def check_model(design: DesignSchema) -> None:
    """Refuse what the chosen model does not know."""
    other = "laminate" if design.model == "published" else "published"
    if getattr(design, other).model_fields_set:
        raise problem(
            f"belongs to the {other} model; remove the table, or write model = {other}",
            key=other,
            value=f"model = {design.model}",
        )
    if design.model == "published":
        for key, value in _of_laminate(design):
            raise problem(
                "belongs to the laminate model; remove it, or write model = laminate",
                key=key,
                value=value,
            )


def _of_laminate(design: DesignSchema) -> Iterator[tuple[str, object]]:
    """Keys and values that the published model does not know."""
    for index, layer in enumerate(design.layers):
        yield from _given(layer, ("eigenstrain_factor",), f"layers[{index}]")
    if design.actuation.whole_sheet and design.actuation.profile != actuation_table.FIELD:
        yield "actuation.profile", design.actuation.profile
    yield from _given(design.actuation, actuation_table.OF_LAMINATE, "actuation")
    for index, support in enumerate(design.supports):
        key = f"supports[{index}]"
        if isinstance(support, SymmetrySupport):
            yield f"{key}.kind", support.kind
        yield from _given(support, support_tables.OF_LAMINATE, key)
    for index, load in enumerate(design.loads):
        yield f"loads[{index}].kind", load.kind
    yield from _given(design.mesh, ("curved",), "mesh")


def _given(table: Section, keys: tuple[str, ...], name: str) -> Iterator[tuple[str, object]]:
    for key in keys:
        if key in table.model_fields_set:
            yield f"{name}.{key}", getattr(table, key)


def check_layers(design: DesignSchema) -> None:
    """Names, places and roles of the layers."""
    seen: set[str] = set()
    parts = list(dict.fromkeys(piece.part for piece in design.pattern))
    if EVERYWHERE in parts:
        raise problem("is the name of the whole sheet", key="pattern.part", value=EVERYWHERE)
    for index, layer in enumerate(design.layers):
        key = f"layers[{index}]"
        if layer.name in seen:
            raise problem("two layers have the same name", key=f"{key}.name", value=layer.name)
        seen.add(layer.name)
        if layer.role == "inert" and "eigenstrain_factor" in layer.model_fields_set:
            raise problem(
                "an inert layer has no free strain; remove it, or write role = active",
                key=f"{key}.eigenstrain_factor",
                value=layer.eigenstrain_factor,
            )
        if layer.where != EVERYWHERE:
            _check_where(design, layer, parts, key)
    _check_active(design)
    if not any(layer.where == EVERYWHERE for layer in design.layers):
        raise problem(
            "no layer lies everywhere, so the sheet is nothing beside its parts",
            key="layers",
            allowed="where = everywhere for one of them",
        )
    for part in parts:
        if not any(layer.where == part for layer in design.layers):
            raise problem(f"no layer has where = {part}, so it is made of nothing", key="pattern")


def _check_active(design: DesignSchema) -> None:
    """Something must move the sheet: active layers and an actuation, or loads."""
    loaded = bool(design.loads) or design.gravity is not None
    if not loaded and "actuation" not in design.model_fields_set:
        raise problem("is required, unless the design has loads or gravity", key="actuation")
    if any(layer.role == "active" for layer in design.layers):
        return
    if not loaded:
        raise problem("no layer is active, so nothing moves", key="layers", allowed="role = active")
    if design.actuation != actuation_table.NO_ACTUATION:
        raise problem(
            "no layer is active, so nothing is actuated; remove the table, or give a layer the "
            "role active",
            key="actuation",
        )


def _check_where(design: DesignSchema, layer: Layer, parts: list[str], key: str) -> None:
    """The place of a layer that lies in a part of the pattern."""
    if layer.role == "active" and design.model == "published":
        raise problem(
            "an active layer covers the whole sheet in the published model",
            key=f"{key}.where",
            value=layer.where,
            allowed=EVERYWHERE,
        )
    if not parts:
        raise problem(
            "this layer lies in a part of the pattern, and the design has none: "
            "add a [[pattern]] shape, or write everywhere",
            key=f"{key}.where",
        )
    if layer.where not in parts:
        guess = nearest(layer.where, [EVERYWHERE, *parts])
        hint = f"; did you mean {guess}?" if guess else ""
        raise problem(
            f"no shape of the pattern belongs to this part{hint}",
            key=f"{key}.where",
            value=layer.where,
            allowed=", ".join([EVERYWHERE, *parts]),
        )


def check_supports(design: DesignSchema) -> None:
    """Supports, and the perturbation that they must bear."""
    free = [isinstance(support, FreeSupport) for support in design.supports]
    if any(free) and not all(free):
        raise problem(
            "a free sheet has no other support; remove one of the two",
            key=f"supports[{free.index(True)}].kind",
        )
    if (not free or all(free)) and design.perturbation.shape == "uniform":
        raise problem(
            "a uniform force does nothing to a free sheet",
            key="perturbation.shape",
            value="uniform",
            allowed="bowl, or add a [[supports]] table",
        )
    for index, support in enumerate(design.supports):
        if getattr(support, "kind", "") == "pattern_in_box" and not design.pattern:
            raise problem(
                "the design has no pattern to hold", key=f"supports[{index}].kind", allowed="box"
            )


def check_smoothing(design: DesignSchema) -> None:
    """Refuse a smeared boundary of the pattern where it has no meaning."""
    if design.mesh.pattern_smoothing is None:
        return
    key = "mesh.pattern_smoothing"
    if not design.pattern:
        raise problem("the design has no pattern whose boundary could be smeared", key=key)
    if design.actuation.distance == "bilayer_edges" and not design.actuation.whole_sheet:
        raise problem(
            "a smeared boundary needs distances that vary smoothly",
            key="actuation.distance",
            value="bilayer_edges",
            allowed='"pattern_boundary", or no mesh.pattern_smoothing',
        )
    if design.model != "published":
        return
    faces = {
        LayerStack.of([one for one in design.layers if one.where in (EVERYWHERE, part)]).face
        for part in {piece.part for piece in design.pattern}
    }
    if len(faces) > 1:
        raise problem(
            "parts on both faces have no common sense of coupling in the published model; choose "
            "one face, or model = laminate",
            key=key,
        )
